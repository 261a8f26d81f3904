//! What the columns of a table seem to be: guesses from their names and their values.

use crate::campaign::begin::survey::{Survey, Surveyed};
use crate::campaign::endings::ending;
use crate::campaign::formats::{Role, unit_since_1970};
use crate::units::{Dimension, Unit};

/// Of so many pairs of rows time may go back in one.
const IN_ORDER: f64 = 0.99;
/// How far the length of a quaternion may be off 1.
const OFF_LENGTH: f64 = 0.02;
/// Names of the numbers of rows.
const NUMBERS: [&str; 9] = ["i", "n", "no", "nr", "id", "row", "index", "number", "count"];
/// Names of stamps, of headings and of angles.
const TIMES: [&str; 7] = ["t", "time", "stamp", "timestamp", "clock", "seconds", "sec"];
const HEADINGS: [&str; 6] = ["th", "theta", "yaw", "heading", "psi", "phi"];
const ANGLES: [&str; 6] = ["angle", "azimuth", "elevation", "roll", "pitch", "joint"];

/// A column with the unit that it seems to have, and why.
#[derive(Clone, Debug)]
pub(super) struct Guessed {
    pub(super) column: usize,
    pub(super) unit: Unit,
    /// Why it is taken for that; empty where the file says so.
    pub(super) why: String,
}

/// What a table seems to hold.
#[derive(Clone, Debug, Default)]
pub(super) struct Guess {
    pub(super) time: Option<Guessed>,
    pub(super) position: Option<[Guessed; 3]>,
    /// Components w, x, y, z of a quaternion.
    pub(super) attitude: Option<[Guessed; 4]>,
    pub(super) heading: Option<Guessed>,
    /// All other columns that move.
    pub(super) others: Vec<Guessed>,
}

/// The name without the ending that is a unit, in small letters; and the unit.
pub(super) fn base(name: &str) -> (String, Option<Unit>) {
    let small = name.to_lowercase();
    let ending = ending(name).and_then(|unit| {
        let (base, _) = small.rsplit_once('_')?;
        Some((base.to_owned(), Unit::parse(unit).ok()?))
    });
    match ending {
        Some((base, unit)) => (base, Some(unit)),
        None => (small, None),
    }
}

/// The unit of a column, and why.
fn unit(column: &Surveyed, usual: &str, what: &str) -> (Unit, String) {
    if let Some(unit) = &column.unit {
        return (unit.clone(), String::new());
    }
    match base(&column.name).1 {
        Some(unit) => (unit, format!("{what}; unit from the ending of the name")),
        None => {
            let unit = Unit::parse(usual).unwrap_or_else(|_| Unit::one());
            (unit, format!("{what}; the file has no unit, CHECK `{usual}`"))
        }
    }
}

impl Guess {
    /// Of a table.
    pub(super) fn of(survey: &Survey) -> Self {
        let all = &survey.columns;
        let mut guess = Self { time: time(survey), ..Self::default() };
        let guessed = |column: usize, usual: &str, what: &str| {
            let (unit, why) = unit(&all[column], usual, what);
            Guessed { column, unit, why }
        };
        let place = |role| {
            let names: Vec<&str> = all.iter().map(|column| column.name.as_str()).collect();
            let names: Vec<&str> = match all.iter().all(|column| column.is_named) {
                true => names,
                false => vec![""; all.len()],
            };
            survey.format.and_then(|format| format.place(role, &names))
        };
        let known: Option<Vec<usize>> = (0..4).map(|k| place(Role::Attitude(k))).collect();
        let quaternion = known.and_then(|known| known.try_into().ok()).or_else(|| quaternion(all));
        guess.attitude = quaternion
            .map(|columns: [usize; 4]| columns.map(|column| guessed(column, "1", "quaternion")));
        let mut taken: Vec<usize> = guess.time.iter().map(|time| time.column).collect();
        taken.extend(quaternion.into_iter().flatten());
        let known: Option<Vec<usize>> = (0..3).map(|k| place(Role::Position(k))).collect();
        let free = |column: &usize| !taken.contains(column) && all[*column].moves();
        let position = known.and_then(|known| known.try_into().ok());
        let position: Option<[usize; 3]> = position.or_else(|| triple(all, &free));
        guess.position =
            position.map(|columns| columns.map(|column| guessed(column, "m", "position")));
        taken.extend(position.into_iter().flatten());
        let is = |names: &[&str], column: &Surveyed| {
            let base = base(&column.name).0;
            names.iter().any(|name| base == *name || base.ends_with(&format!("_{name}")))
        };
        for column in (0..all.len()).filter(|column| !taken.contains(column)) {
            let own = &all[column];
            if !own.moves() {
                continue;
            }
            let is_heading = is(&HEADINGS, own) && guess.heading.is_none();
            if is_heading || is(&ANGLES, own) {
                let largest = own.values.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
                let usual = if largest > 7.0 { "deg" } else { "rad" };
                let angle = guessed(column, usual, "angle");
                match is_heading {
                    true => guess.heading = Some(angle),
                    false => guess.others.push(angle),
                }
            } else {
                guess.others.push(guessed(column, "1", "a column that moves"));
            }
        }
        guess
    }
}

