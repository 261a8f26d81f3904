//! The nominal normal equations, factored: what is taken off everything that a candidate does.
//!
//! It knows no candidate.

use nalgebra::linalg::Cholesky;
use nalgebra::{DMatrix, DVector, Dyn};

use crate::engine::gram::{Normal, PriorRow};
use crate::estimate::arrow::normal_matrix;

/// The nominal normal equations.
#[derive(Clone, Debug)]
pub(super) struct Nominal {
    /// Of columns scaled to unit length.
    factor: Cholesky<f64, Dyn>,
    /// Of each column.
    pub(super) length: DVector<f64>,
    /// What the readings say of each column.
    pub(super) score: DVector<f64>,
    /// Prior knowledge.
    pub(super) priors: Vec<PriorRow>,
}

impl Nominal {
    /// Those of a linearised problem; `None` where its parameters are not determined.
    pub(super) fn of(normal: &Normal) -> Option<Self> {
        let (hessian, score) = normal_matrix(normal).ok()?;
        let n = hessian.nrows();
        let length = DVector::from_fn(n, |i, _| {
            let square: f64 = hessian[(i, i)];
            if square > 0.0 { square.sqrt() } else { 1.0 }
        });
        let scaled = DMatrix::from_fn(n, n, |i, j| hessian[(i, j)] / (length[i] * length[j]));
        let factor = Cholesky::new(scaled)?;
        Some(Self { factor, length, score, priors: normal.priors.clone() })
    }

    /// `H_nn⁻¹` times a matrix.
    pub(super) fn solve(&self, matrix: &DMatrix<f64>) -> DMatrix<f64> {
        let scaled = |m: &DMatrix<f64>| {
            DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)] / self.length[i])
        };
        scaled(&self.factor.solve(&scaled(matrix)))
    }
}
