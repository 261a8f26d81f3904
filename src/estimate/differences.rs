//! The seed's own way to the uncertainty of a delay (Depenthal 2009, section 3.4).
//!
//! The model is evaluated at instants 1 ms apart; the difference of a measurand over 1 ms is the
//! *function value* at that arm position. The *boundary value* is the measurand's standard uncertainty
//! from the residuals of the transformation. Then `U = 2 · boundary value / function value · 1 ms`.
//!
//! Beside the exact `U = 2 √(u_m² + J Σ Jᵀ) / |m'|` ([`crate::estimate::newton`]) it takes a mean
//! slope over the following millisecond for the slope: both agree where the slope hardly changes in
//! 1 ms. Near a reversal the difference vanishes half a millisecond before the slope does, and elsewhere
//! it stays finite. It knows nothing of what the transformation leaves open at another rate, of the
//! timing or of the encoder beyond what shows in the residuals.

use crate::engine::point::Point;
use crate::engine::problem::{Problem, SampleLeaves, wrapped};
use crate::estimate::calibrate::Calibration;
use crate::estimate::newton::ReadingDelay;
use crate::graph::MeasurandKind;

/// The step of the table (s).
pub const STEP: f64 = 1e-3;

/// The boundary value of a measurand: the rms of its residuals, made up for the unknowns fitted.
pub fn boundary(transformation: &Calibration, measurand: &str) -> Option<f64> {
    let (_, rms) = transformation.rms.iter().find(|(name, _)| name == measurand)?;
    let degrees = transformation.degrees_of_freedom();
    (degrees > 0).then(|| rms * (transformation.readings as f64 / degrees as f64).sqrt())
}

/// Expanded uncertainties (s) of delays by differences, one for each of the readings.
pub fn expanded(
    problem: &Problem,
    part: usize,
    point: &Point,
    boundary: f64,
    readings: &[&ReadingDelay],
) -> Vec<f64> {
    readings
        .iter()
        .map(|reading| 2.0 * boundary * STEP / function_value(problem, part, point, reading).abs())
        .collect()
}

/// By how much the measurand changes in the millisecond that begins at a sample's reference time.
fn function_value(problem: &Problem, part: usize, point: &Point, reading: &ReadingDelay) -> f64 {
    let data = &problem.parts[part];
    let mut parameters = problem.parameters::<f64>(part, reading.run, point);
    let delay = data.system.assembly.names.measurands[reading.measurand].delay;
    let randoms = vec![0.0; data.random_sigma.len()];
    let mut workspace = Vec::new();
    let mut at = |offset: f64| {
        parameters[delay][0] = offset;
        let leaves = SampleLeaves {
            parameters: &parameters,
            randoms: &randoms,
            columns: data.columns(),
            run: &data.runs[reading.run],
            sample: reading.sample,
        };
        data.evaluate_one(reading.measurand, &leaves, &mut workspace)[0]
    };
    let difference = at(STEP) - at(0.0);
    match data.slots()[reading.measurand].kind {
        MeasurandKind::Angle { period } => wrapped(difference, period),
        _ => difference,
    }
}
