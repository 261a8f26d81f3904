//! What the calibration of the inputs leaves open, in the delays.
//!
//! An encoder is wrong by the same at the same position, whenever the arm comes by, so this part of a
//! delay's uncertainty does not shrink with the number of readings. How the errors of different
//! positions belong together is not known: the mean's is bounded by that of errors all of one sign,
//! `Σ w |g / m'| u / Σ w`, with the derivative g of the measurand by the input's error and its rate m'.
//! The bound holds for any error of that size. That the transformation was fitted at arm positions
//! with the same errors, which takes some of them up, is not counted.

use crate::engine::point::Point;
use crate::engine::problem::{Problem, SampleLeaves};
use crate::estimate::delays::{Delays, Summary, median};
use crate::estimate::newton::{ReadingDelay, State};
use crate::number::{Gradient, Number, partial, partials};

/// Random quantities handled in one pass.
const CHUNK: usize = 4;

/// Derivatives of readings by what is random in their samples, each at its own delay.
pub(crate) struct Sensitivities<'a> {
    problem: &'a Problem,
    part: usize,
    run: Option<usize>,
    parameters: Vec<[Gradient<CHUNK>; 4]>,
    workspace: Vec<Gradient<CHUNK>>,
    point: &'a Point,
}

impl<'a> Sensitivities<'a> {
    pub(crate) fn new(problem: &'a Problem, part: usize, point: &'a Point) -> Self {
        let (parameters, workspace) = (Vec::new(), Vec::new());
        Self { problem, part, run: None, parameters, workspace, point }
    }

    /// The factor on the reading's standard uncertainty, and its derivative by each random quantity
    /// of `wanted` at the moment of the delay that it gave.
    pub(crate) fn of(&mut self, reading: &ReadingDelay, wanted: &[usize]) -> (f64, Vec<f64>) {
        let part = &self.problem.parts[self.part];
        if self.run != Some(reading.run) {
            self.parameters = self.problem.parameters(self.part, reading.run, self.point);
            self.run = Some(reading.run);
        }
        let delay = part.system.assembly.names.measurands[reading.measurand].delay;
        self.parameters[delay][0] = Gradient::constant(reading.delay);
        let slot = &part.slots()[reading.measurand];
        let mut randoms = vec![Gradient::constant(0.0); part.random_sigma.len()];
        let mut factor = 1.0;
        let mut found = Vec::with_capacity(wanted.len());
        for start in (0..wanted.len().max(1)).step_by(CHUNK) {
            let chunk = &wanted[start.min(wanted.len())..wanted.len().min(start + CHUNK)];
            for (seed, random) in chunk.iter().enumerate() {
                randoms[*random] = partial(0.0, seed);
            }
            let leaves = SampleLeaves {
                parameters: &self.parameters,
                randoms: &randoms,
                columns: part.columns(),
                run: &part.runs[reading.run],
                sample: reading.sample,
            };
            let outputs = part.evaluate(&leaves, &mut self.workspace);
            found.extend(partials(&outputs[slot.output]).into_iter().take(chunk.len()));
            factor = slot.sigma_factor.map_or(1.0, |output| outputs[output].value());
            for random in chunk {
                randoms[*random] = Gradient::constant(0.0);
            }
        }
        (factor, found)
    }
}

/// What calibration leaves open of one input, in the delays of one measurand.
#[derive(Clone, Debug, PartialEq)]
pub struct Systematic {
    /// The input.
    pub input: usize,
    /// Standard uncertainty of each reading (s), NaN where it has no delay.
    pub readings: Vec<f64>,
    /// Of their weighted mean (s), a bound.
    pub mean: f64,
}

/// The part of every calibrated input in the delays of one measurand, whose readings are given.
pub fn of_measurand(
    problem: &Problem,
    part: usize,
    point: &Point,
    readings: &[&ReadingDelay],
) -> Vec<Systematic> {
    let data = &problem.parts[part];
    let mut all = Vec::new();
    for (input, sigma) in data.calibration.iter().enumerate().filter(|(_, sigma)| **sigma > 0.0) {
        let Some(error) = data.system.assembly.names.inputs[input].error else { continue };
        let mut sensitivities = Sensitivities::new(problem, part, point);
        let (mut sum, mut weights) = (0.0, 0.0);
        let of = |reading: &&ReadingDelay| {
            if !reading.delay.is_finite() {
                return f64::NAN;
            }
            let (_, slopes) = sensitivities.of(reading, &[error]);
            let own = (slopes[0] / reading.slope).abs() * sigma;
            if reading.state == State::Solved {
                let weight = reading.random_at_reference.powi(-2);
                sum += weight * own;
                weights += weight;
            }
            own
        };
        let readings: Vec<f64> = readings.iter().map(of).collect();
        all.push(Systematic { input, readings, mean: sum / weights });
    }
    all
}

/// Widens delays and their means by what the inputs' calibration leaves open.
pub fn widen(problem: &Problem, part: usize, point: &Point, delays: &mut Delays) {
    if problem.parts[part].calibration.iter().all(|sigma| *sigma == 0.0) {
        return;
    }
    let names = &problem.parts[part].system.assembly.names.measurands;
    for summary in &mut delays.measurands {
        let Some(measurand) = names.iter().position(|one| one.name == summary.measurand) else {
            continue;
        };
        let own = |reading: &&ReadingDelay| reading.measurand == measurand;
        let readings: Vec<&ReadingDelay> = delays.readings.iter().filter(own).collect();
        let systematic = of_measurand(problem, part, point, &readings);
        for one in &systematic {
            let own = delays.readings.iter_mut().filter(|one| one.measurand == measurand);
            for (reading, sigma) in own.zip(&one.readings) {
                reading.common = reading.common.hypot(*sigma);
            }
        }
        let mean = systematic.iter().map(|one| one.mean).fold(0.0, f64::hypot);
        let own = delays.readings.iter().filter(own);
        widen_summary(summary, mean, own);
    }
}

fn widen_summary<'a>(
    summary: &mut Summary,
    mean: f64,
    readings: impl Iterator<Item = &'a ReadingDelay>,
) {
    summary.common = summary.common.map(|common| common.hypot(mean));
    summary.sigma_of_mean = summary.common.zip(summary.random).map(|(a, b)| a.hypot(b));
    let solved = readings.filter(|reading| reading.state == State::Solved);
    let mut expanded: Vec<f64> = solved.map(ReadingDelay::expanded_uncertainty).collect();
    summary.median_expanded_uncertainty = median(&mut expanded);
}
