//! Which column of numbers are the stamps: one that is called so, else numbers in order that do not
//! merely count the rows.

use crate::campaign::begin::candidate::{Candidate, base, unit};
use crate::campaign::begin::survey::{Survey, Surveyed};
use crate::campaign::formats::unit_since_1970;
use crate::units::{Dimension, Unit};

/// In so many pairs of rows a column of stamps goes on.
const IN_ORDER: f64 = 0.99;
/// ... where its name or its size says that it is one: rows may be out of order.
pub(super) const MOSTLY_IN_ORDER: f64 = 0.75;
/// Names of the numbers of rows, or parts of such names.
const NUMBERS: [&str; 20] = [
    "i", "n", "no", "nr", "id", "row", "index", "number", "count", "counter", "seq", "sequence",
    "packet", "frame", "sample", "shot", "point", "pt", "punkt", "paket",
];
/// In so many pairs of rows a number of rows is one more: some rows may be lost.
const ONE_MORE: f64 = 0.8;
/// Names of stamps, or parts of such names.
const TIMES: [&str; 9] =
    ["t", "time", "stamp", "timestamp", "clock", "seconds", "sec", "zeit", "uhrzeit"];
/// What parts a name.
const PARTS: [char; 7] = ['.', '_', ' ', '-', '/', '(', '%'];

fn is_called(column: &Surveyed, names: &[&str]) -> bool {
    let base = base(&column.name).0;
    let mut parts = base.split(PARTS).map(|part| part.trim_end_matches([')', ':', '#']));
    parts.any(|part| names.contains(&part))
}

/// Whether so many of the steps between values are none back, and most of them go on.
pub(super) fn goes_on(values: &[f64], least: f64) -> bool {
    let steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let on = steps.iter().filter(|step| **step >= 0.0).count();
    let rises = steps.iter().filter(|step| **step > 0.0).count();
    on as f64 >= least * steps.len() as f64 && 2 * rises > steps.len() && !steps.is_empty()
}

/// Whether a column counts rows, stops or frames: it is called so, or most of its values are one more
/// than the last one.
fn counts(column: &Surveyed) -> bool {
    let steps = column.values.len().saturating_sub(1);
    let is_next = |pair: &&[f64]| pair[1] - pair[0] == 1.0 && pair[0].fract() == 0.0;
    let next = column.values.windows(2).filter(is_next).count();
    let is_one_more = steps > 0 && next as f64 >= ONE_MORE * steps as f64;
    column.is_named && (is_called(column, &NUMBERS) || is_one_more)
}

/// The column that counts the rows, if one does.
pub(super) fn counter(survey: &Survey) -> Option<&str> {
    let counter = |column: &&Surveyed| counts(column) && goes_on(&column.values, IN_ORDER);
    survey.columns.iter().find(counter).map(|column| column.name.as_str())
}

/// The column of stamps, and whether its name and its unit say so.
pub(super) fn column(survey: &Survey) -> Option<(Candidate, bool)> {
    let first = |column: &Surveyed| column.values.first().copied().unwrap_or(0.0);
    let is_time = |column: &Surveyed| {
        let unit = column.unit.clone().or(base(&column.name).1);
        unit.is_some_and(|unit| unit.dimension == Dimension::TIME)
    };
    let in_order = |column: &Surveyed| {
        let is_said = is_called(column, &TIMES) || unit_since_1970(first(column)).is_some();
        goes_on(&column.values, if is_said { MOSTLY_IN_ORDER } else { IN_ORDER })
    };
    let numbers = survey.columns.iter().enumerate();
    let is_other = |column: &Surveyed| {
        let is_number = |unit: &Unit| unit.dimension == Dimension::NONE && !unit.is_angle();
        let unit = column.unit.as_ref();
        unit.is_some_and(|unit| unit.dimension != Dimension::TIME && !is_number(unit))
    };
    let numbers = numbers
        .filter(|(_, column)| column.calendar.is_none() && !is_other(column) && in_order(column));
    let candidates: Vec<(usize, &Surveyed)> = numbers.collect();
    let called = candidates.iter().find(|(_, column)| is_called(column, &TIMES));
    let of_time = || candidates.iter().find(|(_, column)| is_time(column));
    let other = || candidates.iter().find(|(_, column)| !counts(column));
    let (column, own) = called.or_else(of_time).or_else(other)?;
    let since = unit_since_1970(first(own));
    let usual = since.unwrap_or_else(|| by_steps(&own.values));
    let passed = candidates.iter().find(|(at, other)| at < column && counts(other));
    let what = match (called.is_some(), passed) {
        (true, _) => "stamps".to_owned(),
        (false, None) => "numbers in order, taken for stamps".to_owned(),
        (false, Some((_, counter))) => {
            format!("numbers in order, taken for stamps: `{}` counts rows", counter.name)
        }
    };
    let (unit, why) = unit(own, usual, &what);
    let why = match (why.as_str(), since) {
        ("", _) => why,
        (_, Some(since)) => format!("{what}; as large as {since} since 1970"),
        _ => why,
    };
    let unit = since.and_then(|since| Unit::parse(since).ok()).unwrap_or(unit);
    let is_sure = called.is_some() && (is_time(own) || since.is_some());
    Some((Candidate { column: *column, unit, why }, is_sure))
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
