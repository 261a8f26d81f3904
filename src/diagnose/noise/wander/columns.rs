//! A walk written as columns of the model: in its own place a sum of sines, with a prior each if
//! its size is known.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::Arc;

use crate::diagnose::library::candidate::Candidate;
use crate::diagnostic::Source;
use crate::effect::Effect;
use crate::formula::Formula;
use crate::system::Selected;
use crate::units::{Dimension, Exponent, Unit};

use super::course::{Column, Course, Times};

/// A walk that takes a course, as columns in its own place.
pub(super) fn select(
    candidate: &Candidate,
    times: &Times,
    course: Course,
    sigma: Option<f64>,
) -> Option<Selected> {
    let Selected { effect, head, .. } = &candidate.selected;
    let effect = Arc::new(columns(effect, times, course, sigma)?);
    Some(Selected { effect, head: head.clone(), member: BTreeMap::new() })
}

/// An effect of random walks that take a course as columns, with a prior if a size is given.
fn columns(effect: &Effect, times: &Times, course: Course, sigma: Option<f64>) -> Option<Effect> {
    let name = format!("{}_columns", effect.name);
    let mut text = format!(
        "name = \"{name}\"\ntitle = \"{}\"\nacts = \"noise\"\n[parameters]\n",
        effect.title
    );
    let mut sums: Vec<(&str, String)> = Vec::new();
    for parameter in &effect.parameters {
        let dimension = parameter.unit.dimension * Dimension::TIME.pow(Exponent::new(1, 2)?);
        let unit = Unit::coherent(dimension).si_symbol();
        let mut sum = Vec::new();
        for Column { name, scope, wave, deviation } in times.columns(course) {
            let own = format!("{}_{name}", parameter.name);
            let prior = sigma.map_or_else(String::new, |sigma| {
                let sigma = (sigma * deviation).max(f64::MIN_POSITIVE);
                format!(", value = \"0 {unit}\", sigma = \"{sigma:e} {unit}\"")
            });
            let line = writeln!(
                text,
                "{own} = {{ unit = \"{unit}\", typical = \"1 {unit}\", scope = \"{scope}\"{prior} }}"
            );
            line.ok()?;
            sum.push(format!("{own}{wave}"));
        }
        sums.push((&parameter.name, format!("({})", sum.join(" + "))));
    }
    text.push_str("[patch]\n");
    for line in &effect.patches {
        let formula = replaced(&line.formula, &sums);
        writeln!(text, "\"{}\" = '{formula}'", line.name).ok()?;
    }
    Effect::parse(Source::new(name, text)).ok()
}

/// A formula's text with some of its names replaced.
fn replaced(formula: &Formula, by: &[(&str, String)]) -> String {
    let (mut made, mut at) = (String::new(), 0);
    for (name, span) in formula.root.names() {
        if let Some((_, sum)) = by.iter().find(|(known, _)| *known == name) {
            made.push_str(&formula.text[at..span.start]);
            made.push_str(sum);
            at = span.end;
        }
    }
    made + &formula.text[at..]
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use super::*;

    #[test]
    fn names_are_replaced_as_wholes_and_units_are_not() {
        let by = [("walk", "(a + b)".to_owned()), ("s", "(c)".to_owned())];
        let of = |text| replaced(&Formula::parse_text("test", text).unwrap(), &by);
        let made = of("position + [walk, 2 * walk_y, -walk]");
        assert_eq!(made, "position + [(a + b), 2 * walk_y, -(a + b)]");
        assert_eq!(of("walk / 5 s * s"), "(a + b) / 5 s * (c)");
    }
}
