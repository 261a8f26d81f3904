//! The nominal normal equations, factored: what is taken off everything that a candidate does.
//!
//! Effects that are adopted bring columns, too, some of which these readings may not determine: a
//! value of a setup in which nothing moves, a direction that other parameters follow. Such
//! directions stay where they are, and take nothing off a candidate. It knows no candidate, and
//! does not say what is not determined.

use std::iter::successors;

use nalgebra::linalg::Cholesky;
use nalgebra::{DMatrix, DVector, Dyn};

use crate::engine::gram::Normal;
use crate::estimate::arrow::normal_matrix;

/// Share of a column's squared length below which what is left of it beside the columns before it
/// is rounding; so much is added where it is.
const ROUNDING: f64 = 1e-12;

/// The nominal normal equations.
#[derive(Clone, Debug)]
pub(super) struct Nominal {
    /// Of columns scaled to unit length.
    factor: Cholesky<f64, Dyn>,
    /// Of each column.
    pub(super) length: DVector<f64>,
    /// What the readings say of each column.
    pub(super) score: DVector<f64>,
}

impl Nominal {
    /// Those of a linearised problem; `None` where they hold what is no number.
    pub(super) fn of(normal: &Normal) -> Option<Self> {
        let (hessian, score) = normal_matrix(normal).ok()?;
        let (factor, length) = factored(&hessian)?;
        Some(Self { factor, length, score })
    }

    /// `H_nn⁻¹` times a matrix.
    pub(super) fn solve(&self, matrix: &DMatrix<f64>) -> DMatrix<f64> {
        self.scaled(&self.factor.solve(&self.scaled(matrix)))
    }

    /// `L⁻¹` times a matrix, where `H_nn = L Lᵀ`: products of its columns are those of the matrix
    /// with `H_nn⁻¹` between them.
    pub(super) fn halfway(&self, matrix: &DMatrix<f64>) -> DMatrix<f64> {
        let mut half = self.scaled(matrix);
        self.factor.l_dirty().solve_lower_triangular_mut(&mut half);
        half
    }

    fn scaled(&self, matrix: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i, j)] / self.length[i])
    }
}

/// The Cholesky factor of a matrix of sums of products, columns scaled to unit length, and their
/// lengths. What the sums do not determine is held. `None` where they are no numbers.
pub(in crate::diagnose) fn factored(
    hessian: &DMatrix<f64>,
) -> Option<(Cholesky<f64, Dyn>, DVector<f64>)> {
    let n = hessian.nrows();
    let length = hessian.diagonal().map(|square| if square > 0.0 { square.sqrt() } else { 1.0 });
    let scaled = |held: f64| {
        let with = |i, j| hessian[(i, j)] / (length[i] * length[j]) + f64::from(i == j) * held;
        Cholesky::new(DMatrix::from_fn(n, n, with))
    };
    let is_sound =
        |factor: &Cholesky<f64, Dyn>| (0..n).all(|i| factor.l_dirty()[(i, i)].powi(2) > ROUNDING);
    let mut held =
        successors(Some(ROUNDING), |held| Some(10.0 * held)).take_while(|held| *held < 1e-6);
    let factor = scaled(0.0).filter(is_sound).or_else(|| held.find_map(scaled))?;
    Some((factor, length))
}
