//! Evidence from readings that a model was not fitted to, fold after fold: the log predictive density
//! that a term raises, by which it is judged, and the drop of squared residuals, by which it closes the
//! gap.
//!
//! Columns that only the held-out readings determine (a start of that run) are fitted there, with
//! and without the term. Stated values count as readings.

use nalgebra::linalg::Cholesky;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::diagnose::gap::Drop;
use crate::estimate::eigen;
use crate::estimate::inverse_factor::Factor;

use super::pieces::{FOLDS, Pieces};
use super::selection::Selection;
use super::terms::Combination;

/// Share of a column's squared length in the readings that are fitted to, from which they determine
/// it.
const KNOWN: f64 = 1e-6;
/// Part of the squared length of what terms do that the readings beside each fold must show.
const SHOWN: f64 = 0.5;
/// Of the squared length of each column, the prior knowledge that its value is about zero: it makes the
/// evidence finite where the other folds do not determine it.
const RIDGE: f64 = 1e-9;
/// Eigenvalue of scaled columns below which held-out readings do not determine a direction.
const RANK: f64 = 1e-9;

/// The columns of a model with sums over all readings and over each fold; the residual last.
#[derive(Clone, Debug)]
pub struct Folded {
    whole: DMatrix<f64>,
    folds: Vec<DMatrix<f64>>,
    prior: DMatrix<f64>,
    /// The columns of each term, in the order of the model.
    terms: Vec<std::ops::Range<usize>>,
    /// So many terms at the beginning count as nominal.
    nominal_terms: usize,
}

/// Values of columns and their covariance.
struct Solved {
    values: DVector<f64>,
    covariance: DMatrix<f64>,
}

impl Solved {
    /// Twice the log evidence that some of the columns bring beside the others: what the readings of a fold
    /// add to it is what the columns add to that of their predictive distribution. With `C` the covariance
    /// of their values `v` it is `vᵀ C⁻¹ v + ln det C`.
    fn evidence_of(&self, columns: &[usize]) -> Option<f64> {
        let covariance = self.covariance.select_rows(columns).select_columns(columns);
        let factor = Cholesky::new(covariance)?;
        let values = self.values.select_rows(columns);
        Some(values.dot(&factor.solve(&values)) + factor.ln_determinant())
    }
}

impl Folded {
    /// Of a model.
    pub fn new(selection: &Selection<'_>, model: &[usize], pieces: &Pieces) -> Self {
        let mut combinations: Vec<Combination> = selection.columns(model);
        let terms = selection.ranges(model);
        combinations.push(selection.residual().clone());
        let weights = selection.weights();
        let fold = |fold: usize| pieces.products(&weights, |piece, _| piece.fold == fold);
        let folds: Vec<DMatrix<f64>> = (0..FOLDS).map(fold).collect();
        let prior = selection.prior(&combinations);
        let mut whole = prior.clone();
        folds.iter().for_each(|fold| whole += fold);
        Self { whole, folds, prior, terms, nominal_terms: 0 }
    }

    /// The same where so many of the first terms count as nominal: the others are judged with them in
    /// the model.
    pub fn with_nominal_terms(self, nominal_terms: usize) -> Self {
        Self { nominal_terms, ..self }
    }

    /// The rise of twice the log predictive density of held-out readings that each of some terms (by their
    /// places among those that are judged) brings, fold after fold: the drop of their squared residuals, in
    /// units of what the fit to the other folds leaves uncertain of them, less what that uncertainty costs. A
    /// prediction from values that the other folds hardly determine is wide, not wrong.
    pub fn predictive_gains(&self, terms: &[usize]) -> Vec<f64> {
        let whole = self.solved(&self.whole);
        let rests: Vec<_> =
            self.folds.par_iter().map(|fold| (fold, self.solved(&(&self.whole - fold)))).collect();
        let gain = |term: &usize| {
            let own: Vec<usize> = self.terms[self.nominal_terms + term].clone().collect();
            let of_fold = |(fold, rest): &(&DMatrix<f64>, Option<Solved>)| {
                // What the other folds do not determine of the term predicts nothing.
                let hidden = self.unknown(fold, &own);
                let brought = |solved: &Option<Solved>| -> Option<f64> {
                    let solved = solved.as_ref()?;
                    Some(solved.evidence_of(&own)? - solved.evidence_of(&hidden)?)
                };
                Some(brought(&whole)? - brought(rest)?)
            };
            let gains: Option<Vec<f64>> = rests.iter().map(of_fold).collect();
            let gain = gains.map_or(f64::NAN, |gains| gains.iter().sum());
            if gain.is_finite() { gain } else { f64::NEG_INFINITY }
        };
        terms.par_iter().map(gain).collect()
    }

    /// The drop of held-out squared residuals that a term brings, fold after fold: how far it closes the
    /// gap.
    pub fn squares_drop(&self, term: usize) -> f64 {
        let (all, others) = self.with_and_without(term);
        let left = |fold: &DMatrix<f64>, fitted: &[usize]| {
            let vector = self.predicting(fold, fitted);
            let left = self.left_of(fold, &vector, &self.unknown(fold, &others));
            left + vector.dot(&(&self.prior * &vector)) / FOLDS as f64
        };
        self.folds.iter().map(|fold| left(fold, &others) - left(fold, &all)).sum()
    }

    /// The columns with a term, and without it.
    fn with_and_without(&self, term: usize) -> (Vec<usize>, Vec<usize>) {
        let own = &self.terms[self.nominal_terms + term];
        let n = self.whole.nrows() - 1;
        ((0..n).collect(), (0..n).filter(|column| !own.contains(column)).collect())
    }

