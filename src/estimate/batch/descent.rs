//! Descent: from a linearised problem and a damping to a step, free or within bounds.

use nalgebra::DVector;

use crate::estimate::arrow::{Arrow, LinearError};
use crate::estimate::batch::FitError;
use crate::estimate::conic::{BoundedError, bounded_step};

/// The damped step; within `bounds` where the free one would leave them. `None` where the damping
/// is too small to make the problem regular.
pub(super) fn step(
    arrow: &Arrow,
    damping: &DVector<f64>,
    bounds: &[(f64, f64)],
) -> Result<Option<DVector<f64>>, FitError> {
    let free = match arrow.solve(damping) {
        Ok(step) => step,
        Err(LinearError::Singular { .. }) => return Ok(None),
        Err(error) => return Err(error.into()),
    };
    if free.iter().zip(bounds).all(|(x, (lower, upper))| lower <= x && x <= upper) {
        return Ok(Some(free));
    }
    let mut hessian = arrow.dense();
    for (i, value) in damping.iter().enumerate() {
        hessian[(i, i)] += value;
    }
    match bounded_step(&hessian, arrow.gradient(), bounds) {
        Ok(bounded) => Ok(Some(bounded.step)),
        Err(BoundedError::NotSolved(_)) => Ok(None),
        Err(error) => Err(error.into()),
    }
}
