//! Stamps as exact numbers, counted from a moment that all files of a campaign share.
//!
//! Seconds since 1970 with nine decimals, or nanoseconds of nineteen digits, have more digits than an
//! `f64`: the whole seconds of the shared moment are taken off before a stamp becomes one.

use crate::units::Unit;

/// Stamps below this (s) count from a moment near by: nothing is taken off.
const FAR: f64 = 1e8;
/// The shared moment is a multiple of so many seconds: runs of one campaign rarely differ in it, and
/// numbers up to it tell a tenth of a nanosecond apart.
const GRID: f64 = 1e6;
/// Decimals of a written stamp.
const DECIMALS: usize = 9;

/// The moment (s) from which the stamps of a campaign count whose first one is this.
pub(crate) fn zero(first: f64) -> i64 {
    if first.abs() < FAR || !first.is_finite() { 0 } else { ((first / GRID).floor() * GRID) as i64 }
}

/// A stamp in seconds since `zero`, as exact as a number can be; `None` for what is no plain decimal
/// number, or of a unit that is no decimal part of a second.
pub(crate) fn since(zero: i64, cell: &str, unit: &Unit) -> Option<f64> {
    let places = [(1.0, 0), (1e-3, 3), (1e-6, 6), (1e-9, 9)];
    let (_, unit_places) = places.into_iter().find(|(factor, _)| *factor == unit.factor)?;
    let (is_negative, digits) = match cell.strip_prefix('-') {
        Some(rest) => (true, rest),
        None => (false, cell.strip_prefix('+').unwrap_or(cell)),
    };
    let (whole, decimals) = digits.split_once(['.', ',']).unwrap_or((digits, ""));
    // More than fit exactly into the sums below.
    if whole.is_empty() || whole.len() > 22 || decimals.len() > 12 {
        return None;
    }
    let number = |text: &str| match text.bytes().all(|byte| byte.is_ascii_digit()) {
        true if text.is_empty() => Some(0),
        true => text.parse::<i128>().ok(),
        false => None,
    };
    let scale = 10_i128.pow(decimals.len() as u32);
    let ticks = number(whole)? * scale + number(decimals)?;
    let ticks = if is_negative { -ticks } else { ticks };
    let per_second = 10_i128.pow(unit_places) * scale;
    let left = ticks - i128::from(zero) * per_second;
    Some(left as f64 / per_second as f64)
}

/// A date with its time of day (ISO 8601: `2025-03-26T12:34:56.789Z`, with a blank for the `T`, with or
/// without zone, which is then UTC) in seconds since `zero`; `None` for anything else.
pub(crate) fn of_date(zero: i64, cell: &str) -> Option<f64> {
    let (date, rest) = cell.split_once(['T', 't', ' '])?;
    let digits = |text: &str| match text.bytes().all(|byte| byte.is_ascii_digit()) {
        true => text.parse::<i64>().ok(),
        false => None,
    };
    let mut parts = date.split('-');
    let [year, month, day] = [parts.next()?, parts.next()?, parts.next()?].map(digits);
    let (year, month, day) = (year?, month?, day?);
    let is_date = date.len() == 10 && (1..=12).contains(&month) && (1..=31).contains(&day);
    if !is_date || parts.next().is_some() {
        return None;
    }
    let (clock, offset) = match rest.find(['Z', 'z', '+', '-']) {
        None => (rest, 0),
        Some(at) if matches!(rest.as_bytes()[at], b'Z' | b'z') => {
            (rest.strip_suffix(['Z', 'z'])?, 0)
        }
        Some(at) => {
            let (hours, minutes) = match &rest[at + 1..] {
                zone if zone.contains(':') => zone.split_once(':')?,
                zone if zone.len() == 4 => zone.split_at(2),
                zone => (zone, "0"),
            };
            let seconds = 3600 * digits(hours)? + 60 * digits(minutes)?;
            (&rest[..at], if rest[at..].starts_with('-') { -seconds } else { seconds })
        }
    };
    let mut parts = clock.trim_end().splitn(3, ':');
    let (hour, minute) = (digits(parts.next()?)?, digits(parts.next()?)?);
    let (second, decimals) = match parts.next() {
        None => (0, ""),
        Some(text) => {
            let (whole, decimals) = text.split_once(['.', ',']).unwrap_or((text, ""));
            (digits(whole)?, decimals)
        }
    };
    if hour > 24 || minute > 59 || second > 60 || decimals.len() > 12 {
        return None;
    }
    let fraction = digits(decimals).filter(|_| !decimals.is_empty()).unwrap_or(0) as f64;
    if !decimals.is_empty() {
        digits(decimals)?;
    }
    // Days of the calendar since 1970, years beginning in March.
    let (year, month) = if month > 2 { (year, month - 3) } else { (year - 1, month + 9) };
    let era = year.div_euclid(400);
    let of_era = year - 400 * era;
    let of_year = (153 * month + 2) / 5 + day - 1;
    let days = 146_097 * era + 365 * of_era + of_era / 4 - of_era / 100 + of_year - 719_468;
    let whole = 86_400 * days + 3600 * hour + 60 * minute + second - offset - zero;
    Some(whole as f64 + fraction / 10_f64.powi(decimals.len() as i32))
}

