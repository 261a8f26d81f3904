//! Stretches in which a stream holds its last value while what it measures moves on: a logger that
//! fills the gaps of its source so. They are gaps.
//!
//! A stream at rest holds its value, too, and slows down and speeds up by small steps; a sequence of
//! setpoints holds each. So a held stretch is one that the stream enters and leaves moving, and leaves
//! by a leap.

use std::ops::Range;

use crate::campaign::stream_rows::leave_rows_out;
use crate::diagnostic::{Diagnostic, decimals};
use crate::model::InputDeclaration;

/// Rows of one value that make a stretch at least.
const SHORTEST: usize = 5;
/// Steps before and after it, all of which move.
const BESIDE: usize = 4;
/// The leap at its end is so many times the largest of them at least.
const LEAP: f64 = 3.0;

/// Leaves the rows of a stream out in which it holds the value of the one before; the warning of them.
/// The first time is at `zero`.
pub(crate) fn without_held(
    input: &InputDeclaration,
    times: &mut Vec<f64>,
    values: &mut Vec<f64>,
    zero: f64,
) -> Option<Diagnostic> {
    let held = held(values);
    let first = times.get(held.first()?.start)? + zero;
    let longest = held.iter().map(ExactSizeIterator::len).max().unwrap_or(0);
    leave_rows_out(times, values, |row| {
        let next = held.partition_point(|one| one.end <= row);
        held.get(next).is_some_and(|one| one.contains(&row))
    });
    let (name, count) = (&input.name, held.len());
    let stretches = if count == 1 { "stretch" } else { "stretches" };
    let message = format!(
        "the stream of `{name}` holds its value in {count} {stretches} of up to {longest} rows, the first at {} s, and leaps on: these rows are left out",
        decimals(first, 3)
    );
    let help = "a logger that repeats the last value where none comes fills gaps so";
    Some(Diagnostic::warning(message).help(help))
}

/// The rows that repeat the value of the one before in stretches that are held.
fn held(values: &[f64]) -> Vec<Range<usize>> {
    let step = |at: usize| (values[at] - values[at - 1]).abs();
    let mut found = Vec::new();
    let mut at = 1;
    while at < values.len() {
        let end = (at..values.len()).find(|next| step(*next) != 0.0).unwrap_or(values.len());
        let is_long = end - at + 1 >= SHORTEST;
        if is_long && at > BESIDE && end + BESIDE < values.len() {
            let beside: Vec<f64> =
                (at - BESIDE..at).chain(end + 1..=end + BESIDE).map(step).collect();
            let most = beside.iter().copied().fold(0.0, f64::max);
            if beside.iter().all(|step| *step > 0.0) && step(end) > LEAP * most {
                found.push(at..end);
            }
        }
        at = end.max(at) + 1;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::held;

    #[test]
    fn a_stretch_that_is_left_by_a_leap_is_held() {
        let wave = |row: usize| (0.013 * row as f64).sin();
        let of = |value: &dyn Fn(usize) -> f64| held(&(0..900).map(value).collect::<Vec<_>>());
        let filled = |row: usize| if (201..230).contains(&row) { 200 } else { row };
        let found = of(&|row| wave(filled(row)));
        assert_eq!((found.len(), found[0].clone()), (1, 201..230));
        // At rest, setpoints, a coarse display, a lone leap, and a stretch up to the end.
        assert!(
            of(&|row| wave(row.min(400)) + if row > 600 { wave(row - 600) } else { 0.0 })
                .is_empty()
        );
        assert!(of(&|row| (row / 50) as f64).is_empty());
        assert!(of(&|row| (20.0 * wave(row)).round()).is_empty());
        assert!(of(&|row| wave(row) + if row > 500 { 3.0 } else { 0.0 }).is_empty());
        assert!(of(&|row| wave(row.min(700))).is_empty());
    }
}
