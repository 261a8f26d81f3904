//! Residuals that are correlated from reading to reading.

use serde_json::{Value, json};

use crate::diagnostic::counted;
use crate::estimate::autocorrelation::{Autocorrelated, autocorrelated};
use crate::estimate::calibrate::Calibration;
use crate::estimate::noise::Noise;
use crate::units::{decimal, ratio};

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
    let (times, level) = (decimal(worst.times, 1), worst.level);
    let both = worst.of_both();
    let effect = if both < 1.0 {
        format!(
            "this alone makes them too small by a factor of about {times}, but the residuals are {} times as large as stated, so they are too large by a factor of about {}",
            ratio(level, 2),
            decimal(both.recip(), 1)
        )
    } else if level > LARGER {
        format!(
            "they are too small by a factor of about {} ({times} for the autocorrelation, {} for residuals larger than stated)",
            decimal(both, 1),
            decimal(level, 1)
        )
    } else {
        format!("they are too small by a factor of about {}", decimal(both, 1))
    };
    format!(
        "\nThe residuals of {} are autocorrelated over {} and more. The standard uncertainties do not allow for that: of a parameter that acts alike on so many readings {effect}. `calibrate --noise sandwich` counts it, `--noise autocorrelated` weights by it, too; `homepoint diagnose` looks for its cause.\n",
        names.join(", "),
        counted(usize::try_from(worst.readings).unwrap_or(usize::MAX), "reading"),
    )
}

/// The same for programs.
pub fn json(all: &[Autocorrelated]) -> Value {
    let each = all.iter().map(
        |one| json!({ "measurand": one.measurand, "times": one.times, "level": one.level, "readings": one.readings }),
    );
    json!({ "autocorrelated": each.collect::<Vec<_>>() })
}
