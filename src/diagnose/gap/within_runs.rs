//! Which samples of a run its own parameters are fitted to, and which are judged: every other eighth.
//!
//! A clock's rate that is learnt from a first half would have to be extrapolated over the second,
//! where its error hides what an effect does.

use crate::engine::Problem;

/// Stretches that a run with parameters of its own is cut into.
const STRETCHES: usize = 8;

/// Every other eighth of each run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Eighths {
    /// To which a run's own parameters are fitted: the first, the third...
    Learnt = 0,
    /// Which are judged.
    Judged = 1,
}

/// A problem with only some eighths of each run.
pub(super) fn only(problem: &Problem, wanted: Eighths) -> Problem {
    let mut parts = problem.parts.clone();
    for part in &mut parts {
        let columns = part.reading_columns();
        for run in &mut part.runs {
            let edge = |eighth: usize| (eighth * run.record.len()).div_ceil(STRETCHES);
            let others = (0..STRETCHES).filter(|eighth| eighth % 2 != wanted as usize);
            let out: Vec<_> =
                others.map(|one| (edge(one)..edge(one + 1), columns.clone())).collect();
            run.record.leave_out(out);
        }
    }
    problem.with_parts(parts)
}
