//! A value with its standard uncertainty as people write it: the uncertainty to two significant
//! digits, the value to the same place, each in a unit in which it is easy to read.
//!
//! A value and a difference are not the same where a unit has an offset: a temperature of 293.15 K
//! is 20 degC, its uncertainty of 0.5 K is no temperature at all. [`value`], [`exact`] and
//! [`measured`] take values; [`size`] and [`uncertainty`] take differences, in K.

use crate::units::{Dimension, LONG, Unit, decimal};

/// Significant digits of an uncertainty.
const DIGITS: i32 = 2;

/// Rates (per second) below it are read by the hour.
const SLOW: f64 = 1e-6;

/// Numbers below it are written with an exponent.
const SHORT: f64 = 1e-4;

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

/// Sizes in a declared unit that are read in it.
const READABLE: std::ops::Range<f64> = 1e-6..1e9;

/// The unit of a ladder in which a size lies between 1 and 1000 (or the smallest); of quotients and
/// powers, and without a ladder, the one of [`unit_for`].
fn readable(size: f64, declared: &Unit) -> Unit {
    let is_plain = !declared.symbol.contains(['/', '*', '^', ' ', '·']);
    // Who declares mm or ms wants to read it, unless the figure would be too long; m and s are SI.
    let is_readable = READABLE.contains(&(size.abs() / declared.factor));
    let is_plain = is_plain && (matches!(declared.symbol.as_str(), "m" | "s") || !is_readable);
    let steps = if is_plain { ladder(declared.dimension) } else { &[] };
    if steps.is_empty() {
        return unit_for(size, declared);
    }
    let step = steps.iter().find(|(_, factor)| size.abs() >= *factor).or(steps.last());
    step.map_or_else(
        || declared.clone(),
        |(symbol, factor)| Unit {
            symbol: (*symbol).into(),
            factor: *factor,
            offset: 0.0,
            dimension: declared.dimension,
        },
    )
}

/// The value in its own readable unit, to the place of its uncertainty (or 6 digits without one).
pub fn value(value: f64, sigma: Option<f64>, declared: &Unit) -> String {
    if !value.is_finite() {
        return "not determined".to_owned();
    }
    let size = value.abs().max(sigma.unwrap_or(0.0));
    let unit = readable(if size == 0.0 { 1.0 } else { size }, declared);
    let scaled = unit.from_si(value);
    let decimals = match sigma {
        Some(sigma) if sigma > 0.0 && sigma.is_finite() => decimals(sigma / unit.factor),
        _ => (6 - magnitude(scaled)).clamp(0, 12) as usize,
    };
    with_symbol(decimal(scaled, decimals), &unit.symbol)
}

/// A number that has no uncertainty, as it is declared, to nine digits without trailing zeros.
pub fn exact(value: f64, declared: &Unit) -> String {
    let scaled = declared.from_si(value);
    let text = if scaled == 0.0 || (1.0 / LONG..LONG).contains(&scaled.abs()) {
        format!("{scaled:.8e}").parse().unwrap_or(scaled).to_string()
    } else if scaled.is_finite() {
        format!("{scaled:.3e}")
    } else {
        "-".to_owned()
    };
    with_symbol(text, &declared.symbol)
}

/// An uncertainty in its own readable unit, to two digits.
pub fn uncertainty(sigma: f64, declared: &Unit) -> String {
    if sigma == 0.0 { "fixed".to_owned() } else { size(sigma, declared) }
}

/// An uncertainty in the unit in which [`value`] writes its value, to two digits.
pub fn uncertainty_of(value: f64, sigma: f64, declared: &Unit) -> String {
    let fits = value.is_finite() && sigma.is_finite() && sigma != 0.0 && declared.offset == 0.0;
    if !fits {
        return uncertainty(sigma, declared);
    }
    let unit = readable(value.abs().max(sigma), declared);
    let scaled = sigma / unit.factor;
    with_symbol(decimal(scaled, decimals(scaled)), &unit.symbol)
}

/// How large a difference is (a root mean square, a scatter), in its own readable unit, to two
/// digits.
pub fn size(size: f64, declared: &Unit) -> String {
    let declared = declared.of_differences();
    let unit = if size == 0.0 { declared } else { readable(size, &declared) };
    size_in(size, &unit)
}

/// Sizes of one quantity, all in the unit in which the smallest is read.
pub fn sizes<const N: usize>(sizes: [Option<f64>; N], declared: &Unit) -> [String; N] {
    let declared = declared.of_differences();
    let some = sizes.iter().flatten().copied().filter(|size| *size > 0.0 && size.is_finite());
    let unit = some.reduce(f64::min).map_or(declared.clone(), |least| readable(least, &declared));
    sizes.map(|size| size.map_or_else(|| "-".to_owned(), |size| size_in(size, &unit)))
}

