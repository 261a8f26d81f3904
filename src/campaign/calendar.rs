//! Cells with dates, times of day or both, as loggers and instruments write them.

use crate::campaign::date::{Date, DateOrder, is_digit, is_number_of};
use crate::campaign::stamps::Exact;

/// What a message says of the forms that are read.
pub(crate) const FORMS: &str = "dates are read as `2026-11-28`, `28.11.2026`, `11/28/2026`, `28-Nov-2026` or `Nov 28 2026`, times of day as `07:11:30.125`, with or without `AM` or `PM`, `Z` or `+02:00`";

/// No zone is farther from UTC (h).
const MOST_HOURS: i64 = 14;

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

/// A date, a time of day or both, with or without zone, which is then UTC; `None` for anything else,
/// and for a date that can be read in several orders where none is known.
pub(crate) fn calendar(cell: &str, order: Option<DateOrder>) -> Option<Calendar> {
    let (date, clock) = split(cell)?;
    let day = |date: &str| Some(Exact::seconds(86_400 * Date::of(date)?.day(order)?));
    match (date, clock) {
        (date, None) => day(date).map(Calendar::Day),
        // Two numbers alone may be minutes and seconds.
        ("", Some(text)) if text.matches(':').count() > 1 || text.ends_with(['m', 'M', '.']) => {
            self::clock(text).map(Calendar::Clock)
        }
        ("", Some(_)) => None,
        (date, Some(text)) => {
            // `Sat Nov 28 07:11:30 2026`
            let behind = text.rsplit_once(' ').filter(|(_, year)| is_number_of(year, 4..=4));
            let (date, text) = match behind {
                Some((text, year)) => (day(&format!("{date} {year}")), text),
                None => (day(date), text),
            };
            date?.plus(self::clock(text)?).map(Calendar::Moment)
        }
    }
}

/// The same of a date in any order: what a cell seems to be.
pub(crate) fn seeming(cell: &str) -> Option<Calendar> {
    let orders = DateOrder::ALL.into_iter().map(Some);
    [None].into_iter().chain(orders).find_map(|order| calendar(cell, order))
}

/// Whether a cell has the form of a date that the calendar does not have.
pub(crate) fn is_no_day(cell: &str) -> bool {
    let date = split(cell).map_or(cell, |(date, _)| date);
    Date::of(date).is_some() && seeming(date).is_none()
}

/// The date in a cell, if it can be read in several orders by its form.
pub(crate) fn open_date(cell: &str) -> Option<&str> {
    let (date, _) = split(cell)?;
    let is_open = Date::of(date)?.is_open();
    is_open.then_some(date)
}

/// A date and a time of day, as far as a cell has them.
fn split(cell: &str) -> Option<(&str, Option<&str>)> {
    let Some(colon) = cell.find(':') else { return Some((cell, None)) };
    let date = cell[..colon].trim_end_matches(|c: char| c.is_ascii_digit());
    let clock = &cell[date.len()..];
    let bare = date.strip_suffix(['T', 't']).filter(|bare| bare.ends_with(is_digit));
    let is_apart = date.is_empty() || bare.is_some() || date.ends_with([' ', ',']);
    is_apart.then(|| (bare.unwrap_or(date).trim_end_matches([' ', ',']), Some(clock)))
}

fn digits(text: &str) -> Option<i64> {
    match text.chars().all(is_digit) {
        true => text.parse::<i64>().ok(),
        false => None,
    }
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

/// A text without one of these endings, in capitals or not.
fn without<'a>(text: &'a str, endings: &[&str]) -> Option<&'a str> {
    endings.iter().find_map(|ending| {
        let (bare, own) = text.split_at_checked(text.len().checked_sub(ending.len())?)?;
        own.eq_ignore_ascii_case(ending).then(|| bare.trim_end())
    })
}

