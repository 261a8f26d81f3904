//! The sums of all measurands together, each with its weight, and prior knowledge.

use nalgebra::DMatrix;

use crate::engine::gram::PriorRow;

use super::{Index, Sums};

/// Sums under given noise scale factors.
#[derive(Clone, Debug)]
pub struct Weighted<'a> {
    /// Of which columns.
    pub sums: &'a Sums,
    /// One over the squared noise scale factor of each measurand.
    pub(in crate::diagnose::budget) weights: Vec<f64>,
    /// The columns that prior knowledge is of, the residual among them, and the sums of its rows.
    prior_at: Index,
    prior: DMatrix<f64>,
}

impl<'a> Weighted<'a> {
    /// Of sums with the weight of each measurand (one over its squared noise scale factor).
    pub fn new(sums: &'a Sums, weights: &[f64]) -> Self {
        let mut prior_at = Index::default();
        let with_residual = |row: &PriorRow| {
            let own = row.coefficients.iter().copied();
            own.chain([(sums.residual(), row.residual)]).collect::<Vec<_>>()
        };
        let rows: Vec<Vec<(usize, f64)>> = sums.priors.iter().map(with_residual).collect();
        for (column, _) in rows.iter().flatten() {
            prior_at.place(*column);
        }
        let mut prior = DMatrix::zeros(prior_at.numbers().len(), prior_at.numbers().len());
        for row in &rows {
            for (a, p) in row {
                for (b, q) in row {
                    prior[(prior_at.place(*a), prior_at.place(*b))] += p * q;
                }
            }
        }
        Self { sums, weights: weights.to_vec(), prior_at, prior }
    }

    /// The product of two columns; the column after the last is the residual.
    #[inline]
    pub fn product(&self, a: usize, b: usize) -> f64 {
        let both = self.sums.measurands_of(a, b).iter();
        let of_readings: f64 =
            both.map(|own| self.weights[*own] * self.sums.product_in(*own, a, b)).sum();
        of_readings + self.prior(a, b)
    }

    /// The product of two columns in the rows of prior knowledge.
    #[inline]
    pub fn prior(&self, a: usize, b: usize) -> f64 {
        match (self.prior_at.get(a), self.prior_at.get(b)) {
            (Some(a), Some(b)) => self.prior[(a, b)],
            _ => 0.0,
        }
    }
}
