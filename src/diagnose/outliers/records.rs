//! The readings of a problem, to put back those that were left out of it.

use crate::campaign::Record;
use crate::engine::Problem;
use crate::estimate::batch::{FitError, Options};
use crate::estimate::calibrate::{Calibration, calibrate};
use crate::estimate::minima::improved;
use crate::estimate::refit::beginning_at;

/// The records of each run of each campaign.
#[derive(Clone, Debug)]
pub struct Records(Vec<Vec<Record>>);

impl Records {
    /// Those that a problem has.
    pub fn of(problem: &Problem) -> Self {
        let parts = problem.parts.iter();
        Self(parts.map(|part| part.runs.iter().map(|run| run.record.clone()).collect()).collect())
    }

    /// The best sound fit of a campaign with these readings alone: from its start or another one that is
    /// found, and from where the fit of all readings ended. `None` where whole runs are not among them.
    pub(in crate::diagnose) fn fitted_anew(
        &self,
        whole: &Calibration,
        options: &Options,
    ) -> Result<Option<Calibration>, FitError> {
        if !self.are_of(&whole.problem) {
            return Ok(None);
        }
        let mut problem = whole.problem.clone();
        self.put_into(&mut problem);
        let from_whole = beginning_at(problem.clone(), &whole.fit.point);
        let mut best: Option<Calibration> = None;
        for problem in [improved(problem).0, from_whole] {
            let anew = calibrate(problem, options)?;
            let is_better = best.as_ref().is_none_or(|best| anew.fit.cost < best.fit.cost);
            if anew.is_sound() && is_better {
                best = Some(anew);
            }
        }
        Ok(best)
    }

    /// Whether a problem has these runs.
    pub(super) fn are_of(&self, problem: &Problem) -> bool {
        let counts = self.0.iter().map(Vec::len);
        counts.eq(problem.parts.iter().map(|part| part.runs.len()))
    }

    /// Gives them to a problem of the same campaigns.
    pub fn put_into(&self, problem: &mut Problem) {
        for (part, records) in problem.parts.iter_mut().zip(&self.0) {
            part.runs.iter_mut().zip(records).for_each(|(run, own)| run.record = own.clone());
        }
    }
}
