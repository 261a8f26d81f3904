//! What terms would gain in the place of a term of a model, for any of its terms: the model is
//! factored once.
//!
//! With `C` the covariance of the model's values `v`, and of a candidate `j` the Schur complement `S`
//! and score `g` beside the model and `w = C H_Mj`, both without the terms `t` are
//! `S + w_tᵀ C_tt⁻¹ w_t` and `g + w_tᵀ C_tt⁻¹ v_t`: the inverse of a matrix without a block.

use std::ops::Range;

use nalgebra::linalg::Cholesky;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::normal::{Beside, gain_beyond_streams};
use super::ranked::TOGETHER;
use super::{Ranked, Selection};

/// Candidates beside a model.
#[derive(Debug)]
pub struct Exchange<'s> {
    selection: &'s Selection<'s>,
    /// The model.
    pub model: Vec<usize>,
    ranges: Vec<Range<usize>>,
    values: DVector<f64>,
    values_of_streams: Option<DVector<f64>>,
    covariance: DMatrix<f64>,
    candidates: Vec<Candidate>,
}

#[derive(Debug)]
struct Candidate {
    term: usize,
    beside: Beside,
    /// `C H_Mj`.
    coefficients: DMatrix<f64>,
}

impl<'s> Exchange<'s> {
    /// Of the terms of a pool that may enter a model.
    pub fn new(selection: &'s Selection<'s>, model: &[usize], pool: &[usize]) -> Self {
        let factored = selection.factored(model);
        let candidate = |(term, beside): (&usize, Beside)| {
            let coefficients = factored.factor.back(&beside.across);
            Candidate { term: *term, beside, coefficients }
        };
        let may_enter = |term: &usize| selection.terms[*term].may_enter && !model.contains(term);
        let pool: Vec<usize> = pool.iter().copied().filter(may_enter).collect();
        let candidates = pool.par_chunks(TOGETHER).flat_map_iter(|terms| {
            let beside = selection.across_each(&factored, terms);
            terms.iter().zip(beside).map(candidate).collect::<Vec<_>>()
        });
        let candidates = candidates.collect();
        let (values, covariance) = factored.solved();
        let values_of_streams = factored.values_of_streams();
        let ranges = selection.ranges(model);
        let model = model.to_vec();
        Self { selection, model, ranges, values, values_of_streams, covariance, candidates }
    }

    /// The best of some candidates in the place of a term of the model.
    pub fn best(&self, out: usize, is_one: impl Fn(usize) -> bool + Sync) -> Option<Ranked> {
        let of_terms = self.model.iter().zip(&self.ranges);
        let at = of_terms.filter(|(term, _)| **term == out).flat_map(|(_, at)| at.clone());
        let at: Vec<usize> = at.collect();
        let own = Cholesky::new(self.covariance.select_rows(&at).select_columns(&at));
        let Some(own) = own else {
            // Sums that do not determine their values.
            let rest = self.model.iter().copied().filter(|one| *one != out);
            let pool = self.candidates.iter().map(|one| one.term).filter(|term| is_one(*term));
            let (rest, pool): (Vec<usize>, Vec<usize>) = (rest.collect(), pool.collect());
            return self.selection.ranked(&rest, &pool).first().copied();
        };
        let back = |values: &DVector<f64>| own.solve(&values.select_rows(&at));
        let (values, streams) = (back(&self.values), self.values_of_streams.as_ref().map(back));
        let ranked = self.candidates.par_iter().filter(|one| is_one(one.term)).map(|one| {
            let coefficients = one.coefficients.select_rows(&at);
            let Beside { left, score, of_streams, raw, .. } = &one.beside;
            let left = left + coefficients.transpose() * own.solve(&coefficients);
            let of_streams = of_streams.as_ref().zip(streams.as_ref());
            let of_streams = of_streams.map(|(own, values)| own + coefficients.tr_mul(values));
            let score = score + coefficients.tr_mul(&values);
            let gain = gain_beyond_streams(&left, &score, of_streams.as_ref(), raw);
            let ln_bayes = self.selection.ln_bayes_factor(one.term, gain);
            Ranked { term: one.term, gain, ln_bayes }
        });
        // The first of equals, whatever the number of threads.
        let ranked: Vec<Ranked> = ranked.collect();
        ranked.into_iter().rev().max_by(|a, b| a.ln_bayes.total_cmp(&b.ln_bayes))
    }
}
