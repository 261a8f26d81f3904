//! How much terms take off squared residuals, as people read them: each reading with the weight of its
//! noise scale factor. Under autocorrelated noise the fit weighs differences of readings instead, in
//! which what varies slowly is small; its weights make the values, not the shares of the gap.

use nalgebra::{DMatrix, DVector};

use crate::diagnose::budget::linear::Linear;
use crate::diagnose::budget::pieces::Pieces;
use crate::diagnose::budget::selection::Selection;
use crate::engine::gram::LeastSquares;

use super::Budget;

/// A linearised fit with white weights, and the products of a model's columns there, the residual last.
pub(super) struct White {
    pub(super) linear: Linear,
    products: DMatrix<f64>,
}

impl White {
    /// `None` where the weights of the fit are white.
    pub(super) fn of(linear: &Linear, selection: &Selection<'_>, model: &[usize]) -> Option<Self> {
        if !linear.fitted.problem.has_memory() {
            return None;
        }
        let mut white = linear.clone();
        let problem = &mut white.fitted.problem;
        problem.parts.iter_mut().for_each(|part| part.gauss_markov.fill(None));
        problem.reweight(&linear.fitted.fit.point);
        let mut columns = selection.columns(model);
        columns.push(selection.residual().clone());
        let pieces = Pieces::new(&white, selection, model);
        let products = pieces.products(&selection.weights(), |_, _| true);
        Some(Self { products: products + selection.prior(&columns), linear: white })
    }
}

impl Budget<'_> {
    /// What a term of the model takes off squared residuals beyond chance, beside others of it.
    pub(super) fn excess(&self, beside: &[usize], term: usize) -> f64 {
        let gain = self.selection.gain(beside, term);
        if self.white.is_none() {
            return gain.excess();
        }
        let with = [beside, &[term]].concat();
        let drop = self.squares(beside) - self.squares(&with);
        (drop - gain.degrees as f64).max(0.0)
    }

    /// The sum of squared residuals of some terms of the model.
    pub(super) fn squares(&self, terms: &[usize]) -> f64 {
        let Self { selection, model, .. } = self;
        let Some(White { products, .. }) = &self.white else {
            return selection.chi_squared(terms);
        };
        let values = selection.values(terms);
        let mut left = DVector::zeros(products.nrows());
        let mut put = |to: usize, from: usize, count: usize| {
            left.rows_mut(to, count).copy_from(&-values.rows(from, count));
        };
        put(0, 0, selection.nominal());
        let places = selection.ranges(model);
        for (term, from) in terms.iter().zip(selection.ranges(terms)) {
            let to = model.iter().zip(&places).find(|(own, _)| *own == term);
            to.into_iter().for_each(|(_, to)| put(to.start, from.start, from.len()));
        }
        let residual = left.len() - 1;
        left[residual] = 1.0;
        left.dot(&(products * &left))
    }
}
