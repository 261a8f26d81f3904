//! What the columns of a table seem to be: guesses from their names and their values.

use crate::campaign::begin::axis_columns::{is_turn, quaternion, triple};
use crate::campaign::begin::candidate::{Candidate, base, unit};
use crate::campaign::begin::kinds::rate;
use crate::campaign::begin::stamps::Stamps;
use crate::campaign::begin::survey::{Survey, Surveyed};
use crate::campaign::formats::Role;

/// Names of headings and of angles.
const HEADINGS: [&str; 6] = ["th", "theta", "yaw", "heading", "psi", "phi"];
const ANGLES: [&str; 6] = ["angle", "azimuth", "elevation", "roll", "pitch", "joint"];

/// What a table seems to hold.
#[derive(Clone, Debug, Default)]
pub(super) struct Guess {
    pub(super) time: Option<Stamps>,
    pub(super) position: Option<[Candidate; 3]>,
    /// Components w, x, y, z of a quaternion.
    pub(super) attitude: Option<[Candidate; 4]>,
    pub(super) heading: Option<Candidate>,
    /// All other columns that move.
    pub(super) others: Vec<Candidate>,
}

impl Guess {
    /// Of a table.
    pub(super) fn of(survey: &Survey) -> Self {
        let all = &survey.columns;
        let mut guess = Self { time: Stamps::of(survey), ..Self::default() };
        let guessed = |column: usize, usual: &str, what: &str| {
            let (unit, why) = unit(&all[column], usual, what);
            Candidate { column, unit, why }
        };
        let place = |role| {
            let name = |column: &'_ Surveyed| -> String {
                if column.is_named { column.name.clone() } else { String::new() }
            };
            let names: Vec<String> = all.iter().map(name).collect();
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            survey.format.and_then(|format| format.place(role, &names))
        };
        let known: Option<Vec<usize>> = (0..4).map(|k| place(Role::Attitude(k))).collect();
        let quaternion = known.and_then(|known| known.try_into().ok()).or_else(|| quaternion(all));
        guess.attitude = quaternion
            .map(|columns: [usize; 4]| columns.map(|column| guessed(column, "1", "quaternion")));
        let mut taken: Vec<usize> =
            guess.time.iter().flat_map(|time| &time.parts).map(|part| part.column).collect();
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
            if is_heading || is(&ANGLES, own) || is_turn(own) {
                let largest = own.values.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
                let usual = if largest > 7.0 { "deg" } else { "rad" };
                let angle = guessed(column, usual, "angle");
                match is_heading {
                    true => guess.heading = Some(angle),
                    false => guess.others.push(angle),
                }
            } else if let Some(usual) = rate(&own.name) {
                guess.others.push(guessed(column, usual, "a rate, by its name"));
            } else if is_coordinate(all, own) {
                guess.others.push(guessed(column, "m", "coordinate"));
            } else {
                guess.others.push(guessed(column, "1", "a column that moves"));
            }
        }
        guess
    }
}

/// Whether a column is x, y or z of a point, and x and y are there.
fn is_coordinate(all: &[Surveyed], column: &Surveyed) -> bool {
    let own = base(&column.name).0;
    let Some(stem) = own.strip_suffix(['x', 'y', 'z']) else { return false };
    let has = |axis: &str| {
        let name = format!("{stem}{axis}");
        all.iter().any(|other| base(&other.name).0 == name)
    };
    ["", "p", "pos_"].contains(&stem) && has("x") && has("y")
}
