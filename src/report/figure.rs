//! A value with its standard uncertainty as people write it: the uncertainty to two significant
//! digits, the value to the same place, each in a unit in which it is easy to read.

use crate::units::{Dimension, Unit};

/// Significant digits of an uncertainty.
const DIGITS: i32 = 2;

/// Units that people read, from large to small, by dimension.
fn ladder(dimension: Dimension) -> &'static [(&'static str, f64)] {
    if dimension == Dimension::TIME {
        &[("s", 1.0), ("ms", 1e-3), ("µs", 1e-6), ("ns", 1e-9)]
    } else if dimension == Dimension::LENGTH {
        &[("m", 1.0), ("mm", 1e-3), ("µm", 1e-6), ("nm", 1e-9)]
    } else {
        &[]
    }
}

/// The unit of a ladder in which a size lies between 1 and 1000 (or the smallest).
fn readable(size: f64, declared: &Unit) -> (String, f64) {
    let steps = ladder(declared.dimension);
    steps
        .iter()
        .find(|(_, factor)| size.abs() >= *factor)
        .or(steps.last())
        .map_or_else(|| (declared.symbol.clone(), declared.factor), |(s, f)| ((*s).to_owned(), *f))
}

/// The value in its own readable unit, to the place of its uncertainty (or 6 digits without one).
pub fn value(value: f64, sigma: Option<f64>, declared: &Unit) -> String {
    if !value.is_finite() {
        return "not determined".to_owned();
    }
    let size = value.abs().max(sigma.unwrap_or(0.0));
    let (symbol, factor) = readable(if size == 0.0 { 1.0 } else { size }, declared);
    let scaled = value / factor;
    let decimals = match sigma {
        Some(sigma) if sigma > 0.0 && sigma.is_finite() => decimals(sigma / factor),
        _ => (6 - magnitude(scaled)).clamp(0, 12) as usize,
    };
    with_symbol(format!("{scaled:.decimals$}"), &symbol)
}

/// An uncertainty in its own readable unit, to two digits.
pub fn uncertainty(sigma: f64, declared: &Unit) -> String {
    if sigma == 0.0 {
        return "fixed".to_owned();
    }
    if !sigma.is_finite() {
        return "not determined".to_owned();
    }
    let (symbol, factor) = readable(sigma, declared);
    let scaled = sigma / factor;
    let text = if (1e-4..1e6).contains(&scaled) {
        format!("{scaled:.*}", decimals(scaled))
    } else {
        format!("{scaled:.1e}")
    };
    with_symbol(text, &symbol)
}

/// `value ± uncertainty` in one unit.
pub fn measured(amount: f64, sigma: f64, declared: &Unit) -> String {
    let (symbol, factor) = readable(amount.abs().max(sigma), declared);
    let places = decimals(sigma / factor);
    let pair = format!("{:.places$} ± {:.places$}", amount / factor, sigma / factor);
    with_symbol(pair, &symbol)
}

fn with_symbol(number: String, symbol: &str) -> String {
    if symbol == "1" { number } else { format!("{number} {symbol}") }
}

fn magnitude(number: f64) -> i32 {
    if number == 0.0 { 0 } else { number.abs().log10().floor() as i32 + 1 }
}

/// Decimals at which `sigma` has two significant digits.
fn decimals(sigma: f64) -> usize {
    (DIGITS - magnitude(sigma)).clamp(0, 15) as usize
}

/// A number to `digits` significant digits, for snapshots and tables.
pub fn sig(number: f64, digits: usize) -> String {
    if number == 0.0 || !number.is_finite() {
        return format!("{number}");
    }
    format!("{number:.*e}", digits.saturating_sub(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_read_as_people_write_them() {
        let second = Unit::coherent(Dimension::TIME);
        let metre = Unit::coherent(Dimension::LENGTH);
        assert_eq!(measured(1.30554e-4, 4.2e-7, &second), "130.55 ± 0.42 µs");
        assert_eq!(value(3.065095880, Some(1.2e-5), &metre), "3.065096 m");
        assert_eq!(uncertainty(1.2e-5, &metre), "12 µm");
        assert_eq!(uncertainty(0.0, &metre), "fixed");
        assert_eq!(value(0.0, None, &metre), "0.000000 m");
        assert_eq!(value(f64::NAN, None, &metre), "not determined");
        assert_eq!(value(0.123456, Some(0.00012), &Unit::one()), "0.12346");
    }
}
