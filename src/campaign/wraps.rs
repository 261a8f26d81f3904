//! Stamps of a counter that begins anew, made to go on.
//!
//! Row by row a leap back across the end of the counter counts as a lap where it is small. A larger
//! one may be a gap or one bad stamp, which only the rows behind tell: the file is then read whole.

/// How much of the counter's size a row may come late by, and rows may leap without a question.
const LATE: f64 = 0.05;
/// Rows behind a leap that are asked whether they go on from before it.
const BEHIND: usize = 10;

/// A counter of stamps, by its size (s).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wraps {
    size: f64,
    /// How often it began anew.
    count: f64,
    last: f64,
}

impl Wraps {
    /// A counter of a size, at its beginning.
    pub(crate) fn new(size: f64) -> Self {
        Self { size, count: 0.0, last: f64::NAN }
    }

    /// The next stamp as if the counter had no end; one that lies before the last is returned so
    /// unless the counter clearly began anew.
    pub(crate) fn next(&mut self, stamp: f64) -> f64 {
        if stamp.is_nan() {
            return stamp;
        }
        let value = stamp + self.count * self.size;
        if value < self.last {
            let anew = value + self.size;
            if anew - self.last > LATE * self.size {
                return value;
            }
            self.count += 1.0;
            self.last = anew;
            return anew;
        }
        if value - self.last > (1.0 - LATE) * self.size {
            return value - self.size;
        }
        self.last = value;
        value
    }
}

/// All stamps of a file as if its counter had no end, and the rows whose stamps are bad: they leap,
/// and the rows behind go on from before. A bad stamp is that of the row before.
pub(crate) fn unwrapped(stamps: &[f64], size: f64) -> (Vec<f64>, Vec<usize>) {
    // From one stamp to another: forward, or back by a little.
    let step = |from: f64, to: f64| {
        let forward = (to - from).rem_euclid(size);
        if forward > (1.0 - LATE) * size { forward - size } else { forward }
    };
    let mut steps: Vec<f64> = stamps.windows(2).map(|two| step(two[0], two[1]).abs()).collect();
    let middle = steps.len() / 2;
    let usual = match steps.is_empty() {
        true => 0.0,
        false => *steps.select_nth_unstable_by(middle, f64::total_cmp).1,
    };
    // Rows so few that some of them make a lap say nothing of each other.
    let can_be_judged = usual * ((2 * BEHIND) as f64) < size;
    let (mut values, mut bad) = (Vec::with_capacity(stamps.len()), Vec::new());
    let Some((mut last, mut value)) = stamps.first().map(|first| (*first, *first)) else {
        return (values, bad);
    };
    let mut row = 0;
    while row < stamps.len() {
        let leap = step(last, stamps[row]);
        if can_be_judged && leap > LATE * size {
            let goes_on = |other: &f64| step(last, *other) <= LATE * size;
            let behind = &stamps[row + 1..];
            let back = behind.iter().take(BEHIND).position(goes_on);
            let back = back.filter(|at| behind.get(at + 1).is_none_or(goes_on));
            if let Some(at) = back {
                bad.extend(row..=row + at);
                values.resize(row + at + 1, value);
                row += at + 1;
                continue;
            }
        }
        // A row that came late does not take the others back.
        values.push(value + leap);
        if leap >= 0.0 {
            (last, value) = (stamps[row], value + leap);
        }
        row += 1;
    }
    (values, bad)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_counter_goes_on_where_it_begins_anew_and_late_rows_keep_their_place() {
        let mut wraps = Wraps::new(100.0);
        let stamps = [10.0, 70.0, 99.0, 1.0, 98.5, 2.0, 60.0, 97.0, 1.0];
        let right = [10.0, 70.0, 99.0, 101.0, 98.5, 102.0, 160.0, 197.0, 201.0];
        assert_eq!(stamps.map(|stamp| wraps.next(stamp)), right);
        assert_eq!(unwrapped(&stamps, 100.0), (right.to_vec(), vec![]));
    }

    #[test]
    fn a_bad_stamp_is_no_lap_and_a_gap_is_one() {
        let size = 65_536.0;
        let time = |n: usize| 20_000.0 + 400.0 * n as f64;
        let right: Vec<f64> = (0..600).map(time).collect();
        let stamps = || -> Vec<f64> { (0..600).map(|n| time(n) % size).collect() };
        for (rows, stamp) in
            [(50..51, 0.0), (50..51, 65_000.0), (50..53, 12.0), (599..600, 0.0), (112..114, 9e9)]
        {
            let mut stamps = stamps();
            stamps[rows.clone()].fill(stamp);
            let (found, bad) = unwrapped(&stamps, size);
            if rows.end < 600 {
                assert_eq!(bad, rows.clone().collect::<Vec<_>>());
            }
            let good = (0..600).filter(|row| !rows.contains(row));
            good.for_each(|row| assert_eq!(found[row], right[row], "row {row} of {rows:?}"));
        }
        // A gap of more than half a lap, about the counter's beginning.
        let gap = |n: usize| if n < 90 { 0.0 } else { 40_000.0 };
        let stamps: Vec<f64> = (0..600).map(|n| (time(n) + gap(n)) % size).collect();
        let right: Vec<f64> = (0..600).map(|n| time(n) + gap(n)).collect();
        assert_eq!(unwrapped(&stamps, size), (right, vec![]));
        // Few rows a lap.
        let stamps: Vec<f64> = (0..40).map(|n| 30_000.0 * f64::from(n) % size).collect();
        let right: Vec<f64> = (0..40).map(|n| 30_000.0 * f64::from(n)).collect();
        assert_eq!(unwrapped(&stamps, size), (right, vec![]));
    }
}
