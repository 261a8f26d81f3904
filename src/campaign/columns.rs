//! The columns of a run's table as its model has them: readings, and rates with their units.

use crate::graph::MeasurandKind;
use crate::model::Model;
use crate::units::{Dimension, Unit};

/// Number of reading columns of a model.
pub(crate) fn column_count(model: &Model) -> usize {
    reading_columns(model).len()
}

/// The reading columns of a model in their order: index of the measurand, name.
pub(crate) fn reading_columns(model: &Model) -> Vec<(usize, String)> {
    let mut columns = Vec::new();
    for (index, measurand) in model.measurands.iter().enumerate() {
        match measurand.kind {
            MeasurandKind::Rotation => {
                columns.extend(
                    ["w", "x", "y", "z"].map(|c| (index, format!("{}_{c}", measurand.name))),
                );
            }
            _ => columns.push((index, measurand.name.clone())),
        }
    }
    columns
}

/// The unit of the rate (order 1) or acceleration (order 2) of what has a unit.
pub(crate) fn derived(unit: &Unit, order: u8) -> Unit {
    let base = if unit.offset != 0.0 { "K".to_owned() } else { unit.symbol.clone() };
    let plain = base.chars().all(char::is_alphabetic);
    let base = if plain || base == "1" { base } else { format!("({base})") };
    let symbol = match order {
        0 => unit.symbol.clone(),
        1 => format!("{base}/s"),
        _ => format!("{base}/s^2"),
    };
    let per = (0..order).fold(unit.dimension, |dimension, _| dimension / Dimension::TIME);
    Unit::parse(&symbol).unwrap_or_else(|_| Unit::coherent(per))
}
