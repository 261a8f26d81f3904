//! The normal equations of a model, factored, and the gain of columns beside it.

use nalgebra::{DMatrix, DVector};

use super::combined::Combined;
use crate::diagnose::budget::terms::Combination;
use crate::diagnose::evidence::basis::basis;
use crate::diagnose::price::Gain;
use crate::diagnose::thresholds::STREAM_NOISE;
use crate::estimate::inverse_factor::inverse_factor;

/// Added to the diagonal of scaled normal equations: what the readings do not determine stays where
/// it is.
const RIDGE: f64 = 1e-10;

/// A model's normal equations, factored.
#[derive(Debug)]
pub struct Factored {
    /// The columns: nominal ones, then those of the terms.
    pub columns: Vec<Combination>,
    pub(super) combined: Combined,
    /// `L⁻¹`, `L` their Cholesky factor: one product with it is quicker than a triangular solution.
    pub inverse: DMatrix<f64>,
    /// The lengths that the columns are scaled by.
    pub length: DVector<f64>,
    /// `L⁻¹ b` of scaled columns.
    pub half: DVector<f64>,
    /// The same of what the noise of smoothed streams adds to `b`.
    pub(super) half_of_streams: Option<DVector<f64>>,
}

/// Columns beside a model.
#[derive(Debug)]
pub(super) struct Beside {
    /// The Schur complement `S`.
    pub(super) left: DMatrix<f64>,
    /// The score `g`, and what the noise of smoothed streams adds to it.
    pub(super) score: DVector<f64>,
    pub(super) of_streams: Option<DVector<f64>>,
    /// Raw lengths.
    pub(super) raw: DVector<f64>,
    /// `L⁻¹ H_Mj`, columns of the model scaled.
    pub(super) across: DMatrix<f64>,
}

impl Beside {
    /// What the columns take off chi squared.
    pub(super) fn gain(&self) -> Gain {
        gain_beyond_streams(&self.left, &self.score, self.of_streams.as_ref(), &self.raw)
    }
}

impl Factored {
    /// Columns with their products, and those with the residual.
    pub(super) fn of(
        columns: Vec<Combination>,
        combined: Combined,
        matrix: &DMatrix<f64>,
        (score, of_streams): (&DVector<f64>, Option<DVector<f64>>),
    ) -> Self {
        let (inverse, length) = factored(matrix);
        let half = &inverse * score.component_div(&length);
        let half_of_streams = of_streams.map(|score| &inverse * score.component_div(&length));
        Self { columns, combined, inverse, length, half, half_of_streams }
    }

    /// The values of the columns.
    pub fn values(&self) -> DVector<f64> {
        self.inverse.tr_mul(&self.half).component_div(&self.length)
    }

    /// What the noise of smoothed streams adds to the values.
    pub(super) fn values_of_streams(&self) -> Option<DVector<f64>> {
        let half = self.half_of_streams.as_ref()?;
        Some(self.inverse.tr_mul(half).component_div(&self.length))
    }

    /// The values of the columns and their covariance.
    pub fn solved(&self) -> (DVector<f64>, DMatrix<f64>) {
        solved(&self.inverse, &self.length, &self.half)
    }
}

/// Values and covariance from `L⁻¹`, the lengths and `L⁻¹ b`.
pub(super) fn solved(
    inverse: &DMatrix<f64>,
    length: &DVector<f64>,
    half: &DVector<f64>,
) -> (DVector<f64>, DMatrix<f64>) {
    let values = inverse.tr_mul(half).component_div(length);
    // A product of two matrices is blocked, `tr_mul` goes column by column.
    let mut covariance = inverse.transpose() * inverse;
    for (j, mut column) in covariance.column_iter_mut().enumerate() {
        column.component_div_assign(length);
        column /= length[j];
    }
    (values, covariance)
}

/// The gain of a score `g` with Schur complement `S`.
pub fn gain_of(left: &DMatrix<f64>, score: &DVector<f64>, raw: &DVector<f64>) -> Gain {
    if !left.iter().chain(score.iter()).all(|value| value.is_finite()) || left.nrows() == 0 {
        return Gain::default();
    }
    let (basis, _) = basis(left, raw);
    let score = basis.tr_mul(score);
    Gain { gain: score.norm_squared(), degrees: score.len() }
}

/// The gain of a score without what the noise of smoothed streams adds to it, never more than with.
pub(super) fn gain_beyond_streams(
    left: &DMatrix<f64>,
    score: &DVector<f64>,
    of_streams: Option<&DVector<f64>>,
    raw: &DVector<f64>,
) -> Gain {
    let plain = gain_of(left, score, raw);
    let Some(added) = of_streams else { return plain };
    let beyond = score.zip_map(added, |score, added| {
        let rest = score - added;
        rest.signum() * (rest.abs() - STREAM_NOISE * added.abs()).max(0.0)
    });
    let beyond = gain_of(left, &beyond, raw);
    if beyond.gain < plain.gain { beyond } else { plain }
}

/// `L⁻¹` of the Cholesky factor `L` of normal equations whose columns are scaled to unit length, and
/// the lengths.
pub fn factored(matrix: &DMatrix<f64>) -> (DMatrix<f64>, DVector<f64>) {
    let n = matrix.nrows();
    let length = matrix.diagonal().map(|square| if square > 0.0 { square.sqrt() } else { 1.0 });
    let scaled = |ridge: f64| {
        DMatrix::from_fn(n, n, |i, j| {
            matrix[(i, j)] / (length[i] * length[j]) + f64::from(i == j) * ridge
        })
    };
    let mut ridge = RIDGE;
    loop {
        if let Some(inverse) = inverse_factor(&scaled(ridge)) {
            return (inverse, length);
        }
        if ridge > 1.0 {
            // Sums that are no numbers: nothing is taken off anything.
            return (DMatrix::identity(n, n), length);
        }
        ridge *= 10.0;
    }
}
