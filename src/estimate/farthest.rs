//! Where the readings stand that are the farthest from a fit that is far beyond its noise: a few
//! stretches of rows of one measurand, or none where far readings are many. The fit is bent by them;
//! whether they are wrong is judged elsewhere.

use crate::estimate::calibrate::Calibration;
use crate::estimate::residuals::{Residuals, seen_from};

/// Readings beyond this part of the largest residual are far.
const FAR: f64 = 0.5;
/// Part of all readings that they may be.
const FEW: f64 = 0.2;
/// Readings between two of a stretch that may be near.
const GAP: usize = 2;

/// Rows of a run whose readings of a measurand are far.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Farthest {
    /// The run.
    pub run: String,
    /// The measurand.
    pub measurand: String,
    /// First and last row of the data file, in order.
    pub rows: Vec<(usize, usize)>,
}

/// The farthest readings of a fit, of the measurand and run of the farthest one.
pub fn farthest(fit: &Calibration) -> Option<Farthest> {
    let (problem, point) = (&fit.problem, &fit.fit.point);
    let all = seen_from(problem, point);
    let size =
        |residual: &f64, sigma: f64| if residual.is_nan() { 0.0 } else { residual.abs() / sigma };
    let of_run = |one: &Residuals, run: usize| {
        let sigma = problem.parts[one.part].sigma[one.measurand];
        one.runs[run].iter().map(|residual| size(residual, sigma)).fold(0.0, f64::max)
    };
    let runs = all.iter().flat_map(|one| (0..one.runs.len()).map(move |run| (one, run)));
    let (one, run) = runs.max_by(|a, b| of_run(a.0, a.1).total_cmp(&of_run(b.0, b.1)))?;
    let readings = one.readings(run);
    let most = readings.iter().map(|(_, residual)| residual.abs()).fold(0.0, f64::max);
    let far: Vec<usize> =
        (0..readings.len()).filter(|at| readings[*at].1.abs() > FAR * most).collect();
    if far.is_empty() || far.len() as f64 > FEW * readings.len() as f64 {
        return None;
    }
    let (run_name, measurand) = one.in_run(run).names(problem);
    let record = &problem.parts[one.part].runs[run].record;
    let stretches = far.chunk_by(|a, b| b - a <= GAP + 1);
    let rows = stretches.filter_map(|stretch| {
        let ends = [stretch[0], stretch[stretch.len() - 1]].map(|at| readings[at].0);
        let rows = record.rows(&ends);
        Some((*rows.first()?, *rows.last()?))
    });
    Some(Farthest { run: run_name, measurand, rows: rows.collect() })
}
