//! The moment, and the stretch, at which a change explains most beside a model.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::absorbed::{AbsorbedLengths, Across, EndProducts};
use super::models::Models;
use super::onsets::Onsets;
use crate::diagnose::budget::linear::Linear;
use crate::diagnose::budget::selection::Selection;
use crate::diagnose::budget::selection::normal::Factored;
use crate::diagnose::budget::terms::{Base, Change, LEAST_STRETCH};
use crate::diagnose::library::place::Place;
use crate::diagnose::price::Gain;
use crate::diagnose::thresholds::ENTER;

/// Places in a run at which a stretch begins or ends at most.
const MOST_ENDS: usize = 40;
/// Rounds in which both ends of a stretch are looked for bin by bin.
const END_ROUNDS: usize = 3;
/// Share of a change's squared length below which the model absorbs it.
const ABSORBED: f64 = 1e-6;

/// The first bin, and the one after the last.
type Ends = (usize, usize);

/// A moment from which on a value is different: the run, and the first sample from it on.
pub(super) type Bin = (usize, usize);

/// The stretches of a run that are tried.
struct Stretches {
    /// Its bins.
    run: Ends,
    /// Bins from one end to the next; 0 where the whole run alone is tried.
    step: usize,
    /// Bins with which they begin and end, and the columns there: none behind the last.
    places: Vec<usize>,
    columns: Vec<Option<usize>>,
    ends: EndProducts,
}

