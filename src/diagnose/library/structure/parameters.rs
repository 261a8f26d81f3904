//! Other values of the model's own parameters in some of the runs, or from a moment on: a camera that was
//! mounted anew, a target that was exchanged. Each is looked for as a change alone: values for each run
//! would take the place of effects.

use crate::graph::{Kind, Scope};
use crate::model::{Model, ParameterDeclaration};
use crate::units::Unit;

use super::covariate::AXES;
use super::made::{Block, made};
use super::{ORIENTATION, POSITION};
use crate::diagnose::library::place::{OF_PARAMETER, Of, POSE, Place, RUN};

/// Components of parameters that are looked at, at most.
const MOST: usize = 15;

/// Another value of each component of a parameter that is estimated. Of what is a value for each run
/// already, and of where the instrument stands, others say it.
pub(super) fn of_parameters(model: &Model) -> Vec<Block> {
    let is_asked = |one: &&ParameterDeclaration| {
        let is_rig = one.name == model.called(POSITION);
        let is_of_runs = matches!(one.setting.scope, Scope::Run | Scope::Sample);
        !one.setting.fixed && !one.per_measurand && !is_of_runs && !is_rig
    };
    let all: Vec<Block> =
        model.parameters.iter().filter(is_asked).flat_map(of_components).take(MOST + 1).collect();
    if all.len() > MOST { Vec::new() } else { all }
}

/// Another place and orientation of the instrument together: what was knocked moves and turns. Each alone is
/// tried by others; this one with a moment that was found for one of them.
pub(super) fn of_the_pose(model: &Model) -> Vec<Block> {
    let free = |name: &str| {
        let name = model.called(name);
        model.parameters.iter().find(|one| one.name == name && !one.setting.fixed)
    };
    let (Some(position), Some(orientation)) = (free(POSITION), free(ORIENTATION)) else {
        return Vec::new();
    };
    if (position.kind, orientation.kind) != (Kind::Vector, Kind::Rotation) {
        return Vec::new();
    }
    let Ok(angle) = Unit::parse("rad") else { return Vec::new() };
    let of = Of::Channel(format!("{OF_PARAMETER}{POSE}"));
    let place = Place::new(of, RUN, format!("another {POSE} over {RUN}"));
    let coefficient = |at: usize| {
        let unit = if at < AXES.len() { &position.unit } else { &angle };
        (format!("part_{at}"), unit.clone())
    };
    let coefficients: Vec<(String, Unit)> = (0..2 * AXES.len()).map(coefficient).collect();
    let sum = |first: usize| {
        let along = AXES.iter().enumerate();
        let along = along.map(|(axis, vector)| format!("part_{} * {vector}", first + axis));
        along.collect::<Vec<_>>().join(" + ")
    };
    let (moved, turned) = (sum(0), sum(AXES.len()));
    let (position, orientation) = (&position.name, &orientation.name);
    let patches = format!(
        "{position} = '{position} + {moved}'\n{orientation} = '{orientation} * turn({turned})'\n"
    );
    made("unknown_pose", &place, (&coefficients, "run"), "", &patches).into_iter().collect()
}

fn of_components(parameter: &ParameterDeclaration) -> Vec<Block> {
    let name = &parameter.name;
    let block = |component: &str, words: String, patch: String, unit: &Unit| {
        let of = Of::Channel(format!("{OF_PARAMETER}{name}{component}"));
        let place = Place::new(of, RUN, format!("another value of {words} over {RUN}"));
        let coefficient = ("part_0".to_owned(), unit.clone());
        let called = format!("unknown_parameter_{name}{component}");
        made(&called, &place, (&[coefficient], "run"), "", &format!("{name} = '{patch}'\n"))
    };
    let along = |(axis, vector): (&str, &str)| match parameter.kind {
        Kind::Rotation => block(
            &format!(" {axis}"),
            format!("`{name}`, turned about {axis},"),
            format!("{name} * turn(part_0 * {vector})"),
            &Unit::parse("rad").ok()?,
        ),
        _ => block(
            &format!(".{axis}"),
            format!("`{name}.{axis}`"),
            format!("{name} + part_0 * {vector}"),
            &parameter.unit,
        ),
    };
    match parameter.kind {
        Kind::Scalar => {
            let patch = format!("{name} + part_0");
            block("", format!("`{name}`"), patch, &parameter.unit).into_iter().collect()
        }
        _ => ["x", "y", "z"].into_iter().zip(AXES).filter_map(along).collect(),
    }
}
