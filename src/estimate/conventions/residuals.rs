//! Which conventions may explain why a model fits badly, before any of them is fitted.
//!
//! A convention that was mistaken leaves residuals of about the size of what it changes. Where these
//! are a thousandth of that, the readings bear out the numbers as they stand, and what is wrong is
//! something else; but not where the fit pays for that with stated values that it leaves by far, such
//! as a span that takes up another unit. Another exception are conventions that parameters follow, such as a mirrored axis of a
//! rig that moves in a plane; then another one changes what is left.

use crate::engine::{Point, Problem};
use crate::estimate::contradicted::BY_FAR;

/// A convention that changes readings by so many times the residuals is not tried.
const BORNE_OUT: f64 = 1e3;

/// Residuals of a problem at a point, over their stated standard uncertainties.
pub(super) struct Residuals {
    values: Vec<f64>,
    /// How far the stated value that is left by most is left, over its standard uncertainty.
    beyond_stated: f64,
}

impl Residuals {
    /// Of all readings; NaN where there is none.
    pub(super) fn of(problem: &Problem, point: &Point) -> Self {
        let mut values = Vec::new();
        for (number, part) in problem.parts.iter().enumerate() {
            let sigma: Vec<f64> =
                (0..part.residual_count()).map(|row| part.sigma[part.measurand_of(row)]).collect();
            for run in 0..part.runs.len() {
                problem.visit_residuals(number, run, point, &mut |_, residuals| {
                    values.extend(residuals.iter().zip(&sigma).map(|(value, sigma)| value / sigma));
                });
            }
        }
        let layout = &problem.layout;
        let priors = (0..layout.instances.len()).flat_map(|one| point.priors_of(layout, one));
        let beyond_stated = priors.map(|one| one.residual.abs()).fold(0.0, f64::max);
        Self { values, beyond_stated }
    }

    /// Whether the readings bear out the numbers as they stand against others, with which these are
    /// the residuals at the same point.
    pub(super) fn bear_out(&self, others: &Self) -> bool {
        let pairs = self.values.iter().zip(&others.values);
        let (mut own, mut changed) = (0.0, 0.0);
        for (value, other) in pairs.filter(|(value, other)| (*value - *other).is_finite()) {
            own += value * value;
            changed += (other - value).powi(2);
        }
        self.beyond_stated < BY_FAR
            && self.values.len() == others.values.len()
            && changed > BORNE_OUT.powi(2) * own
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_changes_readings_a_thousand_times_as_much_as_they_scatter_is_borne_out() {
        let of = |values: &[f64]| Residuals { values: values.to_vec(), beyond_stated: 1.0 };
        let stands = of(&[1.0, -1.0, f64::NAN]);
        assert!(stands.bear_out(&of(&[2_000.0, -1_500.0, 3.0])));
        let contradicted = Residuals { beyond_stated: 400.0, ..of(&[1.0, -1.0, f64::NAN]) };
        assert!(!contradicted.bear_out(&of(&[2_000.0, -1_500.0, 3.0])));
        assert!(!stands.bear_out(&of(&[500.0, -900.0, f64::NAN])));
        // Readings that are there in one of the two alone say nothing.
        assert!(!stands.bear_out(&of(&[f64::NAN, f64::NAN, 5e9])));
        assert!(!stands.bear_out(&of(&[5e9])));
    }
}