impl Linear {
    /// For each base and each of some models the bin from which on a change explains most, where it is
    /// worth it; and whether it is in the place of a part of the whole.
    pub(super) fn best_moments(
        &self,
        selection: &Selection<'_>,
        models: &Models,
        bases: &[Base],
        bins: &[Bin],
    ) -> Vec<(bool, Change)> {
        let Models { whole, factored, lacking, least } = models;
        let Factored { factor, half, columns, .. } = factored;
        let n = columns.len();
        let mut sums: Vec<DMatrix<f64>> =
            bases.iter().map(|_| DMatrix::zeros(n + 3, bins.len())).collect();
        let mut onsets = Onsets::new(n, bases.len(), bins.len());
        let mut of_run: Vec<(usize, usize)> = vec![(0, 0); self.order.len()];
        for (number, (run, _)) in bins.iter().enumerate() {
            let own = &mut of_run[*run];
            *own = if own.1 == 0 { (number, number + 1) } else { (own.0, number + 1) };
        }
        self.visit(selection, whole, bases, &mut |values| {
            let (first, end) = of_run[values.run];
            let own = &bins[first..end];
            let at = own.partition_point(|(_, first)| *first <= values.sample);
            let bin = first + at.saturating_sub(1);
            let weight = selection.scale[values.measurand].powi(-2);
            onsets.see(&values, bin, weight);
            for (sum, x) in sums.iter_mut().zip(values.further) {
                if *x == 0.0 {
                    continue;
                }
                let mut column = sum.column_mut(bin);
                let column = column.as_mut_slice();
                let x = x * weight;
                for (sum, a) in column.iter_mut().zip(values.model) {
                    *sum += x * a;
                }
                column[n] += x * values.residual;
                column[n + 1] += x * x / weight;
            }
        });
        // From each bin on to the end of its campaign.
        let part = |bin: usize| self.fitted.problem.run_at(bins[bin].0).0;
        let totals: Vec<f64> = sums.iter().map(|sum| sum.row(n + 1).iter().sum()).collect();
        for sum in &mut sums {
            for bin in (0..bins.len().saturating_sub(1)).rev() {
                if part(bin) == part(bin + 1) {
                    let later = sum.column(bin + 1).into_owned();
                    let mut own = sum.column_mut(bin);
                    own += later;
                }
            }
        }
        // What is different from the first sample of a campaign on is no change.
        let is_late = |(sum, total): (&DMatrix<f64>, &f64)| -> Vec<bool> {
            sum.row(n + 1).iter().map(|square| square < total).collect()
        };
        let late: Vec<Vec<bool>> = sums.iter().zip(&totals).map(is_late).collect();
        onsets.finish();
        sums.iter_mut().zip(&onsets.added).for_each(|(sum, added)| *sum += added);
        let of_base = |((base, sum), late): ((&Base, &DMatrix<f64>), &Vec<bool>)| {
            let across = factor.across(&sum.rows(0, n).into_owned());
            let across = Across::new(across, half.clone());
            let stretches = self.stretches(*base, bins, &across);
            let is_fixed = self.fixed(base.candidate).is_some();
            let mut all: Vec<(bool, Change)> = Vec::new();
            for (absorbed, least) in AbsorbedLengths::by_each(&across, lacking).iter().zip(least) {
                // What a value that is another one from a bin on gains.
                let gain_from = |bin: usize| -> Option<f64> {
                    let square = sum[(n + 1, bin)];
                    let (taken, along) = absorbed.taken(bin, None);
                    let left = square - taken;
                    (square > 0.0 && left >= ABSORBED * square)
                        .then(|| (sum[(n, bin)] - along).powi(2) / left)
                };
                // Of all moments, and of those at which a run begins.
                let (mut best, mut best_of_runs): (Option<(f64, usize)>, _) = (None, None);
                for bin in 1..bins.len() {
                    let is_whole = || self.is_whole_value(*base, bins[bin], None);
                    if !late[bin] || part(bin) != part(bin - 1) || is_whole() {
                        continue;
                    }
                    let Some(gain) = gain_from(bin) else { continue };
                    let is_better =
                        |best: &Option<(f64, usize)>| best.is_none_or(|one| gain > one.0);
                    if is_better(&best) {
                        best = Some((gain, bin));
                    }
                    if bins[bin].1 == 0 && is_better(&best_of_runs) {
                        best_of_runs = Some((gain, bin));
                    }
                }
                // A value that the campaign fixes may be wrong from the beginning.
                let from_the_first = |(gain, bin): (f64, usize)| {
                    let first = (0..=bin).find(|own| part(*own) == part(bin));
                    first.and_then(gain_from).is_some_and(|whole| whole + 2.0 * ENTER > gain)
                };
                if is_fixed && best.is_some_and(from_the_first) {
                    continue;
                }
                // Things change between runs: only far better evidence places a change within one.
                let of_runs = best_of_runs
                    .zip(best)
                    .filter(|(of_runs, best)| of_runs.0 + 2.0 * ENTER > best.0);
                let best = of_runs.map(|(of_runs, _)| of_runs).or(best);
                let moment = best.map(|(gain, bin)| Change {
                    base: *base,
                    width: 1,
                    at: bins[bin],
                    end: None,
                    gain: Gain { gain, degrees: 1 },
                    members: bins.len(),
                });
                // A stretch has one end more.
                let simpler = moment.as_ref().map_or(0.0, |one| one.gain.gain + 2.0 * ENTER);
                let stretch = self.best_stretch(*base, sum, (absorbed, &stretches), bins);
                let stretch = stretch.filter(|one| {
                    one.gain.gain > simpler && !self.is_whole_value(*base, one.at, one.end)
                });
                let found = moment.into_iter().chain(stretch);
                let worth = found.filter(|one| selection.ln_bayes_factor_of_change(one) >= *least);
                all.extend(worth.map(|one| (absorbed.is_of_a_part(), one)));
            }
            all
        };
        let found = bases.par_iter().zip(&sums).zip(&late).map(of_base).collect::<Vec<_>>();
        found.into_iter().flatten().collect()
    }

    /// The stretches of each run that are tried for a base: its bins, where they may begin and end.
    fn stretches(&self, base: Base, bins: &[Bin], across: &Across) -> Vec<Stretches> {
        // A parameter that changes comes back in another run, if at all.
        let place = self.candidates[base.candidate].place.as_ref();
        let is_whole = place.is_some_and(Place::is_of_a_parameter);
        let mut first = 0;
        let of_run = |own: &[Bin]| {
            let run = (first, first + own.len());
            first = run.1;
            let step = if is_whole { own.len() } else { own.len().div_ceil(MOST_ENDS).max(1) };
            let places: Vec<usize> = (run.0..=run.1).step_by(step).collect();
            let at = |to: &usize| (!self.is_past(bins, run, *to)).then_some(*to);
            let columns: Vec<Option<usize>> = places.iter().map(at).collect();
            let ends = across.ends(&columns);
            Stretches { run, step: if is_whole { 0 } else { step }, places, columns, ends }
        };
        bins.chunk_by(|a, b| a.0 == b.0).map(of_run).collect()
    }

