//! What the columns of a table seem to be: guesses from their names and their values.

use crate::campaign::begin::axis_columns::{axes, is_turn, quaternion};
use crate::campaign::begin::candidate::{Candidate, base, unit};
use crate::campaign::begin::kinds::rate;
use crate::campaign::begin::pose::{self, HEADINGS, is_called};
use crate::campaign::begin::stamps::Stamps;
use crate::campaign::begin::survey::{Survey, Surveyed};
use crate::campaign::formats::Role;

/// Names of other angles than headings.
const ANGLES: [&str; 6] = ["angle", "azimuth", "elevation", "roll", "pitch", "joint"];

/// What a table seems to hold.
#[derive(Clone, Debug)]
pub(super) struct Guess {
    pub(super) time: Option<Stamps>,
    pub(super) position: Option<[Candidate; 3]>,
    /// Components w, x, y, z of a quaternion.
    pub(super) attitude: Option<[Candidate; 4]>,
    pub(super) heading: Option<Candidate>,
    /// Two axes and the heading; else why there are none.
    pub(super) plane: Result<[Candidate; 3], String>,
    /// All other columns that move.
    pub(super) others: Vec<Candidate>,
}

impl Guess {
    /// Of a table.
    pub(super) fn of(survey: &Survey) -> Self {
        let all = &survey.columns;
        let time = Stamps::of(survey);
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
        let attitude = quaternion
            .map(|columns: [usize; 4]| columns.map(|column| guessed(column, "1", "quaternion")));
        let mut taken: Vec<usize> =
            time.iter().flat_map(|time| &time.parts).map(|part| part.column).collect();
        taken.extend(quaternion.into_iter().flatten());
        let known: Option<Vec<usize>> = (0..3).map(|k| place(Role::Position(k))).collect();
        let free = |column: &usize| !taken.contains(column) && all[*column].moves();
        let position = known.and_then(|known| known.try_into().ok());
        let position: Option<[usize; 3]> = position.or_else(|| axes(all, &free));
        let flat: Option<[usize; 2]> = axes(all, &free).filter(|_| position.is_none());
        taken.extend(position.into_iter().flatten());
        let free = |column: &usize| !taken.contains(column) && all[*column].moves();
        let angle = |column: usize| {
            guessed(column, if all[column].seems_in_degrees() { "deg" } else { "rad" }, "angle")
        };
        let of_heading = pose::heading(all, &free);
        let other = |column: usize| {
            let own = &all[column];
            if is_called(own, &HEADINGS) || is_called(own, &ANGLES) || is_turn(own) {
                angle(column)
            } else if let Some(usual) = rate(&own.name) {
                guessed(column, usual, "a rate, by its name")
            } else if flat.is_some_and(|flat| flat.contains(&column)) || is_coordinate(all, own) {
                guessed(column, "m", "coordinate")
            } else {
                guessed(column, "1", "a column that moves")
            }
        };
        let others = (0..all.len()).filter(|column| free(column) && of_heading != Some(*column));
        let others = others.map(other).collect();
        let heading = of_heading.map(angle);
        let length = |column| guessed(column, "m", "position");
        let position = position.map(|columns| columns.map(length));
        let flat = flat.map(|columns| columns.map(length));
        let plane = pose::in_plane(all, position.as_ref(), flat.as_ref(), heading.as_ref());
        Self { time, position, attitude, heading, plane, others }
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
