//! When a channel is moved, and how far each time: a factor for each sample.

use std::f64::consts::TAU;

use rand::RngExt;
use rand_chacha::ChaCha12Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};

use crate::campaign::run::{Run, Samples};
use crate::engine::{Part, Problem};

/// Samples that a run needs for something to happen within it.
const LEAST: usize = 8;

/// When, and how far each time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Course {
    /// By 1 from one run, not the first of its setup, to the end of the setup.
    FromRun,
    /// By 1 from a moment in the middle half of one run on.
    WithinRun {
        /// To the end of the setup; else to the end of the run.
        lasting: bool,
    },
    /// A normal number for each run.
    EachRun,
    /// In proportion to the time since the middle of the setup.
    Drift,
    /// A random walk through each setup: variance in proportion to time.
    Walk,
    /// Exponential settling after each run begins.
    Settling {
        /// Time constant (s).
        time: f64,
    },
    /// The sign of the rate of the first input that moves.
    Direction,
    /// A narrow-band oscillation whose phase and amplitude change at random.
    Ringing {
        /// Frequency (Hz).
        frequency: f64,
        /// Time after which it is another one (s).
        coherence: f64,
    },
    /// First-order Gauss-Markov noise, anew in each run.
    Memory {
        /// Correlation time (s).
        time: f64,
    },
    /// Independent normal numbers.
    White,
    /// The same with a logarithmically normal level for each run, whose factor of one standard
    /// deviation is 2.
    Levels,
}

impl Course {
    /// A factor for each sample: campaign, run, sample.
    pub(super) fn amplitudes(
        &self,
        problem: &Problem,
        chance: &mut ChaCha12Rng,
    ) -> Vec<Vec<Vec<f64>>> {
        let chosen = self.chosen(problem, chance);
        let parts = problem.parts.iter().enumerate().map(|(p, part)| {
            let mut walks: Vec<Option<(f64, f64)>> = vec![None; part.setups.len()];
            let runs = part.runs.iter().enumerate().map(|(r, run)| {
                let samples = run.record.whole();
                match self {
                    Self::FromRun | Self::WithinRun { .. } => {
                        let on = chosen.filter(|chosen| chosen.part == p);
                        let from = on.map_or(samples.len(), |on| self.start(on, part, r));
                        (0..samples.len()).map(|at| f64::from(u8::from(at >= from))).collect()
                    }
                    Self::Walk => walk(samples, &mut walks[run.setup], chance),
                    Self::Drift => drift(samples, setup_length(part, run)),
                    _ => self.of_run(samples, chance),
                }
            });
            runs.collect()
        });
        parts.collect()
    }

    /// The run and sample at which it happens; `None` where it happens at no moment, or where no
    /// run is long enough.
    fn chosen(&self, problem: &Problem, chance: &mut ChaCha12Rng) -> Option<Chosen> {
        let within = matches!(self, Self::WithinRun { .. });
        if !within && *self != Self::FromRun {
            return None;
        }
        let mut all = Vec::new();
        for (p, part) in problem.parts.iter().enumerate() {
            for (r, run) in part.runs.iter().enumerate() {
                let is_first = part.runs[..r].iter().all(|before| before.setup != run.setup);
                if run.record.len() >= LEAST && (within || !is_first) {
                    all.push((p, r, run.record.len()));
                }
            }
        }
        let &(part, run, len) = all.get(chance.random_range(0..all.len().max(1)))?;
        let sample = if within { chance.random_range(len / 4..3 * len / 4) } else { 0 };
        Some(Chosen { part, run, sample })
    }

    /// The first sample of a run at which it has happened.
    fn start(&self, on: Chosen, part: &Part, run: usize) -> usize {
        let is_lasting = !matches!(self, Self::WithinRun { lasting: false });
        let is_later = run > on.run && part.runs[run].setup == part.runs[on.run].setup;
        if run == on.run {
            on.sample
        } else if is_lasting && is_later {
            0
        } else {
            part.runs[run].record.len()
        }
    }

    /// The factors of a run by itself.
    fn of_run(&self, samples: &Samples, chance: &mut ChaCha12Rng) -> Vec<f64> {
        let count = samples.len();
        match self {
            Self::EachRun => vec![normal(chance); count],
            Self::Settling { time } => samples.run_time.iter().map(|t| (-t / time).exp()).collect(),
            Self::Direction => direction(samples),
            Self::Ringing { frequency, coherence } => {
                let [cosine, sine] = [(); 2].map(|()| memory(samples, *coherence, chance));
                let waves = cosine.iter().zip(&sine).zip(&samples.run_time);
                let wave = |((cosine, sine), t): ((&f64, &f64), &f64)| {
                    let phase = TAU * frequency * t;
                    cosine * phase.cos() + sine * phase.sin()
                };
                waves.map(wave).collect()
            }
            Self::Memory { time } => memory(samples, *time, chance),
            Self::Levels => {
                let level = normal(chance).exp2();
                (0..count).map(|_| level * normal(chance)).collect()
            }
            _ => (0..count).map(|_| normal(chance)).collect(),
        }
    }
}

/// Where a change happens.
#[derive(Clone, Copy)]
struct Chosen {
    part: usize,
    run: usize,
    sample: usize,
}

fn normal(chance: &mut ChaCha12Rng) -> f64 {
    StandardNormal.sample(chance)
}

/// First-order Gauss-Markov noise of unit variance.
fn memory(samples: &Samples, time: f64, chance: &mut ChaCha12Rng) -> Vec<f64> {
    let mut last: Option<(f64, f64)> = None;
    let each = samples.time.iter().map(|now| {
        let value = match last {
            Some((before, value)) => {
                let share = (-(now - before).max(0.0) / time).exp();
                share * value + (1.0 - share * share).sqrt() * normal(chance)
            }
            None => normal(chance),
        };
        last = Some((*now, value));
        value
    });
    each.collect()
}

/// A random walk that goes on from where the setup's run before left it.
fn walk(samples: &Samples, last: &mut Option<(f64, f64)>, chance: &mut ChaCha12Rng) -> Vec<f64> {
    let each = samples.time.iter().map(|now| {
        let value = last
            .map_or(0.0, |(before, value)| value + (now - before).max(0.0).sqrt() * normal(chance));
        *last = Some((*now, value));
        value
    });
    each.collect()
}

fn drift(samples: &Samples, length: f64) -> Vec<f64> {
    samples.setup_time.iter().map(|time| time - 0.5 * length).collect()
}

/// Time from the beginning of a run's setup to its end (s).
fn setup_length(part: &Part, run: &Run) -> f64 {
    let own = part.runs.iter().filter(|other| other.setup == run.setup);
    let ends = own.filter_map(|other| other.record.whole().setup_time.last().copied());
    ends.fold(0.0, f64::max)
}

/// The sign of the rate of the first input that moves; 0 where none does.
fn direction(samples: &Samples) -> Vec<f64> {
    let Some(input) = samples.inputs.iter().find(|input| input.moves()) else {
        return vec![0.0; samples.len()];
    };
    let rate = |at: usize| input.at(at, samples.time[at], 0.0, 1);
    (0..samples.len()).map(rate).map(|rate: f64| if rate < 0.0 { -1.0 } else { 1.0 }).collect()
}
