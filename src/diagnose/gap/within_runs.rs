//! Which samples of a run its own parameters are fitted to, and which are judged: every other eighth.
//!
//! A clock's rate that is learnt from a first half would have to be extrapolated over the second,
//! where its error hides what an effect does.

use crate::engine::Problem;

/// Stretches that a run with parameters of its own is cut into.
const STRETCHES: usize = 8;

/// Whether a run's own parameters are fitted to a sample: to every other stretch.
pub(super) fn learns_from(sample: usize, length: usize) -> bool {
    (sample * STRETCHES / length.max(1)).is_multiple_of(2)
}

/// A problem with only some samples of each run, by its length.
pub(super) fn among<W: Fn(usize) -> bool>(
    problem: &Problem,
    wanted: impl Fn(usize) -> W,
) -> Problem {
    let mut parts = problem.parts.clone();
    for part in &mut parts {
        let columns = part.reading_columns();
        for run in &mut part.runs {
            let wanted = wanted(run.record.len());
            let samples: Vec<bool> = (0..run.record.len()).map(wanted).collect();
            let mut from = 0;
            for alike in samples.chunk_by(|a, b| a == b) {
                let to = from + alike.len();
                run.record.leave_out((!alike[0]).then(|| (from..to, columns.clone())));
                from = to;
            }
        }
    }
    Problem::new(parts)
}
