//! Sums of parameters, and why a fit is no result, in words.

use crate::estimate::calibrate::Refused;
use crate::estimate::combination::Combination;
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
    }
}

fn bound(value: f64) -> String {
    decimal(value, 4).trim_end_matches('0').trim_end_matches('.').to_owned()
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
        let size = decimal(factor.abs(), 4);
        let size = size.trim_end_matches('0').trim_end_matches('.');
        let by =
            if size == "1" && unit.is_empty() { String::new() } else { format!("{size}{unit} ") };
        text.push_str(&format!("{sign}{by}`{name}`"));
    }
    text
}