/// A size in this unit, to two digits.
fn size_in(size: f64, unit: &Unit) -> String {
    if !size.is_finite() {
        return "not determined".to_owned();
    }
    if size == 0.0 {
        return with_symbol("0".to_owned(), &unit.symbol);
    }
    let scaled = size / unit.factor;
    let text = if (SHORT..1e6).contains(&scaled) {
        format!("{scaled:.*}", decimals(scaled))
    } else {
        format!("{scaled:.1e}")
    };
    with_symbol(text, &unit.symbol)
}

/// `value ± uncertainty` in one unit.
pub fn measured(amount: f64, sigma: f64, declared: &Unit) -> String {
    if sigma == 0.0 {
        return format!("{} (fixed)", value(amount, None, declared));
    }
    if !amount.is_finite() {
        return "not determined".to_owned();
    }
    if !sigma.is_finite() {
        return format!("{} (uncertainty not determined)", value(amount, None, declared));
    }
    let unit = readable(amount.abs().max(sigma), declared);
    let places = decimals(sigma / unit.factor);
    let (amount, sigma) = (unit.from_si(amount), sigma / unit.factor);
    let size = amount.abs().max(sigma);
    if size < SHORT {
        // Units that take no prefix, such as m³/s.
        let exponent = size.log10().floor() as i32;
        let (by, places) = (10.0_f64.powi(-exponent), decimals(sigma * 10.0_f64.powi(-exponent)));
        let pair = format!("({} ± {})", decimal(amount * by, places), decimal(sigma * by, places));
        return with_symbol(format!("{pair}e{exponent}"), &unit.symbol);
    }
    let pair = format!("{} ± {}", decimal(amount, places), decimal(sigma, places));
    with_symbol(pair, &unit.symbol)
}

/// The unit in which a size is read: a small one in ppm for 1, µrad for rad, µm/h for m/s and µrad/m/h
/// for rad/m/s, µs/(rad/s) for s/(rad/s), others as declared.
fn unit_for(size: f64, declared: &Unit) -> Unit {
    let symbol = declared.symbol.as_str();
    let base = symbol.strip_suffix("/s").filter(|base| !base.ends_with("/s"));
    let rate = base.is_some_and(takes_prefix);
    let size = (size / declared.factor).abs();
    if size >= 1e-3 || size == 0.0 || !size.is_finite() {
        return declared.clone();
    }
    let symbol = match base.filter(|_| rate).unwrap_or(symbol) {
        "1" => "ppm".to_owned(),
        base if rate && size < SLOW => format!("µ{base}/h"),
        _ if takes_prefix(symbol) => format!("µ{symbol}"),
        _ => return declared.clone(),
    };
    let same = |unit: &Unit| unit.dimension == declared.dimension;
    Unit::parse(&symbol).ok().filter(same).unwrap_or_else(|| declared.clone())
}

