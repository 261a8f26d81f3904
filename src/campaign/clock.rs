//! Whether the clock of a file that is written at an even rate was set forward: one interval that is
//! no whole number of others.
//!
//! Rows that are lost leave a gap of whole intervals; a recorder that pauses does so in all of its
//! files. A clock that was set does neither.

use crate::diagnostic::{Diagnostic, decimals};

/// Intervals from which the usual one is taken.
const FIRST: usize = 2000;
/// An interval is even within this part of the usual one, and nearly all are.
const EVEN: f64 = 0.2;
const NEARLY_ALL: f64 = 0.98;
/// How much even intervals may scatter, as a part of the usual one.
const SCATTER: f64 = 0.03;
/// A jump is so many usual intervals at least, and at most.
const JUMP: (f64, f64) = (3.0, 2000.0);
/// How far from a whole number of intervals a jump is that lost rows do not explain.
const OFF_WHOLE: f64 = 0.15;
/// Jumps that are remembered.
const MOST: usize = 4;

/// A jump: its row in the file, the intervals's length, how many usual intervals that is.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Jump {
    row: usize,
    by: f64,
}

/// The intervals between the stamps of a file, block by block.
#[derive(Clone, Debug, Default)]
pub(crate) struct Intervals {
    last: Option<f64>,
    first: Vec<(usize, f64)>,
    usual: Option<f64>,
    count: usize,
    even: usize,
    /// Sum and sum of squares of even intervals, over the usual one.
    sums: (f64, f64),
    jumps: Vec<Jump>,
}

impl Intervals {
    /// Takes the stamps of more rows.
    pub(crate) fn take(&mut self, times: &[f64], rows: &[usize]) {
        for (time, row) in times.iter().zip(rows) {
            if let Some(last) = self.last.replace(*time) {
                match self.usual {
                    Some(usual) => self.judge(usual, *row, time - last),
                    None => self.first.push((*row, time - last)),
                }
            }
            if self.usual.is_none() && self.first.len() >= FIRST {
                self.settle();
            }
        }
    }

    /// Takes the usual interval from the first ones.
    fn settle(&mut self) {
        let mut lengths: Vec<f64> = self.first.iter().map(|(_, by)| *by).collect();
        let middle = lengths.len() / 2;
        if lengths.is_empty() {
            return;
        }
        let usual = *lengths.select_nth_unstable_by(middle, f64::total_cmp).1;
        self.usual = Some(usual);
        for (row, by) in std::mem::take(&mut self.first) {
            self.judge(usual, row, by);
        }
    }

    /// All rows were taken.
    pub(crate) fn end(&mut self) {
        if self.usual.is_none() {
            self.settle();
        }
    }

    fn judge(&mut self, usual: f64, row: usize, by: f64) {
        let part = by / usual;
        self.count += 1;
        if (part - 1.0).abs() < EVEN {
            self.even += 1;
            self.sums = (self.sums.0 + part, self.sums.1 + part * part);
        } else if part > JUMP.0 && self.jumps.len() < MOST {
            self.jumps.push(Jump { row, by });
        }
    }

    /// What is to be said of a file, once all of its rows were taken; `others` are those read beside
    /// it.
    pub(crate) fn told(&mut self, file: &str, others: &[Self]) -> Option<Diagnostic> {
        self.end();
        let (usual, even) = (self.usual?, self.even as f64);
        let mean = self.sums.0 / even;
        let scatter = (self.sums.1 / even - mean * mean).max(0.0).sqrt();
        let is_even = usual > 0.0 && even >= NEARLY_ALL * self.count as f64 && scatter < SCATTER;
        let is_full = self.jumps.len() >= MOST;
        let paused = |jump: &Jump| {
            let mut all = others.iter().flat_map(|other| &other.jumps);
            all.any(|other| (other.by / jump.by - 1.0).abs() < 0.1)
        };
        let is_set = |jump: &&Jump| {
            let part = jump.by / (usual * mean);
            part < JUMP.1 && (part - part.round()).abs() > OFF_WHOLE && !paused(jump)
        };
        let jump = self.jumps.iter().find(is_set).filter(|_| is_even && !is_full)?;
        let message = format!(
            "`{file}`: time jumps by {} s at row {}, where rows come every {} s: no whole number of rows",
            decimals(jump.by, 6),
            jump.row,
            decimals(usual * mean, 6)
        );
        let help = "was the clock set there? `homepoint diagnose` separates that from rows that were lost; of readings, `--with clock_steps` takes it into account; of a stream, split the file there into two runs with delays of their own";
        Some(Diagnostic::warning(message).help(help))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn intervals(times: &[f64]) -> Intervals {
        let mut found = Intervals::default();
        let rows: Vec<usize> = (2..times.len() + 2).collect();
        times.chunks(700).zip(rows.chunks(700)).for_each(|(times, rows)| found.take(times, rows));
        found
    }

    fn told(times: &[f64], other: &[f64]) -> Option<String> {
        let mut others = [intervals(other)];
        others[0].settle();
        intervals(times).told("a.csv", &others).map(|one| one.message)
    }

    #[test]
    fn a_clock_that_was_set_is_told_from_lost_rows_and_pauses() {
        let even: Vec<f64> = (0..5000).map(|n| 0.01 * f64::from(n)).collect();
        let set = |by: f64, jitter: f64| -> Vec<f64> {
            let at = |n: usize, t: &f64| t + if n > 3000 { by } else { 0.0 };
            let shake = |n: usize| jitter * (1.7 * n as f64).sin();
            even.iter().enumerate().map(|(n, t)| at(n, t) + shake(n)).collect()
        };
        let found = told(&set(0.083, 1e-4), &even);
        assert!(found.is_some_and(|one| one.contains("at row 3003") && one.contains("0.0930")));
        // Whole rows are lost; the other file pauses, too; stamps that are not even; none.
        assert_eq!(told(&set(0.08, 1e-4), &even), None);
        assert_eq!(told(&set(0.083, 1e-4), &set(0.083, 0.0)), None);
        assert_eq!(told(&set(0.083, 2e-3), &even), None);
        assert_eq!(told(&even, &even), None);
        assert_eq!(told(&[], &even), None);
        assert_eq!(told(&[0.0, 0.0, 0.0], &even), None);
    }
}
