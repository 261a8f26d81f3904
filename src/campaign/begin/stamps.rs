//! The stamps of a table: which column they are, or which columns make them together.

use crate::campaign::begin::candidate::{Candidate, base, unit};
use crate::campaign::begin::survey::{Survey, Surveyed};
use crate::campaign::endings::{self, ending};
use crate::campaign::formats::unit_since_1970;
use crate::campaign::stamps::Calendar;
use crate::units::{Dimension, Unit};

/// In so many pairs of rows a column of stamps goes on.
const IN_ORDER: f64 = 0.99;
/// ... where its name or its size says that it is one: rows may be out of order.
const MOSTLY_IN_ORDER: f64 = 0.75;
/// Names of the numbers of rows.
const NUMBERS: [&str; 9] = ["i", "n", "no", "nr", "id", "row", "index", "number", "count"];
/// Names of stamps.
const TIMES: [&str; 7] = ["t", "time", "stamp", "timestamp", "clock", "seconds", "sec"];

/// The stamps of a table.
#[derive(Clone, Debug)]
pub(super) struct Stamps {
    /// The columns that are added: most often one.
    pub(super) parts: Vec<Candidate>,
    /// The stamp of each row.
    pub(super) values: Vec<f64>,
    pub(super) unit: Unit,
    /// Whether the first column holds dates, and the one beside it the times of day.
    pub(super) is_dated: bool,
}

impl Stamps {
    /// Of a table: whole seconds with their decimals, else numbers in order, best those that are called
    /// so.
    pub(super) fn of(survey: &Survey) -> Option<Self> {
        let all = &survey.columns;
        if let Some((at, symbol)) = (1..all.len()).find_map(|at| Some((at, decimals(all, at)?))) {
            return Self::sum(survey, at, ["s", symbol], false);
        }
        let column = column(survey)?;
        let is = |at: usize, day: bool| match all[at].calendar {
            Some(Calendar::Day(_)) => day,
            Some(Calendar::Clock(_)) => !day,
            _ => false,
        };
        if column.column > 0 && is(column.column - 1, true) && is(column.column, false) {
            return Self::sum(survey, column.column, ["s", "s"], true);
        }
        let values = all[column.column].values.clone();
        Some(Self { unit: column.unit.clone(), parts: vec![column], values, is_dated: false })
    }

    /// A column and the one before it, which are added.
    fn sum(survey: &Survey, at: usize, symbols: [&str; 2], is_dated: bool) -> Option<Self> {
        let [whole, part] = symbols.map(|symbol| Unit::parse(symbol).ok());
        let units = [whole?, part?];
        let columns = [at - 1, at];
        let values = |k: usize| {
            let unit = units[k].clone();
            survey.columns[columns[k]].values.iter().map(move |value| unit.to_si(*value))
        };
        let why = match is_dated {
            true => "stamps: a date, and the time of day beside it",
            false => "stamps: whole seconds, and their decimals",
        };
        let part = |k: usize| Candidate {
            column: columns[k],
            unit: units[k].clone(),
            why: why.to_owned(),
        };
        let sums = values(0).zip(values(1)).map(|(whole, part)| whole + part);
        Some(Self {
            parts: vec![part(0), part(1)],
            values: sums.collect(),
            unit: Unit::second(),
            is_dated,
        })
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

/// The column of stamps: numbers in order, best one that is called so.
fn column(survey: &Survey) -> Option<Candidate> {
    let is_called = |column: &Surveyed| {
        let base = base(&column.name).0;
        let parts: Vec<&str> = base.split(['.', '_', ' ']).collect();
        TIMES.iter().any(|name| parts.contains(name))
    };
    let first = |column: &Surveyed| column.values.first().copied().unwrap_or(0.0);
    let in_order = |column: &Surveyed| {
        let steps: Vec<f64> = column.values.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let on = steps.iter().filter(|step| **step >= 0.0).count();
        let rises = steps.iter().filter(|step| **step > 0.0).count();
        let is_said = is_called(column) || unit_since_1970(first(column)).is_some();
        let least = if is_said { MOSTLY_IN_ORDER } else { IN_ORDER };
        on as f64 >= least * steps.len() as f64 && 2 * rises > steps.len() && !steps.is_empty()
    };
    let names = survey.columns.iter().enumerate();
    let candidates: Vec<(usize, &Surveyed)> =
        names.filter(|(_, column)| in_order(column)).collect();
    let called = candidates.iter().find(|(_, column)| is_called(column));
    let has_unit = |(_, column): &&(usize, &Surveyed)| {
        let unit = column.unit.clone().or(base(&column.name).1);
        unit.is_some_and(|unit| unit.dimension == Dimension::TIME)
    };
    // Numbers of rows, of stops or of frames: each is one more than the last.
    let counts = |column: &Surveyed| {
        let is_next = |pair: &[f64]| pair[1] - pair[0] == 1.0 && pair[0].fract() == 0.0;
        column.is_named && column.values.windows(2).all(is_next)
    };
    let is_no_number_of_rows = |(_, column): &&(usize, &Surveyed)| {
        !NUMBERS.contains(&base(&column.name).0.as_str()) && !counts(column)
    };
    let (column, own) = called
        .or_else(|| candidates.iter().find(has_unit))
        .or_else(|| candidates.iter().find(is_no_number_of_rows))?;
    let since = unit_since_1970(first(own));
    let usual = since.unwrap_or_else(|| by_steps(&own.values));
    let what = if called.is_some() { "stamps" } else { "numbers in order, taken for stamps" };
    let (unit, why) = unit(own, usual, what);
    let why = match (why.as_str(), since) {
        ("", _) => why,
        (_, Some(since)) => format!("{what}; as large as {since} since 1970"),
        _ => why,
    };
    let unit = since.and_then(|since| Unit::parse(since).ok()).unwrap_or(unit);
    Some(Candidate { column: *column, unit, why })
}

/// The unit of stamps by how far apart they are: whole numbers far apart are no seconds.
fn by_steps(values: &[f64]) -> &'static str {
    let mut steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.retain(|step| step.is_finite() && *step > 0.0);
    let middle = steps.len() / 2;
    if steps.is_empty() {
        return "s";
    }
    let step = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
    let is_whole = values.iter().all(|value| value.fract() == 0.0 || value.is_nan());
    match (is_whole, step) {
        (true, step) if step >= 5e5 => "ns",
        (true, step) if step >= 500.0 => "us",
        (true, step) if step >= 1.0 => "ms",
        _ => "s",
    }
}
