//! Whether the rows of a table whose time goes back may be sorted, and in which order they then are.
//!
//! Rows that several writers put into one file, or that came late, are good rows: they are sorted.
//! A single stamp far from all others is a bad row. Where the clock itself was set, or a counter
//! began anew, sorting would mix rows of different moments: that is said and not sorted.

use crate::diagnostic::decimals;
use crate::units::Unit;

/// A clock was set where the rows before and behind alternate more often than this once sorted.
const ALTERNATIONS: usize = 5;
/// Rows on both sides of a clock that was set.
const ENOUGH: usize = 3;
/// One of so many rows may have a stamp far from all others.
const FAR: usize = 50;
/// How close (relative) a step back is to the size of a counter.
const CLOSE: f64 = 0.02;

/// What is to be done with rows whose time goes back.
#[derive(Debug, PartialEq)]
pub(crate) enum Order {
    /// They are to be sorted.
    Sort {
        /// Rows in the order of time, without those far from all others.
        order: Vec<usize>,
        /// Rows with a time far from all others.
        far: Vec<usize>,
        /// How often time goes back, and by how much at most (s).
        back: usize,
        largest: f64,
    },
    /// The clock was set back, or began anew: the first row behind, how often, by how much (s).
    Set { row: usize, count: usize, by: f64 },
}

/// Judges the times of a table in the order of its rows; all are finite.
pub(crate) fn judge(times: &[f64]) -> Order {
    let mut order: Vec<usize> = (0..times.len()).collect();
    order.sort_by(|a, b| times[*a].total_cmp(&times[*b]));
    let far = far(times, &order);
    order.retain(|row| !far.contains(row));
    let rows: Vec<usize> = (0..times.len()).filter(|row| !far.contains(row)).collect();
    let step = |pair: &[usize]| times[pair[0]] - times[pair[1]];
    let steps: Vec<(usize, f64)> =
        rows.windows(2).map(|pair| (pair[1], step(pair))).filter(|(_, step)| *step > 0.0).collect();
    let largest = steps.iter().map(|(_, step)| *step).fold(0.0, f64::max);
    if let Some((row, by)) = steps.first().copied() {
        let (first, last) = (order.first().copied(), order.last().copied());
        let span = first.zip(last).map_or(0.0, |(first, last)| times[last] - times[first]);
        let smallest = steps.iter().map(|(_, step)| *step).fold(f64::INFINITY, f64::min);
        let begins_anew = smallest > 0.5 * span && rows.len() > ENOUGH * 2 * steps.len();
        let was_set = steps.len() == 1 && is_mixed(&order, row);
        if begins_anew || was_set {
            return Order::Set { row, count: steps.len(), by };
        }
    }
    Order::Sort { order, far, back: steps.len(), largest }
}

/// Rows that are few, out of place, and further from the others than those are from each other.
fn far(times: &[f64], order: &[usize]) -> Vec<usize> {
    let (count, most) = (order.len(), (order.len() / FAR).max(1));
    let time = |place: usize| times[order[place]];
    let is_out_of_place = |places: std::ops::Range<usize>| {
        places.clone().any(|place| !places.contains(&order[place]))
    };
    let (mut low, mut high) = (0, 0);
    for few in 1..=most.min(count.saturating_sub(2)) {
        let (above, below) = (time(few), time(count - few - 1));
        if above - time(few - 1) > time(count - 1 - high) - above && is_out_of_place(0..few) {
            low = few;
        }
        let gap = time(count - few) - below;
        if gap > below - time(low) && is_out_of_place(count - few..count) {
            high = few;
        }
    }
    let mut found = Vec::new();
    for places in [0..low, count - high..count] {
        found.extend_from_slice(&order[places]);
    }
    found.sort_unstable();
    found
}

/// Whether the rows before and from `row` on alternate once they are in the order of time.
fn is_mixed(order: &[usize], row: usize) -> bool {
    let behind = |place: &usize| *place >= row;
    let changes = order.windows(2).filter(|pair| behind(&pair[0]) != behind(&pair[1])).count();
    changes > ALTERNATIONS
}

