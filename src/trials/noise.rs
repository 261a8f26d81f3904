//! Noise that is not what is stated: an effect of the library on the noise, or one of two kinds that
//! no effect describes, a share of outliers and long tails.

use rand::RngExt;
use rand_chacha::ChaCha12Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::engine::part::wrapped;
use crate::engine::simulate::simulate;
use crate::engine::{Point, Problem};
use crate::graph::MeasurandKind;

use super::design::Design;
use super::simulated::{take_readings, with};

/// rms of what noise adds to the readings, in units of the stated noise.
const NOISE_SIZES: (f64, f64) = (0.5, 3.0);
/// Factors on the usual size of a wrong level.
const LEVEL_SIZES: (f64, f64) = (0.5, 2.0);
/// Noise that no effect describes.
const FOREIGN: [&str; 2] = ["scattered_outliers", "long_tails"];
/// Share of outliers, and how far out they are, in standard deviations.
const OUTLIERS: (f64, f64) = (0.01, 30.0);
/// Share of the readings in long tails, and how wide those are.
const TAILS: (f64, f64) = (0.10, 3.0);

/// Whether noise is of a kind that no effect describes.
pub(super) fn is_foreign(noise: &str) -> bool {
    FOREIGN.contains(&noise)
}

/// Simulates readings whose noise is not what is stated; the kind of noise.
pub(super) fn simulate_misstated(
    design: &Design,
    seed: u64,
    problem: &mut Problem,
    chance: &mut ChaCha12Rng,
) -> String {
    let mut names: Vec<&str> = design.noise.iter().map(|one| one.name.as_str()).collect();
    names.dedup();
    names.extend(FOREIGN);
    let name = names[chance.random_range(0..names.len())];
    let ways: Vec<_> = design.noise.iter().filter(|one| one.name == name).collect();
    if ways.is_empty() {
        simulate(problem, &design.truth, seed, design.planned);
        spoil(problem, name, chance);
        return name.to_owned();
    }
    let way = ways[chance.random_range(0..ways.len())];
    let share = chance.random::<f64>();
    let between = |(from, to): (f64, f64)| from * (to / from).powf(share);
    let (mut full, mut point) = with(design, std::slice::from_ref(&way.selected), &[]);
    for (index, instance) in full.layout.instances.iter().enumerate() {
        let own = instance.name.split('.').next() == Some(name);
        if let (true, Some(typical)) = (own, instance.setting.typical) {
            point.values[index][0] = between(LEVEL_SIZES) * typical;
        }
    }
    let added = added(&full, &point, name, seed);
    let by = if added > 0.0 { between(NOISE_SIZES) / added } else { 0.0 };
    set_randoms(&mut full, name, by);
    simulate(&mut full, &point, seed, design.planned);
    take_readings(problem, &full);
    name.to_owned()
}

/// Gives the random quantities of an effect so many times their usual size.
fn set_randoms(problem: &mut Problem, effect: &str, by: f64) {
    for part in &mut problem.parts {
        for (random, sigma) in part.system.randoms.iter().zip(&mut part.random_sigma) {
            if random.effect.as_deref() == Some(effect) {
                *sigma = by * random.typical.unwrap_or(0.0);
            }
        }
    }
}

/// rms of what an effect's random quantities of their usual size add to the readings, in units of
/// the stated noise.
fn added(full: &Problem, point: &Point, effect: &str, seed: u64) -> f64 {
    let mut quiet = full.clone();
    for part in &mut quiet.parts {
        part.sigma.fill(0.0);
        part.random_sigma.fill(0.0);
    }
    let mut moved = quiet.clone();
    // Of a tenth of the size, where it is linear.
    set_randoms(&mut moved, effect, 0.1);
    simulate(&mut quiet, point, seed, true);
    simulate(&mut moved, point, seed, true);
    let (mut squares, mut count) = (0.0, 0.0);
    for ((part, other), stated) in quiet.parts.iter().zip(&moved.parts).zip(&full.parts) {
        for (run, other) in part.runs.iter().zip(&other.runs) {
            for (slot, sigma) in part.slots().iter().zip(&stated.sigma) {
                let columns = [run, other].map(|run| &run.held().readings[slot.column]);
                let period = match slot.kind {
                    MeasurandKind::Angle { period } => period,
                    _ => 0.0,
                };
                for (a, b) in columns[0].iter().zip(columns[1]) {
                    squares += (wrapped(b - a, period) / sigma).powi(2);
                    count += 1.0;
                }
            }
        }
    }
    10.0 * (squares / f64::max(count, 1.0)).sqrt()
}

/// Adds what no normal distribution gives.
fn spoil(problem: &mut Problem, name: &str, chance: &mut ChaCha12Rng) {
    let (share, width) = if name == FOREIGN[0] { OUTLIERS } else { TAILS };
    for part in &mut problem.parts {
        let slots = part.slots().to_vec();
        let sigma = part.sigma.clone();
        for run in &mut part.runs {
            run.record.edit(|samples| {
                for (slot, sigma) in
                    slots.iter().zip(&sigma).filter(|(slot, _)| slot.components == 1)
                {
                    for reading in &mut samples.readings[slot.column] {
                        if chance.random::<f64>() < share {
                            let far: f64 = StandardNormal.sample(&mut *chance);
                            *reading += width * sigma * far;
                        }
                    }
                }
            });
        }
    }
}
