//! Campaigns with effects of known values, and their readings.
//!
//! Which effects and values is settled elsewhere ([`super::draw`]).

use crate::engine::point::NamedValue;
use crate::engine::simulate::simulate;
use crate::engine::{Point, Problem};
use crate::system::Selected;

use super::design::Design;

/// The campaigns with readings as their models give them, without noise.
pub(super) fn noiseless(full: &Problem, point: &Point) -> Problem {
    let mut quiet = full.clone();
    for part in &mut quiet.parts {
        part.sigma.fill(0.0);
        part.random_sigma.fill(0.0);
    }
    simulate(&mut quiet, point, 0, true);
    quiet
}

/// The campaigns with effects of these values, at the truth.
pub(super) fn with(
    design: &Design,
    selected: &[Selected],
    values: &[NamedValue],
) -> (Problem, Point) {
    let parts = design.problem.parts.iter().zip(&design.recipes).map(|(part, recipe)| match recipe
        .with(selected)
    {
        Ok(system) => part.with_system(system),
        Err(_) => part.clone(),
    });
    let full = Problem::new(parts.collect());
    let mut point = design.truth.carried(&design.problem.layout, &full.layout);
    point.set_named(&full.layout, values);
    (full, point)
}

/// Gives one problem the readings of another.
pub(super) fn take_readings(problem: &mut Problem, from: &Problem) {
    for (part, other) in problem.parts.iter_mut().zip(&from.parts) {
        for (run, other) in part.runs.iter_mut().zip(&other.runs) {
            run.record.clone_from(&other.record);
        }
    }
}
