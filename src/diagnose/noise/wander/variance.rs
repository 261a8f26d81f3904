//! How large a walk is, and how unlikely what it does is by chance.
//!
//! With the scores `g` of independent coefficients over their share of the walk, beyond the nominal
//! parameters, `Q = gᵀ g` has the mean `tr M` without a walk, `M` being the covariance of `g`: a
//! test of the variance, one-sided. The tail of `Q`, a sum of chi squared numbers with unequal
//! weights, is that of the chi squared number with the same three first cumulants (Pearson 1959;
//! Imhof 1961). The size is that of largest likelihood.

use nalgebra::linalg::SymmetricTridiagonal;
use nalgebra::{DMatrix, DVector};

use crate::diagnose::evidence::{Entry, Evidence, Projected};
use crate::statistics::ln_gamma_tail;

use super::course::Steps;

/// Cuts in search of a variance.
const POLISH: usize = 16;

/// Scores of a walk's independent steps, and their covariance without a walk.
pub(super) struct Scores {
    scores: DVector<f64>,
    covariance: DMatrix<f64>,
}

impl Scores {
    /// Beyond the nominal parameters and something known. `None` where nothing of the walk is left.
    pub(super) fn beyond(
        evidence: &Evidence,
        known: &Entry,
        own: &Projected,
        steps: &Steps,
    ) -> Option<Self> {
        let shared = evidence.shared(known, own);
        let score = &own.score - shared.tr_mul(&known.score);
        Self::of(&score, &(&own.left - shared.tr_mul(&shared)), steps)
    }

    /// Of steps in columns with such scores.
    pub(super) fn of(score: &DVector<f64>, left: &DMatrix<f64>, steps: &Steps) -> Option<Self> {
        let (scores, covariance) = (steps.scores(score), steps.covariance(left));
        let finite = covariance.iter().chain(scores.iter()).all(|value| value.is_finite());
        (finite && covariance.trace() > 0.0).then_some(Self { scores, covariance })
    }

    /// Logarithm of the probability of such scores without a walk.
    pub(super) fn ln_p(&self) -> f64 {
        let matrix = &self.covariance;
        let third = (matrix * matrix).component_mul(matrix).sum();
        ln_tail(self.scores.norm_squared(), [matrix.trace(), matrix.norm_squared(), third])
    }
}

/// The scores in a basis that begins with them and in which their covariance has three diagonals:
/// all that is asked of a walk then takes one pass along them.
pub(super) struct Walk {
    diagonal: DVector<f64>,
    beside: DVector<f64>,
    /// Squared length of the scores.
    square: f64,
}

/// What a variance `v` of the walk makes of the scores `s` with their covariance `M`.
struct Weighed {
    /// `sᵀ (1 + v M)⁻¹ s`.
    square: f64,
    /// `ln det (1 + v M)`.
    ln_determinant: f64,
    /// `tr (M (1 + v M)⁻¹)²`, the negative second derivative of that.
    curvature: f64,
}

impl Walk {
    /// Of scores.
    pub(super) fn of(Scores { scores, covariance }: Scores) -> Self {
        // The first reflection of a matrix that they border turns them into its second axis.
        let order = scores.len() + 1;
        let mut bordered = DMatrix::zeros(order, order);
        bordered.view_mut((1, 0), (order - 1, 1)).copy_from(&scores);
        bordered.view_mut((0, 1), (1, order - 1)).copy_from(&scores.transpose());
        bordered.view_mut((1, 1), (order - 1, order - 1)).copy_from(&covariance);
        let (diagonal, beside) = SymmetricTridiagonal::new(bordered).unpack_tridiagonal();
        let (diagonal, beside) = (diagonal.remove_row(0), beside.remove_row(0));
        Self { diagonal, beside, square: scores.norm_squared() }
    }

    /// The traces of the first three powers of the covariance.
    fn powers(&self) -> [f64; 3] {
        let mut powers = [self.diagonal.sum(), self.diagonal.norm_squared(), 0.0];
        powers[2] = self.diagonal.iter().map(|one| one.powi(3)).sum();
        for (k, beside) in self.beside.iter().enumerate() {
            powers[1] += 2.0 * beside.powi(2);
            powers[2] += 3.0 * beside.powi(2) * (self.diagonal[k] + self.diagonal[k + 1]);
        }
        powers
    }

    /// Logarithm of the probability of such scores without a walk.
    pub(super) fn ln_p(&self) -> f64 {
        ln_tail(self.square, self.powers())
    }

