//! Units that may stand in the place of those that are stated, and whether a factor is that of a unit.

use crate::convention::{Convention, Form};
use crate::diagnostic::Source;
use crate::units::{TABLE, Unit};

/// Units of compound dimensions that logs are written in.
const COMPOUND: &[&str] = &[
    "km/h", "ft/s", "in/s", "mm/s", "deg/s", "mdeg/s", "turn/s", "lbf*in", "lbf*ft", "kgf*m",
    "kgf*cm",
];

/// Factors closer than this are the same.
const SAME: f64 = 1e-9;

/// Factors beside that of a unit with which it is compared: what they make fit better by so much is
/// another factor.
const NEARBY: [f64; 10] = [0.75, 0.85, 0.9, 0.95, 0.98, 1.02, 1.05, 1.1, 1.18, 1.33];
pub(super) const BETTER_NEARBY: f64 = 4.0;

/// For each unit that heads state, the others of its kind, for columns of that unit, without factors
/// that known conventions have. `units` are all in which something is stated, by files or by the
/// model: they are tried, too, as those of the table and of logs are.
pub(super) fn other_units(
    form: Form,
    heads: &[Unit],
    units: &[Unit],
    known: &[Convention],
) -> Vec<Convention> {
    let all = TABLE.iter().map(|(symbol, ..)| *symbol).chain(COMPOUND.iter().copied());
    let all: Vec<Unit> = all.filter_map(|symbol| Unit::parse(symbol).ok()).collect();
    let mut found: Vec<Convention> = Vec::new();
    for head in heads {
        // Of units with one factor the one that something is stated in, then that of the table.
        let others = units.iter().cloned().chain(all.iter().cloned()).chain(beside(head));
        for other in others.filter(|other| head.accepts(other) && other.accepts(head)) {
            let factor = other.factor / head.factor;
            let is_about = |one: &Convention| {
                let is_own = |own: &Unit| own.symbol == head.symbol;
                one.form == form && is_for(one, head) && one.head.as_ref().is_none_or(is_own)
            };
            let mut factors =
                known.iter().chain(&found).filter(|one| is_about(one)).filter_map(scale);
            if (factor - 1.0).abs() > SAME && factors.all(|own| (own / factor - 1.0).abs() > SAME) {
                found.extend(instead(form, &other, head, factor));
            }
        }
    }
    found
}

/// Units that differ from one of a quotient by what is divided: `mm/s^2`, `ft/s^2` beside `m/s^2`.
fn beside(unit: &Unit) -> Vec<Unit> {
    let Some((over, under)) = unit.symbol.split_once('/') else { return Vec::new() };
    let Some(over) = Unit::parse(over).ok() else { return Vec::new() };
    let others = TABLE.iter().filter_map(|(symbol, ..)| {
        let is_of_kind = |one: &Unit| one.accepts(&over) && over.accepts(one);
        Unit::parse(symbol).ok().filter(is_of_kind)
    });
    others.filter_map(|one| Unit::parse(&format!("{}/{under}", one.symbol)).ok()).collect()
}

/// That values are in another unit than heads state.
fn instead(form: Form, other: &Unit, head: &Unit, factor: f64) -> Option<Convention> {
    let (symbol, unit) = (&other.symbol, &head.symbol);
    let of = if form == Form::Vector { " of the coordinates" } else { "" };
    let name = format!("{symbol} for {unit}");
    let title = format!("unit{of}: {symbol} stand where {unit} are stated");
    let one = scaled(form, &name, &title, factor, Some(unit))?;
    Some(Convention { head: Some(head.clone()), ..one })
}

/// A factor as it is written: `/ 0.3048`, where that is shorter than `* 3.28...`.
fn by(factor: f64) -> String {
    let digits = |value: f64| -> String {
        let rounded: Option<f64> = format!("{value:.14e}").parse().ok();
        rounded.unwrap_or(value).to_string()
    };
    let [times, over] = [digits(factor), digits(1.0 / factor)];
    if over.len() < times.len() { format!("/ {over}") } else { format!("* {times}") }
}

/// A convention that multiplies numbers, or the components of vectors.
fn scaled(
    form: Form,
    name: &str,
    title: &str,
    factor: f64,
    unit: Option<&String>,
) -> Option<Convention> {
    let of = if form == Form::Vector { "vector" } else { "number" };
    let unit = unit.map_or_else(String::new, |unit| format!("unit = \"{unit}\"\n"));
    let by = by(factor);
    let line = |component: &&str| format!("{component} = '{component} {by}'\n");
    let lines: String = form.components().iter().map(line).collect();
    let text =
        format!("name = \"{name}\"\ntitle = \"{title}\"\nof = \"{of}\"\n{unit}[as]\n{lines}");
    Convention::parse(Source::new(name.to_owned(), text)).ok()
}

