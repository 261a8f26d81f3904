//! Terms in competition: what each would take off chi squared beside a model, and what each of the
//! model's terms contributes, under noise scale factors that follow from the model.
//!
//! With the nominal columns and those of the model's terms `M`, a term `j` has
//! `S = H_jj - H_jM H_MM⁻¹ H_Mj` and the score `g` likewise; it takes `gᵀ S⁺ g` off chi squared,
//! over the directions of which more than a share of 3e-4 of their length is left. Where none is left
//! the term is absorbed and never enters. It searches nothing.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use self::combined::Combined;
use self::normal::{Beside, Factored};
pub use self::ranked::Ranked;
use super::sums::{Sums, Weighted};
use super::terms::{Change, Combination, Term};
use crate::diagnose::library::place::Place;
use crate::diagnose::price::{Gain, ln_bayes_factor, ln_bayes_factor_of_any_noise};
use crate::estimate::inverse_factor::Factor;

mod combined;
pub mod exchange;
mod forms;
pub mod normal;
mod ranked;
mod scale;

/// The terms and the sums that they are compared on.
#[derive(Clone, Debug)]
pub struct Selection<'a> {
    /// The sums.
    pub sums: &'a Sums,
    /// The terms.
    pub terms: Vec<Term>,
    /// Noise scale factor of each measurand: found over stated standard deviation.
    pub scale: Vec<f64>,
    /// Columns of the nominal parameters.
    nominal: Vec<Combination>,
    /// The residual of the nominal model.
    residual: Combination,
    weighted: Weighted<'a>,
    /// Product of each column with the residual.
    score: Vec<f64>,
    /// What the noise of smoothed streams adds to it.
    of_streams: Option<Vec<f64>>,
    effects: usize,
    blocks: usize,
}

impl<'a> Selection<'a> {
    /// Of terms; `active` rows that are in the fit with their values (column and value).
    pub fn new(sums: &'a Sums, terms: &[Term], active: &[(usize, f64)]) -> Self {
        let in_fit = |column: usize| active.iter().any(|(own, _)| *own == column);
        let nominal = (0..sums.nominal).filter(|column| !in_fit(*column));
        let mut residual = vec![(sums.residual(), 1.0)];
        residual.extend(active);
        // What shows in no reading raises no false alarm, nor what is looked for as a change alone.
        let is_change = |one: &Term| one.place.as_ref().is_some_and(Place::is_of_a_parameter);
        let shown = terms.iter().filter(|one| !one.columns.is_empty() && !is_change(one));
        let [effects, blocks] =
            [true, false].map(|kind| shown.clone().filter(|one| one.is_effect() == kind).count());
        let scale = vec![1.0; sums.readings.len()];
        let weighted = Weighted::new(sums, &scale);
        let mut terms = terms.to_vec();
        terms.iter_mut().for_each(|one| one.may_enter &= !one.columns.is_empty());
        let mut selection = Self {
            sums,
            terms,
            scale,
            nominal: nominal.map(|column| vec![(column, 1.0)]).collect(),
            residual,
            weighted,
            score: Vec::new(),
            of_streams: None,
            effects: effects.max(1),
            blocks: blocks.max(1),
        };
        selection.weigh();
        selection
    }

    /// The weight of each measurand's readings beside that of its stated noise.
    pub fn weights(&self) -> Vec<f64> {
        self.scale.iter().map(|scale| scale.powi(-2)).collect()
    }

    /// Sums anew with the noise scale factors as they are.
    fn weigh(&mut self) {
        self.weighted.weights = self.weights();
        let product = |column| {
            self.residual.iter().map(|(other, by)| by * self.weighted.product(column, *other)).sum()
        };
        self.score = (0..self.sums.residual()).map(product).collect();
        self.of_streams = self.sums.scores_of_streams(&self.weights());
    }

