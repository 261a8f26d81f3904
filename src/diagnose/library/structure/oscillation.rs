//! An oscillation of the readings in time that no effect describes.

use crate::graph::MeasurandKind;
use crate::model::Model;
use crate::units::Unit;

use super::covariate::AXES;
use super::made::{Block, made};
use super::waves::range;
use crate::diagnose::library::place::{ALL_READINGS, OSCILLATION, Of, Place};

/// Frequency (Hz) from which an oscillation is looked for in the spectrum of the residuals.
pub(in crate::diagnose) const FAST: f64 = 10.0;
/// Frequencies (Hz) from where slow waves end, and fast ones, up to what a campaign's sampling carries.
const SLOW: (&str, &str) = ("0.1 Hz", "10 Hz");
const BEYOND: (&str, &str) = ("10 Hz", "100 kHz");

/// Oscillations of all readings, a slow and a fast one, with phases and strengths of each run's own.
pub(super) fn in_time(model: &Model) -> Vec<Block> {
    [("", SLOW), ("fast_", BEYOND)].into_iter().filter_map(|own| oscillation(model, own)).collect()
}

fn oscillation(model: &Model, (kind, range_of): (&str, (&str, &str))) -> Option<Block> {
    let all = &model.measurands;
    let (of, what) = match all.as_slice() {
        [one] => (Of::Measurand(one.name.clone()), format!("`{}`", one.name)),
        _ => (Of::Channel(ALL_READINGS.to_owned()), "the readings".to_owned()),
    };
    let place = Place::new(of, OSCILLATION, format!("an oscillation of {what} at {{member}} Hz"));
    let (mut coefficients, mut patches) = (Vec::new(), String::new());
    for (number, measurand) in all.iter().enumerate() {
        let name = measurand.name.as_str();
        let is_turn = measurand.kind == MeasurandKind::Rotation;
        let along = AXES.map(|axis| format!(" * {axis}"));
        let along = if is_turn { &along[..] } else { &[String::new()] };
        let mut wave = Vec::new();
        for (axis, along) in along.iter().enumerate() {
            for phase in ["cos", "sin"] {
                let coefficient = format!("unknown_{phase}_{number}_{axis}");
                wave.push(format!(
                    "{coefficient} * {phase}(2 * pi * unknown_frequency * run_time){along}"
                ));
                coefficients.push((coefficient, Unit::coherent(measurand.unit.dimension)));
            }
        }
        let sum = wave.join(" + ");
        patches.push_str(&match is_turn {
            true => format!("{name} = '{name} * turn({sum})'\n"),
            false => format!("{name} = '{name} + {sum}'\n"),
        });
    }
    // Models with other measurands have another family.
    let names: Vec<&str> = all.iter().map(|one| one.name.as_str()).collect();
    let name = format!("unknown_{kind}oscillation_{}", names.join("_"));
    let line = range("unknown_frequency", "Hz", range_of);
    made(&name, &place, (&coefficients, "run"), &line, &patches)
}
