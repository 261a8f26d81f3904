//! Readings drawn from a model: predictions, random quantities, noise.
//!
//! Every reading's noise comes from a stream of its own run and kind, so adding a run never changes
//! the others. Random quantities are drawn first and act through the graph, exactly as they act in
//! reality; only then the reading's own noise is added.

use rand::SeedableRng;
use rand_chacha::ChaCha12Rng;
use rand_distr::{Distribution, StandardNormal, StandardUniform};

use crate::engine::point::Point;
use crate::engine::problem::{Problem, SampleLeaves};
use crate::graph::MeasurandKind;
use crate::model::{Process, Shape};
use crate::quaternion::Quaternion;

/// Replaces all readings of a problem by drawn ones. With `complete`, readings that are missing
/// are drawn too (a planned run has none); otherwise they stay missing.
pub fn simulate(problem: &mut Problem, point: &Point, seed: u64, complete: bool) {
    for p in 0..problem.parts.len() {
        for r in 0..problem.parts[p].runs.len() {
            let stream = problem.run_index(p, r) as u64;
            let readings = draw_run(problem, p, r, point, seed, stream, complete);
            problem.parts[p].runs[r].record.edit(|samples| samples.readings = readings);
        }
    }
}

fn generator(seed: u64, stream: u64) -> ChaCha12Rng {
    let mut generator = ChaCha12Rng::seed_from_u64(seed);
    generator.set_stream(stream);
    generator
}

fn normal(generator: &mut ChaCha12Rng) -> f64 {
    StandardNormal.sample(generator)
}

fn draw_run(
    problem: &Problem,
    p: usize,
    r: usize,
    point: &Point,
    seed: u64,
    stream: u64,
    complete: bool,
) -> Vec<Vec<f64>> {
    let part = &problem.parts[p];
    let run = &part.runs[r];
    let count = run.record.len();
    let mut generator = generator(seed, stream);
    let randoms: Vec<Vec<f64>> = (0..part.random_sigma.len())
        .map(|k| draw_random(problem, p, r, k, &mut generator))
        .collect();
    let parameters = problem.parameters::<f64>(p, r, point);
    let mut readings = run.held().readings.clone();
    for column in &mut readings {
        column.resize(count, f64::NAN);
    }
    let mut workspace = Vec::new();
    for sample in 0..count {
        let randoms: Vec<f64> = randoms.iter().map(|draws| draws[sample]).collect();
        let leaves = SampleLeaves {
            parameters: &parameters,
            randoms: &randoms,
            columns: part.columns(),
            run,
            sample,
        };
        let outputs = part.evaluate(&leaves, &mut workspace);
        for (slot, sigma) in part.slots().iter().zip(&part.sigma) {
            let sigma = sigma * slot.sigma_factor.map_or(1.0, |output| outputs[output]);
            let noise: [f64; 3] = std::array::from_fn(|_| sigma * normal(&mut generator));
            if !complete && !part.is_present(r, sample, slot) {
                continue;
            }
            let predicted = &outputs[slot.output..];
            match slot.kind {
                MeasurandKind::Plain => readings[slot.column][sample] = predicted[0] + noise[0],
                MeasurandKind::Angle { period } => {
                    let value = predicted[0] + noise[0];
                    readings[slot.column][sample] =
                        if period > 0.0 { value.rem_euclid(period) } else { value };
                }
                MeasurandKind::Rotation => {
                    let true_rotation = Quaternion {
                        w: predicted[0],
                        v: [predicted[1], predicted[2], predicted[3]],
                    };
                    let read = true_rotation * Quaternion::turn(noise);
                    for (k, value) in
                        [read.w, read.v[0], read.v[1], read.v[2]].into_iter().enumerate()
                    {
                        readings[slot.column + k][sample] = value;
                    }
                }
            }
        }
    }
    readings
}

/// One random quantity over a run.
fn draw_random(
    problem: &Problem,
    p: usize,
    r: usize,
    k: usize,
    generator: &mut ChaCha12Rng,
) -> Vec<f64> {
    let part = &problem.parts[p];
    let sigma = part.random_sigma_in(r, k);
    let random = &part.system.randoms[k];
    let time = &part.runs[r].held().time;
    let unit_draw = |generator: &mut ChaCha12Rng| match random.shape {
        Shape::Normal => normal(generator),
        Shape::Uniform => {
            let uniform: f64 = StandardUniform.sample(generator);
            (2.0 * uniform - 1.0) * 3.0_f64.sqrt()
        }
    };
    let mut state = 0.0;
    (0..time.len())
        .map(|i| {
            let elapsed = if i == 0 { 0.0 } else { (time[i] - time[i - 1]).max(0.0) };
            let draw = unit_draw(generator);
            state = match random.process {
                Process::White => sigma * draw,
                Process::Walk => state + sigma * elapsed.sqrt() * draw,
                Process::Memory => {
                    // First-order autoregressive with correlation exp(-Δ/T), stationary from the start.
                    let memory = random.memory.unwrap_or(0.0);
                    let rho = if i == 0 || memory <= 0.0 { 0.0 } else { (-elapsed / memory).exp() };
                    rho * state + sigma * (1.0 - rho * rho).sqrt() * draw
                }
            };
            state
        })
        .collect()
}
