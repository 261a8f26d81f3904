//! A date, as loggers and instruments write it.
//!
//! It can be read in one way where its year of four digits comes first, where it has points, or the
//! name of its month. Others (`07/03/2024`) can be read in several orders of day, month and year: the
//! campaign states the order, or the column decides (`date_order`).

/// Years of two digits below this are of this century.
const LAST_CENTURY: i64 = 70;

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

/// The number of a date since 1970, as it is read in an order.
pub(crate) fn day_in(date: &str, order: DateOrder) -> Option<i64> {
    Date::of(date)?.day(Some(order))
}

/// The parts of a date.
pub(crate) enum Date {
    /// Year, month and day.
    Known([i64; 3]),
    /// Three numbers as they are written, the digits of the first and the last one, and the order in
    /// which they are read where none is stated.
    Numbers { parts: [i64; 3], digits: [usize; 2], usual: Option<DateOrder> },
}

impl Date {
    /// Of a text; `None` where it is no date.
    pub(crate) fn of(text: &str) -> Option<Self> {
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

    /// Whether it can be read in several orders by its form.
    pub(crate) fn is_open(&self) -> bool {
        matches!(self, Self::Numbers { usual: None, .. })
    }

    /// Its number since 1970; `None` for a day that the calendar does not have.
    pub(crate) fn day(&self, order: Option<DateOrder>) -> Option<i64> {
        let [year, month, day] = match *self {
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

/// A day since 1970 as a date.
pub(crate) fn written(days: i64) -> String {
    // Years that begin in March, in eras of 400.
    let days = days + 719_468;
    let (era, of_era) = (days.div_euclid(146_097), days.rem_euclid(146_097));
    let of = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * of + of / 4 - of / 100);
    let march = (5 * of_year + 2) / 153;
    let day = of_year - (153 * march + 2) / 5 + 1;
    let month = if march < 10 { march + 3 } else { march - 9 };
    let year = of + 400 * era + i64::from(month <= 2);
    format!("{year:04}-{month:02}-{day:02}")
}

/// Whether it is one of ASCII.
pub(crate) fn is_digit(c: char) -> bool {
    c.is_ascii_digit()
}

/// Whether a text is a number of so many digits.
pub(crate) fn is_number_of(text: &str, digits: std::ops::RangeInclusive<usize>) -> bool {
    digits.contains(&text.len()) && text.chars().all(is_digit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_are_written_as_they_are_read() {
        for date in ["1970-01-01", "2000-02-29", "2024-03-07", "1999-12-31", "2100-03-01"] {
            let day = day_in(date, DateOrder::DayFirst);
            assert_eq!(day.map(written).as_deref(), Some(date));
        }
    }
}
