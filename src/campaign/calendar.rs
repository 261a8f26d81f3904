//! Dates and times of day, as loggers and instruments write them.
//!
//! A date can be read in one way where its year of four digits comes first, where it has points, or
//! the name of its month. Others (`07/03/2024`) can be read in several orders of day, month and year:
//! the campaign states the order, or the column decides (`dates`).

use crate::campaign::stamps::Exact;

/// What a message says of the forms that are read.
pub(crate) const FORMS: &str = "dates are read as `2026-11-28`, `28.11.2026`, `11/28/2026`, `28-Nov-2026` or `Nov 28 2026`, times of day as `07:11:30.125`, with or without `AM` or `PM`, `Z` or `+02:00`";

/// No zone is farther from UTC (h).
const MOST_HOURS: i64 = 14;
/// Years of two digits below this are of this century.
const LAST_CENTURY: i64 = 70;

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

/// The order of the parts of a date.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DateOrder {
    /// `28/11/2026`
    DayFirst,
    /// `11/28/2026`
    MonthFirst,
    /// `26/11/28`
    YearFirst,
}

impl DateOrder {
    /// All of them.
    pub(crate) const ALL: [Self; 3] = [Self::DayFirst, Self::MonthFirst, Self::YearFirst];

    /// As a campaign states it.
    pub(crate) fn words(self) -> &'static str {
        match self {
            Self::DayFirst => "day/month/year",
            Self::MonthFirst => "month/day/year",
            Self::YearFirst => "year/month/day",
        }
    }

    /// The order that a campaign states.
    pub(crate) fn of(text: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|order| order.words() == text)
    }
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

/// The date in a cell, if it can be read in several orders by its form.
pub(crate) fn open_date(cell: &str) -> Option<&str> {
    let (date, _) = split(cell)?;
    let is_open = matches!(Date::of(date)?, Date::Numbers { usual: None, .. });
    is_open.then_some(date)
}

/// The number of a date since 1970, as it is read in an order.
pub(crate) fn day_in(date: &str, order: DateOrder) -> Option<i64> {
    Date::of(date)?.day(Some(order))
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

/// The parts of a date.
enum Date {
    /// Year, month and day.
    Known([i64; 3]),
    /// Three numbers as they are written, the digits of the first and the last one, and the order in
    /// which they are read where none is stated.
    Numbers { parts: [i64; 3], digits: [usize; 2], usual: Option<DateOrder> },
}

impl Date {
    fn of(text: &str) -> Option<Self> {
        if text.contains(char::is_alphabetic) {
            return named(text);
        }
        let mark = text.chars().find(|c| !c.is_ascii_digit())?;
        let mut all = text.split(mark);
        let parts = [all.next()?, all.next()?, all.next()?];
        let is_date = matches!(mark, '-' | '/' | '.')
            && all.next().is_none()
            && is_number_of(parts[0], 1..=4)
            && is_number_of(parts[1], 1..=2)
            && is_number_of(parts[2], 1..=4);
        let digits = [parts[0].len(), parts[2].len()];
        let [first, middle, last] = parts.map(|part| part.parse().ok());
        let numbers = [first?, middle?, last?];
        match digits {
            _ if !is_date => None,
            [4, 1 | 2] => Some(Self::Known(numbers)),
            [1 | 2, 2 | 4] => {
                let usual = (mark == '.').then_some(DateOrder::DayFirst);
                Some(Self::Numbers { parts: numbers, digits, usual })
            }
            _ => None,
        }
    }

    /// Its number since 1970; `None` for a day that the calendar does not have.
    fn day(self, order: Option<DateOrder>) -> Option<i64> {
        let [year, month, day] = match self {
            Self::Known(date) => date,
            Self::Numbers { parts: [first, middle, last], digits, usual } => {
                match order.or(usual)? {
                    DateOrder::DayFirst => [whole_year(last, digits[1])?, middle, first],
                    DateOrder::MonthFirst => [whole_year(last, digits[1])?, first, middle],
                    DateOrder::YearFirst if digits == [2, 2] => {
                        [whole_year(first, digits[0])?, middle, last]
                    }
                    DateOrder::YearFirst => return None,
                }
            }
        };
        let is_leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
        let days = match month {
            4 | 6 | 9 | 11 => 30,
            2 if is_leap => 29,
            2 => 28,
            _ => 31,
        };
        let is_date = (1..=12).contains(&month) && (1..=days).contains(&day);
        is_date.then(|| since_1970(year, month, day))
    }
}

/// The year of so many digits.
fn whole_year(year: i64, digits: usize) -> Option<i64> {
    match digits {
        4 => Some(year),
        2 if year < LAST_CENTURY => Some(2000 + year),
        2 => Some(1900 + year),
        _ => None,
    }
}

/// Names of months, in English and in German.
const MONTHS: [&[&str]; 12] = [
    &["jan", "january", "januar"],
    &["feb", "february", "februar"],
    &["mar", "march", "mär", "mrz", "märz"],
    &["apr", "april"],
    &["may", "mai"],
    &["jun", "june", "juni"],
    &["jul", "july", "juli"],
    &["aug", "august"],
    &["sep", "sept", "september"],
    &["oct", "october", "okt", "oktober"],
    &["nov", "november"],
    &["dec", "december", "dez", "dezember"],
];
const WEEKDAYS: [&str; 7] = ["mon", "tue", "wed", "thu", "fri", "sat", "sun"];

/// A date with the name of its month, with or without day of the week.
fn named(text: &str) -> Option<Date> {
    let mut month = None;
    let mut numbers: Vec<&str> = Vec::new();
    for (place, part) in
        text.split(['-', '/', '.', ',', ' ']).filter(|part| !part.is_empty()).enumerate()
    {
        let small = part.to_lowercase();
        if is_number_of(part, 1..=4) {
            numbers.push(part);
        } else if let Some(at) = MONTHS.iter().position(|names| names.contains(&small.as_str())) {
            if month.replace(at as i64 + 1).is_some() {
                return None;
            }
        } else if place > 0 || !WEEKDAYS.iter().any(|day| small.starts_with(day)) {
            return None;
        }
    }
    let [first, last] = numbers.as_slice() else { return None };
    let (year, day) = if first.len() == 4 { (first, last) } else { (last, first) };
    let [whole, day] = [year.parse().ok()?, day.parse().ok()?];
    Some(Date::Known([whole_year(whole, year.len())?, month?, day]))
}

/// Days of the calendar since 1970, years beginning in March.
fn since_1970(year: i64, month: i64, day: i64) -> i64 {
    let (year, month) = if month > 2 { (year, month - 3) } else { (year - 1, month + 9) };
    let era = year.div_euclid(400);
    let of_era = year - 400 * era;
    let of_year = (153 * month + 2) / 5 + day - 1;
    146_097 * era + 365 * of_era + of_era / 4 - of_era / 100 + of_year - 719_468
}

fn is_digit(c: char) -> bool {
    c.is_ascii_digit()
}

fn is_number_of(text: &str, digits: std::ops::RangeInclusive<usize>) -> bool {
    digits.contains(&text.len()) && text.chars().all(is_digit)
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
