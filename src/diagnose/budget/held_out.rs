//! Evidence from readings that a model was not fitted to: the drop of their squared residuals that
//! a term brings, fold after fold.
//!
//! Columns that only the held-out readings determine (a start of that run) are fitted there, with
//! and without the term. Stated values count as readings.

use nalgebra::{DMatrix, DVector};

use crate::estimate::eigen;

use super::pieces::{FOLDS, Pieces};
use super::selection::Selection;
use super::terms::Combination;

/// Share of a column's squared length in the readings that are fitted to, from which they determine
/// it.
const KNOWN: f64 = 1e-6;
/// Added to the diagonal of scaled normal equations.
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
}

impl Folded {
    /// Of a model.
    pub fn new(selection: &Selection<'_>, model: &[usize], pieces: &Pieces) -> Self {
        let mut combinations: Vec<Combination> = selection.columns(model);
        let terms = selection.ranges(model);
        combinations.push(selection.residual().clone());
        let weights: Vec<f64> = selection.scale.iter().map(|scale| scale.powi(-2)).collect();
        let residual = selection.sums.residual();
        let fold = |fold: usize| pieces.products(&weights, |piece| piece.fold == fold);
        let folds: Vec<DMatrix<f64>> = (0..FOLDS).map(fold).collect();
        let n = combinations.len();
        let mut prior = DMatrix::zeros(n, n);
        for row in &selection.sums.priors {
            let value = |combination: &Combination| -> f64 {
                let of = |column: usize| {
                    if column == residual {
                        return row.residual;
                    }
                    let own = row.coefficients.iter().filter(|(own, _)| *own == column);
                    own.map(|(_, by)| by).sum()
                };
                combination.iter().map(|(column, by)| by * of(*column)).sum()
            };
            let row = DVector::from_iterator(n, combinations.iter().map(value));
            prior += &row * row.transpose();
        }
        let mut whole = prior.clone();
        folds.iter().for_each(|fold| whole += fold);
        Self { whole, folds, prior, terms }
    }

    /// Number of terms.
    pub fn terms(&self) -> usize {
        self.terms.len()
    }

    /// The drop of held-out squared residuals that a term (by its place in the model) brings.
    pub fn drop(&self, term: usize) -> f64 {
        let own = &self.terms[term];
        let n = self.whole.nrows() - 1;
        let others: Vec<usize> = (0..n).filter(|column| !own.contains(column)).collect();
        let all: Vec<usize> = (0..n).collect();
        self.folds
            .iter()
            .map(|fold| self.left(fold, &others, &others) - self.left(fold, &all, &others))
            .sum()
    }

    /// The drop of held-out squared residuals that all terms bring together.
    pub fn drop_of_all(&self) -> f64 {
        let first = self.terms.first().map_or(0, |own| own.start);
        let n = self.whole.nrows() - 1;
        let nominal: Vec<usize> = (0..first.min(n)).collect();
        let all: Vec<usize> = (0..n).collect();
        let drop = |fold| self.left(fold, &nominal, &nominal) - self.left(fold, &all, &nominal);
        if self.terms.is_empty() { 0.0 } else { self.folds.iter().map(drop).sum() }
    }

    /// Squared residuals of a fold under the columns `fitted` to the other folds; those of `free`
    /// that these do not determine are fitted in the fold.
    fn left(&self, fold: &DMatrix<f64>, fitted: &[usize], free: &[usize]) -> f64 {
        let n = self.whole.nrows() - 1;
        let scale = |column: usize| self.whole[(column, column)].max(f64::MIN_POSITIVE);
        let rest = |i: usize, j: usize| self.whole[(i, j)] - fold[(i, j)];
        let is_known = |column: &usize| rest(*column, *column) > KNOWN * scale(*column);
        let fit: Vec<usize> = fitted.iter().copied().filter(is_known).collect();
        let free: Vec<usize> = free.iter().copied().filter(|column| !is_known(column)).collect();
        let k = fit.len();
        let mut vector = DVector::zeros(n + 1);
        vector[n] = 1.0;
        if k > 0 {
            let length: Vec<f64> = fit.iter().map(|column| scale(*column).sqrt()).collect();
            let matrix = DMatrix::from_fn(k, k, |i, j| {
                rest(fit[i], fit[j]) / (length[i] * length[j]) + f64::from(i == j) * RIDGE
            });
            let right = DVector::from_fn(k, |i, _| rest(fit[i], n) / length[i]);
            let Some(values) = matrix.cholesky().map(|factor| factor.solve(&right)) else {
                return 0.0;
            };
            for (i, column) in fit.iter().enumerate() {
                vector[*column] = -values[i] / length[i];
            }
        }
        let slope = fold * &vector;
        let mut left = vector.dot(&slope);
        let m = free.len();
        if m > 0 {
            let root = |i: usize| scale(free[i]).sqrt();
            let own = DMatrix::from_fn(m, m, |i, j| fold[(free[i], free[j])] / (root(i) * root(j)));
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
        left + (vector.transpose() * &self.prior * &vector)[(0, 0)] / FOLDS as f64
    }
}