    /// The product of two combinations of columns.
    fn product(&self, a: &Combination, b: &Combination) -> f64 {
        let with = |(i, p): &(usize, f64)| {
            p * b.iter().map(|(j, q)| q * self.weighted.product(*i, *j)).sum::<f64>()
        };
        a.iter().map(with).sum()
    }

    /// The products of some columns with the residual.
    fn scores(&self, columns: &[Combination]) -> DVector<f64> {
        let of = |one: &Combination| one.iter().map(|(column, by)| by * self.score[*column]).sum();
        DVector::from_iterator(columns.len(), columns.iter().map(of))
    }

    /// The products of some columns in the rows of prior knowledge.
    pub(super) fn prior(&self, columns: &[Combination]) -> DMatrix<f64> {
        Combined::of(columns.iter()).squares(|a, b| self.weighted.prior(a, b))
    }

    /// What the noise of smoothed streams adds to the scores of some columns.
    fn of_streams(&self, columns: &[Combination]) -> Option<DVector<f64>> {
        let added = self.of_streams.as_ref()?;
        let of = |one: &Combination| {
            one.iter().map(|(column, by)| by * added.get(*column).unwrap_or(&0.0)).sum()
        };
        Some(DVector::from_iterator(columns.len(), columns.iter().map(of)))
    }

    /// The columns of a model: nominal ones, then those of its terms in order.
    pub fn columns(&self, model: &[usize]) -> Vec<Combination> {
        let own = model.iter().flat_map(|term| self.terms[*term].columns.iter().cloned());
        self.nominal.iter().cloned().chain(own).collect()
    }

    /// The places of each term's columns among those of a model.
    pub fn ranges(&self, model: &[usize]) -> Vec<Range<usize>> {
        let mut end = self.nominal();
        let range = |term: &usize| {
            let start = end;
            end += self.terms[*term].columns.len();
            start..end
        };
        model.iter().map(range).collect()
    }

    /// The measurands whose readings a term changes.
    pub(super) fn measurands_of(&self, term: usize) -> Vec<usize> {
        let columns = || self.terms[term].columns.iter().flatten().map(|(column, _)| *column);
        let acts = |one: &usize| columns().any(|at| self.sums.product_in(*one, at, at) > 0.0);
        (0..self.scale.len()).filter(acts).collect()
    }

    /// The effects of a model.
    pub(super) fn rows_of(&self, model: &[usize]) -> Vec<usize> {
        model.iter().copied().filter(|term| self.terms[*term].is_effect()).collect()
    }

    /// Number of nominal columns.
    pub fn nominal(&self) -> usize {
        self.nominal.len()
    }

    /// The residual of the nominal model: the fit's, with what rows in the fit explain added back.
    pub fn residual(&self) -> &Combination {
        &self.residual
    }

    pub(super) fn factored(&self, model: &[usize]) -> Factored {
        self.factored_under(model, &[])
    }

    /// With the inverse covariance, beforehand, of the values of some columns: where they begin.
    pub(super) fn factored_under(
        &self,
        model: &[usize],
        priors: &[(usize, DMatrix<f64>)],
    ) -> Factored {
        let columns = self.columns(model);
        let combined = Combined::of(columns.iter());
        let mut matrix = combined.squares(|a, b| self.weighted.product(a, b));
        for (first, prior) in priors {
            let mut own = matrix.view_mut((*first, *first), prior.shape());
            own += prior;
        }
        let factor = Factor::of(&matrix);
        let half = factor.half(&self.scores(&columns));
        let half_of_streams = self.of_streams(&columns).map(|score| factor.half(&score));
        Factored { columns, combined, factor, half, half_of_streams }
    }

    /// Squared length of a column.
    pub fn square(&self, column: &Combination) -> f64 {
        self.product(column, column)
    }

    /// Chi squared of a model.
    pub fn chi_squared(&self, model: &[usize]) -> f64 {
        self.residual_square() - self.factored(model).half.norm_squared()
    }

    /// Squared length of the residual.
    fn residual_square(&self) -> f64 {
        self.product(&self.residual, &self.residual)
    }

