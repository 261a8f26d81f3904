//! Readings drawn from a model: predictions, random quantities, noise.
//!
//! Every reading's noise comes from a stream of its own run and kind, so adding a run at the end
//! never changes the others. Random quantities act through the graph, exactly as they act in
//! reality; only then the reading's own noise is added. A walk goes on from run to run of a setup,
//! in the order in which they are listed; where a run's times begin before the last one's end, it
//! does so without a pause. A run is drawn a stretch at a time, however long it is.

use std::convert::Infallible;

use rand::SeedableRng;
use rand_chacha::ChaCha12Rng;
use rand_distr::{Distribution, StandardNormal, StandardUniform};

use crate::campaign::record::BLOCK;
use crate::campaign::{Samples, Stretch};
use crate::engine::part::{Part, SampleLeaves, Slot};
use crate::engine::point::Point;
use crate::engine::problem::Problem;
use crate::graph::MeasurandKind;
use crate::model::{Process, Shape};
use crate::progress::Task;
use crate::quaternion::Quaternion;
use crate::system::RandomSetting;

/// Replaces all readings of a problem by drawn ones, in memory. With `complete`, readings that are
/// missing are drawn too (a planned run has none); otherwise they stay missing.
pub fn simulate(problem: &mut Problem, point: &Point, seed: u64, complete: bool) {
    for p in 0..problem.parts.len() {
        for r in 0..problem.parts[p].runs.len() {
            let mut all: Vec<Vec<f64>> = Vec::new();
            let keep = &mut |_: Stretch<'_>, drawn: &[Vec<f64>]| {
                all.resize(drawn.len(), Vec::new());
                all.iter_mut().zip(drawn).for_each(|(all, drawn)| all.extend_from_slice(drawn));
                Ok::<_, Infallible>(())
            };
            let Ok(()) = draw_run(problem, (p, r), point, seed, complete, keep);
            problem.parts[p].runs[r].record.edit(|samples| samples.readings = all);
        }
    }
}

/// What sees the readings of a run as they are drawn.
pub type Drawn<'a, E> = dyn FnMut(Stretch<'_>, &[Vec<f64>]) -> Result<(), E> + 'a;

/// Draws the readings of one run and shows them in their order, a stretch at a time: the stretch as
/// recorded, and the columns of its readings as drawn.
///
/// # Errors
/// The first that `visit` gives; nothing more is drawn then.
pub fn draw_run<E>(
    problem: &Problem,
    (p, r): (usize, usize),
    point: &Point,
    seed: u64,
    complete: bool,
    visit: &mut Drawn<'_, E>,
) -> Result<(), E> {
    let part = &problem.parts[p];
    let record = &part.runs[r].record;
    let mut generator = stream(seed, problem.run_index(p, r));
    // All of a quantity's draws come before those of the next one, and of the noise.
    let mut randoms: Vec<Draws<'_>> = Vec::new();
    let walked = walked(part, r, (seed, problem.run_index(p, 0)));
    for (k, random) in part.system.randoms.iter().enumerate() {
        let sigma = part.random_sigma_in(r, k);
        randoms.push(Draws { random, sigma, generator: generator.clone(), last: walked[k] });
        skip(random, record.len(), &mut generator);
    }
    let parameters = problem.parameters::<f64>(p, r, point);
    let mut values = vec![0.0; randoms.len()];
    let (mut workspace, mut scratch) = (Vec::new(), Samples::default());
    let mut drawn: Vec<Vec<f64>> = Vec::new();
    for range in record.ranges(BLOCK) {
        let stretch = record.stretch(range, &mut scratch);
        drawn.clear();
        drawn.extend(stretch.samples.readings.iter().map(|c| c[stretch.range()].to_vec()));
        for (row, sample) in stretch.each().enumerate() {
            for (value, draws) in values.iter_mut().zip(&mut randoms) {
                *value = draws.next(sample.time());
            }
            let (randoms, columns) = (&values[..], part.columns());
            let leaves = SampleLeaves { parameters: &parameters, randoms, columns, sample };
            let outputs = part.evaluate(&leaves, &mut workspace);
            for (slot, sigma) in part.slots().iter().zip(&part.sigma) {
                let sigma = sigma * slot.sigma_factor.map_or(1.0, |output| outputs[output]);
                let noise: [f64; 3] = std::array::from_fn(|_| sigma * normal(&mut generator));
                if complete || part.is_present(sample, slot) {
                    let read = reading(slot, &outputs[slot.output..], noise);
                    for (column, value) in drawn[slot.column..].iter_mut().zip(read) {
                        column[row] = value;
                    }
                }
            }
        }
        visit(stretch, &drawn)?;
        let done = (stretch.first + stretch.len) as u64;
        problem.progress.tell(Task::Drawing, done, record.len() as u64);
    }
    Ok(())
}

