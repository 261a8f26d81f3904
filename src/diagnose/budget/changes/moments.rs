//! The moment, and the stretch, at which a change explains most beside a model.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::diagnose::budget::linear::Linear;
use crate::diagnose::budget::selection::Selection;
use crate::diagnose::budget::terms::{Base, Change};
use crate::diagnose::price::Gain;

/// Samples of a stretch at least: fewer are outliers.
const LEAST_STRETCH: usize = 8;
/// Places in a run at which a stretch begins or ends at most.
const MOST_ENDS: usize = 40;
/// Share of a change's squared length below which the model takes it up.
const TAKEN_UP: f64 = 1e-6;

/// A moment from which on a value is different.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bin {
    /// The run.
    pub(super) run: usize,
    /// The first sample from it on.
    pub(super) first: usize,
}

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
        for (number, bin) in bins.iter().enumerate() {
            let own = &mut of_run[bin.run];
            *own = if own.1 == 0 { (number, number + 1) } else { (own.0, number + 1) };
        }
        self.visit(selection, whole, bases, &mut |values| {
            let (first, end) = of_run[values.run];
            let own = &bins[first..end];
            let at = own.partition_point(|bin| bin.first <= values.sample);
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
        let part = |bin: usize| self.part_of(bins[bin].run).0;
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
            let (inverse, length, half) = selection.normal_equations(model);
            for ((base, sum), total) in bases.iter().zip(&sums).zip(&totals) {
                let scaled = DMatrix::from_fn(kept.len(), bins.len(), |i, bin| {
                    sum[(kept[i], bin)] / length[i]
                });
                let across = &inverse * scaled;
                let mut best: Option<(f64, usize)> = None;
                for bin in 1..bins.len() {
                    let square = sum[(n + 1, bin)];
                    if square <= 0.0 || square >= *total {
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
                    at: (bins[bin].run, bins[bin].first),
                    end: None,
                    gain: Gain { gain, degrees: 1 },
                    members: bins.len(),
                }));
                let across_of = (&across, &half);
                found.extend(self.best_stretch(sum, across_of, bins).map(|mut one| {
                    one.base = *base;
                    one
                }));
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
        sum: &DMatrix<f64>,
        (across, half): (&DMatrix<f64>, &DVector<f64>),
        bins: &[Bin],
    ) -> Option<Change> {
        let n = sum.nrows() - 2;
        let mut best: Option<(f64, usize, usize)> = None;
        let mut tried = 0;
        let mut first = 0;
        while first < bins.len() {
            let run = bins[first].run;
            let count = bins[first..].iter().take_while(|bin| bin.run == run).count();
            let next = first + count;
            let is_last =
                next >= bins.len() || self.part_of(bins[next].run).0 != self.part_of(run).0;
            let step = count.div_ceil(MOST_ENDS).max(1);
            for from in (first..next).step_by(step) {
                for to in (from + step..=next).step_by(step) {
                    let whole = to == next && is_last;
                    let end = bins.get(to).filter(|bin| bin.run == run);
                    let end = end.map_or_else(|| self.samples_in(run), |bin| bin.first);
                    if end - bins[from].first < LEAST_STRETCH {
                        continue;
                    }
                    tried += 1;
                    let beyond = |row: usize| if whole { 0.0 } else { sum[(row, to)] };
                    let square = sum[(n + 1, from)] - beyond(n + 1);
                    if square <= 0.0 {
                        continue;
                    }
                    let (mut taken, mut along) = (0.0, 0.0);
                    for i in 0..half.len() {
                        let own = across[(i, from)] - if whole { 0.0 } else { across[(i, to)] };
                        taken += own * own;
                        along += own * half[i];
                    }
                    let left = square - taken;
                    if left < TAKEN_UP * square {
                        continue;
                    }
                    let score = sum[(n, from)] - beyond(n) - along;
                    let gain = score * score / left;
                    if best.is_none_or(|(known, ..)| gain > known) {
                        best = Some((gain, from, to));
                    }
                }
            }
            first = next;
        }
        best.map(|(gain, from, to)| {
            let run = bins[from].run;
            let same = bins.get(to).filter(|bin| bin.run == run);
            let end = same.map_or_else(|| self.samples_in(run), |bin| bin.first);
            Change {
                base: Base { candidate: 0, signature: 0 },
                at: (run, bins[from].first),
                end: Some(end),
                gain: Gain { gain, degrees: 1 },
                members: tried,
            }
        })
    }
}