    /// The values of all columns by some sums; `None` where these are no numbers.
    fn solved(&self, sums: &DMatrix<f64>) -> Option<Solved> {
        let n = self.whole.nrows() - 1;
        let square = self.whole.diagonal().remove_row(n);
        let length = square.map(|square| if square > 0.0 { square.sqrt() } else { 1.0 });
        let factor = Factor::scaled(sums, &length, RIDGE)?;
        let values = factor.values(&factor.half(&sums.view((0, n), (n, 1)).column(0).into_owned()));
        Some(Solved { values, covariance: factor.covariance() })
    }

    /// For the first term, the first two, and so on the drop that they bring in each piece of the
    /// readings, which they were not fitted to.
    pub fn drops(&self, selection: &Selection<'_>, pieces: &Pieces) -> Vec<Vec<Drop>> {
        let nominal = self.upto(self.nominal_terms);
        let models = (self.nominal_terms..=self.terms.len()).map(|count| self.upto(count));
        let models: Vec<Vec<usize>> = models.collect();
        let in_fold = |fold: &DMatrix<f64>| {
            let predicting = models.iter().map(|fitted| self.predicting(fold, fitted));
            (predicting.collect::<Vec<_>>(), self.unknown(fold, &nominal))
        };
        let folds: Vec<_> = self.folds.iter().map(in_fold).collect();
        let weights = selection.weights();
        let mut drops: Vec<Vec<Drop>> = vec![Vec::new(); self.terms.len() - self.nominal_terms];
        for piece in &pieces.pieces {
            let (predicting, free) = &folds[piece.fold];
            let [before, after @ ..] = predicting.as_slice() else { continue };
            let own = pieces.products_in(piece, &weights);
            let left = |vector: &DVector<f64>| self.left_of(&own, vector, free);
            let without = left(before);
            for (drops, after) in drops.iter_mut().zip(after) {
                let taken = without - left(after);
                drops.push(Drop { taken, length: left(&(after - before)) });
            }
        }
        drops
    }

    /// Whether the readings beside each fold show a good part of what the terms do beyond the nominal
    /// columns: where one fold holds most of it, the others have little to learn from.
    pub fn is_shown(&self) -> bool {
        let n = self.whole.nrows() - 1;
        let nothing = DMatrix::zeros(n + 1, n + 1);
        let nominal = self.upto(self.nominal_terms);
        let mut terms = self.predicting(&nothing, &self.upto(self.terms.len()));
        nominal.iter().chain([&n]).for_each(|column| terms[*column] = 0.0);
        let length = |sums: &DMatrix<f64>| self.left_of(sums, &terms, &nominal);
        let whole = length(&self.whole);
        self.folds.iter().all(|fold| length(&(&self.whole - fold)) >= SHOWN * whole)
    }

    /// The nominal columns and those of the first terms.
    fn upto(&self, terms: usize) -> Vec<usize> {
        let end = match self.terms.get(terms) {
            Some(next) => next.start,
            None => self.whole.nrows() - 1,
        };
        (0..end).collect()
    }

    fn scale(&self, column: usize) -> f64 {
        self.whole[(column, column)].max(f64::MIN_POSITIVE)
    }

    /// Whether the readings beside a fold determine a column.
    fn is_known(&self, fold: &DMatrix<f64>, column: usize) -> bool {
        let at = (column, column);
        self.whole[at] - fold[at] > KNOWN * self.scale(column)
    }

    /// The columns that they do not determine.
    fn unknown(&self, fold: &DMatrix<f64>, columns: &[usize]) -> Vec<usize> {
        columns.iter().copied().filter(|column| !self.is_known(fold, *column)).collect()
    }

    /// Coefficients of the columns, the residual's 1, that make a prediction of the fold from the
    /// other folds its residual.
    fn predicting(&self, fold: &DMatrix<f64>, fitted: &[usize]) -> DVector<f64> {
        let n = self.whole.nrows() - 1;
        let is_known = |column: &usize| self.is_known(fold, *column);
        let fit: Vec<usize> = fitted.iter().copied().filter(is_known).collect();
        let rest = &self.whole - fold;
        let factor = Factor::of(&rest.select_rows(&fit).select_columns(&fit));
        let score = rest.column(n).select_rows(&fit);
        let values = factor.values(&factor.half(&score));
        let mut vector = DVector::zeros(n + 1);
        vector[n] = 1.0;
        fit.iter().zip(values.iter()).for_each(|(column, value)| vector[*column] = -value);
        vector
    }

    /// The squared length of a combination of columns in some readings, the `free` ones fitted there.
    fn left_of(&self, sums: &DMatrix<f64>, vector: &DVector<f64>, free: &[usize]) -> f64 {
        let slope = sums * vector;
        let mut left = vector.dot(&slope);
        let m = free.len();
        if m > 0 {
            let root = |i: usize| self.scale(free[i]).sqrt();
            let own = DMatrix::from_fn(m, m, |i, j| sums[(free[i], free[j])] / (root(i) * root(j)));
            let score = DVector::from_fn(m, |i, _| slope[free[i]] / root(i));
            if let Some(eigen) = eigen::symmetric(own) {
                let along = eigen.eigenvectors.tr_mul(&score);
                for (value, along) in eigen.eigenvalues.iter().zip(along.iter()) {
                    if *value > RANK {
                        left -= along * along / value;
                    }
                }
            }
        }
        left
    }
}
