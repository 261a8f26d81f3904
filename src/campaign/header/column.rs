//! A column of a table: its name, its unit, its values.

use crate::campaign::wanted::Choice;
use crate::units::Unit;

/// A column of a table.
#[derive(Clone, Debug)]
pub struct Column {
    /// Its name in the file; its number where it has none.
    pub name: String,
    /// Whether the file names it.
    pub is_named: bool,
    /// The wanted column it is, if any.
    pub wanted: Option<String>,
    /// Its unit in the file (`1` where it is not wanted).
    pub unit: Unit,
    /// Whether the header states it.
    pub is_unit_in_header: bool,
    /// Whether its cells are degrees, minutes and seconds.
    pub is_sexagesimal: bool,
    /// Number of the column, from 0.
    pub index: usize,
    /// Values in SI, NaN where missing; empty where it is not wanted.
    pub values: Vec<f64>,
}

/// Splits a header cell into its name and its unit with the unit's bytes within the cell: `x [m]`,
/// or `x (m)` where that is a unit.
pub fn split(cell: &str) -> (&str, Option<(&str, usize)>) {
    let parts = |open: char, close: char| {
        let open = cell.find(open).filter(|_| cell.ends_with(close))?;
        Some((cell[..open].trim(), (&cell[open + 1..cell.len() - 1], open + 1)))
    };
    // `q[0]` names an element; `[1]` may be the unit 1.
    let is_index = |text: &str| text.parse::<u32>().is_ok_and(|index| index != 1);
    if let Some((name, unit)) = parts('[', ']').filter(|(_, unit)| !is_index(unit.0)) {
        return (name, Some(unit));
    }
    match parts('(', ')') {
        Some((name, unit)) if !name.is_empty() && Unit::parse(unit.0).is_ok() => (name, Some(unit)),
        _ => (cell.trim(), None),
    }
}

impl Choice {
    /// Whether it is one of these columns.
    pub(crate) fn is_among(&self, columns: &[Column]) -> bool {
        match self {
            Self::Number(number) => (1..=columns.len()).contains(number),
            Self::Name(name) => columns.iter().any(|column| column.name == *name),
        }
    }
}