/// When the runs of a setup before a run ended, and where each random quantity that walks had come
/// to then.
fn walked(part: &Part, run: usize, (seed, first): (u64, usize)) -> Vec<Option<(f64, f64)>> {
    let randoms = &part.system.randoms;
    let mut last = vec![None; randoms.len()];
    let walks = |k: &usize| randoms[*k].process == Process::Walk && part.random_sigma[*k] != 0.0;
    let walking: Vec<usize> = (0..randoms.len()).filter(walks).collect();
    if walking.is_empty() {
        return last;
    }
    let setup = part.runs[run].setup;
    for before in (0..run).filter(|before| part.runs[*before].setup == setup) {
        let record = &part.runs[before].record;
        let mut generator = stream(seed, first + before);
        let mut all = Vec::with_capacity(walking.len());
        for (k, random) in randoms.iter().enumerate() {
            if walking.contains(&k) {
                let sigma = part.random_sigma_in(before, k);
                all.push(Draws { random, sigma, generator: generator.clone(), last: last[k] });
            }
            skip(random, record.len(), &mut generator);
        }
        record.walk(|stretch| {
            for time in &stretch.samples.time[stretch.range()] {
                for draws in &mut all {
                    draws.next(*time);
                }
            }
        });
        for (k, draws) in walking.iter().zip(&all) {
            last[*k] = draws.last;
        }
    }
    last
}

/// The random numbers of a run.
fn stream(seed: u64, run: usize) -> ChaCha12Rng {
    let mut generator = ChaCha12Rng::seed_from_u64(seed);
    generator.set_stream(run as u64);
    generator
}

/// Draws so many values and forgets them.
fn skip(random: &RandomSetting, count: usize, generator: &mut ChaCha12Rng) {
    for _ in 0..count {
        unit_draw(random, generator);
    }
}

/// A prediction with its noise, in as many columns as the reading has.
fn reading(slot: &Slot, predicted: &[f64], noise: [f64; 3]) -> impl Iterator<Item = f64> {
    let (values, count) = match slot.kind {
        MeasurandKind::Plain => ([predicted[0] + noise[0], 0.0, 0.0, 0.0], 1),
        MeasurandKind::Angle { period } => {
            let value = predicted[0] + noise[0];
            ([if period > 0.0 { value.rem_euclid(period) } else { value }, 0.0, 0.0, 0.0], 1)
        }
        MeasurandKind::Rotation => {
            let v = [predicted[1], predicted[2], predicted[3]];
            let read = Quaternion { w: predicted[0], v } * Quaternion::turn(noise);
            ([read.w, read.v[0], read.v[1], read.v[2]], 4)
        }
    };
    values.into_iter().take(count)
}

fn normal(generator: &mut ChaCha12Rng) -> f64 {
    StandardNormal.sample(generator)
}

/// A draw of a random quantity's shape, with standard deviation 1.
fn unit_draw(random: &RandomSetting, generator: &mut ChaCha12Rng) -> f64 {
    match random.shape {
        Shape::Normal => normal(generator),
        Shape::Uniform => {
            let uniform: f64 = StandardUniform.sample(generator);
            (2.0 * uniform - 1.0) * 3.0_f64.sqrt()
        }
    }
}

/// One random quantity over a run.
struct Draws<'a> {
    random: &'a RandomSetting,
    sigma: f64,
    generator: ChaCha12Rng,
    /// Time of the sample before (s), and the value there.
    last: Option<(f64, f64)>,
}

impl Draws<'_> {
    /// The value at the next sample.
    fn next(&mut self, time: f64) -> f64 {
        let elapsed = self.last.map_or(0.0, |(before, _)| (time - before).max(0.0));
        let state = self.last.map_or(0.0, |(_, state)| state);
        let (sigma, draw) = (self.sigma, unit_draw(self.random, &mut self.generator));
        let value = match self.random.process {
            Process::White => sigma * draw,
            Process::Walk => state + sigma * elapsed.sqrt() * draw,
            Process::Memory => {
                // First-order autoregressive with correlation exp(-Δ/T), stationary from the start.
                let memory = self.random.memory.unwrap_or(0.0);
                let first = self.last.is_none() || memory <= 0.0;
                let rho = if first { 0.0 } else { (-elapsed / memory).exp() };
                rho * state + sigma * (1.0 - rho * rho).sqrt() * draw
            }
        };
        self.last = Some((time, value));
        value
    }
}