/// A convention that multiplies by a constant, with factors beside it; none of others.
pub(super) fn nearby_factors(convention: &Convention) -> Vec<Convention> {
    if !scale(convention).is_some_and(|scale| (scale.abs() - 1.0).abs() > SAME) {
        return Vec::new();
    }
    let nearby =
        |factor: &f64| scaled(convention.form, "nearby factor", "nearby factor", *factor, None);
    let all = NEARBY.iter().filter_map(nearby);
    all.filter_map(|one| one.after(convention)).collect()
}

/// Whether a convention is about numbers of a unit.
fn is_for(convention: &Convention, unit: &Unit) -> bool {
    convention.unit.as_ref().is_none_or(|own| own.dimension == unit.dimension)
}

/// What a single number, or a vector, is multiplied by; `None` where it is something else that is changed.
pub(super) fn scale(convention: &Convention) -> Option<f64> {
    let names = match convention.form {
        Form::Number => return slope(convention),
        Form::Vector => Form::Vector.components(),
        _ => return None,
    };
    let of = |component: usize, one: &str| {
        let named = |name: &str| Some(if name == one { 1.0 } else { 0.0 });
        convention.formulas.get(component)?.root.value(&named)
    };
    let factor = of(0, names[0])?;
    let is_scaled = |at: usize, component: &str| {
        let own = if names[at] == component { factor } else { 0.0 };
        of(at, component).is_some_and(|value| (value - own).abs() <= SAME * factor.abs())
    };
    let mut all = (0..names.len()).flat_map(|at| names.iter().map(move |name| (at, *name)));
    all.all(|(at, component)| is_scaled(at, component)).then_some(factor)
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
        let unit = |symbol: &str| Unit::parse(symbol).unwrap();
        let of =
            |heads: &[Unit], known: &[Convention]| other_units(Form::Number, heads, heads, known);
        let speed = [unit("m/s")];
        let found = of(&speed, &[]);
        let slope_of = |found: &[Convention], name: &str| {
            let own = found.iter().find(|one| one.name == name);
            assert!(own.is_some(), "{name}: {found:?}");
            slope(own.unwrap()).unwrap()
        };
        assert!((slope_of(&found, "kn for m/s") - 1852.0 / 3600.0).abs() < 1e-12);
        assert!((slope_of(&found, "km/h for m/s") * 3.6 - 1.0).abs() < 1e-12);
        assert!((slope_of(&found, "ft/s for m/s") - 0.3048).abs() < 1e-12);
        // An angle's unit is not tried for a plain number, and no factor comes back.
        assert!(of(&[Unit::one()], &[]).iter().all(|one| !one.name.starts_with("deg")));
        assert!(of(&speed, &found).is_empty());
        let rates = of(&[unit("rad/s")], &[]);
        assert!(rates.iter().any(|one| one.name == "rpm for rad/s"), "{rates:?}");
        // Heads of logs state other units than models, and what a model states may stand there.
        let pressures = of(&[unit("bar")], &[]);
        assert!(pressures.iter().any(|one| one.name == "psi for bar"), "{pressures:?}");
        let found =
            other_units(Form::Number, &[unit("ft/s")], &[unit("ft/s"), speed[0].clone()], &[]);
        assert!((slope_of(&found, "m/s for ft/s") * 0.3048 - 1.0).abs() < 1e-12);
        // Every unit of the kind of every unit of the table, either way.
        for (head, ..) in TABLE {
            let found = of(&[unit(head)], &[]);
            for (other, ..) in TABLE {
                let [head, other] = [unit(head), unit(other)];
                let factor = other.factor / head.factor;
                if head.accepts(&other) && other.accepts(&head) && (factor - 1.0).abs() > SAME {
                    let is_own = |one: &Convention| {
                        slope(one).is_some_and(|own| (own / factor - 1.0).abs() < 1e-9)
                    };
                    assert!(found.iter().any(is_own), "{} for {}", other.symbol, head.symbol);
                }
            }
        }
    }

    #[test]
    fn vectors_are_read_in_other_units_of_their_heads() {
        let feet = [Unit::parse("ft").unwrap()];
        let metre = [Unit::parse("m").unwrap()];
        let found = other_units(Form::Vector, &feet, &metre, &[]);
        let own = found.iter().find(|one| one.name == "m for ft").unwrap();
        assert!((scale(own).unwrap() * 0.3048 - 1.0).abs() < 1e-12);
        assert_eq!(own.head.as_ref().unwrap().symbol, "ft");
        assert!(other_units(Form::Vector, &feet, &metre, &found).is_empty());
    }
}
