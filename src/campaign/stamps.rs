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
/// The longest unit of stamps (s): the day.
const LONGEST_UNIT: f64 = 86_400.0;
/// Decimals of a written stamp.
const DECIMALS: usize = 9;

/// The moment (s) from which the stamps of a campaign count whose first one is this.
pub(crate) fn zero(first: f64) -> i64 {
    if first.abs() < FAR || !first.is_finite() { 0 } else { ((first / GRID).floor() * GRID) as i64 }
}

/// A time as an exact number: so many ticks, of which a second has a power of ten.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Exact {
    ticks: i128,
    per_second: i128,
}

impl Exact {
    /// No time.
    pub(crate) const ZERO: Self = Self { ticks: 0, per_second: 1 };

    /// Of whole seconds.
    pub(crate) fn seconds(count: i64) -> Self {
        Self { ticks: count.into(), per_second: 1 }
    }

    /// Of decimals of a second, so many.
    pub(crate) fn decimals(digits: i64, count: u32) -> Self {
        Self { ticks: digits.into(), per_second: 10_i128.pow(count) }
    }

    /// Of a plain decimal number; `None` for anything else, or of a unit that is neither a decimal part
    /// of a second nor whole seconds.
    pub(crate) fn of_number(cell: &str, unit: &Unit) -> Option<Self> {
        let places = [(1e-3, 3), (1e-6, 6), (1e-9, 9)];
        let part = places.into_iter().find(|(factor, _)| *factor == unit.factor);
        let is_whole = unit.factor.fract() == 0.0 && (1.0..=LONGEST_UNIT).contains(&unit.factor);
        let (unit_places, seconds) = match part {
            Some((_, places)) => (places, 1),
            None if is_whole => (0, unit.factor as i128),
            None => return None,
        };
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
        let ticks = seconds * if is_negative { -ticks } else { ticks };
        Some(Self { ticks, per_second: 10_i128.pow(unit_places) * scale })
    }

    /// The sum with another time; `None` where it has too many digits.
    pub(crate) fn plus(self, other: Self) -> Option<Self> {
        let per_second = self.per_second.max(other.per_second);
        let [own, other] =
            [self, other].map(|time| time.ticks.checked_mul(per_second / time.per_second));
        Some(Self { ticks: own?.checked_add(other?)?, per_second })
    }

    /// In seconds since `zero`, as exact as a number can be; `None` where it has too many digits.
    pub(crate) fn since(self, zero: i64) -> Option<f64> {
        let left = self.plus(Self { ticks: -i128::from(zero), per_second: 1 })?;
        Some(left.ticks as f64 / left.per_second as f64)
    }
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
    fn parts_of_a_stamp_are_added_with_all_of_their_digits() {
        let [s, ns] = ["s", "ns"].map(|symbol| Unit::parse(symbol).unwrap());
        let part = |cell: &str, unit: &Unit| Exact::of_number(cell, unit).unwrap();
        let sum = part("987654321", &ns).plus(part("1712345677", &s)).unwrap();
        assert_eq!(sum.since(1_712_000_000), Some(345_677.987_654_321));
        // More digits than can be added.
        let long = part(&"9".repeat(22), &s);
        assert_eq!((long.plus(part("0.000000000001", &ns)), long.since(0)), (None, Some(1e22)));
    }

    #[test]
    fn stamps_of_many_digits_keep_them() {
        let zero = zero(1_403_715_524.9);
        assert_eq!(zero, 1_403_000_000);
        let unit = |symbol: &str| Unit::parse(symbol).unwrap();
        let since = |zero, cell: &str, unit: &Unit| Exact::of_number(cell, unit)?.since(zero);
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
        // Unix time in minutes, and a Julian date to 86 ns.
        assert_eq!(since(zero, "24000000", &unit("min")), Some(37e6));
        let of_days = since(212_570_000_000, "2460395.123456789012", &unit("d"));
        assert_eq!(of_days, Some(8_138_666.666_570_637), "{of_days:?}");
        assert_eq!(since(0, "-0.25", &unit("s")), Some(-0.25));
        assert_eq!(written(zero, 715_524.907_143_168), "1403715524.907143168");
        assert_eq!(written(0, 0.1), "0.1");
        assert_eq!((super::zero(12.0), super::zero(-5e9)), (0, -5_000_000_000));
    }
}
