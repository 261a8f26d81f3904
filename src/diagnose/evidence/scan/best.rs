//! The best member of a family: of a grid, where that misses none, else of finer grids where values of
//! each run's own explain most; then between its neighbours.

use crate::diagnose::fitted::Fitted;
use crate::diagnose::library::candidate::Candidate;
use crate::diagnose::thresholds::TIE;
use crate::effect::Members;

use super::grid::{NEIGHBOURS, Tried};
use super::{Scan, TOGETHER};

/// Of many members those that are looked at with what nominal parameters absorb taken off.
const BEST: usize = 40;
/// Members that are all looked at so: as a pass with the nominal columns costs half as much again, a
/// choice of the best of them by a pass without would take longer.
const FEW: usize = 3 * BEST;
/// Members of a grid with values of each run's own near which a finer one looks.
const PEAKS: usize = 4;
/// Passes between the neighbours of the best member, at most, and what another may add to the gain
/// for it to be worth it.
const POLISH: usize = 4;
const WORTH: f64 = 0.01;

/// The best member of a family, and the number of members that it was chosen among.
pub(super) fn best_member(fitted: &Fitted, family: &Candidate) -> Option<(f64, usize)> {
    let mut scan = Scan::new(fitted, family)?;
    if scan.is_fast {
        return scan.best_of_spectrum();
    }
    let Tried { members, paid, is_coarse } = scan.tried()?;
    let whole = scan.best_of(&members);
    let by_runs = if is_coarse { scan.best_by_runs() } else { None };
    let of_first = if is_coarse { scan.best_of_first() } else { None };
    // With the finer grids all members of the range are paid for.
    let paid = if by_runs.is_some() || of_first.is_some() { paid } else { 2 * members.len() };
    let found = whole.into_iter().chain(by_runs).chain(of_first);
    let best = found.max_by(|a, b| a.1.total_cmp(&b.1));
    best.map(|(value, _)| (value, paid))
}

/// Share of a gain by which members differ that the readings do not tell apart.
const SAME: f64 = 1e-6;

/// Share of the gain of the best member by which another that is nearly as good is worse at most.
const NEARLY: f64 = 0.2;

/// Whether a member, by its place and gain, is better than another. Of those that the readings do not
/// tell apart, as waves through few angles, the first is.
fn is_better(one: (usize, f64), other: (usize, f64)) -> bool {
    let near = SAME * other.1.abs();
    if (one.1 - other.1).abs() <= near { one.0 < other.0 } else { one.1 > other.1 }
}

/// By how much less a member gains that is as good as the best one but for a tie of log Bayes factors,
/// with noise of this variance. Where that holds other structure, a share of the gain is the limit: of a
/// wave of another order there is less.
fn nearly(gain: f64, noise: f64) -> f64 {
    (2.0 * TIE * noise).min(NEARLY * gain)
}

/// The first of members by their places and gains that is nearly as good as the best one.
fn first_within(gains: &[(usize, f64)], best: (usize, f64), noise: f64) -> usize {
    let as_good = gains.iter().filter(|(_, gain)| best.1 - gain <= nearly(best.1, noise));
    as_good.map(|(place, _)| *place).fold(best.0, usize::min)
}

/// The members of a grid, by their places in order, that gain more than those beside them.
fn peaks(gains: &[(usize, f64)]) -> Vec<(usize, f64)> {
    let mut all = gains.to_vec();
    all.sort_by_key(|one| one.0);
    let is_peak = |at: &usize| {
        let (place, gain) = all[*at];
        let beside = [at.checked_sub(1), Some(at + 1)].into_iter().flatten();
        let beside = beside.filter_map(|other| all.get(other));
        beside.filter(|one| one.0.abs_diff(place) == 1).all(|one| one.1 <= gain)
    };
    (0..all.len()).filter(is_peak).map(|at| all[at]).collect()
}

