//! Squared residuals of whole samples, in the standard uncertainties that are stated for them.

use crate::engine::{Point, Problem};

/// Campaign, run and number of a sample.
pub(super) type Place = (usize, usize, usize);

/// The sum of squares of each sample that has residuals.
pub(super) fn sample_squares(problem: &Problem, point: &Point) -> Vec<(f64, Place)> {
    let mut squares = Vec::new();
    for (p, part) in problem.parts.iter().enumerate() {
        let sigma = |row: usize| part.sigma[part.measurand_of(row)];
        for run in 0..part.runs.len() {
            problem.visit_residuals(p, run, point, &mut |sample, residuals| {
                let rows = residuals.iter().enumerate().filter(|(_, value)| !value.is_nan());
                let sum: f64 = rows.map(|(row, value)| (value / sigma(row)).powi(2)).sum();
                if sum > 0.0 {
                    squares.push((sum, (p, run, sample.number)));
                }
            });
        }
    }
    squares
}

/// The square that a part of the samples exceeds.
pub(super) fn exceeded_by(part: f64, problem: &Problem, point: &Point) -> Option<f64> {
    let mut squares: Vec<f64> =
        sample_squares(problem, point).into_iter().map(|(square, _)| square).collect();
    let at = ((1.0 - part) * squares.len() as f64) as usize;
    let last = squares.len().checked_sub(1)?;
    let (_, square, _) = squares.select_nth_unstable_by(at.min(last), f64::total_cmp);
    Some(*square)
}
