//! Two conventions that were mistaken for the same number: another unit and the other sense, such as
//! elevations in gon where zenith angles in degrees are stated. Neither by itself makes a model fit.

use crate::convention::{Convention, Form};

use super::units::slope;

/// All of a convention that stretches a number followed by one that does not.
pub(super) fn composed(conventions: &[&Convention]) -> Vec<Convention> {
    let of_numbers = || conventions.iter().copied().filter(|one| one.form == Form::Number);
    let senses = of_numbers().filter(|one| slope(one).is_some_and(|slope| slope == -1.0));
    let units = of_numbers().filter(|one| slope(one).is_some_and(|slope| slope.abs() != 1.0));
    let units: Vec<&Convention> = units.collect();
    senses.flat_map(|sense| units.iter().filter_map(|unit| sense.after(unit))).collect()
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use super::*;
    use crate::diagnostic::Source;

    #[test]
    fn a_unit_comes_before_a_sense() {
        let of = |name: &str, formula: &str| {
            let text = format!(
                "name = \"{name}\"\ntitle = \"{name}\"\nof = \"number\"\nunit = \"rad\"\n[as]\nvalue = '{formula}'\n"
            );
            Convention::parse(Source::new(name, text)).unwrap()
        };
        let all = [
            of("gon", "value * 0.9"),
            of("zenith", "90 deg - value"),
            of("turn", "value + 90 deg"),
        ];
        let found = composed(&all.iter().collect::<Vec<_>>());
        let texts: Vec<&str> = found.iter().map(|one| one.formulas[0].text.as_str()).collect();
        assert_eq!(texts, ["90 deg - value * 0.9"]);
        assert_eq!(found[0].name, "gon and zenith");
    }
}