impl Scan<'_> {
    /// What the members of a grid gain, those that may gain most.
    fn gains_of(&self, grid: &[f64]) -> Vec<(usize, f64)> {
        let mut order: Vec<usize> = (0..grid.len()).collect();
        if grid.len() > FEW {
            let plain =
                grid.chunks(TOGETHER).flat_map(|members| self.added(&self.alone, members, None));
            let plain: Vec<f64> = plain.collect();
            order.sort_by(|a, b| plain[*b].total_cmp(&plain[*a]));
            order.truncate(BEST);
        }
        let gains = order.chunks(TOGETHER).flat_map(|members| {
            let values: Vec<f64> = members.iter().map(|member| grid[*member]).collect();
            members.iter().copied().zip(self.gains(&values))
        });
        gains.collect()
    }

    /// The best member of a grid, polished where it is one of a range, and its gain.
    fn best_of(&self, grid: &[f64]) -> Option<(f64, f64)> {
        let gains = self.gains_of(grid);
        let better = |best, other| if is_better(other, best) { other } else { best };
        let best = gains.iter().copied().reduce(better)?;
        if matches!(self.members, Members::List(_)) {
            return Some((grid[first_within(&gains, best, self.noise_beside(best.1))], best.1));
        }
        let polished =
            |(at, gain): (usize, f64)| self.polished(neighbours(grid, at), (grid[at], gain));
        let top = polished(best);
        let near = nearly(top.1, self.noise_beside(top.1));
        // The first of the peaks that are as good: at even places, or nearly so, fine waves are long ones.
        let peaks = if self.is_over_motion { peaks(&gains) } else { Vec::new() };
        let before = peaks.into_iter().filter(|one| one.0 < best.0 && one.1 >= NEIGHBOURS * top.1);
        let first = before.map(polished).find(|one| top.1 - one.1 <= near);
        Some(first.unwrap_or(top))
    }

    /// The variance of the noise that a gain leaves. Of places that are nearly even the noise decides which
    /// of several waves fits best.
    fn noise_beside(&self, gain: f64) -> f64 {
        self.fitted.variance_factor() * (1.0 - gain / self.fitted.fit.cost).max(0.0)
    }

    /// The best member of a range of which a grid that misses none has too many: where values hold
    /// together over many runs, lines are as narrow as all of them are long. With values of each run's
    /// own they are wider; where those explain most, the others are looked for. `None` where lines of
    /// runs are as narrow.
    fn best_by_runs(&mut self) -> Option<(f64, f64)> {
        let Members::Range { from, to } = self.members else { return None };
        self.is_by_runs = true;
        let coarse = self.grid(*from, *to).filter(|grid| !grid.is_coarse);
        let mut gains = coarse.as_ref().map_or_else(Vec::new, |grid| self.gains_of(&grid.members));
        self.is_by_runs = false;
        let coarse = coarse?.members;
        gains.sort_by(|a, b| b.1.total_cmp(&a.1));
        let near = gains.iter().take(PEAKS).filter_map(|(at, _)| {
            let (low, high) = neighbours(&coarse, *at);
            self.best_of(&self.grid(low, high)?.members)
        });
        near.max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The best member near the low end of a range of waves over what moves, of which a grid has too
    /// many: a long way has room for more fine waves than samples show, and it is the long ones that these
    /// show best. `None` of other families.
    fn best_of_first(&self) -> Option<(f64, f64)> {
        let Members::Range { from, to } = self.members else { return None };
        if self.is_over_motion { self.best_of(&self.first_of(*from, *to)) } else { None }
    }

    /// The best value between two members about the best one, and its gain.
    pub(super) fn polished(
        &self,
        (mut low, mut high): (f64, f64),
        mut best: (f64, f64),
    ) -> (f64, f64) {
        let neighbours = high - low;
        for _ in 0..POLISH {
            // The gain falls by the square of the distance, and to `NEIGHBOURS` at the next.
            let away = (high - low) / neighbours;
            if best.1 * (1.0 - NEIGHBOURS) * away.powi(2) < WORTH {
                break;
            }
            let part = (high - low) / (TOGETHER + 1) as f64;
            let between: Vec<f64> = (1..=TOGETHER).map(|one| low + part * one as f64).collect();
            for (value, gain) in between.iter().zip(self.gains(&between)) {
                if gain > best.1 {
                    best = (*value, gain);
                }
            }
            let below = between.iter().copied().filter(|value| *value < best.0);
            let above = between.iter().copied().filter(|value| *value > best.0);
            (low, high) = (below.fold(low, f64::max), above.fold(high, f64::min));
        }
        best
    }
}

/// The members before and after one of a grid.
fn neighbours(grid: &[f64], at: usize) -> (f64, f64) {
    (grid[at.saturating_sub(1)], grid[(at + 1).min(grid.len() - 1)])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An order and its alias at places that are nearly even; a wave of another order is no alias, however
    /// noisy other readings are.
    #[test]
    fn of_members_that_are_nearly_as_good_the_first_is_taken() {
        let gains = [(0, 12.0), (1, 97.0), (2, 3.0), (21, 100.0), (40, 99.0)];
        assert_eq!(first_within(&gains, (21, 100.0), 1.0), 1);
        assert_eq!(first_within(&gains, (21, 100.0), 0.1), 21);
        assert_eq!(first_within(&gains, (21, 100.0), 1e6), 1);
        assert_eq!(first_within(&[(0, 60.0), (9, 100.0)], (9, 100.0), 1e6), 9);
    }

    #[test]
    fn peaks_are_higher_than_what_stands_beside_them() {
        let gains = [(7, 9.0), (2, 3.0), (3, 8.0), (4, 5.0), (12, 1.0), (6, 2.0)];
        assert_eq!(peaks(&gains), [(3, 8.0), (7, 9.0), (12, 1.0)]);
    }
}
