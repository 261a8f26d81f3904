//! Whether it is one run that does not fit, rather than a convention of all.

use rayon::prelude::*;

use crate::engine::Problem;
use crate::estimate::minima::thinned::Tried;
use crate::estimate::start::start;

use super::{BETTER, GOOD, ITERATIONS};

/// Of fewer runs none is another one than the rest.
const FEW_RUNS: usize = 3;

/// Whether a problem fits far better without one of its runs than this, which is no good fit: then
/// that run is another one, and no convention is mistaken in all of them.
pub(super) fn is_of_one_run(problem: &Problem, variance_factor: f64) -> bool {
    let runs: usize = problem.parts.iter().map(|part| part.runs.len()).sum();
    if variance_factor < GOOD || runs < FEW_RUNS {
        return false;
    }
    let without = |(part, run): (usize, usize)| {
        let mut parts = problem.parts.clone();
        let columns = parts[part].reading_columns();
        let record = &mut parts[part].runs[run].record;
        record.leave_out([(0..record.len(), columns)]);
        let rest = Problem::new(parts);
        let begin = start(&rest).0;
        let fit = Tried::fit(rest, begin, 0.0, ITERATIONS[2]);
        fit.is_some_and(|fit| fit.variance_factor * BETTER[0] < variance_factor)
    };
    let parts = problem.parts.iter().enumerate();
    let all = parts.flat_map(|(part, one)| (0..one.runs.len()).map(move |run| (part, run)));
    all.collect::<Vec<_>>().into_par_iter().any(without)
}
