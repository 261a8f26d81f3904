//! Whether the values of a row differ between groups of readings.

use nalgebra::{DMatrix, DVector};

use crate::diagnose::budget::labels::Label;
use crate::diagnose::budget::pieces::Pieces;
use crate::diagnose::budget::selection::Selection;
use crate::diagnose::budget::selection::normal::gain_of;
use crate::diagnose::budget::terms::Combination;
use crate::diagnose::price::price;
use crate::estimate::inverse_factor::Factor;

/// Groups that have values of their own at most.
const MOST_GROUPS: usize = 12;

impl Selection<'_> {
    /// The log Bayes factor of separate values of a row by groups of readings against one value for
    /// all, the largest of the wanted labels, and their gain.
    pub(in crate::diagnose::budget) fn separate_values(
        &self,
        model: &[usize],
        at: usize,
        pieces: &Pieces,
        wanted: impl Fn(&Label) -> bool,
    ) -> Option<(Label, f64, f64)> {
        let term = &self.terms[model[at]];
        let mut base: Vec<Combination> = self.columns(model);
        base.push(self.residual().clone());
        let k = term.columns.len();
        let own_at = self.ranges(model)[at].start;
        let weights = self.weights();
        let prior = self.prior(&base);
        let n = base.len() - 1;
        let mut best: Option<(Label, f64, f64)> = None;
        for grouping in &pieces.labels {
            let count = grouping.count();
            if !(2..=MOST_GROUPS).contains(&count) || !wanted(&grouping.label) {
                continue;
            }
            // Sums of each group: its own columns are zero elsewhere.
            let of: Vec<_> = (0..count)
                .map(|group| {
                    let holds = |run, measurand| grouping.holds(group, run, measurand);
                    pieces.products(&weights, |piece, own| holds(piece.run, own))
                })
                .collect();
            let size = k * (count - 1);
            let mut whole = of.iter().skip(1).fold(of[0].clone(), |sum, more| sum + more);
            whole += &prior;
            let factor = Factor::of(&whole.view((0, 0), (n, n)).into_owned());
            let mut across = DMatrix::zeros(n, size);
            let mut own = DMatrix::zeros(size, size);
            let mut score = DVector::zeros(size);
            for (group, sums) in of.iter().enumerate().skip(1) {
                let first = k * (group - 1);
                for j in 0..k {
                    for i in 0..n {
                        across[(i, first + j)] = sums[(i, own_at + j)];
                    }
                    for i in 0..k {
                        own[(first + i, first + j)] = sums[(own_at + i, own_at + j)];
                    }
                    score[first + j] = sums[(own_at + j, n)];
                }
            }
            let raw = own.diagonal().map(|square: f64| square.max(0.0).sqrt());
            let half = factor.half(&whole.view((0, n), (n, 1)).column(0).into_owned());
            let across = factor.across(&across);
            let left = own - across.transpose() * &across;
            let score = score - across.tr_mul(&half);
            let gain = gain_of(&left, &score, &raw);
            if gain.degrees == 0 {
                continue;
            }
            let ln_bayes = 0.5 * gain.gain - price(gain, 1, 1);
            if best.as_ref().is_none_or(|(_, known, _)| ln_bayes > *known) {
                best = Some((grouping.label.clone(), ln_bayes, gain.gain));
            }
        }
        best
    }
}
