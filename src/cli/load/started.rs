//! The warning that a fit starts elsewhere than stated.

use crate::diagnostic::Diagnostic;
use crate::estimate::minima::{Found, MOST};
use crate::units::decimal;

/// Says that another start than the stated one was taken, of a problem with attitudes to look for or
/// without.
pub(super) fn started(found: &Found, has_attitudes: bool) -> Diagnostic {
    let [own, best] = found.variance_factors.map(|factor| decimal(factor, 1));
    let [from, to] = found.offsets;
    let tried = match to - from {
        // One offset, in several attitudes.
        0.0 if has_attitudes => {
            format!("tried was one offset, {} s, in {} attitudes", decimal(from, 1), found.tried)
        }
        0.0 => format!("tried was one offset, {} s", decimal(from, 1)),
        width => {
            let attitudes = if has_attitudes { " and several attitudes" } else { "" };
            let [from, to] = [from, to].map(|at| decimal(at, if width < 1.0 { 3 } else { 1 }));
            format!("tried were offsets from {from} to {to} s{attitudes}")
        }
    };
    let offset = decimal(found.offset, 3);
    let of = found.delay.as_ref().map(|delay| format!(" (`{delay}`)")).unwrap_or_default();
    let known = found.variance_factors[0].is_finite();
    let message = if let Some(most) = found.most {
        let [own, best] = most.map(|residual| decimal(residual, 1));
        format!(
            "the stated start fits badly; of {} others the one with clocks {offset} s apart{of} fits {} % of the samples far better (normalized residuals up to {best}, {own} from the stated start): the fit starts there",
            found.tried,
            decimal(100.0 * MOST, 0)
        )
    } else if known {
        format!(
            "the stated start fits badly (variance factor {own}); of {} others the one with clocks {offset} s apart{of} fits far better ({best}): the fit starts there",
            found.tried
        )
    } else {
        format!(
            "of {} starts within `delay_range` the one with clocks {offset} s apart{of} fits best (variance factor {best}): the fit starts there",
            found.tried
        )
    };
    let rotations = if has_attitudes { " and rotations" } else { "" };
    let mut warning = Diagnostic::warning(message).help(format!(
        "{tried}; state a `start` of delays{rotations}, or `delay_range`, to look elsewhere"
    ));
    if found.attitudes_left_out > 0 {
        warning = warning.help(format!(
            "{} combinations of attitudes were not tried, there are too many: state a `start` of those that are known",
            found.attitudes_left_out
        ));
    }
    if found.left_out > 0 {
        warning = warning.help(format!(
            "{} left out, for which no stream is there at this offset",
            match found.left_out {
                1 => "1 sample is".to_owned(),
                several => format!("{several} samples are"),
            }
        ));
    }
    warning
}
