//! The seed's own way to the uncertainty of a delay (Depenthal 2009, section 3.4).
//!
//! The model is evaluated at instants 1 ms apart; the difference of a measurand over 1 ms is the
//! *function value* at that arm position. The *boundary value* is the measurand's standard
//! uncertainty from the residuals of the transformation. Then
//! `U = 2 · boundary value / function value · 1 ms`.
//!
//! Beside the exact `U = 2 √(u_m² + J Σ Jᵀ) / |m'|` ([`crate::estimate::newton`]) it takes a mean
//! slope over the following millisecond for the slope: both agree where the slope hardly changes in
//! 1 ms. Near a reversal the difference vanishes half a millisecond before the slope does, and
//! elsewhere it stays finite. It knows nothing of what the transformation leaves open at another
//! rate, of the timing or of the encoder beyond what shows in the residuals.

use crate::engine::part::{SampleLeaves, wrapped};
use crate::engine::point::Point;
use crate::engine::problem::Problem;
use crate::estimate::calibrate::Calibration;
use crate::estimate::nearby::Nearby;
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

/// Function values of readings, in whatever order they come.
pub struct Differences<'a> {
    problem: &'a Problem,
    part: usize,
    point: &'a Point,
    nearby: Nearby,
    workspace: Vec<f64>,
}

impl<'a> Differences<'a> {
    /// For the delays of one campaign at a point.
    pub fn new(problem: &'a Problem, part: usize, point: &'a Point) -> Self {
        Self { problem, part, point, nearby: Nearby::default(), workspace: Vec::new() }
    }

    /// Expanded uncertainty (s), k = 2, of the delay of a reading with this boundary value.
    pub fn expanded(&mut self, boundary: f64, reading: &ReadingDelay) -> f64 {
        2.0 * boundary * STEP / self.function_value(reading).abs()
    }

    /// By how much the measurand changes in the millisecond that begins at the reference time.
    fn function_value(&mut self, reading: &ReadingDelay) -> f64 {
        let data = &self.problem.parts[self.part];
        let mut parameters = self.problem.parameters::<f64>(self.part, reading.run, self.point);
        let delay = data.system.assembly.names.measurands[reading.measurand].delay;
        let randoms = vec![0.0; data.random_sigma.len()];
        let sample = self.nearby.sample(data, reading);
        let mut at = |offset: f64| {
            parameters[delay][0] = offset;
            let leaves = SampleLeaves {
                parameters: &parameters,
                randoms: &randoms,
                columns: data.columns(),
                sample,
            };
            data.evaluate_one(reading.measurand, &leaves, &mut self.workspace)[0]
        };
        let difference = at(STEP) - at(0.0);
        match data.slots()[reading.measurand].kind {
            MeasurandKind::Angle { period } => wrapped(difference, period),
            _ => difference,
        }
    }
}
