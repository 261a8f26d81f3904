//! What the calibration of the inputs leaves open, in the delays.
//!
//! An encoder is wrong by the same at the same position, whenever the arm comes by, so this part of
//! a delay's uncertainty does not shrink with the number of readings. How the errors of different
//! positions belong together is not known: the mean's is bounded by that of errors all of one sign,
//! `Σ w |g / m'| u / Σ w`, with the derivative g of the measurand by the input's error and its rate
//! m'. The bound holds for any error of that size. That the transformation was fitted at arm
//! positions with the same errors, which takes some of them up, is not counted.

use crate::engine::part::SampleLeaves;
use crate::engine::point::Point;
use crate::engine::problem::Problem;
use crate::estimate::delays::Delays;
use crate::estimate::median::Median;
use crate::estimate::nearby::Nearby;
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
    nearby: Nearby,
}

impl<'a> Sensitivities<'a> {
    pub(crate) fn new(problem: &'a Problem, part: usize, point: &'a Point) -> Self {
        let (parameters, workspace, nearby) = (Vec::new(), Vec::new(), Nearby::default());
        Self { problem, part, run: None, parameters, workspace, point, nearby }
    }

    /// The factor on the reading's standard uncertainty, and its derivative by each random quantity
    /// of `wanted` at the moment of the delay that it gave.
    pub(crate) fn of(&mut self, reading: &ReadingDelay, wanted: &[usize]) -> (f64, Vec<f64>) {
        let part = &self.problem.parts[self.part];
        if self.run != Some(reading.run) {
            self.parameters = self.problem.parameters(self.part, reading.run, self.point);
            self.run = Some(reading.run);
        }
        // Another measurand's delay may be left there: only this one's is looked at.
        let delay = part.system.assembly.names.measurands[reading.measurand].delay;
        self.parameters[delay][0] = Gradient::constant(reading.delay);
        let slot = &part.slots()[reading.measurand];
        let sample = self.nearby.sample(part, reading);
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
                sample,
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
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Systematic {
    /// The input.
    pub input: usize,
    /// In one reading (s), root mean square over the solved ones.
    pub reading: f64,
    /// In their weighted mean (s), a bound.
    pub mean: f64,
}

/// Widens delays by what the calibration of inputs leaves open, as they come.
pub struct Widening<'a> {
    sensitivities: Sensitivities<'a>,
    /// Inputs with a calibration, and its standard uncertainty (SI).
    inputs: Vec<(usize, f64)>,
    /// Their errors among the random quantities.
    errors: Vec<usize>,
    sums: Vec<Sum>,
}

/// Sums over the solved readings of one measurand.
#[derive(Clone, Debug, Default)]
struct Sum {
    count: f64,
    weights: f64,
    /// For each input `Σ w |g / m'| u`, and the sum of squares without weights.
    weighted: Vec<f64>,
    squares: Vec<f64>,
    expanded: Median,
}

impl<'a> Widening<'a> {
    /// For the delays of one campaign at a point.
    pub fn new(problem: &'a Problem, part: usize, point: &'a Point) -> Self {
        let data = &problem.parts[part];
        let names = &data.system.assembly.names;
        let (mut inputs, mut errors) = (Vec::new(), Vec::new());
        for (input, sigma) in data.calibration.iter().enumerate() {
            if let (true, Some(error)) = (*sigma > 0.0, names.inputs[input].error) {
                inputs.push((input, *sigma));
                errors.push(error);
            }
        }
        let none = vec![0.0; inputs.len()];
        let sum = Sum { weighted: none.clone(), squares: none, ..Sum::default() };
        let sums = vec![sum; names.measurands.len()];
        Self { sensitivities: Sensitivities::new(problem, part, point), inputs, errors, sums }
    }

    /// A reading's delay, widened.
    pub fn see(&mut self, reading: &ReadingDelay) -> ReadingDelay {
        let mut wide = reading.clone();
        if self.inputs.is_empty() || reading.state != State::Solved {
            return wide;
        }
        let (_, slopes) = self.sensitivities.of(reading, &self.errors);
        let sum = &mut self.sums[reading.measurand];
        let weight = reading.random_at_reference.powi(-2);
        sum.count += 1.0;
        sum.weights += weight;
        for (number, ((_, sigma), slope)) in self.inputs.iter().zip(slopes).enumerate() {
            let own = (slope / reading.slope).abs() * sigma;
            sum.weighted[number] += weight * own;
            sum.squares[number] += own * own;
            wide.common = wide.common.hypot(own);
        }
        sum.expanded.see(wide.expanded_uncertainty());
        wide
    }

    /// What each input's calibration left open of the readings seen.
    pub fn parts(&self, measurand: usize) -> Vec<Systematic> {
        let sum = &self.sums[measurand];
        let seen = self.inputs.iter().enumerate().filter(|_| sum.count > 0.0);
        seen.map(|(number, (input, _))| Systematic {
            input: *input,
            reading: (sum.squares[number] / sum.count).sqrt(),
            mean: sum.weighted[number] / sum.weights,
        })
        .collect()
    }

    /// Widens the means of the readings seen.
    pub fn widen(&self, delays: &mut Delays) {
        let part = &self.sensitivities.problem.parts[self.sensitivities.part];
        let names = &part.system.assembly.names.measurands;
        for summary in &mut delays.measurands {
            let is_it = |one: &crate::graph::Measurand| one.name == summary.measurand;
            let Some(measurand) = names.iter().position(is_it) else { continue };
            let parts = self.parts(measurand);
            if parts.is_empty() {
                continue;
            }
            let mean = parts.iter().map(|one| one.mean).fold(0.0, f64::hypot);
            summary.common = summary.common.map(|common| common.hypot(mean));
            summary.sigma_of_mean = summary.common.zip(summary.random).map(|(a, b)| a.hypot(b));
            summary.median_expanded_uncertainty = self.sums[measurand].expanded.value();
        }
    }
}