/// A time (s) since `zero` as it is written in tables: to a nanosecond, or with all of its digits
/// where nothing is taken off.
pub fn written(zero: i64, time: f64) -> String {
    if zero == 0 || !time.is_finite() {
        return time.to_string();
    }
    let nanoseconds = (time * 1e9).round() as i128 + i128::from(zero) * 1_000_000_000;
    let (sign, size) = (if nanoseconds < 0 { "-" } else { "" }, nanoseconds.unsigned_abs());
    format!("{sign}{}.{:0DECIMALS$}", size / 1_000_000_000, size % 1_000_000_000)
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use super::*;

    #[test]
    fn dates_are_seconds_since_1970() {
        for (cell, seconds) in [
            ("1970-01-01T00:00:00Z", 0.0),
            ("2025-03-26T12:34:56.25Z", 1_742_992_496.25),
            ("2025-03-26 12:34:56,25", 1_742_992_496.25),
            ("2025-03-26T14:34:56.25+02:00", 1_742_992_496.25),
            ("2025-03-26T05:04:56.25-0730", 1_742_992_496.25),
            ("2024-02-29T00:00Z", 1_709_164_800.0),
            ("2000-03-01T00:00:00", 951_868_800.0),
            ("1969-12-31T23:59:59Z", -1.0),
        ] {
            assert_eq!(of_date(0, cell), Some(seconds), "{cell}");
        }
        // With all of their digits.
        let exact = of_date(1_742_000_000, "2025-03-26T12:34:56.123456789Z").unwrap();
        assert!((exact - 992_496.123_456_789).abs() < 1e-10, "{exact}");
        for cell in ["2025-13-26T00:00", "2025-03-26", "12:34:56", "2025-3-26T00:00", "", "1e5 3"] {
            assert_eq!(of_date(0, cell), None, "{cell}");
        }
    }

    #[test]
    fn stamps_of_many_digits_keep_them() {
        let zero = zero(1_403_715_524.9);
        assert_eq!(zero, 1_403_000_000);
        let unit = |symbol: &str| Unit::parse(symbol).unwrap();
        for (cell, symbol) in [
            ("1403715524907143168", "ns"),
            ("1403715524907143.168", "us"),
            ("1403715524907,143168", "ms"),
            ("1403715524.907143168", "s"),
            ("+1403715524.907143168000", "s"),
        ] {
            assert_eq!(since(zero, cell, &unit(symbol)), Some(715_524.907_143_168), "{cell}");
        }
        assert_eq!(since(zero, "1.4e9", &unit("s")), None);
        assert_eq!(since(zero, "24000000", &unit("min")), None);
        assert_eq!(since(0, "-0.25", &unit("s")), Some(-0.25));
        assert_eq!(written(zero, 715_524.907_143_168), "1403715524.907143168");
        assert_eq!(written(0, 0.1), "0.1");
        assert_eq!((super::zero(12.0), super::zero(-5e9)), (0, -5_000_000_000));
    }
}
