//! Pairs of effects: two whose forms nearly cancel explain together what neither explains alone,
//! such as the collimation and the non-perpendicularity of a telescope. Terms that enter one after
//! the other never find them.

use nalgebra::DVector;
use rayon::prelude::*;

use crate::diagnose::budget::selection::Selection;
use crate::diagnose::budget::selection::normal::{Beside, gain_of};
use crate::diagnose::budget::terms::Combination;
use crate::diagnose::price::ln_bayes_factor;
use crate::diagnose::thresholds::ENTER;

/// Columns of an effect that is tried in pairs at most.
const MOST_COLUMNS: usize = 8;

impl Selection<'_> {
    /// The two effects of a pool that together explain most beside a model, if they are worth the
    /// price of both.
    pub(super) fn best_pair(&self, model: &[usize], pool: &[usize]) -> Option<[usize; 2]> {
        let is_tried = |term: &&usize| {
            let columns = self.terms[**term].columns.len();
            self.terms[**term].may_enter && !model.contains(term) && columns <= MOST_COLUMNS
        };
        let tried: Vec<usize> = pool.iter().filter(is_tried).copied().collect();
        let (mut columns, mut ranges): (Vec<Combination>, Vec<_>) = (Vec::new(), Vec::new());
        for term in &tried {
            let first = columns.len();
            columns.extend(self.terms[*term].columns.iter().cloned());
            ranges.push(first..columns.len());
        }
        let Beside { left, score, raw, .. } = self.across(&self.factored(model), &columns);
        let ln_bayes = |(i, j): (usize, usize)| {
            let at: Vec<usize> = ranges[i].clone().chain(ranges[j].clone()).collect();
            let of =
                |all: &DVector<f64>| DVector::from_iterator(at.len(), at.iter().map(|k| all[*k]));
            let left = left.select_rows(&at).select_columns(&at);
            let gain = gain_of(&left, &of(&score), &of(&raw));
            let [a, b] = [i, j].map(|k| &self.terms[tried[k]]);
            let candidates = self.candidates(tried[i]).pow(2);
            ln_bayes_factor(gain, a.members * b.members, candidates) + a.ln_prior + b.ln_prior
        };
        let pairs: Vec<(usize, usize)> =
            (0..tried.len()).flat_map(|j| (0..j).map(move |i| (i, j))).collect();
        let priced = pairs.into_par_iter().map(|pair| (ln_bayes(pair), pair));
        let best = priced.max_by(|a, b| a.0.total_cmp(&b.0))?;
        (best.0 >= ENTER).then(|| [tried[best.1.0], tried[best.1.1]])
    }
}
