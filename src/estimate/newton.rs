//! Each reading's own delay: safeguarded Newton from the reference time.
//!
//! A measurand is a function `m(t)` of its delay alone once the transformation is known (the seed,
//! section 3.2.1); `m(t) = reading` is solved for `t`, starting at the reference time, `t = 0`.
//! The delay is an implicit function of every parameter: `dt/dθ = -(∂m/∂θ) / m'`, so
//! `u² = (u_m² + J Σ Jᵀ) / m'²` with the full covariance Σ of the parameters (the seed, section 3.4,
//! has the reading's part alone). Where `m'` vanishes the reading is *blind*.

use nalgebra::{DMatrix, DVector};

use crate::engine::point::Point;
use crate::engine::problem::{Problem, SampleLeaves};
use crate::number::{Dual, Gradient, Number, derivative, partials, variable};

/// Tangents in one pass.
const CHUNK: usize = 8;
/// Newton steps before giving up.
const MAXIMUM_STEPS: usize = 50;
/// A step this small (s), or this small against the delay, ends the iteration.
const TOLERANCE: f64 = 1e-14;

/// Whether a reading gave its delay.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum State {
    /// Solved.
    Solved,
    /// The measurand hardly changes with time here.
    Blind,
    /// Newton's iteration found no delay that explains the reading.
    Failed,
}

impl State {
    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Solved => "solved",
            Self::Blind => "blind",
            Self::Failed => "failed",
        }
    }
}

/// The delay of one reading.
#[derive(Clone, Debug)]
pub struct ReadingDelay {
    /// Run of the campaign.
    pub run: usize,
    /// Sample of the run.
    pub sample: usize,
    /// Measurand.
    pub measurand: usize,
    /// What came of it.
    pub state: State,
    /// Delay (s); NaN unless solved or blind.
    pub delay: f64,
    /// Derivative of the measurand with respect to its delay (unit/s).
    pub slope: f64,
    /// Random part of the standard uncertainty (s): the reading and what is random in its sample.
    pub random: f64,
    /// The same with the slope at the reference time, which the reading's own error does not touch:
    /// what decides on blindness and weights.
    pub random_at_reference: f64,
    /// Common part (s): the parameters' covariance.
    pub common: f64,
    /// `dt/dθ` over the columns the run touches.
    pub sensitivity: DVector<f64>,
    /// Newton steps.
    pub steps: usize,
}

impl ReadingDelay {
    /// Combined standard uncertainty (s).
    pub fn standard_uncertainty(&self) -> f64 {
        self.random.hypot(self.common)
    }

    /// Expanded uncertainty (s), k = 2.
    pub fn expanded_uncertainty(&self) -> f64 {
        2.0 * self.standard_uncertainty()
    }
}

/// What the delays of a run are computed from.
#[derive(Clone, Copy, Debug)]
pub struct Given<'a> {
    /// The campaigns.
    pub problem: &'a Problem,
    /// Parameter values.
    pub point: &'a Point,
    /// Covariance of all columns at that point.
    pub covariance: &'a DMatrix<f64>,
    /// Farthest delay looked for (s).
    pub range: f64,
}

/// Solves `f(t) = 0` by Newton from 0, within `±range`: steps are halved while they do not bring
/// `f` nearer to zero. Returns the root, the slope there and the number of steps.
pub fn solve(range: f64, mut f: impl FnMut(Dual) -> Dual) -> Option<(f64, f64, usize)> {
    let mut t = 0.0;
    let mut here = f(variable(t));
    for step_number in 0..MAXIMUM_STEPS {
        if !here.value().is_finite() {
            return None;
        }
        let slope = derivative(here);
        if here.value() == 0.0 {
            return Some((t, slope, step_number));
        }
        let mut step = -here.value() / slope;
        if !step.is_finite() {
            return None;
        }
        step = step.clamp(-range, range);
        if step.abs() <= TOLERANCE.max(4.0 * f64::EPSILON * t.abs()) {
            return Some((t + step, slope, step_number));
        }
        let mut next = f(variable((t + step).clamp(-range, range)));
        for _ in 0..20 {
            if next.value().is_finite() && next.value().abs() < here.value().abs() {
                break;
            }
            step *= 0.5;
            next = f(variable((t + step).clamp(-range, range)));
        }
        let moved = (t + step).clamp(-range, range);
        if next.value().abs() >= here.value().abs() {
            // No further descent: rounding has been reached, or there is no root.
            let rounding = step.abs() <= 1e-9 * range || here.value().abs() <= 1e-12;
            return rounding.then_some((t, slope, step_number));
        }
        t = moved;
        here = next;
    }
    None
}

