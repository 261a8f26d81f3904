//! Accelerations that nobody recorded, and that the readings miss.
//!
//! A signal captured with its rate alone is taken to move at that rate until the reading, `½ a τ²`
//! short of where it is. Whether that matters depends on the delay `τ`, so it is asked at an
//! estimate, of all such signals at once: components of a rotation that turns evenly accelerate,
//! and together change nothing.
//!
//! Accelerations are differences of neighbouring rates, whose errors must not pass for motion.
//! Those of `b` and `a`, some samples before and after a reading, have none in common, also where
//! rates are differences of values. With what they would change, whitened by the noise, `Σ b·a` is
//! therefore `λ²` of what true accelerations change. These cancel in `d = ½ |b - a|²`, which errors
//! alone make, so that by chance `Σ b·a` has the variance `⅓ Σ d²` (a sample's readings share the
//! errors of its rates), or twice that at most, for neighbours share rates. Rates sparser than the
//! motion say nothing of it: then it is silent. It mends nothing.

use nalgebra::{Cholesky, DVector};

use crate::campaign::{Sample, Samples, Track};
use crate::engine::noise::{CHUNK, active_randoms, covariance_of};
use crate::engine::part::SampleLeaves;
use crate::engine::problem::Problem;
use crate::engine::{Part, Point};
use crate::number::Gradient;

/// Samples of a run that are looked at, in stretches of so many spread over it.
const LOOK: usize = 1_024;
const STRETCH: usize = 256;
/// Samples from a reading back to the difference before it, and on to the one after it.
const AWAY: usize = 2;
/// Length of what is missed, in units of the noise, from which on estimates are wrong by as much.
const SEEN: f64 = 3.0;
/// It must exceed what errors of the rates give by chance so many times (in standard deviations).
const SURE: f64 = 4.0;
/// Part of what is missed from which on a signal is named.
const NAMED: f64 = 0.1;

/// Signals whose accelerations would change readings.
#[derive(Clone, Debug, PartialEq)]
pub struct Unrecorded {
    /// The signals.
    pub inputs: Vec<String>,
    /// Length of what the readings miss, in units of their noise.
    pub lambda: f64,
    /// The run that misses most.
    pub run: String,
    /// The measurand that misses most there.
    pub measurand: String,
    /// What it misses there (rms), in units of its standard uncertainty.
    pub most: f64,
}

/// The signals of all campaigns whose accelerations are missed at a point, if they are.
pub fn unrecorded(problem: &Problem, point: &Point) -> Option<Unrecorded> {
    let all: Vec<Vec<usize>> = problem.parts.iter().map(with_rates_alone).collect();
    let missed = over_runs(problem, point, &all);
    let lambda = length(&missed)?;
    let label = |p: usize, name: &str| problem.parts[p].qualified(name);
    let signals = all.iter().enumerate().flat_map(|(p, own)| own.iter().map(move |k| (p, *k)));
    let signals: Vec<(usize, usize)> = signals.collect();
    let name = |(p, input): &(usize, usize)| {
        label(*p, &problem.parts[*p].system.assembly.names.inputs[*input].name)
    };
    let is_named = |(p, input): &&(usize, usize)| {
        let mut alone = vec![Vec::new(); all.len()];
        alone[*p].push(*input);
        let own: f64 = over_runs(problem, point, &alone).iter().map(|one| one.product).sum();
        own >= NAMED * lambda * lambda
    };
    let mut inputs: Vec<String> = match signals.len() {
        1 => Vec::new(),
        _ => signals.iter().filter(is_named).map(name).collect(),
    };
    if inputs.is_empty() {
        inputs = signals.iter().map(name).collect();
    }
    let worst = missed.iter().max_by(|a, b| a.product.total_cmp(&b.product))?;
    let part = &problem.parts[worst.part];
    let of_measurand = |m: &usize| worst.by_measurand[*m].1;
    let measurand =
        (0..worst.by_measurand.len()).max_by(|a, b| of_measurand(a).total_cmp(&of_measurand(b)))?;
    let (readings, product) = worst.by_measurand[measurand];
    Some(Unrecorded {
        inputs,
        lambda,
        run: label(worst.part, &part.runs[worst.run].name),
        measurand: part.system.assembly.names.measurands[measurand].name.clone(),
        most: (product / readings.max(1.0)).max(0.0).sqrt(),
    })
}

/// The length of what is missed, if it is sure.
fn length(missed: &[Missed]) -> Option<f64> {
    let product: f64 = missed.iter().map(|one| one.product).sum();
    let chance: f64 = missed.iter().map(|one| one.chance).sum();
    let is_seen = product >= SEEN * SEEN && product >= SURE * chance.sqrt();
    is_seen.then(|| product.sqrt())
}

/// The inputs that some run has with their rates alone.
fn with_rates_alone(part: &Part) -> Vec<usize> {
    let alone =
        |input: &usize| part.runs.iter().any(|run| run.record.inputs()[*input].has_rate_alone());
    (0..part.system.assembly.names.inputs.len()).filter(alone).collect()
}

/// What is missed in a run.
struct Missed {
    part: usize,
    run: usize,
    /// `Σ b·a`.
    product: f64,
    /// Its variance by errors of the rates.
    chance: f64,
    /// For each measurand the readings looked at, and the same sum in units of its own standard
    /// uncertainty.
    by_measurand: Vec<(f64, f64)>,
}

