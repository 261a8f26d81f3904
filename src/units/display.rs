//! The units in which results are shown: as declared, unless a campaign states others.

use super::{Dimension, Unit};

/// What `[output] units` may speak of beside names: the unit that each stands for.
pub const KINDS: [(&str, &str); 3] = [("angle", "rad"), ("length", "m"), ("time", "s")];

/// Units by what they are for: a kind of [`KINDS`], or the name of a parameter or measurand.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DisplayUnits(Vec<(String, Unit)>);

impl DisplayUnits {
    /// Adds a unit; what was added first holds.
    pub fn add(&mut self, of: impl Into<String>, unit: Unit) {
        self.0.push((of.into(), unit));
    }

    /// What was stated, in order.
    pub fn stated(&self) -> impl Iterator<Item = (&str, &Unit)> {
        self.0.iter().map(|(of, unit)| (of.as_str(), unit))
    }

    /// The unit of a parameter or measurand: as stated for its name, else for its kind, else
    /// `None`.
    pub fn of(&self, name: &str, declared: &Unit) -> Option<Unit> {
        let find = |of: &str| self.0.iter().find(|(key, _)| key == of).map(|(_, unit)| unit);
        let found = find(name).or_else(|| find(kind(declared)?))?;
        declared.accepts(found).then(|| found.clone())
    }
}

/// The kind of a plain unit: quotients and powers have none.
fn kind(unit: &Unit) -> Option<&'static str> {
    if unit.is_angle() {
        return Some("angle");
    }
    let is_plain = !unit.symbol.contains(['/', '*', '^', ' ', '·']);
    match unit.dimension {
        Dimension::LENGTH if is_plain => Some("length"),
        Dimension::TIME if is_plain => Some("time"),
        _ => None,
    }
}
