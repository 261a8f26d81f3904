//! Blocks as effects: their text, from what they are over and what they change.

use std::sync::Arc;

use crate::diagnostic::Source;
use crate::effect::Effect;
use crate::units::{Dimension, Unit};

use super::covariate::Covariate;
use crate::diagnose::library::place::{Of, Place};

/// A block as an effect, and where it sits.
pub(super) type Block = (Arc<Effect>, Place);

/// Blocks of what is wrong, with a phrase for that, over each of some covariates: the sum of
/// coefficients times terms, put into a patch. `unit` is that of the error: one of an angle is in rad.
pub(super) fn blocks_over(
    of: &Of,
    what: &str,
    covariates: &[Covariate],
    unit: &Unit,
    patch: impl Fn(&str) -> String,
) -> Vec<Block> {
    let (kind, wrong) = match of {
        Of::Measurand(name) => ("reading", name),
        Of::Channel(name) => ("channel", name),
    };
    let over = |Covariate { name, over, words, terms, orders, scope, family }: &Covariate| {
        let words = format!("{what} over {words}");
        let place = Place { orders: *orders, ..Place::new(of.clone(), over, words) };
        let (mut coefficients, mut sum) = (Vec::new(), Vec::new());
        for (number, (term, of)) in terms.iter().enumerate() {
            let own = match unit.is_angle() && *of == Dimension::NONE {
                true => unit.clone(),
                false => Unit::coherent(unit.dimension / *of),
            };
            coefficients.push((format!("part_{number}"), own));
            sum.push(format!("part_{number} * {term}"));
        }
        let name = format!("unknown_{kind}_{wrong}_{name}");
        made(&name, &place, (&coefficients, scope), family, &patch(&sum.join(" + ")))
    };
    covariates.iter().filter_map(over).collect()
}

/// An effect of unknown structure: coefficients with their units and scope, the line of its
/// family, if it has one, and its patches.
pub(super) fn made(
    name: &str,
    place: &Place,
    (coefficients, scope): (&[(String, Unit)], &str),
    family: &str,
    patches: &str,
) -> Option<Block> {
    let name = called(name);
    let mut text =
        format!("name = \"{name}\"\ntitle = \"{}\"\nacts = \"noise\"\n[parameters]\n", place.words);
    for (coefficient, unit) in coefficients {
        let unit = unit.si_symbol();
        text.push_str(&format!(
            "{coefficient} = {{ unit = \"{unit}\", typical = \"1 {unit}\", scope = \"{scope}\" }}\n"
        ));
    }
    let shape = if family.is_empty() { "" } else { "[shape]\n" };
    text.push_str(&format!("[patch]\n{patches}\n{shape}{family}\n"));
    let effect = Effect::parse(Source::new(name, text));
    debug_assert!(effect.is_ok(), "{effect:?}");
    Some((Arc::new(effect.ok()?), place.clone()))
}

/// Letters of a block's name at most; effects may have 64.
const LONGEST: usize = 60;

/// A name that an effect may have, the same each time: a long one's beginning and a number for it all.
fn called(name: &str) -> String {
    let plain: Vec<char> =
        name.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect();
    if plain.len() <= LONGEST {
        return plain.into_iter().collect();
    }
    // FNV-1a: the standard library promises no hash that is the same each time.
    let number = name.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    });
    let beginning: String = plain.into_iter().take(LONGEST - 17).collect();
    format!("{beginning}_{number:016x}")
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use super::*;

    /// An error of an angle is one, whatever the input is stated in.
    #[test]
    fn errors_of_angles_are_in_radians() {
        let unit = Unit::parse("deg").unwrap();
        let terms = vec![("cos(joint)".to_owned(), Dimension::NONE)];
        let of = Of::Channel("input joint".to_owned());
        let patch = |sum: &str| format!("joint = 'joint + {sum}'");
        let covariate = Covariate::new("joint", terms);
        let all = blocks_over(&of, "an error of the input `joint`", &[covariate], &unit, patch);
        assert_eq!(all[0].0.parameters[0].unit.symbol, "rad");
    }
}
