//! Whether the rows of a table whose time goes back may be sorted, and in which order they then are.
//!
//! Rows that several writers put into one file, or that came late, are good rows: they are sorted.
//! A single stamp far from all others is a bad row. Where the clock itself was set, or a counter
//! began anew, sorting would mix rows of different moments: that is reported, and they are not sorted.

use crate::diagnostic::decimals;
use crate::units::Unit;

/// A clock was set where the rows before and behind alternate more often than this once sorted.
const ALTERNATIONS: usize = 5;
/// Rows on both sides of a clock that was set.
const ENOUGH: usize = 3;
/// Several writers cover this part of the time twice and more, with so many steps back at least.
const COVERED: f64 = 0.8;
const WRITERS: usize = 3;
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
    let is_far = marked(times.len(), &far);
    order.retain(|row| !is_far[*row]);
    let rows: Vec<usize> = (0..times.len()).filter(|row| !is_far[*row]).collect();
    // Where in `rows` time goes back, and by how much.
    let steps: Vec<(usize, f64)> = (1..rows.len())
        .map(|place| (place, times[rows[place - 1]] - times[rows[place]]))
        .filter(|(_, by)| *by > 0.0)
        .collect();
    let largest = steps.iter().map(|(_, by)| *by).fold(0.0, f64::max);
    if let Some((place, by)) = steps.first().copied() {
        let (first, last) = (order.first().copied(), order.last().copied());
        let span = first.zip(last).map_or(0.0, |(first, last)| times[last] - times[first]);
        let smallest = steps.iter().map(|(_, by)| *by).fold(f64::INFINITY, f64::min);
        if smallest > 0.5 * span && rows.len() > ENOUGH * 2 * steps.len() {
            return Order::Set { row: rows[place], count: steps.len(), by };
        }
        let set = mixed(times, &rows, &steps);
        let covered: f64 = set.iter().map(|at| steps[*at].1).sum();
        let are_writers = set.len() >= WRITERS && covered > COVERED * span;
        if let (Some(at), false) = (set.first(), are_writers) {
            let (place, by) = steps[*at];
            return Order::Set { row: rows[place], count: set.len(), by };
        }
    }
    Order::Sort { order, far, back: steps.len(), largest }
}

/// Which of so many rows are among these.
pub(crate) fn marked(count: usize, rows: &[usize]) -> Vec<bool> {
    let mut marked = vec![false; count];
    rows.iter().for_each(|row| marked[*row] = true);
    marked
}

/// The steps back whose rows before and behind, up to the next step, alternate in the order of time.
fn mixed(times: &[f64], rows: &[usize], steps: &[(usize, f64)]) -> Vec<usize> {
    let place = |at: usize| steps.get(at).map_or(rows.len(), |(place, _)| *place);
    let is_mixed = |at: &usize| {
        let from = if *at == 0 { 0 } else { place(at - 1) };
        let (before, behind) = (&rows[from..place(*at)], &rows[place(*at)..place(at + 1)]);
        alternations(times, before, behind) > ALTERNATIONS
    };
    (0..steps.len()).filter(is_mixed).collect()
}

/// Rows that are few, out of place, and further from the others than those are from each other.
fn far(times: &[f64], order: &[usize]) -> Vec<usize> {
    let (count, most) = (order.len(), (order.len() / FAR).max(1));
    let most = most.min(count.saturating_sub(2));
    let time = |place: usize| times[order[place]];
    let (mut low, mut high) = (0, 0);
    // The first and the last rows of the file are in their places.
    let (mut last_of_low, mut first_of_high) = (0, count);
    for few in 1..=most {
        let (above, below) = (time(few), time(count - few - 1));
        last_of_low = last_of_low.max(order[few - 1]);
        first_of_high = first_of_high.min(order[count - few]);
        if above - time(few - 1) > time(count - 1 - high) - above && last_of_low >= few {
            low = few;
        }
        let gap = time(count - few) - below;
        if gap > below - time(low) && first_of_high < count - few {
            high = few;
        }
    }
    let mut found = [&order[..low], &order[count - high..]].concat();
    found.sort_unstable();
    found
}