    /// Whether a bin is the one after the last of a run's campaign: running sums begin anew there.
    fn is_past(&self, bins: &[Bin], (first, next): Ends, to: usize) -> bool {
        let part = |bin: usize| bins.get(bin).map(|(run, _)| self.fitted.problem.run_at(*run).0);
        to == next && part(next) != part(first)
    }

    /// The stretch of a run in which a change explains most, of all that begin and end with bins;
    /// running sums of a base as `best_moments` has them.
    fn best_stretch(
        &self,
        base: Base,
        sum: &DMatrix<f64>,
        (absorbed, stretches): (&AbsorbedLengths<'_>, &[Stretches]),
        bins: &[Bin],
    ) -> Option<Change> {
        let n = sum.nrows() - 3;
        let end_of = |run: Ends, to: usize| {
            if to < run.1 { bins[to].1 } else { self.fitted.problem.samples_in(bins[run.0].0) }
        };
        // What a stretch of a run, whose bins are `first..next`, gains, from the squared length that
        // the model absorbs, and the product with what the residual has in common with it.
        let gain = |run: Ends, (from, to): Ends, (taken, along): (f64, f64)| -> Option<f64> {
            if to <= from || end_of(run, to) - bins[from].1 < LEAST_STRETCH {
                return None;
            }
            let later = (!self.is_past(bins, run, to)).then_some(to);
            let within =
                |row: usize| sum[(row, from)] - later.map_or(0.0, |later| sum[(row, later)]);
            // Its end is whitened as its beginning is.
            let shared = later.map_or(0.0, |later| 2.0 * sum[(n + 2, later)]);
            let square = within(n + 1) + shared;
            let left = square - taken;
            (square > 0.0 && left >= ABSORBED * square).then(|| (within(n) - along).powi(2) / left)
        };
        let gain_alone = |run: Ends, (from, to): Ends| -> Option<f64> {
            let later = (!self.is_past(bins, run, to)).then_some(to);
            (to > from)
                .then(|| absorbed.taken(from, later))
                .and_then(|taken| gain(run, (from, to), taken))
        };
        let mut best: Option<(f64, &Stretches, Ends)> = None;
        let mut tried = 0;
        for own in stretches {
            let taken = absorbed.between(&own.ends, &own.columns);
            for (i, from) in own.places.iter().enumerate() {
                for (j, to) in own.places.iter().enumerate().skip(i + 1) {
                    let gain = gain(own.run, (*from, *to), taken(i, j));
                    tried += usize::from(gain.is_some());
                    if let Some(gain) = gain.filter(|gain| best.is_none_or(|best| *gain > best.0)) {
                        best = Some((gain, own, (*from, *to)));
                    }
                }
            }
        }
        // Either end bin by bin, while the other one stays.
        let (mut most, Stretches { run, step, .. }, (mut from, mut to)) = best?;
        let (run, step) = (*run, *step);
        for _ in 0..if step > 0 { END_ROUNDS } else { 0 } {
            let (near_from, near_to) = (from, to);
            for other in near_from.saturating_sub(step).max(run.0)..(near_from + step).min(run.1) {
                if let Some(gain) = gain_alone(run, (other, to)).filter(|gain| *gain > most) {
                    (most, from) = (gain, other);
                }
            }
            for other in near_to.saturating_sub(step)..=(near_to + step).min(run.1) {
                if let Some(gain) = gain_alone(run, (from, other)).filter(|gain| *gain > most) {
                    (most, to) = (gain, other);
                }
            }
            tried += 4 * step;
        }
        let gain = Gain { gain: most, degrees: 1 };
        let (at, end) = (bins[from], Some(end_of(run, to)));
        Some(Change { base, width: 1, at, end, gain, members: tried })
    }
}