    /// The pivots of `1 + v M` from the last to the first, with their first two derivatives along
    /// `v`.
    fn weighed(&self, variance: f64) -> Weighed {
        let (mut ln_determinant, mut curvature) = (0.0, 0.0);
        let mut pivot = [1.0, 0.0, 0.0];
        for (k, diagonal) in self.diagonal.iter().enumerate().rev() {
            let beside = self.beside.get(k).copied().unwrap_or(0.0);
            let [last, slope, bend] = pivot;
            // What is taken off: (v b)² / last.
            let taken = (variance * beside).powi(2) / last;
            let along = (2.0 * variance * beside.powi(2) - taken * slope) / last;
            let bent = (2.0 * beside.powi(2) - 2.0 * along * slope - taken * bend) / last;
            pivot = [1.0 + variance * diagonal - taken, diagonal - along, -bent];
            ln_determinant += pivot[0].ln();
            curvature += (pivot[1] / pivot[0]).powi(2) - pivot[2] / pivot[0];
        }
        Weighed { square: self.square / pivot[0], ln_determinant, curvature }
    }

    /// Logarithm of the likelihood ratio of a walk of some variance.
    fn likelihood_at(&self, variance: f64) -> f64 {
        let Weighed { square, ln_determinant, .. } = self.weighed(variance);
        0.5 * variance * square - 0.5 * ln_determinant
    }

    /// The variance of largest likelihood: the best of a grid, polished by cutting off thirds.
    fn best(&self) -> f64 {
        let typical = 1.0 / self.diagonal.max();
        let at = |logarithm: f64| typical * logarithm.exp();
        let step = 0.5;
        // What is taken up is rounding, and may be less than nothing where a walk is very strong.
        let grid = (-16..32)
            .map(|k| step * f64::from(k))
            .filter(|k| self.likelihood_at(at(*k)).is_finite());
        let better =
            |a: &f64, b: &f64| self.likelihood_at(at(*a)).total_cmp(&self.likelihood_at(at(*b)));
        let best = grid.max_by(better).unwrap_or(0.0);
        let (mut low, mut high) = (best - step, best + step);
        for _ in 0..POLISH {
            let third = (high - low) / 3.0;
            if better(&(low + third), &(high - third)).is_lt() {
                low += third;
            } else {
                high -= third;
            }
        }
        at(0.5 * (low + high))
    }

    /// Logarithm of the largest likelihood ratio.
    pub(super) fn likelihood(&self) -> f64 {
        self.likelihood_at(self.best())
    }

    /// The variance of a walk of one unit, and its standard uncertainty (Fisher's information).
    pub(super) fn variance(&self) -> (f64, f64) {
        let variance = self.best();
        let information = 0.5 * self.weighed(variance).curvature;
        (variance, information.sqrt().recip())
    }
}

/// Logarithm of the probability that a sum of weighted chi squared numbers exceeds a value, from
/// the sums of the first three powers of its weights.
fn ln_tail(value: f64, [mean, second, third]: [f64; 3]) -> f64 {
    let degrees = second.powi(3) / third.powi(2);
    let like = (value - mean) / (2.0 * second).sqrt() * (2.0 * degrees).sqrt() + degrees;
    ln_gamma_tail(0.5 * degrees, 0.5 * like.max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_diagonals_say_what_axes_say() {
        let root =
            DMatrix::from_fn(7, 7, |i, j| ((3 * i + 5 * j) as f64).sin() + f64::from(i == j));
        let matrix = &root * root.transpose();
        let scores = DVector::from_fn(7, |i, _| 1.0 + i as f64);
        let plain = || Scores { scores: scores.clone(), covariance: matrix.clone() };
        let walk = Walk::of(plain());
        let eigen = nalgebra::SymmetricEigen::new(matrix.clone());
        let along = eigen.eigenvectors.tr_mul(&scores);
        let (values, variance) = (&eigen.eigenvalues, 0.37);
        let sum = |term: &dyn Fn(f64, f64) -> f64| -> f64 {
            values.iter().zip(along.iter()).map(|(value, along)| term(*value, *along)).sum()
        };
        let alike = |a: f64, b: f64| assert!((a - b).abs() < 1e-10 * b.abs(), "{a} {b}");
        let weighed = walk.weighed(variance);
        alike(weighed.square, sum(&|value, along| along * along / (1.0 + variance * value)));
        alike(weighed.ln_determinant, sum(&|value, _| (1.0 + variance * value).ln()));
        alike(weighed.curvature, sum(&|value, _| (value / (1.0 + variance * value)).powi(2)));
        for (order, power) in (1..).zip(walk.powers()) {
            alike(power, sum(&|value, _| value.powi(order)));
        }
        alike(walk.ln_p(), plain().ln_p());
        let best = walk.best();
        for by in [0.99, 1.01] {
            assert!(walk.likelihood_at(best) >= walk.likelihood_at(by * best));
        }
    }

    #[test]
    fn the_tail_of_equal_weights_is_chi_squared() {
        // Five weights of 2: twice chi squared of five degrees; 1 % beyond 2 * 15.086.
        let found = ln_tail(2.0 * 15.086_27, [10.0, 20.0, 40.0]).exp();
        assert!((found - 0.01).abs() < 1e-6, "{found}");
    }
}
