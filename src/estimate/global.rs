//! The global test of a fit: whether chi squared agrees with the stated uncertainties.
//!
//! Two-sided (Baarda 1968): residuals may be larger than stated, or smaller.

use crate::estimate::calibrate::Calibration;
use crate::statistics::{ln_below, ln_chi_squared};

/// Level below which residuals count as larger or smaller than stated.
pub const LEVEL: f64 = 0.001;
/// A smaller ratio of residuals to what is stated is not worth a sentence, however sure it is.
const RATIO: f64 = 1.1;

/// The probability that chi squared of a right model lies as far out or farther, on both sides;
/// `None` without degrees of freedom or without a finite sum.
pub fn p_value(result: &Calibration) -> Option<f64> {
    let degrees = usize::try_from(result.degrees_of_freedom()).ok().filter(|count| *count > 0)?;
    let chi_squared = Some(result.fit.cost).filter(|cost| cost.is_finite())?;
    let above = ln_chi_squared(chi_squared, degrees).exp();
    let below = ln_below(chi_squared, degrees).exp();
    Some((2.0 * above.min(below)).min(1.0))
}

/// By how many times residuals are as large as stated, where the test rejects that they agree and
/// the difference is worth a word; `None` where they agree, or the fit is no solution. Residuals are
/// as large whether or not every parameter is determined.
pub fn misfit(result: &Calibration) -> Option<f64> {
    let rejects = p_value(result).is_some_and(|p| p < LEVEL);
    let ratio = result.variance_factor().map_or(1.0, f64::sqrt);
    (result.has_settled() && rejects && !(1.0 / RATIO..RATIO).contains(&ratio)).then_some(ratio)
}
