//! The readings of a problem, to put back those that were left out of it.

use crate::campaign::Record;
use crate::engine::Problem;

/// The records of each run of each campaign.
#[derive(Clone, Debug)]
pub struct Records(Vec<Vec<Record>>);

impl Records {
    /// Those that a problem has.
    pub fn of(problem: &Problem) -> Self {
        let parts = problem.parts.iter();
        Self(parts.map(|part| part.runs.iter().map(|run| run.record.clone()).collect()).collect())
    }

    /// Gives them to a problem of the same campaigns.
    pub fn put_into(&self, problem: &mut Problem) {
        for (part, records) in problem.parts.iter_mut().zip(&self.0) {
            part.runs.iter_mut().zip(records).for_each(|(run, own)| run.record = own.clone());
        }
    }
}
