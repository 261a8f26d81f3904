//! How well a value is known, as a certificate states it (GUM, JCGM 100:2008, 4.3.3 and G.6.4).
//!
//! `sigma = "20 um"` is a standard uncertainty. `U = "40 um", k = 2` is an expanded one,
//! `u = U / k`. Either may say on how many degrees of freedom it rests; unless it does they are
//! infinite. No coverage factor is assumed: a `U` without its `k` is refused.

use crate::document::entries::{Entry, Reader, get};
use crate::units::Unit;

/// The keys with which a spread is stated.
pub(crate) const KEYS: [&str; 4] = ["sigma", "U", "k", "degrees_of_freedom"];

/// A standard uncertainty.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    /// Standard uncertainty (SI).
    pub sigma: f64,
    /// Degrees of freedom it rests on; `None`: known as if from infinitely many.
    pub degrees_of_freedom: Option<f64>,
}

/// What a table says of the uncertainty of `what`; `None` if it says nothing
/// or a fault was noted.
pub(crate) fn spread(
    reader: &mut Reader,
    entries: &[Entry],
    what: &str,
    like: &Unit,
) -> Option<Spread> {
    let coverage = coverage(reader, entries, what);
    let sigma = match (get(entries, "sigma"), get(entries, "U")) {
        (Some(item), _) => reader.positive_of(item, &format!("sigma of {what}"), like),
        (None, Some(item)) => {
            let expanded = reader.positive_of(item, &format!("U of {what}"), like);
            expanded.zip(coverage.factor).map(|(expanded, factor)| expanded / factor)
        }
        (None, None) => None,
    };
    Some(Spread { sigma: sigma?, degrees_of_freedom: coverage.degrees_of_freedom })
}

/// What stands beside `sigma` or `U`.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Coverage {
    /// `k`.
    pub(crate) factor: Option<f64>,
    pub(crate) degrees_of_freedom: Option<f64>,
}

/// Reads `k` and `degrees_of_freedom` and notes what does not fit together.
pub(crate) fn coverage(reader: &mut Reader, entries: &[Entry], what: &str) -> Coverage {
    let [sigma, expanded, factor, degrees] = KEYS.map(|key| get(entries, key));
    match (sigma, expanded, factor) {
        (Some(_), Some(item), _) => {
            let message = format!("{what} has two uncertainties, `sigma` and `U`");
            reader.fault(item.span, message, "keep one: sigma = U / k");
        }
        (_, Some(item), None) => {
            let message = format!("the coverage factor of {what} is not stated");
            reader.fault(item.span, message, "write it beside U: k = 2");
        }
        (_, None, Some(item)) => {
            let message = format!("{what} has a coverage factor, but no expanded uncertainty");
            reader.fault(item.span, message, "`k` belongs to `U`; `sigma` has none");
        }
        _ => {}
    }
    if let (Some(item), None, None) = (degrees, sigma, expanded) {
        let message = format!("{what} has degrees of freedom, but no uncertainty");
        reader.fault(item.span, message, "state `sigma`, or `U` with its `k`");
    }
    let mut number = |item: Option<&_>, name: &str, least: f64| {
        let item = item?;
        let value = reader.number(item, name)?;
        if value < least || (least == 0.0 && value == 0.0) {
            let bound =
                if least == 0.0 { "greater than zero".into() } else { format!("at least {least}") };
            reader.fault(item.span, format!("{name} of {what} must be {bound}"), "");
            return None;
        }
        Some(value)
    };
    Coverage {
        factor: number(factor, "k", 0.0),
        degrees_of_freedom: number(degrees, "degrees_of_freedom", 1.0),
    }
}
