//! Newton's iteration for the readings of a chunk at once: each on its own way, all evaluated
//! together.

use crate::engine::lanes::{Chunk, LANES, Lanes, Workspace};
use crate::engine::programs::DelayProgram;

/// Newton steps before giving up.
pub(super) const MAXIMUM_STEPS: u32 = 50;
/// Times that a step is halved before giving up.
const HALVINGS: u32 = 20;
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
    /// Derivative of the prediction with respect to the delay.
    pub(super) slope: Lanes,
    /// The step to be tried (s).
    step: Lanes,
    halvings: [u32; LANES],
    pub(super) steps: [u32; LANES],
}

impl Roots {
    /// Solves `prediction(delay) = reading` for each reading of a chunk, from the reference time,
    /// within `±range`: steps are halved while they do not bring the prediction nearer. The chunk is
    /// loaded; `value` and `slope` are those at the reference time.
    pub(super) fn find(
        program: &DelayProgram,
        workspace: &mut Workspace,
        chunk: &Chunk<'_>,
        present: &[bool; LANES],
        [value, slope]: [Lanes; 2],
        range: f64,
    ) -> Self {
        let mut roots = Self {
            stage: present.map(|there| if there { Stage::Trying } else { Stage::Absent }),
            delay: [0.0; LANES],
            value,
            slope,
            step: [0.0; LANES],
            halvings: [0; LANES],
            steps: [0; LANES],
        };
        (0..LANES).filter(|lane| present[*lane]).for_each(|lane| roots.propose(lane, range));
        while roots.stage.contains(&Stage::Trying) {
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
        } else if step.abs() <= TOLERANCE.max(4.0 * f64::EPSILON * self.delay[lane].abs()) {
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

    /// Takes a step that was tried, or halves it.
    fn judge(&mut self, lane: usize, trial: f64, value: f64, slope: f64, range: f64) {
        if value.abs() < self.value[lane].abs() {
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
