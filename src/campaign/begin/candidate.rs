//! A column with its unit, by the header or by the ending of its name.

use crate::campaign::begin::survey::Surveyed;
use crate::campaign::endings::ending;
use crate::units::Unit;

/// A column with the unit that it seems to have, and why.
#[derive(Clone, Debug)]
pub(super) struct Candidate {
    pub(super) column: usize,
    pub(super) unit: Unit,
    /// Why it is taken for that; empty where the file says so.
    pub(super) why: String,
}

/// The name without the ending that is a unit, in small letters; and the unit.
pub(super) fn base(name: &str) -> (String, Option<Unit>) {
    let small = name.to_lowercase();
    let ending = ending(name).and_then(|unit| {
        let (base, _) = small.rsplit_once('_')?;
        Some((base.to_owned(), Unit::parse(unit).ok()?))
    });
    match ending {
        Some((base, unit)) => (base, Some(unit)),
        None => (small, None),
    }
}

/// The unit of a column, and why.
pub(super) fn unit(column: &Surveyed, usual: &str, what: &str) -> (Unit, String) {
    if let Some(unit) = &column.unit {
        return (unit.clone(), String::new());
    }
    match base(&column.name).1 {
        Some(unit) => (unit, format!("{what}; unit from the ending of the name")),
        None => {
            let unit = Unit::parse(usual).unwrap_or_else(|_| Unit::one());
            (unit, format!("{what}; the file has no unit, CHECK `{usual}`"))
        }
    }
}
