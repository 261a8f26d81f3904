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
/// No zone is farther from UTC (h).
const MOST_HOURS: i64 = 14;
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

    fn seconds(count: i64) -> Self {
        Self { ticks: count.into(), per_second: 1 }
    }

    /// Of a plain decimal number; `None` for anything else, or of a unit that is no decimal part of a
    /// second.
    pub(crate) fn of_number(cell: &str, unit: &Unit) -> Option<Self> {
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

/// What a cell of stamps holds that is no number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Calendar {
    /// A date with its time of day.
    Moment(Exact),
    /// A date alone.
    Day(Exact),
    /// A time of day alone.
    Clock(Exact),
}

/// A date (`2025-03-26`, `2025/03/26`), a time of day (`12:34:56.789`) or both, between them a `T` or
/// a blank, with or without zone, which is then UTC (ISO 8601); `None` for anything else.
pub(crate) fn calendar(cell: &str) -> Option<Calendar> {
    let Some((date, rest)) = cell.split_once(['T', 't', ' ']) else {
        return match day(cell) {
            Some(day) => Some(Calendar::Day(Exact::seconds(day))),
            None if cell.matches(':').count() > 1 => clock(cell).map(Calendar::Clock),
            None => None,
        };
    };
    Exact::seconds(day(date)?).plus(clock(rest.trim_start())?).map(Calendar::Moment)
}

fn digits(text: &str) -> Option<i64> {
    match text.bytes().all(|byte| byte.is_ascii_digit()) {
        true => text.parse::<i64>().ok(),
        false => None,
    }
}

/// Seconds from 1970 to the beginning of a date.
fn day(date: &str) -> Option<i64> {
    let mark = if date.contains('/') { '/' } else { '-' };
    let mut parts = date.split(mark);
    let [year, month, day] = [parts.next()?, parts.next()?, parts.next()?].map(digits);
    let (year, month, day) = (year?, month?, day?);
    let is_date = date.len() == 10 && date.as_bytes().get(4) == Some(&(mark as u8));
    let is_date = is_date && (1..=12).contains(&month) && (1..=31).contains(&day);
    if !is_date || parts.next().is_some() {
        return None;
    }
    // Days of the calendar since 1970, years beginning in March.
    let (year, month) = if month > 2 { (year, month - 3) } else { (year - 1, month + 9) };
    let era = year.div_euclid(400);
    let of_era = year - 400 * era;
    let of_year = (153 * month + 2) / 5 + day - 1;
    let days = 146_097 * era + 365 * of_era + of_era / 4 - of_era / 100 + of_year - 719_468;
    Some(86_400 * days)
}

/// The distance (s) of a zone from UTC: `02`, `0730` or `05:30`.
fn zone(text: &str) -> Option<i64> {
    let (hours, minutes) = match text.split_once(':') {
        Some(parts) => parts,
        None if text.len() == 4 => text.split_at_checked(2)?,
        None => (text, "0"),
    };
    let (hours, minutes) = (digits(hours)?, digits(minutes)?);
    (hours <= MOST_HOURS && minutes <= 59).then_some(3600 * hours + 60 * minutes)
}

/// A time of day since midnight of UTC.
fn clock(text: &str) -> Option<Exact> {
    let (clock, offset) = match text.find(['Z', 'z', '+', '-']) {
        None => (text, 0),
        Some(at) if matches!(text.as_bytes()[at], b'Z' | b'z') => {
            (text.strip_suffix(['Z', 'z'])?, 0)
        }
        Some(at) => {
            let seconds = zone(&text[at + 1..])?;
            (&text[..at], if text[at..].starts_with('-') { -seconds } else { seconds })
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
    let fraction = if decimals.is_empty() { 0 } else { digits(decimals)? };
    let fraction = Exact { ticks: fraction.into(), per_second: 10_i128.pow(decimals.len() as u32) };
    Exact::seconds(3600 * hour + 60 * minute + second - offset).plus(fraction)
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

    /// A date with its time of day in seconds since `zero`; `None` for anything else.
    fn of_date(zero: i64, cell: &str) -> Option<f64> {
        match calendar(cell)? {
            Calendar::Moment(moment) => moment.since(zero),
            _ => None,
        }
    }

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
            ("2025/03/26 12:34:56.25", 1_742_992_496.25),
            ("2025/03/26  12:34:56.25", 1_742_992_496.25),
        ] {
            assert_eq!(of_date(0, cell), Some(seconds), "{cell}");
        }
        // With all of their digits.
        let exact = of_date(1_742_000_000, "2025-03-26T12:34:56.123456789Z").unwrap();
        assert!((exact - 992_496.123_456_789).abs() < 1e-10, "{exact}");
        for cell in [
            "2025-13-26T00:00",
            "2025-03-26",
            "12:34:56",
            "2025-3-26T00:00",
            "2025/03-26T00:00",
            "26/03/2025 0:0",
            "",
            "1e5 3",
            "é",
            "2025-03-26T12:34:56+15:00",
            "2025-03-26T12:34:56+02:60",
            "2025-03-26T12:34:56+9223372036854775807",
        ] {
            assert_eq!(of_date(0, cell), None, "{cell}");
        }
        for cell in ["-5°C", "+1µm", "a-1µs", "12:00:00+aé1", "12:00:00+aé", "1:2:3-é"] {
            assert_eq!(calendar(cell), None, "{cell}");
        }
    }

    #[test]
    fn parts_of_a_stamp_are_added_with_all_of_their_digits() {
        let [s, ns] = ["s", "ns"].map(|symbol| Unit::parse(symbol).unwrap());
        let part = |cell: &str, unit: &Unit| Exact::of_number(cell, unit).unwrap();
        let sum = part("987654321", &ns).plus(part("1712345677", &s)).unwrap();
        assert_eq!(sum.since(1_712_000_000), Some(345_677.987_654_321));
        let day = Exact::seconds(day("2025/03/26").unwrap());
        let clock = clock("12:34:56.123456789").unwrap();
        assert_eq!(calendar("2025/03/26"), Some(Calendar::Day(day)));
        assert_eq!(calendar("12:34:56.123456789"), Some(Calendar::Clock(clock)));
        let sum = day.plus(clock).unwrap();
        assert_eq!(sum.since(1_742_000_000), Some(992_496.123_456_789));
        assert_eq!(Some(sum.since(0)), Some(of_date(0, "2025-03-26T12:34:56.123456789")));
        for cell in ["12:34", "2025/3/26", "26.03.2025", "25:00:00", "7"] {
            assert_eq!(calendar(cell), None, "{cell}");
        }
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
        assert_eq!(since(zero, "24000000", &unit("min")), None);
        assert_eq!(since(0, "-0.25", &unit("s")), Some(-0.25));
        assert_eq!(written(zero, 715_524.907_143_168), "1403715524.907143168");
        assert_eq!(written(0, 0.1), "0.1");
        assert_eq!((super::zero(12.0), super::zero(-5e9)), (0, -5_000_000_000));
    }
}
