//! Sums of parameters, and why a fit is no result, in words.

use crate::estimate::combination::Combination;
use crate::estimate::refused::{Outside, Refused};
use crate::units::decimal;

/// Why a fit that settled is no result, in a sentence.
pub(crate) fn refused(one: &Refused) -> String {
    match one {
        Refused::Worse { effects, chi_squared: [with, without] } => {
            let names: Vec<String> = effects.iter().map(|name| format!("`{name}`")).collect();
            let it = if names.len() == 1 { "it" } else { "them" };
            format!(
                "with {} the fit is worse than without {it} (chi squared {} against {}), which no solution is, and from the solution without {it} it finds no better one. State a `start`, or leave {it} out.",
                names.join(", "),
                decimal(*with, 1),
                decimal(*without, 1)
            )
        }
        Refused::OutsideRange { delay, value, range } => format!(
            "`{delay}` ends at {} s, outside the stated `delay_range` (from {} to {} s). State a `start` for it, or a larger `delay_range`.",
            decimal(*value, 4),
            bound(range[0]),
            bound(range[1])
        ),
        Refused::OutsideStreams(Outside { delay, of, value, counts: [outside, all] }) => format!(
            "`{delay}`{} ends at {} s, where {outside} of {all} readings lie outside their streams, or in gaps of them. State a `start` for it, or a `delay_range`; a reading in a wrong unit may lead it there, too.",
            of.as_ref().map_or_else(String::new, |of| format!(" of `{of}`")),
            decimal(*value, 4)
        ),
    }
}

/// Smaller factors are written with an exponent.
const SMALL: f64 = 0.01;

fn bound(value: f64) -> String {
    decimal(value, 4).trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A factor, with enough digits that a small one is no zero.
fn size(factor: f64) -> String {
    if factor < SMALL {
        return format!("{factor:.3e}");
    }
    bound(factor)
}

/// `` `a` + 2.5 m/s `b` ``.
pub(crate) fn terms(sum: &Combination) -> String {
    let mut text = String::new();
    for ((name, factor), unit) in sum.terms.iter().zip(&sum.factor_units) {
        let sign = match (text.is_empty(), *factor < 0.0) {
            (true, _) => "",
            (false, true) => " - ",
            (false, false) => " + ",
        };
        let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
        let size = size(factor.abs());
        let by =
            if size == "1" && unit.is_empty() { String::new() } else { format!("{size}{unit} ") };
        text.push_str(&format!("{sign}{by}`{name}`"));
    }
    text
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use super::*;
    use crate::units::Unit;

    #[test]
    fn a_small_factor_is_no_zero() {
        let of = |factor: f64| {
            terms(&Combination {
                terms: vec![("a".to_owned(), 1.0), ("b".to_owned(), factor)],
                factor_units: vec!["1".to_owned(), "1/s".to_owned()],
                value: 0.0,
                sigma: 1.0,
                declared: Unit::parse("1").unwrap(),
            })
        };
        assert_eq!(of(1.293e-8), "`a` + 1.293e-8 1/s `b`");
        assert_eq!(of(-2.5), "`a` - 2.5 1/s `b`");
    }
}
