//! The delays of runs however long: block by block, in order, and nothing is kept.
//!
//! What the best reading of a run sees decides which of its readings are blind, so each run is looked
//! at twice: for its best reading, then for its delays. Many blocks are computed at once; every number
//! of threads gives the same bits.

use std::convert::Infallible;
use std::ops::Range;

use super::solver::Solver;
use super::{Given, RunDelays};
use crate::campaign::run::Samples;
use crate::engine::blocks::in_waves;
use crate::engine::lanes::Chunk;
use crate::progress::Task;

/// Samples in one block: a wave of them has its readings in memory.
const BLOCK: usize = 2048;

/// Solves every reading of one measurand in some runs of a campaign. `visit` sees them in their
/// order, block by block: the readings of a block, with their sums over the columns the run touches.
/// A rotation has no single delay and shows none.
///
/// # Errors
/// The first that `visit` gives; nothing more is solved then.
pub fn each_delay<E>(
    given: &Given<'_>,
    part: usize,
    runs: &[usize],
    measurand: usize,
    mut visit: impl FnMut(usize, RunDelays) -> Result<(), E>,
) -> Result<(), E> {
    let data = &given.problem.parts[part];
    if data.slots()[measurand].components != 1 {
        return Ok(());
    }
    let ranges = |run: &usize| {
        let run = *run;
        data.runs[run].record.ranges(BLOCK).map(move |range| (run, range))
    };
    let blocks: Vec<(usize, Range<usize>)> = runs.iter().flat_map(ranges).collect();
    let mut best = vec![f64::INFINITY; data.runs.len()];
    let look = |scratch: &mut Samples, (run, range): &(usize, Range<usize>)| {
        let mut solver = Solver::new(given, [part, *run, measurand], 0);
        let stretch = data.runs[*run].record.stretch(range.clone(), scratch);
        Chunk::all(stretch, data.columns()).for_each(|chunk| solver.look(&chunk));
        solver.best()
    };
    let all = 2 * blocks.iter().map(|(_, range)| range.len() as u64).sum::<u64>();
    let mut done = 0;
    let mut tell = |range: &Range<usize>| {
        done += range.len() as u64;
        given.problem.progress.tell(Task::Solving, done, all);
    };
    let Ok(()) = in_waves(&blocks, look, |(run, range), seen| {
        best[*run] = best[*run].min(seen);
        tell(range);
        Ok::<_, Infallible>(())
    });
    let solve = |scratch: &mut Samples, (run, range): &(usize, Range<usize>)| {
        let mut solver = Solver::new(given, [part, *run, measurand], range.len());
        solver.know(best[*run]);
        let stretch = data.runs[*run].record.stretch(range.clone(), scratch);
        Chunk::all(stretch, data.columns()).for_each(|chunk| solver.next(&chunk));
        solver.careful();
        let touched = given.problem.layout.columns.touched_by(given.problem.run_index(part, *run));
        let weighted_sensitivity = solver.weighted_sensitivity(touched.len());
        RunDelays { readings: solver.readings(), weighted_sensitivity }
    };
    in_waves(&blocks, solve, |(run, range), found| {
        tell(range);
        visit(*run, found)
    })
}