fn over_runs(problem: &Problem, point: &Point, inputs: &[Vec<usize>]) -> Vec<Missed> {
    let mut all = Vec::new();
    for (part, inputs) in inputs.iter().enumerate().filter(|(_, own)| !own.is_empty()) {
        for run in 0..problem.parts[part].runs.len() {
            all.extend(in_run(problem, (part, run), inputs, point));
        }
    }
    all
}

fn in_run(
    problem: &Problem,
    (p, r): (usize, usize),
    inputs: &[usize],
    point: &Point,
) -> Option<Missed> {
    let part = &problem.parts[p];
    let run = &part.runs[r];
    let has_rate_alone = |input: &usize| run.record.inputs()[*input].has_rate_alone();
    let inputs: Vec<usize> = inputs.iter().copied().filter(has_rate_alone).collect();
    if inputs.is_empty() {
        return None;
    }
    let mut look = Look::new(problem, (p, r), point);
    let share = LOOK as f64 / run.record.len().max(1) as f64;
    for range in run.record.share(share, STRETCH) {
        look.at(&run.record.cut(range), &inputs);
    }
    let more = run.record.len() as f64 / look.samples.max(1) as f64;
    Some(Missed {
        part: p,
        run: r,
        product: more * look.product,
        chance: more * more * 2.0 / 3.0 * look.apart,
        by_measurand: look.by_measurand,
    })
}

/// Sums over the samples of a run that are looked at.
struct Look<'a> {
    part: &'a Part,
    run: usize,
    parameters: Vec<[f64; 4]>,
    /// The same as numbers with derivatives, for the covariance.
    seeded: Vec<[Gradient<CHUNK>; 4]>,
    randoms: Vec<f64>,
    active: Vec<usize>,
    samples: usize,
    product: f64,
    /// `Σ d²`.
    apart: f64,
    by_measurand: Vec<(f64, f64)>,
}

impl<'a> Look<'a> {
    fn new(problem: &'a Problem, (p, r): (usize, usize), point: &Point) -> Self {
        let part = &problem.parts[p];
        Self {
            part,
            run: r,
            parameters: problem.parameters(p, r, point),
            seeded: problem.parameters(p, r, point),
            randoms: vec![0.0; part.random_sigma.len()],
            active: active_randoms(part),
            samples: 0,
            product: 0.0,
            apart: 0.0,
            by_measurand: vec![(0.0, 0.0); part.slots().len()],
        }
    }

    /// Looks at a stretch.
    fn at(&mut self, plain: &Samples, inputs: &[usize]) {
        let with = |ahead: bool| {
            let mut samples = plain.clone();
            for input in inputs {
                let found = accelerations(&plain.time, &plain.inputs[*input], ahead);
                if let Track::Captured { acceleration, .. } = &mut samples.inputs[*input] {
                    *acceleration = Some(found);
                }
            }
            samples
        };
        let (before, after) = (with(false), with(true));
        self.samples += plain.len();
        let mut memory = Vec::new();
        for at in 0..plain.len() {
            let [own, before, after] = [plain, &before, &after]
                .map(|samples| self.residuals(Sample { samples, at, number: at }));
            let (b, a) = (&before - &own, &after - &own);
            if b.iter().chain(a.iter()).any(|value| !value.is_finite()) {
                continue;
            }
            let sample = Sample { samples: plain, at, number: at };
            let (part, active) = (self.part, &self.active);
            let made = covariance_of(part, self.run, sample, &self.seeded, active, &mut memory);
            for (slot, (readings, sum)) in part.slots().iter().zip(&mut self.by_measurand) {
                if part.is_present(sample, slot) {
                    let rows = slot.residual..slot.residual + slot.components;
                    *readings += 1.0;
                    *sum += rows.map(|k| b[k] * a[k] / made.covariance[(k, k)]).sum::<f64>();
                }
            }
            let Some(factor) = Cholesky::new(made.covariance) else { continue };
            let white = |change: &DVector<f64>| factor.l().solve_lower_triangular(change);
            let (Some(b), Some(a)) = (white(&b), white(&a)) else { continue };
            self.product += b.dot(&a);
            self.apart += (0.5 * (b - a).norm_squared()).powi(2);
        }
    }

    /// The residuals of a sample; zero where there is no reading.
    fn residuals(&self, sample: Sample<'_>) -> DVector<f64> {
        let part = self.part;
        let (parameters, randoms, columns) =
            (&self.parameters[..], &self.randoms[..], part.columns());
        let leaves = SampleLeaves { parameters, randoms, columns, sample };
        let mut workspace = Vec::new();
        let outputs = part.evaluate(&leaves, &mut workspace);
        let mut own = DVector::zeros(part.residual_count());
        for slot in part.slots().iter().filter(|slot| part.is_present(sample, slot)) {
            let residual = part.residual(sample, slot, outputs);
            for (k, value) in residual.iter().take(slot.components).enumerate() {
                own[slot.residual + k] = *value;
            }
        }
        own
    }
}

/// By time the differences of a track's rates some samples before each one, or after it; NaN where
/// there are none.
fn accelerations(time: &[f64], track: &Track, ahead: bool) -> Vec<f64> {
    let Track::Captured { rate: Some(rate), .. } = track else {
        return vec![f64::NAN; time.len()];
    };
    let slope = |at: usize| {
        let from = if ahead { at + AWAY } else { at.checked_sub(AWAY)? };
        let passed = time.get(from + 1)? - time[from];
        (passed > 0.0).then(|| (rate[from + 1] - rate[from]) / passed)
    };
    (0..time.len()).map(|at| slope(at).unwrap_or(f64::NAN)).collect()
}
