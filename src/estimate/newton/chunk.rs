//! Newton's iteration for the readings of a chunk at once: each on its own way, all evaluated
//! together.

use crate::engine::lanes::{Chunk, LANES, Lanes, Workspace};
use crate::engine::programs::DelayProgram;

/// Newton steps before giving up.
pub(super) const MAXIMUM_STEPS: u32 = 50;
/// Times that a step is halved before giving up.
const HALVINGS: u32 = 20;
/// Evaluations after which nobody waits for readings that are blind anyway.
const IMPATIENCE: u32 = 4;
/// A step that is this part of the range, or less, need not be halved.
const ROUNDING: f64 = 1e-9;
/// A step this small (s), or this small against the delay, ends the iteration.
const TOLERANCE: f64 = 1e-14;

/// Where a reading's iteration stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    /// There is no reading.
    Absent,
    /// A step is to be tried.
    Trying,
    /// Solved.
    Solved,
    /// There is no delay that explains the reading.
    Failed,
}

/// The readings of a chunk, each with its delay.
#[derive(Debug)]
pub(super) struct Roots {
    pub(super) stage: [Stage; LANES],
    /// Delay (s).
    pub(super) delay: Lanes,
    /// `prediction - reading` there.
    value: Lanes,
    /// Derivative of the prediction with respect to the delay, where it was evaluated last.
    slope: Lanes,
    /// The step to be tried (s).
    step: Lanes,
    /// The step taken last (s).
    taken: Lanes,
    reading: Lanes,
    halvings: [u32; LANES],
    pub(super) steps: [u32; LANES],
}

impl Roots {
    /// Solves `prediction(delay) = reading` for each reading of a chunk, from the reference time,
    /// within `±range`: steps are halved while they do not bring the prediction nearer. The chunk is
    /// loaded; `value` and `slope` are those at the reference time. Readings that are not `sighted`
    /// may be given up: nobody waits for them.
    pub(super) fn find(
        program: &DelayProgram,
        workspace: &mut Workspace,
        chunk: &Chunk<'_>,
        present: &[bool; LANES],
        sighted: &[bool; LANES],
        [value, slope, reading]: [Lanes; 3],
        range: f64,
    ) -> Self {
        let mut roots = Self {
            stage: present.map(|there| if there { Stage::Trying } else { Stage::Absent }),
            delay: [0.0; LANES],
            value,
            slope,
            step: [0.0; LANES],
            taken: [0.0; LANES],
            reading,
            halvings: [0; LANES],
            steps: [0; LANES],
        };
        (0..LANES).filter(|lane| present[*lane]).for_each(|lane| roots.propose(lane, range));
        let mut passes = 0;
        let trying = |roots: &Self, passes| {
            let waits = |lane: &usize| passes < IMPATIENCE || sighted[*lane];
            (0..LANES).filter(waits).any(|lane| roots.stage[lane] == Stage::Trying)
        };
        while trying(&roots, passes) {
            passes += 1;
            let mut trial = roots.delay;
            for (delay, step) in trial.iter_mut().zip(&roots.step) {
                *delay = (*delay + step).clamp(-range, range);
            }
            workspace.give(&program.code, 0, &trial);
            workspace.compute(&program.code, 0, chunk);
            let outputs = workspace.outputs(&program.code, 0);
            for lane in 0..LANES {
                if roots.stage[lane] == Stage::Trying {
                    roots.judge(lane, trial[lane], outputs[0][lane], outputs[1][lane], range);
                }
            }
        }
        roots
    }

    /// Sets the next step, or ends.
    fn propose(&mut self, lane: usize, range: f64) {
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
            self.step[lane] = step.clamp(-range, range);
            self.halvings[lane] = 0;
            Stage::Trying
        };
        if self.stage[lane] != Stage::Trying {
            self.step[lane] = 0.0;
        }
    }

    /// Whether nothing worth a further evaluation is left after a step: by its size, by what rounding
    /// of the reading leaves of any step, or as the next one, by the quadratic convergence that the
    /// last two show, would be.
    fn is_last(&self, lane: usize, step: f64) -> bool {
        let rounding = 8.0 * f64::EPSILON * self.reading[lane].abs() / self.slope[lane].abs();
        let tolerance = TOLERANCE.max(4.0 * f64::EPSILON * self.delay[lane].abs());
        let taken = self.taken[lane];
        let next = (step / taken).powi(2) * step.abs();
        step.abs() <= tolerance.max(rounding) || (taken != 0.0 && next <= tolerance)
    }

    /// Takes a step that was tried, or halves it.
    fn judge(&mut self, lane: usize, trial: f64, value: f64, slope: f64, range: f64) {
        if value.abs() < self.value[lane].abs() {
            self.taken[lane] = self.delay[lane] - trial;
            self.delay[lane] = trial;
            self.value[lane] = value;
            self.slope[lane] = slope;
            self.steps[lane] += 1;
            self.propose(lane, range);
        } else if self.step[lane].abs() <= ROUNDING * range {
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
