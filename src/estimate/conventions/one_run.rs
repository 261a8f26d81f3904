//! The run that does not fit beside the others, if there is one.

use rayon::prelude::*;

use crate::engine::Problem;
use crate::estimate::minima::thinned::Tried;
use crate::estimate::start::start;

use super::{BETTER, GOOD, ITERATIONS};

/// Of fewer runs none is another one than the rest.
const FEW_RUNS: usize = 3;

/// A run by its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct OneRun {
    /// Index of the campaign.
    pub(super) part: usize,
    /// Index of the run in the campaign.
    pub(super) run: usize,
}

impl OneRun {
    /// All runs of a problem.
    pub(super) fn all(problem: &Problem) -> impl Iterator<Item = Self> + use<> {
        let counts: Vec<usize> = problem.parts.iter().map(|part| part.runs.len()).collect();
        let parts = counts.into_iter().enumerate();
        parts.flat_map(|(part, count)| (0..count).map(move |run| Self { part, run }))
    }
}

/// The run without which a problem fits best, and far better than this, which is no good fit; with the
/// variance factor of the others.
pub(super) fn run_that_does_not_fit(
    problem: &Problem,
    variance_factor: f64,
) -> Option<(f64, OneRun)> {
    let runs: Vec<OneRun> = OneRun::all(problem).collect();
    if variance_factor < GOOD || runs.len() < FEW_RUNS {
        return None;
    }
    let without = |one: OneRun| {
        let mut parts = problem.parts.clone();
        let columns = parts[one.part].reading_columns();
        let record = &mut parts[one.part].runs[one.run].record;
        record.leave_out([(0..record.len(), columns)]);
        let rest = Problem::new(parts);
        let begin = start(&rest).0;
        let fit = Tried::fit(rest, begin, 0.0, ITERATIONS[2])?;
        let is_better = fit.variance_factor * BETTER[0] < variance_factor;
        is_better.then_some((fit.variance_factor, one))
    };
    let all: Vec<(f64, OneRun)> = runs.into_par_iter().filter_map(without).collect();
    all.into_iter().min_by(|a, b| a.0.total_cmp(&b.0))
}