/// The delay of every reading of one measurand in one run, a rotation left out (it has no single
/// delay).
pub fn delays_of_run(
    given: &Given<'_>,
    p: usize,
    run: usize,
    measurand: usize,
) -> Vec<ReadingDelay> {
    let problem = given.problem;
    let part = &problem.parts[p];
    let slot = &part.slots()[measurand];
    if slot.components != 1 {
        return Vec::new();
    }
    let delay = part.system.assembly.names.measurands[measurand].delay;
    let delay_instance = problem.layout.instance_in(p, run, delay);
    let mut tangents = problem.tangents(p, run);
    tangents.retain(|(instance, _)| *instance != delay_instance);
    let touched = problem.layout.columns.touched_by(problem.run_index(p, run));
    let local = local_covariance(given.covariance, &touched);
    let movers: Vec<Vec<(usize, f64)>> = tangents
        .iter()
        .map(|(instance, component)| {
            let columns = problem.layout.columns_of(*instance, *component);
            columns
                .into_iter()
                .filter_map(|(column, c)| Some((touched.iter().position(|t| *t == column)?, c)))
                .collect()
        })
        .collect();
    let chunks: Vec<Vec<[Gradient<CHUNK>; 4]>> = tangents
        .chunks(CHUNK)
        .map(|chunk| problem.seeded_parameters(p, run, given.point, chunk))
        .collect();
    let constants = problem.parameters::<Dual>(p, run, given.point);
    let random_parts = random_parts(problem, p, run, measurand, given.point);
    let zero_randoms = vec![Dual::constant(0.0); part.random_sigma.len()];
    let no_randoms = vec![Gradient::<CHUNK>::constant(0.0); part.random_sigma.len()];
    let (mut dual_work, mut gradient_work) = (Vec::new(), Vec::new());
    let mut parameters = constants;
    let mut found = Vec::new();
    for (sample, random_part) in random_parts.into_iter().enumerate() {
        if !part.is_present(run, sample, slot) {
            continue;
        }
        let mut reference_slope = None;
        let solution = solve(given.range, |t| {
            parameters[delay][0] = t;
            let leaves = SampleLeaves {
                parameters: &parameters,
                randoms: &zero_randoms,
                columns: part.columns(),
                run: &part.runs[run],
                sample,
            };
            let outputs = part.evaluate_one(measurand, &leaves, &mut dual_work);
            let difference = -part.residual_of_one(run, sample, measurand, outputs)[0];
            // Newton begins at the reference time.
            reference_slope.get_or_insert(derivative(difference));
            difference
        });
        let mut reading = ReadingDelay {
            run,
            sample,
            measurand,
            state: State::Failed,
            delay: f64::NAN,
            slope: f64::NAN,
            random: f64::NAN,
            random_at_reference: f64::INFINITY,
            common: f64::NAN,
            sensitivity: DVector::zeros(touched.len()),
            steps: MAXIMUM_STEPS,
        };
        if let Some(slope) = reference_slope.filter(|slope| slope.is_finite() && *slope != 0.0) {
            reading.random_at_reference = random_part / slope.abs();
        }
        if let Some((t, slope, steps)) = solution {
            for (number, seeded) in chunks.iter().enumerate() {
                let mut seeded = seeded.clone();
                seeded[delay][0] = Gradient::constant(t);
                let leaves = SampleLeaves {
                    parameters: &seeded,
                    randoms: &no_randoms,
                    columns: part.columns(),
                    run: &part.runs[run],
                    sample,
                };
                let outputs = part.evaluate_one(measurand, &leaves, &mut gradient_work);
                let residual = part.residual_of_one(run, sample, measurand, outputs)[0];
                let first = number * CHUNK;
                for (movers, change) in movers.iter().skip(first).zip(partials(&residual)) {
                    for (column, coefficient) in movers {
                        // residual = reading - m, so -∂m/∂θ is the residual's derivative.
                        reading.sensitivity[*column] += coefficient * change / slope;
                    }
                }
            }
            reading.state = State::Solved;
            reading.delay = t;
            reading.slope = slope;
            reading.steps = steps;
            reading.random = random_part / slope.abs();
            let common = (reading.sensitivity.transpose() * &local * &reading.sensitivity)[(0, 0)];
            reading.common = common.max(0.0).sqrt();
        }
        found.push(reading);
    }
    found
}

fn local_covariance(covariance: &DMatrix<f64>, touched: &[usize]) -> DMatrix<f64> {
    DMatrix::from_fn(touched.len(), touched.len(), |i, j| covariance[(touched[i], touched[j])])
}

/// Standard deviation of each reading of a measurand: its own noise and the sample's random
/// quantities.
fn random_parts(
    problem: &Problem,
    p: usize,
    run: usize,
    measurand: usize,
    point: &Point,
) -> Vec<f64> {
    let part = &problem.parts[p];
    let parameters = problem.parameters(p, run, point);
    let active = crate::engine::noise::active_randoms(part);
    let row = part.slots()[measurand].residual;
    let mut workspace = Vec::new();
    (0..part.runs[run].record.len())
        .map(|sample| {
            let made = crate::engine::noise::covariance_of(
                part,
                run,
                sample,
                &parameters,
                &active,
                &mut workspace,
            );
            made.covariance[(row, row)].max(0.0).sqrt()
        })
        .collect()
}