/// Whether a unit begins with metres, radians or seconds to the first power.
fn takes_prefix(symbol: &str) -> bool {
    ["m", "rad", "s"].into_iter().any(|base| {
        symbol
            .strip_prefix(base)
            .is_some_and(|rest| rest.is_empty() || rest.starts_with(['/', '*', ' ']))
    })
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
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use super::*;

    #[test]
    fn figures_read_as_people_write_them() {
        let second = Unit::coherent(Dimension::TIME);
        let metre = Unit::coherent(Dimension::LENGTH);
        assert_eq!(measured(1.30554e-4, 4.2e-7, &second), "130.55 ± 0.42 µs");
        assert_eq!(value(3.065095880, Some(1.2e-5), &metre), "3.065096 m");
        assert_eq!(exact(99_999.0, &metre), "99999 m");
        assert_eq!(exact(-std::f64::consts::PI / 180.0, &Unit::parse("deg").unwrap()), "-1 deg");
        assert_eq!(uncertainty(1.2e-5, &metre), "12 µm");
        assert_eq!(uncertainty(0.0, &metre), "fixed");
        assert_eq!(size(0.0, &Unit::parse("mm").unwrap()), "0 mm");
        assert_eq!(size(f64::INFINITY, &metre), "not determined");
        assert_eq!(measured(1.1, f64::NAN, &metre), "1.10000 m (uncertainty not determined)");
        assert_eq!(measured(f64::NAN, 1.0, &metre), "not determined");
        assert_eq!(value(0.0, None, &metre), "0.000000 m");
        assert_eq!(value(f64::NAN, None, &metre), "not determined");
        assert_eq!(value(0.123456, Some(0.00012), &Unit::one()), "0.12346");
    }

    #[test]
    fn temperatures_are_values_and_their_uncertainties_are_differences() {
        let celsius = Unit::parse("degC").unwrap();
        assert_eq!(value(293.15, Some(0.5), &celsius), "20.00 degC");
        assert_eq!(value(293.15, None, &celsius), "20.0000 degC");
        assert_eq!(measured(293.15, 0.5, &celsius), "20.00 ± 0.50 degC");
        assert_eq!(measured(293.15, 0.0, &celsius), "20.0000 degC (fixed)");
        assert_eq!(exact(273.15, &celsius), "0 degC");
        assert_eq!(uncertainty(0.5, &celsius), "0.50 K");
        assert_eq!(size(0.5, &celsius), "0.50 K");
    }

    #[test]
    fn no_figure_is_longer_than_people_read() {
        let metre = Unit::coherent(Dimension::LENGTH);
        for huge in [1e15, 1e150, -1e300, f64::MAX, f64::MIN_POSITIVE, 1e-300] {
            for sigma in [huge.abs(), 1.0, f64::MIN_POSITIVE] {
                for unit in [&metre, &Unit::one(), &Unit::parse("ns").unwrap()] {
                    let all = [
                        value(huge, Some(sigma), unit),
                        value(huge, None, unit),
                        exact(huge, unit),
                        measured(huge, sigma, unit),
                        size(sigma, unit),
                    ];
                    for text in all {
                        assert!(text.len() < 60, "{text}");
                        assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
                    }
                }
            }
        }
    }

    #[test]
    fn small_sizes_have_units_in_which_they_are_read() {
        let shown = |size: f64, sigma: f64, symbol: &str| {
            measured(size, sigma, &Unit::parse(symbol).unwrap())
        };
        assert_eq!(shown(-2.073e-5, 6.7e-7, "rad"), "-20.73 ± 0.67 µrad");
        assert_eq!(shown(1.25, 0.01, "rad"), "1.250 ± 0.010 rad");
        assert_eq!(shown(1.966e-6, 3.7e-8, "m/(rad/s)^2"), "1.966 ± 0.037 µm/(rad/s)^2");
        assert_eq!(shown(1.996e-6, 1.1e-8, "m/rad"), "1.996 ± 0.011 µm/rad");
        assert_eq!(shown(4e-6, 2e-7, "s^2"), "(4.00 ± 0.20)e-6 s^2");
        assert_eq!(shown(2e-9, 1e-10, "rad/s"), "7.20 ± 0.36 µrad/h");
        assert_eq!(shown(2e-5, 1e-6, "m/s"), "20.0 ± 1.0 µm/s");
        assert_eq!(shown(-7e-12, 2.2e-11, "rad/m/s"), "-0.025 ± 0.079 µrad/m/h");
        assert_eq!(shown(2e-5, 1e-6, "rad/m"), "20.0 ± 1.0 µrad/m");
        // A rate of decay is no part of a million a second.
        assert_eq!(shown(-4e-5, 2e-6, "1/s"), "(-4.00 ± 0.20)e-5 1/s");
        assert_eq!(shown(3e-9, 5e-10, "ppm/h"), "10.8 ± 1.8 ppm/h");
        assert_eq!(shown(-4e-5, 2e-6, "1"), "-40.0 ± 2.0 ppm");
        assert_eq!(shown(4.712389e-5, 7.853982e-6, "mgon"), "3.00 ± 0.50 mgon");
        assert_eq!(shown(0.0, 0.5, "rad"), "0.00 ± 0.50 rad");
        assert_eq!(shown(25.3e-6, 0.0, "s"), "25.3000 µs (fixed)");
    }

    #[test]
    fn sizes_of_one_quantity_have_one_unit() {
        let shown =
            |all: [f64; 3], symbol: &str| sizes(all.map(Some), &Unit::parse(symbol).unwrap());
        assert_eq!(shown([5e-3, 1.1e-5, 2.4e-5], "1"), ["5000 ppm", "11 ppm", "24 ppm"]);
        assert_eq!(shown([0.02, 4e-5, 0.0], "1/s"), ["0.020 1/s", "4.0e-5 1/s", "0 1/s"]);
        assert_eq!(sizes([Some(2e-3), None], &Unit::one()), ["0.0020", "-"]);
    }
}
