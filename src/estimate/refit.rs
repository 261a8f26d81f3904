//! Fits of nearly the same readings: without some that were left out.
//!
//! From its start such a fit may end elsewhere than that of all readings: in another period of a
//! motion, say, where a gain starts far off. It must not end worse than where the other one did.

use crate::engine::gram::LeastSquares;
use crate::engine::{Point, Problem};
use crate::estimate::batch::{FitError, Options};
use crate::estimate::calibrate::{Calibration, calibrate};

/// Estimates everything from the start of a problem, and from a point near its end where the fit is
/// worse than that.
///
/// # Errors
/// As [`calibrate`].
pub fn calibrate_near(
    problem: Problem,
    near: &Point,
    options: &Options,
) -> Result<Calibration, FitError> {
    let fitted = calibrate(problem, options)?;
    if fitted.is_sound() && fitted.fit.cost <= fitted.problem.cost(near) {
        return Ok(fitted);
    }
    let other = calibrate(beginning_at(fitted.problem.clone(), near), options)?;
    let is_better = other.is_sound() && (!fitted.is_sound() || other.fit.cost < fitted.fit.cost);
    Ok(if is_better { other } else { fitted })
}

/// The problem with all free parameters starting at a point of it, as if a search had found that.
pub fn beginning_at(mut problem: Problem, point: &Point) -> Problem {
    for index in 0..problem.layout.instances.len() {
        if problem.layout.is_free(index) {
            let components = point.components(&problem.layout, index);
            problem.begin_at_found(index, components);
        }
    }
    problem
}
