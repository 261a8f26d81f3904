//! Campaigns some of whose runs are only planned: what was measured says where the rest stands.
//!
//! Answers: what of a problem can be fitted, where all of it stands with that fit, and which places
//! and turns nobody says. It does not fit.

use crate::engine::layout::Instance;
use crate::engine::{Point, Problem};

/// The runs that have readings, and nothing else.
pub fn measured(problem: &Problem) -> Problem {
    let mut parts = problem.parts.clone();
    for part in &mut parts {
        let measured: Vec<bool> = (0..part.runs.len()).map(|run| part.has_readings(run)).collect();
        let mut measured = measured.into_iter();
        part.runs.retain(|_| measured.next().unwrap_or(false));
    }
    parts.retain(|part| !part.runs.is_empty());
    problem.with_parts(parts)
}

/// The point of all runs with the fit of the [`measured`] ones: as stated where the fit says
/// nothing.
pub fn placed(problem: &Problem, measured: &Problem, point: &Point) -> Point {
    point.carried_onto(&measured.layout, &problem.layout, Point::stated(&problem.layout))
}

/// What has a place or a turn that nobody states, nor the readings of a `measured` part of it:
/// names, with the setup.
pub fn unplaced(problem: &Problem, measured: Option<&Problem>) -> Vec<String> {
    let known = measured.map(silent).unwrap_or_default();
    let mut unplaced = silent(problem);
    unplaced.retain(|one| !known.contains(one));
    unplaced
}

/// The same, whatever readings say.
fn silent(problem: &Problem) -> Vec<String> {
    let silent = |instance: &&Instance| {
        let setting = &instance.setting;
        setting.value.is_none() && setting.start.is_none() && instance.dimension() > 1
    };
    let full = |one: &Instance| match &one.of {
        Some(of) => format!("`{}` ({of})", one.name),
        None => format!("`{}`", one.name),
    };
    problem.layout.instances.iter().filter(silent).map(full).collect()
}