/// How often rows of two stretches, each in the order of time, take turns where they are merged.
fn alternations(times: &[f64], before: &[usize], behind: &[usize]) -> usize {
    let (mut a, mut b) = (before.iter().peekable(), behind.iter().peekable());
    let (mut count, mut last) = (0, None);
    // What remains of one stretch at the end takes one more turn at most.
    while let (Some(one), Some(other)) = (a.peek(), b.peek()) {
        let is_first = times[**one] <= times[**other];
        count += usize::from(last.is_some_and(|last| last != is_first));
        last = Some(is_first);
        if is_first {
            a.next()
        } else {
            b.next()
        };
    }
    count + usize::from(last.is_some())
}

/// Clocks that begin anew: each minute, hour, half day, day, week.
const CLOCKS: [(&str, f64); 5] =
    [("60 s", 60.0), ("1 h", 3600.0), ("12 h", 43_200.0), ("24 h", 86_400.0), ("168 h", 604_800.0)];

/// The size of a counter that a step back (s) of stamps of a unit is close to, if any: powers of two
/// and of ten, and clocks.
pub(crate) fn counter(step: f64, unit: &Unit) -> Option<String> {
    let clock = CLOCKS.into_iter().find(|(_, size)| (step / size - 1.0).abs() < CLOSE);
    let clock = clock.map(|(words, _)| words.to_owned());
    let counts = |size: f64| match unit.symbol.starts_with(|c: char| c.is_ascii_digit()) {
        true => format!("{} s", size * unit.factor),
        false => format!("{size} {}", unit.symbol),
    };
    clock.or_else(|| size(step / unit.factor).map(counts))
}

/// The power of two or of ten that a step of a counter is close to, if any.
pub(crate) fn size(step: f64) -> Option<f64> {
    let twos = (8..=48).map(|bits| 2_f64.powi(bits));
    let tens = (2..=15).map(|digits| 10_f64.powi(digits));
    twos.chain(tens).find(|size| (step / size - 1.0).abs() < CLOSE)
}

/// How often, in words.
pub(crate) fn times(count: usize) -> String {
    if count == 1 { "once".to_owned() } else { format!("{count} times") }
}

/// What is said of rows that were sorted.
pub(crate) fn told(file: &str, rows: usize, back: usize, largest: f64) -> String {
    let times = times(back);
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
        // Two writers that take turns, twenty rows at a time: even numbers, odd ones.
        let turn = |n: u32| 40 * (n / 40) + 2 * (n % 20) + (n / 20) % 2;
        let turns: Vec<f64> = (0..400).map(|n| f64::from(turn(n))).collect();
        assert_eq!(sorted(&turns), ((0..400).map(f64::from).collect(), vec![], 10));
    }

    #[test]
    fn many_stamps_far_away_among_many_rows_take_no_long_time() {
        let count = 400_000;
        let bad = |n: u32| n % 60 == 7;
        let times: Vec<f64> =
            (0..count).map(|n| if bad(n) { 1e9 + f64::from(n) } else { f64::from(n) }).collect();
        let begun = std::time::Instant::now();
        let (order, far, back) = sorted(&times);
        let bad = (0..count).filter(|n| bad(*n)).count();
        assert_eq!((order.len(), far.len(), back), (400_000 - bad, bad, 0));
        assert!(begun.elapsed().as_secs_f64() < 5.0, "{:?}", begun.elapsed());
    }

    #[test]
    fn a_clock_that_was_set_and_a_counter_that_wraps_are_not_sorted() {
        let set: Vec<f64> =
            (0..100).map(|n| f64::from(n) - if n < 50 { 0.0 } else { 8.3 }).collect();
        assert!(matches!(judge(&set), Order::Set { row: 50, count: 1, .. }));
        // Set back twice and three times, once with a row that came late besides.
        let twice = |n: u32| f64::from(n) - 8.3 * f64::from(n / 40);
        let mut set: Vec<f64> = (0..120).map(twice).collect();
        assert!(matches!(judge(&set), Order::Set { row: 40, count: 2, .. }));
        set.swap(10, 11);
        assert!(matches!(judge(&set), Order::Set { row: 40, count: 2, .. }));
        let set: Vec<f64> = (0..160).map(twice).collect();
        assert!(matches!(judge(&set), Order::Set { row: 40, count: 3, .. }));
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
