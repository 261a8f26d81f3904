//! The global test of a fit: whether chi squared agrees with the stated uncertainties.
//!
//! Two-sided (Baarda 1968): residuals may be larger than stated, or smaller.

use crate::diagnose::evidence::tail::{ln_below, ln_chi_squared};
use crate::estimate::calibrate::Calibration;

/// Level below which residuals count as larger or smaller than stated.
const LEVEL: f64 = 0.001;

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

/// The line with the test.
pub fn line(result: &Calibration) -> String {
    let Some(p) = p_value(result) else { return String::new() };
    let shown = match p {
        p if p < 1e-12 => "p < 1e-12".to_owned(),
        p if p < 1e-3 => format!("p = {p:.1e}"),
        p => format!("p = {p:.3}"),
    };
    format!(
        "global test: chi squared {:.1}, {} degrees of freedom, {shown} (two-sided)\n",
        result.fit.cost,
        result.degrees_of_freedom()
    )
}

/// What the test says of the stated uncertainties; empty if they agree with the residuals.
pub fn verdict(result: &Calibration) -> String {
    let rejects = p_value(result).is_some_and(|p| p < LEVEL);
    let ratio = result.variance_factor().map_or(1.0, f64::sqrt);
    if !result.is_sound() || !rejects || (1.0 / RATIO..RATIO).contains(&ratio) {
        return String::new();
    }
    if ratio > 1.0 {
        format!(
            "\nThe residuals are {ratio:.2} times as large as stated: the uncertainties do not hold. `homepoint diagnose` looks for the cause.\n"
        )
    } else {
        format!(
            "\nThe residuals are {ratio:.2} times as large as stated, less than chance allows: the stated sigmas are too large, or readings are not independent.\n"
        )
    }
}
