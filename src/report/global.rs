//! The global test of a fit, in words.

use crate::estimate::calibrate::Calibration;
use crate::estimate::global::{misfit, p_value};
use crate::estimate::noise::Noise;
use crate::units::{decimal, ratio};

/// Residuals so many times as large as stated speak of another unit.
const ANOTHER_UNIT: f64 = 0.1;

/// The line with the test.
pub fn line(result: &Calibration) -> String {
    let Some(p) = p_value(result) else { return String::new() };
    let shown = match p {
        p if p < 1e-12 => "p < 1e-12".to_owned(),
        p if p < 1e-3 => format!("p = {p:.1e}"),
        p => format!("p = {p:.3}"),
    };
    let degrees = result.degrees_of_freedom();
    let degree = if degrees == 1 { "degree" } else { "degrees" };
    format!(
        "global test: chi squared {}, {degrees} {degree} of freedom, {shown} (two-sided)\n",
        decimal(result.fit.cost, 1)
    )
}

/// What the test says of the stated uncertainties; empty if they agree with the residuals, or if
/// uncertainties follow from the residuals themselves.
pub fn verdict(result: &Calibration) -> String {
    let Some(misfit) = misfit(result).filter(|_| result.noise == Noise::Stated) else {
        return String::new();
    };
    if misfit > 1.0 {
        format!(
            "\nThe residuals are {} times as large as stated: the uncertainties do not hold. `homepoint diagnose` looks for the cause.\n",
            decimal(misfit, 2)
        )
    } else if misfit < ANOTHER_UNIT {
        format!(
            "\nThe residuals are {} times as large as stated: the sigmas are stated too large by far, in another unit perhaps, and so are the uncertainties below.\n",
            ratio(misfit, 2)
        )
    } else {
        format!(
            "\nThe residuals are {misfit:.2} times as large as stated, less than chance allows: the stated sigmas are too large, or readings are not independent.\n"
        )
    }
}