/// Clocks that begin anew: each minute, hour, half day, day, week.
const CLOCKS: [(&str, f64); 5] =
    [("60 s", 60.0), ("1 h", 3600.0), ("12 h", 43_200.0), ("24 h", 86_400.0), ("168 h", 604_800.0)];

/// The size of a counter that a step back (s) of stamps of a unit is close to, if any: powers of two
/// and of ten, and clocks.
pub(crate) fn counter(step: f64, unit: &Unit) -> Option<String> {
    let clock = CLOCKS.into_iter().find(|(_, size)| (step / size - 1.0).abs() < CLOSE);
    let clock = clock.map(|(words, _)| words.to_owned());
    clock.or_else(|| size(step / unit.factor).map(|size| format!("{size} {}", unit.symbol)))
}

/// The power of two or of ten that a step of a counter is close to, if any.
pub(crate) fn size(step: f64) -> Option<f64> {
    let twos = (8..=48).map(|bits| 2_f64.powi(bits));
    let tens = (2..=15).map(|digits| 10_f64.powi(digits));
    twos.chain(tens).find(|size| (step / size - 1.0).abs() < CLOSE)
}

/// What is said of rows that were sorted.
pub(crate) fn told(file: &str, rows: usize, back: usize, largest: f64) -> String {
    let times = if back == 1 { "once".to_owned() } else { format!("{back} times") };
    format!(
        "`{file}`: time goes back {times} in {rows} rows, by {} s at most: the rows were sorted by time",
        decimals(largest, 6)
    )
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use super::*;

    fn sorted(times: &[f64]) -> (Vec<f64>, Vec<usize>, usize) {
        match judge(times) {
            Order::Sort { order, far, back, .. } => {
                (order.into_iter().map(|row| times[row]).collect(), far, back)
            }
            Order::Set { row, count, .. } => (Vec::new(), vec![row], count),
        }
    }

    #[test]
    fn rows_that_came_late_are_sorted_and_stamps_far_away_are_bad() {
        assert_eq!(sorted(&[0.0, 2.0, 1.0, 3.0]), (vec![0.0, 1.0, 2.0, 3.0], vec![], 1));
        assert_eq!(sorted(&[0.0, 1e9, 2.0, 3.0]), (vec![0.0, 2.0, 3.0], vec![1], 0));
        assert_eq!(sorted(&[1e9, 1.0, 2.0]), (vec![1.0, 2.0], vec![0], 0));
        assert_eq!(sorted(&[10.0, 11.0, 13.0, 1.0, 15.0]).1, vec![3]);
        assert_eq!(sorted(&[0.0, 0.3, 0.2]), (vec![0.0, 0.2, 0.3], vec![], 1));
        // A long pause is none.
        assert_eq!(sorted(&[0.0, 2.0, 1.0, 3.0, 900.0]).0, [0.0, 1.0, 2.0, 3.0, 900.0]);
        // A block that was written late.
        let blocks = (0..40).chain(60..80).chain(40..60).chain(80..99).map(f64::from);
        let blocks: Vec<f64> = blocks.collect();
        assert_eq!(sorted(&blocks), ((0..99).map(f64::from).collect(), vec![], 1));
    }

    #[test]
    fn a_clock_that_was_set_and_a_counter_that_wraps_are_not_sorted() {
        let set: Vec<f64> =
            (0..100).map(|n| f64::from(n) - if n < 50 { 0.0 } else { 8.3 }).collect();
        assert!(matches!(judge(&set), Order::Set { row: 50, count: 1, .. }));
        let wraps: Vec<f64> = (0..100).map(|n| f64::from((n * 2000) % 65_536)).collect();
        assert!(matches!(judge(&wraps), Order::Set { count: 3, .. }));
        let unit = |symbol: &str| Unit::parse(symbol).unwrap();
        let counter = |step: f64, symbol: &str| counter(step * unit(symbol).factor, &unit(symbol));
        assert_eq!(counter(65_530.0, "ms").as_deref(), Some("65536 ms"));
        assert_eq!(counter(999_990.0, "us").as_deref(), Some("1000000 us"));
        assert_eq!(counter(4_294_967_290.0, "us").as_deref(), Some("4294967296 us"));
        assert_eq!(counter(86_399_990.0, "ms").as_deref(), Some("24 h"));
        assert_eq!(counter(83.0, "s"), None);
    }
}
