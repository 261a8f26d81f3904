//! Units that may stand in the place of those that are stated, and whether a factor is that of a unit.

use crate::convention::{Convention, Form};
use crate::diagnostic::Source;
use crate::units::{TABLE, Unit};

/// Units of compound dimensions that logs are written in.
const COMPOUND: &[&str] = &[
    "km/h", "ft/s", "in/s", "mm/s", "deg/s", "mdeg/s", "turn/s", "lbf*in", "lbf*ft", "kgf*m",
    "kgf*cm",
];

/// Units that heads of logs state, whatever the model's are.
const HEADS: &[&str] = &["deg", "deg/s", "mm", "km/h", "bar", "kPa", "kN"];

/// Factors closer than this are the same.
const SAME: f64 = 1e-9;

/// Factors beside that of a unit with which it is compared: what they make fit better by so much is
/// another factor.
const NEARBY: [f64; 10] = [0.75, 0.85, 0.9, 0.95, 0.98, 1.02, 1.05, 1.1, 1.18, 1.33];
pub(super) const BETTER_NEARBY: f64 = 4.0;

/// For each unit that a model states, and those of its kind that heads of logs state, the others of
/// its kind, without factors that known conventions have.
pub(super) fn other_units(of_model: &[Unit], known: &[Convention]) -> Vec<Convention> {
    let mut found: Vec<Convention> = Vec::new();
    let heads: Vec<Unit> = HEADS.iter().filter_map(|head| Unit::parse(head).ok()).collect();
    let is_of_kind = |one: &Unit, other: &Unit| one.accepts(other) && other.accepts(one);
    let are_asked = |head: &&Unit| of_model.iter().any(|own| is_of_kind(own, head));
    let stated = of_model.iter().chain(heads.iter().filter(are_asked));
    let all = || TABLE.iter().map(|(symbol, ..)| *symbol).chain(COMPOUND.iter().copied());
    for unit in stated {
        let is_new = |factor: f64, among: &[Convention]| {
            let own = among.iter().filter(|one| is_for(one, unit)).filter_map(slope);
            (factor - 1.0).abs() > SAME
                && own.into_iter().all(|own| (own / factor - 1.0).abs() > SAME)
        };
        for other in all().filter_map(|symbol| Unit::parse(symbol).ok()) {
            let factor = other.factor / unit.factor;
            if is_of_kind(unit, &other) && is_new(factor, known) && is_new(factor, &found) {
                found.extend(instead(&other, unit, factor));
            }
        }
    }
    found
}

/// That values are in another unit than is stated.
fn instead(other: &Unit, stated: &Unit, factor: f64) -> Option<Convention> {
    let (other, unit) = (&other.symbol, &stated.symbol);
    let name = format!("{other} for {unit}");
    let title = format!("unit: {other} stand where {unit} are stated");
    scaled(&name, &title, factor, Some(unit))
}

/// A convention of single numbers that multiplies them.
fn scaled(name: &str, title: &str, factor: f64, unit: Option<&String>) -> Option<Convention> {
    let unit = unit.map_or_else(String::new, |unit| format!("unit = \"{unit}\"\n"));
    let text = format!(
        "name = \"{name}\"\ntitle = \"{title}\"\nof = \"number\"\n{unit}[as]\nvalue = 'value * {factor}'\n"
    );
    Convention::parse(Source::new(name.to_owned(), text)).ok()
}

/// A convention that multiplies by a constant, with factors beside it; none of others.
pub(super) fn nearby_factors(convention: &Convention) -> Vec<Convention> {
    if !slope(convention).is_some_and(|slope| (slope.abs() - 1.0).abs() > SAME) {
        return Vec::new();
    }
    let all =
        NEARBY.iter().filter_map(|factor| scaled("nearby factor", "nearby factor", *factor, None));
    all.filter_map(|one| one.after(convention)).collect()
}

/// Whether a convention is about numbers of a unit.
fn is_for(convention: &Convention, unit: &Unit) -> bool {
    convention.unit.as_ref().is_none_or(|own| own.dimension == unit.dimension)
}

/// What a single number is multiplied by.
pub(super) fn slope(convention: &Convention) -> Option<f64> {
    if convention.form != Form::Number {
        return None;
    }
    let of = |value: f64| {
        let named = move |name: &str| (name == "value").then_some(value);
        convention.formulas.first()?.root.value(&named)
    };
    Some(of(1.0)? - of(0.0)?)
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use super::*;

    #[test]
    fn units_of_the_kind_that_is_stated_are_tried_once() {
        let speed = [Unit::parse("m/s").unwrap()];
        let found = other_units(&speed, &[]);
        let slope_of = |name: &str| {
            let own = found.iter().find(|one| one.name == name);
            assert!(own.is_some(), "{name}: {found:?}");
            slope(own.unwrap()).unwrap()
        };
        assert!((slope_of("kn for m/s") - 1852.0 / 3600.0).abs() < 1e-12);
        assert!((slope_of("km/h for m/s") * 3.6 - 1.0).abs() < 1e-12);
        // An angle's unit is not tried for a plain number, and no factor comes back.
        let plain = [Unit::one()];
        assert!(other_units(&plain, &[]).iter().all(|one| !one.name.starts_with("deg")));
        assert!(other_units(&speed, &found).is_empty());
        let rate = [Unit::parse("rad/s").unwrap()];
        let rates = other_units(&rate, &[]);
        assert!(rates.iter().any(|one| one.name == "rpm for rad/s"), "{rates:?}");
        // Heads of logs state other units than models.
        let pressure = [Unit::parse("Pa").unwrap()];
        let pressures = other_units(&pressure, &[]);
        assert!(pressures.iter().any(|one| one.name == "psi for bar"), "{pressures:?}");
    }
}
