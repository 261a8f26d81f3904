//! The stamps of a table: which column they are, or which columns make them together.

use crate::campaign::begin::candidate::{Candidate, base};
use crate::campaign::begin::stamp_column::{MOSTLY_IN_ORDER, column, goes_on};
use crate::campaign::begin::survey::{Survey, Surveyed};
use crate::campaign::calendar::Calendar;
use crate::campaign::endings::{self, ending};
use crate::campaign::formats::{Role, unit_since_1970};
use crate::units::{Dimension, Unit};

/// The stamps of a table.
#[derive(Clone, Debug)]
pub(super) struct Stamps {
    /// The columns that are added: most often one.
    pub(super) parts: Vec<Candidate>,
    /// The stamp of each row.
    pub(super) values: Vec<f64>,
    pub(super) unit: Unit,
    /// Whether they are dates or times of day: of two columns the first holds the dates.
    pub(super) is_dated: bool,
}

impl Stamps {
    /// Of a table: whole seconds with their decimals; else numbers that are called stamps and whose unit
    /// is known; else dates and times of day; else other numbers in order.
    pub(super) fn of(survey: &Survey) -> Option<Self> {
        let all = &survey.columns;
        if let Some((at, symbol)) = (1..all.len()).find_map(|at| Some((at, decimals(all, at)?))) {
            return Self::sum(
                survey,
                [(at - 1, "s"), (at, symbol)],
                "whole seconds, and their decimals",
            );
        }
        if let Some(of_format) = of_format(survey) {
            return Some(of_format);
        }
        let found = column(survey);
        let number = |column: Candidate| {
            let values = all[column.column].values.clone();
            Self { unit: column.unit.clone(), parts: vec![column], values, is_dated: false }
        };
        match found {
            Some((column, true)) => Some(number(column)),
            Some((column, false)) => Some(Self::dated(survey).unwrap_or_else(|| number(column))),
            None => Self::dated(survey),
        }
    }

    /// Dates with their times of day in one column or in two, or times of day alone, if they go on.
    fn dated(survey: &Survey) -> Option<Self> {
        let all = || survey.columns.iter().enumerate();
        let are = |is: fn(&Calendar) -> bool| -> Vec<usize> {
            let own = all().filter(|(_, column)| column.calendar.as_ref().is_some_and(is));
            own.map(|(at, _)| at).collect()
        };
        let moments = are(|own| matches!(own, Calendar::Moment(_)));
        let days = are(|own| matches!(own, Calendar::Day(_)));
        let clocks = are(|own| matches!(own, Calendar::Clock(_)));
        let one = |at: usize, why: &str| {
            let part =
                Candidate { column: at, unit: Unit::second(), why: format!("stamps: {why}") };
            let values = survey.columns[at].values.clone();
            Some(Self { parts: vec![part], values, unit: Unit::second(), is_dated: true })
        };
        let pairs = days.iter().flat_map(|day| {
            let beside = clocks.iter().filter(move |clock| **clock == day + 1);
            beside.chain(&clocks).map(move |clock| [(*day, "s"), (*clock, "s")])
        });
        let pairs = pairs.filter_map(|pair| {
            let sum = Self::sum(survey, pair, "a date and a time of day")?;
            Some(Self { is_dated: true, ..sum })
        });
        let alone = clocks.iter().filter(|_| days.is_empty());
        let mut ways = moments
            .iter()
            .filter_map(|at| one(*at, "dates"))
            .chain(pairs)
            .chain(alone.filter_map(|at| one(*at, "times of day")));
        ways.find(|stamps| goes_on(&stamps.values, MOSTLY_IN_ORDER))
    }

    /// Two columns that are added, each with its unit.
    fn sum(survey: &Survey, columns: [(usize, &str); 2], why: &str) -> Option<Self> {
        let [whole, part] = columns.map(|(column, symbol)| {
            let unit = Unit::parse(symbol).ok()?;
            Some(Candidate { column, unit, why: format!("stamps: {why}") })
        });
        let parts = [whole?, part?];
        let si = |part: &Candidate| -> Vec<f64> {
            let values = survey.columns[part.column].values.iter();
            values.map(|value| part.unit.to_si(*value)).collect()
        };
        let sums = si(&parts[0]).into_iter().zip(si(&parts[1])).map(|(whole, part)| whole + part);
        let values = sums.collect();
        Some(Self { parts: parts.to_vec(), values, unit: Unit::second(), is_dated: false })
    }

    /// Whether a column is part of the stamps.
    pub(super) fn has(&self, column: usize) -> bool {
        self.parts.iter().any(|part| part.column == column)
    }

    /// The first and the last stamp (s).
    pub(super) fn span(&self) -> Option<[f64; 2]> {
        let all = || self.values.iter().copied().filter(|value| value.is_finite());
        let (first, last) = (all().reduce(f64::min)?, all().reduce(f64::max)?);
        Some([first, last].map(|value| value * self.unit.factor))
    }
}

/// The one column of numbers that the format of the file says are the stamps.
fn of_format(survey: &Survey) -> Option<Stamps> {
    let format = survey.format?;
    let names: Vec<&str> = survey.columns.iter().map(|column| column.name.as_str()).collect();
    let own = survey.columns.get(format.place(Role::Time(0), &names)?)?;
    let is_alone =
        format.place(Role::Time(1), &names).is_none() && own.is_named && own.calendar.is_none();
    let at = survey.columns.iter().position(|column| std::ptr::eq(column, own))?;
    let why = format!("stamps of the format `{}`", format.name);
    let first = own.values.first().copied().unwrap_or(0.0);
    let since = unit_since_1970(first).and_then(|symbol| Unit::parse(symbol).ok());
    let unit = own.unit.clone().or(since).unwrap_or_else(|| format.unit(Role::Time(0)));
    let part = Candidate { column: at, unit: unit.clone(), why };
    let values = own.values.clone();
    is_alone.then(|| Stamps { parts: vec![part], values, unit, is_dated: false })
}

/// The unit of a column of decimals of the whole seconds since 1970 in the column before it.
fn decimals(all: &[Surveyed], at: usize) -> Option<&'static str> {
    let (seconds, part) = (&all[at - 1], &all[at]);
    let finite = |column: &Surveyed| {
        column.values.iter().copied().filter(|v| v.is_finite()).collect::<Vec<_>>()
    };
    let (whole, parts) = (finite(seconds), finite(part));
    let are_whole = |values: &[f64]| values.iter().all(|value| value.fract() == 0.0);
    if whole.is_empty() || parts.is_empty() || !are_whole(&whole) || !are_whole(&parts) {
        return None;
    }
    // `stamp_s` and `stamp_ns`: names that differ in their unit alone.
    let are_alike = base(&seconds.name).0 == base(&part.name).0;
    let by_ending = ending(&part.name).filter(|_| are_alike);
    let known = by_ending.or_else(|| endings::decimals(&base(&part.name).0));
    let symbol = if part.is_named { known? } else { "ns" };
    let unit = Unit::parse(symbol).ok().filter(|unit| unit.dimension == Dimension::TIME)?;
    let count = 1.0 / unit.factor;
    let most = parts.iter().copied().fold(0.0, f64::max);
    // Numbers of rows are smaller than most decimals.
    let are_decimals = parts.iter().all(|part| (0.0..count).contains(part)) && most > 0.1 * count;
    let are_seconds = whole.iter().all(|stamp| unit_since_1970(*stamp) == Some("s"));
    (are_decimals && are_seconds).then_some(symbol)
}
