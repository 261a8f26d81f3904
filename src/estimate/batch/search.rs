//! Search: how strongly to damp, learnt from how well the last linearisation predicted the cost.
//!
//! Nielsen's rule (Madsen, Nielsen, Tingleff 2004, eq. (2.21)) on Moré's scale, the largest length
//! each column has had so far (Moré 1978, eq. (6.3)). It does not know how a step is found.

use nalgebra::DVector;

/// Damping beyond which no step means anything.
const LIMIT: f64 = 1e40;
/// Least share of the predicted decrease that must come true.
pub(super) const ACCEPT: f64 = 1e-4;

/// The state of the search.
#[derive(Clone, Debug)]
pub(super) struct Search {
    damping: f64,
    growth: f64,
    /// Largest squared column lengths so far.
    scale: DVector<f64>,
}

impl Search {
    pub(super) fn new(unknowns: usize, damping: f64) -> Self {
        Self { damping, growth: 2.0, scale: DVector::zeros(unknowns) }
    }

    /// Lets the scale follow a new linearisation; `diagonal` holds squared column lengths.
    pub(super) fn rescale(&mut self, diagonal: &DVector<f64>) {
        self.scale = self.scale.zip_map(diagonal, f64::max);
    }

    /// What to add to the diagonal: a column without effect is held by a term of its own.
    pub(super) fn terms(&self) -> DVector<f64> {
        ridge(&self.scale, self.damping)
    }

    /// The prediction came true to `ratio`.
    pub(super) fn accept(&mut self, ratio: f64) {
        let shrink = 1.0 - (2.0 * ratio - 1.0).powi(3);
        self.damping = (self.damping * shrink.clamp(1.0 / 3.0, 2.0)).max(1e-15);
        self.growth = 2.0;
    }

    /// The step was of no use.
    pub(super) fn reject(&mut self) {
        self.damping *= self.growth;
        self.growth *= 2.0;
    }

    /// Whether shorter steps are still worth trying.
    pub(super) fn alive(&self) -> bool {
        self.damping < LIMIT
    }
}

/// `share` of each squared column length; `1` for a column without length.
pub(super) fn ridge(squares: &DVector<f64>, share: f64) -> DVector<f64> {
    squares.map(|square| if square > 0.0 { share * square } else { 1.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn good_predictions_lower_the_damping_and_bad_ones_raise_it_faster_and_faster() {
        let mut search = Search::new(2, 1.0);
        search.rescale(&DVector::from_vec(vec![4.0, 0.0]));
        search.rescale(&DVector::from_vec(vec![1.0, 0.0]));
        assert_eq!(search.terms().as_slice(), [4.0, 1.0], "the scale never shrinks");
        search.accept(1.0);
        assert!((search.damping - 1.0 / 3.0).abs() < 1e-15);
        search.accept(0.5);
        assert!((search.damping - 1.0 / 3.0).abs() < 1e-15, "half right: keep");
        search.reject();
        search.reject();
        assert!((search.damping - 8.0 / 3.0).abs() < 1e-14);
        for _ in 0..20 {
            search.reject();
        }
        assert!(!search.alive());
    }
}
