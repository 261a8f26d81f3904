//! Newton's iteration, safeguarded: each reading on its own way, all evaluated together.
//!
//! A step is halved while it does not bring the prediction nearer to the reading. This is what a
//! delay is; [`super::quick`] is the short way to the same for readings that behave.

use crate::engine::lanes::{LANES, Lanes};

/// Newton steps before giving up.
const MAXIMUM_STEPS: u32 = 50;
/// Times that a step is halved before giving up.
const HALVINGS: u32 = 20;
/// A step that is this part of the range, or less, need not be halved.
const ROUNDING: f64 = 1e-9;
/// A step this small (s), or this small against the delay, ends the iteration.
pub(super) const TOLERANCE: f64 = 1e-14;

/// Where a reading's iteration stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    /// A step is to be tried.
    Trying,
    /// Solved.
    Solved,
    /// There is no delay that explains the reading.
    Failed,
}

/// Some readings, each with its delay.
#[derive(Debug)]
pub(super) struct Roots {
    /// The first so many lanes are readings.
    len: usize,
    pub(super) stage: [Stage; LANES],
    /// Delay (s).
    pub(super) delay: Lanes,
    /// `prediction - reading` there.
    value: Lanes,
    /// Derivative of the prediction with respect to the delay, where it was evaluated last.
    slope: Lanes,
    /// The step to be tried (s).
    step: Lanes,
    reading: Lanes,
    halvings: [u32; LANES],
    pub(super) steps: [u32; LANES],
    range: f64,
}

impl Roots {
    /// Solves `prediction(delay) = reading` for the first `len` readings, from the reference time,
    /// within `±range`. `value` and `slope` are those at the reference time; `evaluate` gives
    /// value and slope at delays.
    pub(super) fn find(
        len: usize,
        [value, slope, reading]: [Lanes; 3],
        range: f64,
        mut evaluate: impl FnMut(&Lanes) -> [Lanes; 2],
    ) -> Self {
        let mut roots = Self {
            len,
            stage: [Stage::Failed; LANES],
            delay: [0.0; LANES],
            value,
            slope,
            step: [0.0; LANES],
            reading,
            halvings: [0; LANES],
            steps: [0; LANES],
            range,
        };
        (0..len).for_each(|lane| roots.propose(lane));
        while roots.stage[..roots.len].contains(&Stage::Trying) {
            let mut trial = roots.delay;
            for (delay, step) in trial.iter_mut().zip(&roots.step) {
                *delay = (*delay + step).clamp(-range, range);
            }
            let [value, slope] = evaluate(&trial);
            for lane in 0..len {
                if roots.stage[lane] == Stage::Trying {
                    roots.judge(lane, trial[lane], value[lane], slope[lane]);
                }
            }
        }
        roots
    }

    /// Sets the next step, or ends.
    fn propose(&mut self, lane: usize) {
        let value = self.value[lane];
        let step = -value / self.slope[lane];
        self.stage[lane] = if value == 0.0 {
            Stage::Solved
        } else if !value.is_finite() || !step.is_finite() || self.steps[lane] >= MAXIMUM_STEPS {
            Stage::Failed
        } else if self.is_last(lane, step) {
            self.delay[lane] += step;
            Stage::Solved
        } else {
            self.step[lane] = step.clamp(-self.range, self.range);
            self.halvings[lane] = 0;
            Stage::Trying
        };
        if self.stage[lane] != Stage::Trying {
            self.step[lane] = 0.0;
        }
    }

    /// Whether a step is not worth a further evaluation: by its size, or by what rounding of the
    /// reading leaves of any step.
    fn is_last(&self, lane: usize, step: f64) -> bool {
        let rounding = 8.0 * f64::EPSILON * self.reading[lane].abs() / self.slope[lane].abs();
        let tolerance = TOLERANCE.max(4.0 * f64::EPSILON * self.delay[lane].abs());
        step.abs() <= tolerance.max(rounding)
    }

    /// Takes a step that was tried, or halves it.
    fn judge(&mut self, lane: usize, trial: f64, value: f64, slope: f64) {
        if value.abs() < self.value[lane].abs() {
            self.delay[lane] = trial;
            self.value[lane] = value;
            self.slope[lane] = slope;
            self.steps[lane] += 1;
            self.propose(lane);
        } else if self.step[lane].abs() <= ROUNDING * self.range {
            // A tiny step that does not descend: rounding has been reached.
            self.stage[lane] = Stage::Solved;
            self.step[lane] = 0.0;
        } else if self.halvings[lane] < HALVINGS {
            self.halvings[lane] += 1;
            self.step[lane] *= 0.5;
        } else {
            let rounding = self.value[lane].abs() <= 1e-12;
            self.stage[lane] = if rounding { Stage::Solved } else { Stage::Failed };
            self.step[lane] = 0.0;
        }
    }
}
