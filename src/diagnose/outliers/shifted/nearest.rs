//! The nearest moment to which a stretch of readings belongs: a motion that repeats has several.

use std::ops::Range;

use super::{NEAR, SHORTEST, Shift, Shifted, halves, is_worse};

/// Between two moments that are looked at, in sample periods.
const STEP: f64 = 0.5;

impl Shifted<'_> {
    /// The shift of the clock (sample periods), not farther than so many, that carries a stretch back
    /// among the others, each half of it like the other: the nearest one.
    pub(in crate::diagnose::outliers) fn nearest(
        &self,
        periods: isize,
        samples: &Range<usize>,
    ) -> Option<f64> {
        let reach = periods.abs() + 4;
        let count = (periods.abs() as f64 / STEP) as isize + 2;
        let grid: Vec<f64> = (-count..=count).map(|n| STEP * n as f64).collect();
        let shifts: Vec<Shift> = grid.iter().copied().map(Shift::Time).collect();
        let (sums, _) = self.sums(&shifts, samples, reach);
        let is_least = |at: &usize| sums[*at] < sums[at - 1] && sums[*at] <= sums[at + 1];
        let mut least: Vec<f64> = (1..grid.len() - 1).filter(is_least).map(|at| grid[at]).collect();
        least.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
        let refined = least.into_iter().filter_map(|about| {
            let (best, sum, count) = self.grids((about, STEP), samples, reach).last()?;
            let fits = |samples: &Range<usize>| {
                let (sums, count) = self.sums(&[Shift::Time(best)], samples, reach);
                samples.len() < SHORTEST || sums[0] <= NEAR * count
            };
            halves(samples).iter().all(fits).then_some((best, sum, count))
        });
        let refined: Vec<(f64, f64, f64)> = refined.collect();
        let best = refined.iter().map(|one| one.1).fold(f64::INFINITY, f64::min);
        // Of those that fit as well as the best.
        refined.iter().find(|one| !is_worse(one.1, best, one.2)).map(|one| one.0)
    }
}
