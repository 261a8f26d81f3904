//! Residuals that are correlated from reading to reading.

use serde_json::{Value, json};

use crate::diagnostic::counted;
use crate::estimate::autocorrelation::{Autocorrelated, autocorrelated};
use crate::estimate::calibrate::Calibration;
use crate::estimate::noise::Noise;
use crate::units::decimal;

/// Those of a fit whose numbers can be used, and do not count it.
pub fn correlated(result: &Calibration) -> Vec<Autocorrelated> {
    let is_counted = result.noise != Noise::Stated;
    if result.is_sound() && !is_counted { autocorrelated(result) } else { Vec::new() }
}

/// What that does to uncertainties, in a sentence; empty where none are.
pub fn text(all: &[Autocorrelated]) -> String {
    let Some(worst) = all.first() else { return String::new() };
    let names: Vec<String> = all.iter().map(|one| format!("`{}`", one.measurand)).collect();
    format!(
        "\nThe residuals of {} are correlated from reading to reading, over {} and more: uncertainties may be too small by up to {} times. `calibrate --noise sandwich` counts it, `--noise autocorrelated` weights by it, too; `homepoint diagnose` looks for its cause.\n",
        names.join(", "),
        counted(usize::try_from(worst.readings).unwrap_or(usize::MAX), "reading"),
        decimal(worst.times, 1)
    )
}

/// The same for programs.
pub fn json(all: &[Autocorrelated]) -> Value {
    let each = all.iter().map(
        |one| json!({ "measurand": one.measurand, "times": one.times, "readings": one.readings }),
    );
    json!({ "autocorrelated": each.collect::<Vec<_>>() })
}