    /// Values of the columns of a model.
    pub fn values(&self, model: &[usize]) -> DVector<f64> {
        self.factored(model).values()
    }

    /// Columns beside a model.
    pub(super) fn across(&self, model: &Factored, columns: &[Combination]) -> Beside {
        let across = self.products_with(model, &Combined::of(columns.iter()));
        self.beside(model, columns, across)
    }

    /// The columns of each of some terms beside a model: products with it are taken together.
    pub(super) fn across_each(&self, model: &Factored, terms: &[usize]) -> Vec<Beside> {
        let columns = |term: &usize| self.terms[*term].columns.as_slice();
        let across = self.products_with(model, &Combined::of(terms.iter().flat_map(columns)));
        let mut first = 0;
        let beside = |columns: &[Combination]| {
            let own = across.columns(first, columns.len()).into_owned();
            first += columns.len();
            self.beside(model, columns, own)
        };
        terms.iter().map(columns).map(beside).collect()
    }

    /// `L⁻¹ H_Mj` of columns.
    fn products_with(&self, model: &Factored, columns: &Combined) -> DMatrix<f64> {
        let product = |a, b| self.weighted.product(a, b);
        model.factor.across(&model.combined.products(columns, product))
    }

    /// Columns beside a model, from their products with it.
    fn beside(&self, model: &Factored, columns: &[Combination], across: DMatrix<f64>) -> Beside {
        let own = Combined::of(columns.iter()).squares(|a, b| self.weighted.product(a, b));
        let raw = own.diagonal().map(|square| square.max(0.0).sqrt());
        let left = own - across.transpose() * &across;
        let score = self.scores(columns) - across.tr_mul(&model.half);
        let of_streams = self.of_streams(columns).zip(model.half_of_streams.as_ref());
        let of_streams = of_streams.map(|(own, half)| own - across.tr_mul(half));
        Beside { left, score, of_streams, raw, across }
    }

    /// What a term takes off chi squared beside a model.
    pub fn gain(&self, model: &[usize], term: usize) -> Gain {
        self.across(&self.factored(model), &self.terms[term].columns).gain()
    }

    /// A term's columns beside the nominal parameters.
    pub fn alone(&self, term: usize) -> Beside {
        self.across(&self.factored(&[]), &self.terms[term].columns)
    }

    /// The Schur complement of a term's columns beside a model.
    pub fn left(&self, model: &[usize], term: usize) -> DMatrix<f64> {
        self.across(&self.factored(model), &self.terms[term].columns).left
    }

    /// The log Bayes factor of a gain of a term.
    pub fn ln_bayes_factor(&self, term: usize, gain: Gain) -> f64 {
        let own = &self.terms[term];
        ln_bayes_factor(gain, own.members, self.candidates(term)) + own.ln_prior
    }

    /// The log Bayes factor of a change.
    pub fn ln_bayes_factor_of_change(&self, change: &Change) -> f64 {
        self.ln_bayes_factor_of_block(change.gain, change.members)
    }

    /// The same in so many readings with so much chi squared, also with the noise that they would have.
    pub fn ln_bayes_factor_within(&self, change: &Change, count: f64, chi_squared: f64) -> f64 {
        let gain = Gain { gain: change.gain.gain / chi_squared * count, ..change.gain };
        let own = ln_bayes_factor_of_any_noise(gain, count, change.members, self.blocks);
        own.min(self.ln_bayes_factor_of_change(change))
    }

    /// The log Bayes factor of a gain that is no effect's.
    pub(super) fn ln_bayes_factor_of_block(&self, gain: Gain, members: usize) -> f64 {
        ln_bayes_factor(gain, members, self.blocks)
    }

    /// Number of candidates of a term's kind.
    pub(super) fn candidates(&self, term: usize) -> usize {
        if self.terms[term].is_effect() { self.effects } else { self.blocks }
    }
}
