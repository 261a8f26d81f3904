//! The normal equations of a model, factored, and the gain of columns beside it.

use nalgebra::{DMatrix, DVector};

use super::combined::Combined;
use crate::diagnose::budget::terms::Combination;
use crate::diagnose::evidence::basis::basis;
use crate::diagnose::price::Gain;
use crate::diagnose::thresholds::STREAM_NOISE;
use crate::estimate::inverse_factor::Factor;

/// A model's normal equations, factored.
#[derive(Debug)]
pub struct Factored {
    /// The columns: nominal ones, then those of the terms.
    pub columns: Vec<Combination>,
    pub(super) combined: Combined,
    /// Their normal equations.
    pub factor: Factor,
    /// `L⁻¹ b` of scaled columns.
    pub half: DVector<f64>,
    /// The same of what the noise of smoothed streams adds to `b`.
    pub(super) half_of_streams: Option<DVector<f64>>,
}

/// Columns beside a model.
#[derive(Debug)]
pub struct Beside {
    /// The Schur complement `S`.
    pub left: DMatrix<f64>,
    /// The score `g`, and what the noise of smoothed streams adds to it.
    pub score: DVector<f64>,
    pub(super) of_streams: Option<DVector<f64>>,
    /// Raw lengths.
    pub raw: DVector<f64>,
    /// `L⁻¹ H_Mj`, columns of the model scaled.
    pub across: DMatrix<f64>,
}

impl Beside {
    /// What the columns take off chi squared.
    pub(super) fn gain(&self) -> Gain {
        gain_beyond_streams(&self.left, &self.score, self.of_streams.as_ref(), &self.raw)
    }
}

impl Factored {
    /// The values of the columns.
    pub fn values(&self) -> DVector<f64> {
        self.factor.values(&self.half)
    }

    /// What the noise of smoothed streams adds to the values.
    pub(super) fn values_of_streams(&self) -> Option<DVector<f64>> {
        self.half_of_streams.as_ref().map(|half| self.factor.values(half))
    }

    /// The values of the columns and their covariance.
    pub fn solved(&self) -> (DVector<f64>, DMatrix<f64>) {
        (self.values(), self.factor.covariance())
    }
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

/// The log Bayes factor of values that are normal about zero with these standard deviations, from
/// their Schur complement `S` and score `g`: with `T` the diagonal of the deviations
/// `gᵀ T (1 + T S T)⁻¹ T g / 2 - ln det(1 + T S T) / 2`. Infinite where `S` is no such matrix.
pub(super) fn ln_bayes_factor_of_sizes(
    left: &DMatrix<f64>,
    score: &DVector<f64>,
    sizes: &[f64],
) -> f64 {
    let scaled =
        |i: usize, j: usize| left[(i, j)] * sizes[i] * sizes[j] + f64::from(u8::from(i == j));
    let whole = DMatrix::from_fn(sizes.len(), sizes.len(), scaled);
    let Some(factor) = whole.cholesky() else { return f64::INFINITY };
    let score = score.component_mul(&DVector::from_column_slice(sizes));
    let ln_determinant = 2.0 * factor.l_dirty().diagonal().map(f64::ln).sum();
    0.5 * (score.dot(&factor.solve(&score)) - ln_determinant)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of one value by hand; of two independent ones the sum.
    #[test]
    fn a_bayes_factor_of_sizes_is_that_of_normal_values() {
        let one = |s: f64, g: f64, t: f64| {
            0.5 * (g * t).powi(2) / (1.0 + t * t * s) - 0.5 * (1.0 + t * t * s).ln()
        };
        let of = |s: &[f64], g: &[f64], t: &[f64]| {
            let left = DMatrix::from_diagonal(&DVector::from_column_slice(s));
            ln_bayes_factor_of_sizes(&left, &DVector::from_column_slice(g), t)
        };
        assert!((of(&[4.0], &[6.0], &[0.5]) - one(4.0, 6.0, 0.5)).abs() < 1e-12);
        let both = of(&[4.0, 100.0], &[6.0, 0.3], &[0.5, 3.0]);
        assert!((both - one(4.0, 6.0, 0.5) - one(100.0, 0.3, 3.0)).abs() < 1e-12);
        // A large value that is not seen is not there; one that cannot show says nothing.
        assert!(of(&[1e4], &[1.0], &[1.0]) < -4.0 && of(&[0.0], &[0.0], &[9.0]) == 0.0);
    }
}
