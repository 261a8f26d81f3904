//! Terms beside a model, best first, and what each of the model's own terms contributes.

use std::ops::Range;

use nalgebra::linalg::Cholesky;
use rayon::prelude::*;

use super::Selection;
use super::normal::{Factored, gain_beyond_streams, ln_bayes_factor_of_sizes};
use crate::diagnose::budget::terms::without;
use crate::diagnose::price::{Gain, ln_bayes_factor_of_any_noise, price};

/// Terms whose products with a model are taken together.
pub(super) const TOGETHER: usize = 32;

/// A term beside a model.
#[derive(Clone, Copy, Debug)]
pub struct Ranked {
    /// The term.
    pub term: usize,
    /// What it takes off chi squared.
    pub gain: Gain,
    /// Its log Bayes factor.
    pub ln_bayes: f64,
}

impl Selection<'_> {
    /// Terms of a pool beside a model, best first: log Bayes factor, term, gain.
    pub fn ranked(&self, model: &[usize], pool: &[usize]) -> Vec<Ranked> {
        let factored = self.factored(model);
        let may_enter = |term: &usize| self.terms[*term].may_enter && !model.contains(term);
        let pool: Vec<usize> = pool.iter().copied().filter(may_enter).collect();
        let ranked = pool.par_chunks(TOGETHER).flat_map_iter(|terms| {
            let beside = self.across_each(&factored, terms);
            terms.iter().zip(beside).map(|(term, beside)| {
                let gain = beside.gain();
                Ranked { term: *term, gain, ln_bayes: self.ln_bayes_factor(*term, gain) }
            })
        });
        let mut ranked: Vec<Ranked> = ranked.collect();
        ranked.sort_by(|a, b| b.ln_bayes.total_cmp(&a.ln_bayes));
        ranked
    }

    /// Ranks terms beside a model anew, each as if it may be most of what the model leaves: noise that this
    /// model makes look large hides a wide one of few readings.
    pub fn rank_under_any_noise(&self, model: &[usize], ranked: &mut [Ranked]) {
        let readings = |of: &[usize]| of.iter().map(|one| self.sums.readings[*one]).sum::<usize>();
        let all: Vec<usize> = (0..self.scale.len()).collect();
        let freedom_of_a_reading = self.chi_squared(model) / readings(&all).max(1) as f64;
        for one in ranked.iter_mut() {
            let own = &self.terms[one.term];
            let freedom = freedom_of_a_reading * readings(&self.measurands_of(one.term)) as f64;
            let candidates = self.candidates(one.term);
            let priced = ln_bayes_factor_of_any_noise(one.gain, freedom, own.members, candidates);
            one.ln_bayes = priced + own.ln_prior;
        }
        ranked.sort_by(|a, b| b.ln_bayes.total_cmp(&a.ln_bayes));
    }

    /// What each term of a model contributes beyond the others: with `C` the covariance of its values
    /// `v` beside these, `S = C⁻¹` and `g = S v`.
    pub fn contributions(&self, model: &[usize]) -> Vec<Gain> {
        self.contributions_in(model, &self.factored(model))
    }

    fn contributions_in(&self, model: &[usize], factored: &Factored) -> Vec<Gain> {
        let (values, covariance) = factored.solved();
        let streams = factored.values_of_streams();
        let gain = |(term, range): (&usize, Range<usize>)| {
            let (at, k) = (range.start, range.len());
            let own = covariance.view((at, at), (k, k)).into_owned();
            let Some(factor) = Cholesky::new(own) else {
                return self.gain(&without(model, *term), *term);
            };
            let left = factor.inverse();
            let score = &left * values.rows(at, k);
            let of_streams = streams.as_ref().map(|values| &left * values.rows(at, k));
            let raw = factored.factor.length.rows(at, k).into_owned();
            gain_beyond_streams(&left, &score, of_streams.as_ref(), &raw)
        };
        model.iter().zip(self.ranges(model)).map(gain).collect()
    }

    /// The log posterior odds of a term beside a model, its values normal about zero with these typical
    /// sizes: one whose values would show otherwise is not there. Where a size is not known, or nothing
    /// of the term is left beside the model, at the size that suits its gain best.
    pub(in crate::diagnose::budget) fn ln_odds_at(
        &self,
        model: &[usize],
        term: usize,
        typical: &[Option<f64>],
    ) -> f64 {
        let own = &self.terms[term];
        let beside = self.across(&self.factored(model), &own.columns);
        let gain = beside.gain();
        let sizes: Option<Vec<f64>> = typical.iter().copied().collect();
        let Some(sizes) = sizes.filter(|_| gain.degrees > 0) else {
            return self.ln_bayes_factor(term, gain);
        };
        let score = match &beside.of_streams {
            Some(added) => &beside.score - added,
            None => beside.score,
        };
        let choices = own.members.max(1) as f64 * self.candidates(term).max(1) as f64;
        ln_bayes_factor_of_sizes(&beside.left, &score, &sizes) - choices.ln() + own.ln_prior
    }

    /// Log evidence of a model but for a constant: comparable between models under the same noise.
    pub fn ln_evidence(&self, model: &[usize]) -> f64 {
        self.contributions_with_evidence(model).1
    }

    /// What each term of a model contributes, and the log evidence of the model.
    pub(in crate::diagnose::budget) fn contributions_with_evidence(
        &self,
        model: &[usize],
    ) -> (Vec<Gain>, f64) {
        let factored = self.factored(model);
        let gains = self.contributions_in(model, &factored);
        let chi_squared = self.residual_square() - factored.half.norm_squared();
        let evidence = -0.5 * chi_squared - self.prices_of(model, &gains).sum::<f64>();
        (gains, evidence)
    }

    /// What each term of a model costs.
    pub fn prices(&self, model: &[usize]) -> Vec<f64> {
        self.prices_of(model, &self.contributions(model)).collect()
    }

    fn prices_of(&self, model: &[usize], gains: &[Gain]) -> impl Iterator<Item = f64> {
        model.iter().zip(gains).map(|(term, gain)| {
            let own = &self.terms[*term];
            price(*gain, own.members, self.candidates(*term)) - own.ln_prior
        })
    }
}
