//! The moment, and the stretch, at which a change explains most beside a model.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::diagnose::budget::linear::Linear;
use crate::diagnose::budget::selection::Selection;
use crate::diagnose::budget::selection::normal::Factored;
use crate::diagnose::budget::terms::{Base, Change};
use crate::diagnose::library::place::Place;
use crate::diagnose::price::Gain;

/// Samples of a stretch at least: fewer are outliers.
const LEAST_STRETCH: usize = 8;
/// Places in a run at which a stretch begins or ends at most.
const MOST_ENDS: usize = 40;
/// Rounds in which both ends of a stretch are looked for bin by bin.
const END_ROUNDS: usize = 3;
/// Share of a change's squared length below which the model takes it up.
const TAKEN_UP: f64 = 1e-6;

/// The first bin, and the one after the last.
type Ends = (usize, usize);

/// A moment from which on a value is different: the run, and the first sample from it on.
pub(super) type Bin = (usize, usize);

/// The columns of a model that is a part of another, among those of that.
fn columns_within(selection: &Selection<'_>, whole: &[usize], part: &[usize]) -> Vec<usize> {
    let nominal = 0..selection.nominal();
    let of_terms = whole.iter().zip(selection.ranges(whole));
    let kept = of_terms.filter(|(term, _)| part.contains(term)).flat_map(|(_, range)| range);
    nominal.chain(kept).collect()
}

impl Linear {
    /// For each base and each of some models, all of them parts of one, the bin from which on a
    /// change explains most, where its log Bayes factor is at least that of the model.
    pub(super) fn best_moments(
        &self,
        selection: &Selection<'_>,
        (whole, models, least): (&[usize], &[Vec<usize>], &[f64]),
        bases: &[Base],
        bins: &[Bin],
    ) -> Vec<Change> {
        let n = selection.columns(whole).len();
        let mut sums: Vec<DMatrix<f64>> =
            bases.iter().map(|_| DMatrix::zeros(n + 2, bins.len())).collect();
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
        let of_model = |(model, least): (&Vec<usize>, &f64)| {
            let mut found: Vec<Change> = Vec::new();
            let kept = columns_within(selection, whole, model);
            let Factored { factor, half, .. } = selection.factored(model);
            for ((base, sum), total) in bases.iter().zip(&sums).zip(&totals) {
                let across = factor.across(sum.select_rows(&kept));
                let mut best: Option<(f64, usize)> = None;
                for bin in 1..bins.len() {
                    let square = sum[(n + 1, bin)];
                    // What is different from the first sample of a campaign on is no change.
                    if square <= 0.0 || square >= *total || part(bin) != part(bin - 1) {
                        continue;
                    }
                    let across = across.column(bin);
                    let left = square - across.norm_squared();
                    if left < TAKEN_UP * square {
                        continue;
                    }
                    let gain = (sum[(n, bin)] - across.dot(&half)).powi(2) / left;
                    if best.is_none_or(|(known, _)| gain > known) {
                        best = Some((gain, bin));
                    }
                }
                found.extend(best.map(|(gain, bin)| Change {
                    base: *base,
                    at: bins[bin],
                    end: None,
                    gain: Gain { gain, degrees: 1 },
                    members: bins.len(),
                }));
                found.extend(self.best_stretch(*base, sum, (&across, &half), bins));
            }
            found.retain(|one| selection.ln_bayes_factor_of_change(one) >= *least);
            found
        };
        let found = models.par_iter().zip(least).map(of_model).collect::<Vec<_>>();
        found.into_iter().flatten().collect()
    }

    /// The stretch of a run in which a change explains most, of all that begin and end with bins;
    /// running sums of a base as `best_moments` has them.
    fn best_stretch(
        &self,
        base: Base,
        sum: &DMatrix<f64>,
        (across, half): (&DMatrix<f64>, &DVector<f64>),
        bins: &[Bin],
    ) -> Option<Change> {
        let n = sum.nrows() - 2;
        let part = |bin: usize| bins.get(bin).map(|(run, _)| self.fitted.problem.run_at(*run).0);
        // Running sums begin anew with each campaign.
        let is_past = |(first, next): Ends, to: usize| to == next && part(next) != part(first);
        // What a stretch of a run, whose bins are `first..next`, gains, from the squared length that
        // the model takes up, and the product with what the residual has in common with it.
        let gain = |run: Ends, (from, to): Ends, (taken, along): (f64, f64)| -> Option<f64> {
            let end =
                if to < run.1 { bins[to].1 } else { self.fitted.problem.samples_in(bins[run.0].0) };
            if to <= from || end - bins[from].1 < LEAST_STRETCH {
                return None;
            }
            let within =
                |row: usize| sum[(row, from)] - if is_past(run, to) { 0.0 } else { sum[(row, to)] };
            let square = within(n + 1);
            let left = square - taken;
            (square > 0.0 && left >= TAKEN_UP * square).then(|| (within(n) - along).powi(2) / left)
        };
        let gain_alone = |run: Ends, (from, to): Ends| -> Option<f64> {
            let to_end = is_past(run, to);
            let (mut taken, mut along) = (0.0, 0.0);
            for i in 0..if to > from { half.len() } else { 0 } {
                let own = across[(i, from)] - if to_end { 0.0 } else { across[(i, to)] };
                taken += own * own;
                along += own * half[i];
            }
            gain(run, (from, to), (taken, along))
        };
        // A parameter that changes comes back in another run, if at all.
        let place = self.candidates[base.candidate].place.as_ref();
        let is_whole = place.is_some_and(Place::is_of_a_parameter);
        let mut best: Option<(f64, Ends, Ends)> = None;
        let mut tried = 0;
        let mut first = 0;
        for own in bins.chunk_by(|a, b| a.0 == b.0) {
            let run = (first, first + own.len());
            let step = if is_whole { own.len() } else { own.len().div_ceil(MOST_ENDS).max(1) };
            let ends: Vec<usize> = (run.0..=run.1).step_by(step).collect();
            // All products at once: of what the model takes up at each end with that at each other.
            let at_ends = DMatrix::from_fn(half.len(), ends.len(), |i, end| {
                if is_past(run, ends[end]) { 0.0 } else { across[(i, ends[end])] }
            });
            let products = at_ends.transpose() * &at_ends;
            let along = at_ends.tr_mul(half);
            for (i, from) in ends.iter().enumerate() {
                for (j, to) in ends.iter().enumerate().skip(i + 1) {
                    let taken = products[(i, i)] - 2.0 * products[(i, j)] + products[(j, j)];
                    let (from, to) = (*from, *to);
                    let gain = gain(run, (from, to), (taken, along[i] - along[j]));
                    tried += usize::from(gain.is_some());
                    if let Some(gain) = gain.filter(|gain| best.is_none_or(|best| *gain > best.0)) {
                        best = Some((gain, run, (from, to)));
                    }
                }
            }
            first = run.1;
        }
        // Either end bin by bin, while the other one stays.
        let (mut most, run, (mut from, mut to)) = best?;
        let step = (run.1 - run.0).div_ceil(MOST_ENDS);
        for _ in 0..if is_whole { 0 } else { END_ROUNDS } {
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
        let end =
            if to < run.1 { bins[to].1 } else { self.fitted.problem.samples_in(bins[run.0].0) };
        let gain = Gain { gain: most, degrees: 1 };
        Some(Change { base, at: bins[from], end: Some(end), gain, members: tried })
    }
}