/// A time of day since midnight of UTC.
fn clock(text: &str) -> Option<Exact> {
    let text = text.trim_end();
    let (before_noon, after_noon) =
        (without(text, &["am", "a.m."]), without(text, &["pm", "p.m."]));
    let bare = before_noon.or(after_noon);
    let text = bare.or(without(text, &["z", "utc", "gmt"])).unwrap_or(text);
    let (clock, offset) = match text.find(['+', '-']) {
        None => (text, 0),
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
            // Behind a colon three digits are milliseconds; two may be frames.
            let by_colon = text.split_once(':').filter(|(_, rest)| rest.len() == 3);
            let parts = by_colon.or_else(|| text.split_once(['.', ',']));
            let (whole, decimals) = parts.unwrap_or((text, ""));
            (digits(whole)?, decimals)
        }
    };
    let hour = match (before_noon, after_noon) {
        (None, None) => hour,
        _ if !(1..=12).contains(&hour) => return None,
        (Some(_), _) => hour % 12,
        (None, Some(_)) => hour % 12 + 12,
    };
    if hour > 24 || minute > 59 || second > 60 || decimals.len() > 12 {
        return None;
    }
    let fraction = if decimals.is_empty() { 0 } else { digits(decimals)? };
    Exact::seconds(3600 * hour + 60 * minute + second - offset)
        .plus(Exact::decimals(fraction, decimals.len() as u32))
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use super::*;

    /// A date with its time of day in seconds since `zero`; `None` for anything else.
    fn of_date(zero: i64, cell: &str) -> Option<f64> {
        match calendar(cell, None)? {
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
            ("2025.03.26 12:34:56.25", 1_742_992_496.25),
            ("2025-3-26T12:34:56.25", 1_742_992_496.25),
            ("26.03.2025 12:34:56,25", 1_742_992_496.25),
            ("26.3.25, 12:34:56.25 PM", 1_742_992_496.25),
            ("26-Mar-2025 12:34:56.25", 1_742_992_496.25),
            ("26-MAR-25 12:34:56.25 UTC", 1_742_992_496.25),
            ("Mar 26 2025 12:34:56.25 pm", 1_742_992_496.25),
            ("Wednesday, March 26, 2025 12:34:56.25", 1_742_992_496.25),
            ("Wed Mar 26 12:34:56.25 2025", 1_742_992_496.25),
            ("26. März 2025 12:34:56,25", 1_742_992_496.25),
            ("26.03.2025 12:34:56:250", 1_742_992_496.25),
            ("26.03.2025 12:00:00 AM", 1_742_947_200.0),
            ("26.03.2025 1:00:00 a.m.", 1_742_950_800.0),
        ] {
            assert_eq!(of_date(0, cell), Some(seconds), "{cell}");
        }
        // With all of their digits.
        let exact = of_date(1_742_000_000, "2025-03-26T12:34:56.123456789Z").unwrap();
        assert!((exact - 992_496.123_456_789).abs() < 1e-10, "{exact}");
        for cell in [
            "2025-13-26T00:00",
            "2025-02-29T00:00",
            "31.04.2025 00:00",
            "2025-03-26",
            "12:34:56",
            "2025/03-26T00:00",
            "26/03/2025 0:0",
            "26.03.2025 13:00:00 PM",
            "26.03.2025 0:00:00 AM",
            "26 March 0:00:00",
            "26 March May 2025 0:00:00",
            "26 Marchy 2025 0:00:00",
            "26.03.2025 1:00:00 CET",
            "26.03.2025 1:00:00:25",
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
            assert_eq!(seeming(cell), None, "{cell}");
        }
    }

    #[test]
    fn a_date_and_a_time_of_day_are_added_with_all_of_their_digits() {
        let part = |cell| calendar(cell, None);
        let Some(Calendar::Day(day)) = part("2025/03/26") else { unreachable!() };
        let Some(Calendar::Clock(clock)) = part("12:34:56.123456789") else { unreachable!() };
        let sum = day.plus(clock).unwrap();
        assert_eq!(sum.since(1_742_000_000), Some(992_496.123_456_789));
        assert_eq!(sum.since(0), of_date(0, "2025-03-26T12:34:56.123456789"));
        for same in ["2025/3/26", "26.03.2025", "26 Mar 2025"] {
            assert_eq!(part(same), Some(Calendar::Day(day)), "{same}");
        }
        assert!(matches!(part("12:34 PM"), Some(Calendar::Clock(_))));
        for cell in ["12:34", "25:00:00", "7", "1.5", "1.2.345", "192.168.1.1"] {
            assert_eq!(seeming(cell), None, "{cell}");
        }
    }

    #[test]
    fn a_date_of_an_open_order_is_read_in_the_order_that_is_stated() {
        use DateOrder::{DayFirst, MonthFirst, YearFirst};
        let is = |cell: &str, order, due: &str| {
            assert_eq!(calendar(cell, None), None, "{cell}");
            assert!(matches!(seeming(cell), Some(Calendar::Day(_))), "{cell}");
            assert_eq!(calendar(cell, Some(order)), calendar(due, None), "{cell}");
        };
        is("07/03/2024", DayFirst, "2024-03-07");
        is("7-3-2024", MonthFirst, "2024-07-03");
        is("24/03/07", YearFirst, "2024-03-07");
        is("07/03/99", DayFirst, "1999-03-07");
        assert_eq!(calendar("07/03/2024", Some(YearFirst)), None);
        assert_eq!(calendar("13/03/2024", Some(MonthFirst)), None);
        // Points stand between day, month and year, unless another order is stated.
        assert_eq!(calendar("03.07.2024", Some(MonthFirst)), calendar("2024-03-07", None));
        assert_eq!(open_date("07/03/2024 12:00:00"), Some("07/03/2024"));
        for known in ["2024/03/07", "07.03.2024", "7 Mar 2024", "12:00:00", "7"] {
            assert_eq!(open_date(known), None, "{known}");
        }
    }
}
