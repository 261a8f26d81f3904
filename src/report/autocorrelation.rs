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

/// Residuals larger than stated by so much are worth a word here.
const LARGER: f64 = 1.1;

/// What that does to uncertainties, in a sentence; empty where none are.
pub fn text(all: &[Autocorrelated]) -> String {
    let Some(worst) = all.first() else { return String::new() };
    let names: Vec<String> = all.iter().map(|one| format!("`{}`", one.measurand)).collect();
    let larger = match worst.level > LARGER {
        true => format!(
            " ({} times by the correlation, {} times by residuals larger than stated)",
            decimal(worst.times, 1),
            decimal(worst.level, 1)
        ),
        false => String::new(),
    };
    format!(
        "\nThe residuals of {} are correlated from reading to reading, over {} and more: the standard uncertainty of what acts evenly over so many is too small by about {} times{larger}. `calibrate --noise sandwich` counts it, `--noise autocorrelated` weights by it, too; `homepoint diagnose` looks for its cause.\n",
        names.join(", "),
        counted(usize::try_from(worst.readings).unwrap_or(usize::MAX), "reading"),
        decimal(worst.of_both(), 1)
    )
}

/// The same for programs.
pub fn json(all: &[Autocorrelated]) -> Value {
    let each = all.iter().map(
        |one| json!({ "measurand": one.measurand, "times": one.times, "level": one.level, "readings": one.readings }),
    );
    json!({ "autocorrelated": each.collect::<Vec<_>>() })
}
