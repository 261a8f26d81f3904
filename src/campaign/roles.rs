//! Which of a model's names have a role that formats know: the time, the position, the attitude.

use crate::campaign::attitude::quaternions;
use crate::campaign::axes::triples;
use crate::campaign::formats::Role;
use crate::graph::MeasurandKind;
use crate::model::Model;
use crate::units::{Dimension, Unit};

/// The roles of a file's columns, by the names that the model has for them. Where two names could
/// have a role none has it. Readings come before inputs, if the file may hold `readings`.
pub(crate) fn roles(model: &Model, readings: bool) -> Vec<(String, Role)> {
    let mut found = vec![(crate::campaign::header::TIME.to_owned(), Role::Time(0))];
    let measurands = model.measurands.iter().map(|one| (one.name.as_str(), &one.unit));
    let inputs = model.inputs.iter().map(|one| (one.name.as_str(), &one.unit));
    let of_readings = triple(&measurands.collect::<Vec<_>>()).filter(|_| readings);
    let position = of_readings.or_else(|| triple(&inputs.collect::<Vec<_>>()));
    let axes = position.into_iter().flatten().enumerate();
    found.extend(axes.map(|(axis, name)| (name, Role::Position(axis))));
    let mut rotations = model.measurands.iter().filter(|one| one.kind == MeasurandKind::Rotation);
    let of_readings = match (rotations.next(), rotations.next()) {
        (Some(one), None) => Some(["w", "x", "y", "z"].map(|axis| format!("{}_{axis}", one.name))),
        _ => None,
    };
    let of_inputs = || match quaternions(model).as_slice() {
        [one] => Some(one.clone()),
        _ => None,
    };
    let attitude = of_readings.filter(|_| readings).or_else(of_inputs);
    let components = attitude.into_iter().flatten().enumerate();
    found.extend(components.map(|(k, name)| (name, Role::Attitude(k))));
    found
}

/// The only three lengths whose names differ in their axis alone.
fn triple(all: &[(&str, &Unit)]) -> Option<[String; 3]> {
    let is_length = |name: &str| {
        all.iter().any(|(own, unit)| *own == name && unit.dimension == Dimension::LENGTH)
    };
    let names = |first: &str| {
        let all = triples(first).into_iter().map(|(_, names)| names);
        all.filter(|names| names.iter().all(|name| is_length(name))).collect::<Vec<_>>()
    };
    let mut found = all.iter().flat_map(|(name, _)| names(name));
    let first = found.next()?;
    found.next().is_none().then_some(first)
}