/// The column of stamps: numbers in order, best one that is called so.
fn time(survey: &Survey) -> Option<Guessed> {
    let in_order = |column: &Surveyed| {
        let steps: Vec<f64> = column.values.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let on = steps.iter().filter(|step| **step >= 0.0).count();
        let rises = steps.iter().filter(|step| **step > 0.0).count();
        on as f64 >= IN_ORDER * steps.len() as f64 && 2 * rises > steps.len() && !steps.is_empty()
    };
    let is_called = |column: &Surveyed| {
        let base = base(&column.name).0;
        let parts: Vec<&str> = base.split(['.', '_', ' ']).collect();
        TIMES.iter().any(|name| parts.contains(name))
    };
    let names = survey.columns.iter().enumerate();
    let candidates: Vec<(usize, &Surveyed)> =
        names.filter(|(_, column)| in_order(column)).collect();
    let called = candidates.iter().find(|(_, column)| is_called(column));
    let has_unit = |(_, column): &&(usize, &Surveyed)| {
        let unit = column.unit.clone().or(base(&column.name).1);
        unit.is_some_and(|unit| unit.dimension == Dimension::TIME)
    };
    let is_no_number_of_rows =
        |(_, column): &&(usize, &Surveyed)| !NUMBERS.contains(&base(&column.name).0.as_str());
    let (column, own) = called
        .or_else(|| candidates.iter().find(has_unit))
        .or_else(|| candidates.iter().find(is_no_number_of_rows))?;
    let first = own.values.first().copied().unwrap_or(0.0);
    let usual = unit_since_1970(first).unwrap_or_else(|| by_steps(&own.values));
    let what = if called.is_some() { "stamps" } else { "numbers in order, taken for stamps" };
    let (unit, why) = unit(own, usual, what);
    let why = match (why.as_str(), unit_since_1970(first)) {
        ("", _) => why,
        (_, Some(since)) => format!("{what}; as large as {since} since 1970"),
        _ => why,
    };
    let unit = unit_since_1970(first).and_then(|since| Unit::parse(since).ok()).unwrap_or(unit);
    Some(Guessed { column: *column, unit, why })
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

/// Four columns whose names differ in w, x, y and z alone, of length 1.
fn quaternion(all: &[Surveyed]) -> Option<[usize; 4]> {
    let find = |name: &str| all.iter().position(|column| column.name.eq_ignore_ascii_case(name));
    let is_unit = |columns: &[usize; 4]| {
        let rows = all[columns[0]].values.len();
        let length = |row: usize| {
            columns.iter().map(|column| all[*column].values[row].powi(2)).sum::<f64>().sqrt()
        };
        let good = (0..rows).filter(|row| (length(*row) - 1.0).abs() < OFF_LENGTH).count();
        good > 0 && 10 * good >= 9 * rows
    };
    all.iter().find_map(|column| {
        let small = column.name.to_lowercase();
        small.match_indices('w').find_map(|(at, _)| {
            let name = |axis: &str| format!("{}{axis}{}", &small[..at], &small[at + 1..]);
            let places = ["w", "x", "y", "z"].map(|axis| find(&name(axis)));
            let [Some(w), Some(x), Some(y), Some(z)] = places else { return None };
            Some([w, x, y, z]).filter(is_unit)
        })
    })
}

/// Three columns whose names differ in x, y and z alone: those first that are called positions.
fn triple(all: &[Surveyed], free: &dyn Fn(&usize) -> bool) -> Option<[usize; 3]> {
    let find = |name: &str| all.iter().position(|column| column.name.eq_ignore_ascii_case(name));
    let mut found: Vec<([usize; 3], bool)> = Vec::new();
    for column in all {
        let small = column.name.to_lowercase();
        for (at, _) in small.match_indices('x') {
            let name = |axis: &str| format!("{}{axis}{}", &small[..at], &small[at + 1..]);
            let places = ["x", "y", "z"].map(|axis| find(&name(axis)));
            let [Some(x), Some(y), Some(z)] = places else { continue };
            let is_length = column
                .unit
                .as_ref()
                .or(base(&column.name).1.as_ref())
                .is_none_or(|u| u.dimension == crate::units::Dimension::LENGTH);
            if is_length && [x, y, z].iter().all(free) {
                let stem = &small[..at];
                let is_called =
                    ["", "p", "p_", "pos", "position", "t", "tool_", "hand_"].iter().any(|own| {
                        stem == *own || stem.ends_with("position.") || stem.starts_with("p_")
                    });
                found.push(([x, y, z], is_called));
            }
        }
    }
    let called = found.iter().find(|(_, is_called)| *is_called);
    called.or_else(|| found.first()).map(|(columns, _)| *columns)
}
