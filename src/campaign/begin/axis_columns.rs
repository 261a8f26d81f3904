//! Columns whose names differ in their axis alone: positions and quaternions.
//!
//! Names may repeat (`X,Y,Z,W,X,Y,Z` of a tracked body): columns that stand together are one thing, and
//! a word above them says which.

use crate::campaign::axes::triples;
use crate::campaign::begin::candidate::base;
use crate::campaign::begin::kinds::rate;
use crate::campaign::begin::survey::Surveyed;
use crate::units::Dimension;

/// How far the length of a quaternion may be off 1.
const OFF_LENGTH: f64 = 0.02;
/// Words above columns that are no positions.
const TURNS: [&str; 5] = ["rotation", "orientation", "attitude", "quaternion", "euler"];

/// Words before the axis of a position.
const POSITIONS: [&str; 8] = ["p", "pos", "position", "pose", "t", "translation", "tool", "hand"];
/// What parts a name.
pub(super) const PARTS: [char; 5] = ['_', '.', '/', ' ', '-'];

/// The columns of these names, in each way that may be one thing: side by side, else the first of
/// each name.
fn ways<const N: usize>(all: &[Surveyed], names: &[String; N]) -> Vec<[usize; N]> {
    let is = |column: &usize, name: &String| all[*column].name.eq_ignore_ascii_case(name);
    let find = |from: usize, to: usize, name: &String| (from..to).find(|at| is(at, name));
    let within = |from: usize, to: usize| {
        let places = names.each_ref().map(|name| find(from, to, name));
        places.iter().all(Option::is_some).then(|| places.map(Option::unwrap_or_default))
    };
    let beside = (0..all.len()).filter_map(|from| within(from, all.len().min(from + N)));
    beside.chain(within(0, all.len())).collect()
}

/// Whether a word above a column says that it is part of an attitude.
pub(super) fn is_turn(column: &Surveyed) -> bool {
    TURNS.iter().any(|word| column.above.contains(word))
}

/// Four columns whose names differ in w, x, y and z alone, of length 1.
pub(super) fn quaternion(all: &[Surveyed]) -> Option<[usize; 4]> {
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
            let names = ["w", "x", "y", "z"].map(name);
            ways(all, &names).into_iter().find(is_unit)
        })
    })
}

/// Columns of lengths, three or two, whose names differ in their axis alone: those first that are called
/// positions. Two without a unit are called so, for two forces are as common.
pub(super) fn axes<const N: usize>(
    all: &[Surveyed],
    free: &dyn Fn(&usize) -> bool,
) -> Option<[usize; N]> {
    let mut found: Vec<([usize; N], bool)> = Vec::new();
    for column in all {
        let small = column.name.to_lowercase();
        for (at, names) in triples(&small) {
            let words: Vec<&str> =
                small[..at].split(PARTS).filter(|word| !word.is_empty()).collect();
            let is_called = words.last().is_none_or(|last| POSITIONS.contains(last))
                || words.first() == Some(&"p");
            let unit = column.unit.clone().or(base(&column.name).1);
            let is_length = match unit {
                Some(unit) => unit.dimension == Dimension::LENGTH,
                None => rate(&column.name).is_none() && (N == 3 || is_called),
            };
            let names: [String; N] = std::array::from_fn(|axis| names[axis].clone());
            let is_position = |columns: &[usize; N]| {
                columns.iter().all(|column| free(column) && !is_turn(&all[*column]))
            };
            let columns = ways(all, &names).into_iter().find(is_position);
            found.extend(columns.filter(|_| is_length).map(|columns| (columns, is_called)));
        }
    }
    let called = found.iter().find(|(_, is_called)| *is_called);
    called.or_else(|| found.first()).map(|(columns, _)| *columns)
}
