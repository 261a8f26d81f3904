//! Standardised residuals and redundancy numbers, reading by reading (Baarda 1968; Förstner 1979).
//!
//! The redundancy number of a reading is the part of an error in it that its residual shows, from 0
//! to 1; all of them and those of stated values add up to the degrees of freedom. The standardised
//! residual is the residual over its own standard deviation, a standard normal number where the
//! reading is right. Readings of one sample may share errors of inputs; correlation from sample to
//! sample is left out here.

use nalgebra::{DMatrix, DVector};

use crate::campaign::Sample;
use crate::engine::noise::{CHUNK, active_randoms, covariance_of};
use crate::estimate::calibrate::Calibration;
use crate::number::Gradient;

/// Redundancy below which a residual shows nothing of its reading.
const SILENT: f64 = 1e-6;

/// What is known of one residual component.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Checked {
    /// `reading - prediction` (SI); NaN where there is no reading.
    pub residual: f64,
    /// Over its standard deviation; NaN where the residual shows nothing of the reading.
    pub standardised: f64,
    /// Between 0 and 1.
    pub redundancy: f64,
}

/// Calls `visit(sample, components)` for each sample of a run.
pub fn visit_checked(
    result: &Calibration,
    (p, r): (usize, usize),
    visit: &mut dyn FnMut(Sample<'_>, &[Checked]),
) {
    let problem = &result.problem;
    let part = &problem.parts[p];
    let touched = problem.layout.columns.touched_by(problem.run_index(p, r));
    let size = touched.len();
    let own = DMatrix::from_fn(size, size, |i, j| result.covariance[(touched[i], touched[j])]);
    let parameters = problem.parameters::<Gradient<CHUNK>>(p, r, &result.fit.point);
    let active = active_randoms(part);
    let mut workspace = Vec::new();
    let mut made = Vec::new();
    problem.visit_samples(p, r, &result.fit.point, &mut |sample, jacobian, residuals| {
        let stated = covariance_of(part, r, sample, &parameters, &active, &mut workspace);
        let read: Vec<usize> =
            (0..residuals.len()).filter(|row| residuals[*row].is_finite()).collect();
        let nothing = |residual: &f64| Checked {
            residual: *residual,
            standardised: f64::NAN,
            redundancy: f64::NAN,
        };
        made.clear();
        made.extend(residuals.iter().map(nothing));
        let variance = stated.covariance.select_rows(&read).select_columns(&read);
        let lines = jacobian.select_rows(&read);
        if let Some(weights) = variance.clone().try_inverse() {
            // Covariance of the residuals, then of the weighted residuals.
            let left = &variance - &lines * &own * lines.transpose();
            let shown = &left * &weights;
            let spread = &weights * &shown;
            let values = DVector::from_iterator(read.len(), read.iter().map(|row| residuals[*row]));
            let pull = &weights * values;
            for (place, row) in read.iter().enumerate() {
                let redundancy = shown[(place, place)];
                made[*row].redundancy = redundancy;
                if redundancy > SILENT && spread[(place, place)] > 0.0 {
                    made[*row].standardised = pull[place] / spread[(place, place)].sqrt();
                }
            }
        }
        visit(sample, &made);
    });
}
