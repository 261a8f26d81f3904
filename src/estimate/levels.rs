//! Fits with levels of noise estimated beside: residuals of a fit give the levels, which weight the next fit.

use crate::engine::{Point, Problem};
use crate::estimate::batch::{Fit, FitError, Options, Outcome, fit};
use crate::estimate::variance;

/// Rounds of estimating noise levels and fitting again.
const NOISE_ROUNDS: usize = 12;

/// Fits, estimates noise levels, fits again, until the levels stand.
pub(crate) fn fit_with_levels(
    problem: &mut Problem,
    start: Point,
    options: &Options,
) -> Result<(Fit<Point>, Vec<variance::Level>), FitError> {
    let unknown = variance::unknown_levels(problem);
    if unknown.is_empty() {
        return Ok((fit(problem, start, options)?, Vec::new()));
    }
    variance::start_levels(problem, &unknown);
    let first = fit(problem, start, options)?;
    settle_levels(problem, first, &unknown, options)
}

/// Estimates noise levels from a fit, fits again, until the levels stand.
pub(crate) fn settle_levels(
    problem: &mut Problem,
    first: Fit<Point>,
    unknown: &[variance::Unknown],
    options: &Options,
) -> Result<(Fit<Point>, Vec<variance::Level>), FitError> {
    let mut best = first;
    let mut iterations = best.iterations;
    let mut levels = Vec::new();
    for _ in 0..NOISE_ROUNDS {
        if best.outcome == Outcome::NotFinite {
            break;
        }
        let Some((found, change)) = variance::estimate(problem, &mut best.point, unknown) else {
            best.outcome = Outcome::NotFinite;
            break;
        };
        levels = found;
        best = fit(problem, best.point.clone(), options)?;
        iterations += best.iterations;
        if change < 1e-4 {
            break;
        }
    }
    best.iterations = iterations;
    Ok((best, levels))
}
