//! What a disturbance moves, and by how much each reading changes when it does.
//!
//! Changes of times and parameters come from the model itself: its noiseless readings with and
//! without the move. Attitudes (measurands of three components) stay as they are.

use rand::RngExt;
use rand_chacha::ChaCha12Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};

use crate::engine::part::wrapped;
use crate::engine::{Point, Problem};
use crate::graph::MeasurandKind;
use crate::trials::simulated::noiseless;

use super::course::Course;
use super::replaced::{scalars, within};

/// The move (s, or the parameter's SI unit) that is tried first.
const PROBE: f64 = 1e-6;
/// How often a move is scaled to the wanted size; readings are nearly linear in it.
const SCALED: usize = 4;

/// What moves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Channel {
    /// The reading of one measurand.
    Reading,
    /// The reading of every measurand, each by itself.
    EveryReading,
    /// The time of all readings.
    Time,
    /// A parameter of the model, a vector in a direction that is drawn.
    Parameter(String),
}

/// By how much readings change: campaign, run, measurand of one component, sample (SI).
type Changes = Vec<Vec<Vec<Vec<f64>>>>;

/// A channel with what is drawn of it.
enum Direction {
    /// The measurand with this number, modulo those that a campaign has.
    Measurand(usize),
    /// Parameters: instance, component, part of the move.
    Point(Vec<(usize, usize, f64)>),
}

impl Channel {
    fn directions(&self, problem: &Problem, chance: &mut ChaCha12Rng) -> Vec<Direction> {
        let instances = || problem.layout.instances.iter().enumerate();
        match self {
            Self::Reading => vec![Direction::Measurand(chance.random_range(0..usize::MAX))],
            Self::EveryReading => {
                let most = problem.parts.iter().map(|part| scalars(part).len()).max();
                (0..most.unwrap_or(0)).map(Direction::Measurand).collect()
            }
            Self::Time => {
                let delays = instances().filter(|(_, one)| one.is_delay());
                vec![Direction::Point(delays.map(|(index, _)| (index, 0, 1.0)).collect())]
            }
            Self::Parameter(name) => {
                let drawn: [f64; 3] = std::array::from_fn(|_| StandardNormal.sample(&mut *chance));
                let length = drawn.iter().map(|one| one * one).sum::<f64>().sqrt();
                let own = instances().filter(|(_, one)| one.name == *name);
                let each = own.flat_map(|(index, one)| match one.dimension() {
                    1 => vec![(index, 0, 1.0)],
                    all => (0..all).map(|axis| (index, axis, drawn[axis] / length)).collect(),
                });
                vec![Direction::Point(each.collect())]
            }
        }
    }
}

impl Direction {
    /// By how much readings change with a move (SI; of a measurand in units of its stated noise).
    fn changes(&self, problem: &Problem, point: &Point, by: f64) -> Changes {
        let Self::Point(moves) = self else { return self.constant(problem, by) };
        let mut moved = point.clone();
        for (instance, component, part) in moves {
            let values = point.components(&problem.layout, *instance);
            let value = values[*component] + part * by;
            moved.set_component(&problem.layout, *instance, *component, value);
        }
        difference(&noiseless(problem, point), &noiseless(problem, &moved))
    }

    /// The same change of all readings of a measurand.
    fn constant(&self, problem: &Problem, by: f64) -> Changes {
        let parts = problem.parts.iter().map(|part| {
            let scalars = scalars(part);
            let runs = part.runs.iter().map(|run| {
                let of = |(place, (index, _)): (usize, &(usize, _))| {
                    let is_own = matches!(self, Self::Measurand(which)
                        if place == which % scalars.len());
                    let each = if is_own { by * part.sigma[*index] } else { 0.0 };
                    vec![each; run.record.len()]
                };
                scalars.iter().enumerate().map(of).collect()
            });
            runs.collect()
        });
        parts.collect()
    }
}

/// What the readings of one problem have more than those of another.
fn difference(from: &Problem, to: &Problem) -> Changes {
    let parts = from.parts.iter().zip(&to.parts).map(|(part, other)| {
        let runs = part.runs.iter().zip(&other.runs).map(|(run, other)| {
            let columns = scalars(part).into_iter().map(|(_, slot)| {
                let period = match slot.kind {
                    MeasurandKind::Angle { period } => period,
                    _ => 0.0,
                };
                let [a, b] = [run, other].map(|one| &one.record.whole().readings[slot.column]);
                a.iter().zip(b).map(|(a, b)| wrapped(b - a, period)).collect()
            });
            columns.collect()
        });
        runs.collect()
    });
    parts.collect()
}

/// Moves a channel in its course. The size is the rms change of the readings that are moved, in
/// units of their stated noise. Nothing happens where the channel moves no reading.
pub(super) fn move_readings(
    problem: &mut Problem,
    point: &Point,
    (channel, course): (&Channel, &Course),
    size: f64,
    chance: &mut ChaCha12Rng,
) {
    for direction in channel.directions(problem, chance) {
        let amplitudes = course.amplitudes(problem, chance);
        let mut by = PROBE;
        for _ in 0..SCALED {
            let found = rms(problem, &direction.changes(problem, point, by), &amplitudes);
            by = if found > 0.0 { by * size / found } else { 0.0 };
        }
        if by > 0.0 {
            add(problem, &direction.changes(problem, point, by), &amplitudes);
        }
    }
}

/// rms of changes over the readings that are moved, in units of their stated noise.
fn rms(problem: &Problem, changes: &Changes, amplitudes: &[Vec<Vec<f64>>]) -> f64 {
    let (mut squares, mut count) = (0.0, 0_usize);
    for ((part, changes), amplitudes) in problem.parts.iter().zip(changes).zip(amplitudes) {
        for ((index, _), measurand) in scalars(part).iter().zip(0..) {
            for (changes, amplitudes) in changes.iter().zip(amplitudes) {
                for (change, amplitude) in changes[measurand].iter().zip(amplitudes) {
                    let own: f64 = change * amplitude / part.sigma[*index];
                    if own.is_finite() && own != 0.0 {
                        squares += own * own;
                        count += 1;
                    }
                }
            }
        }
    }
    (squares / count.max(1) as f64).sqrt()
}

fn add(problem: &mut Problem, changes: &Changes, amplitudes: &[Vec<Vec<f64>>]) {
    for ((part, changes), amplitudes) in problem.parts.iter_mut().zip(changes).zip(amplitudes) {
        let scalars = scalars(part);
        for ((run, changes), amplitudes) in part.runs.iter_mut().zip(changes).zip(amplitudes) {
            run.record.edit(|samples| {
                for ((_, slot), changes) in scalars.iter().zip(changes) {
                    let readings = samples.readings[slot.column].iter_mut();
                    for ((reading, change), amplitude) in readings.zip(changes).zip(amplitudes) {
                        *reading = within(slot, *reading + amplitude * change);
                    }
                }
            });
        }
    }
}
