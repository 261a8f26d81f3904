//! The delays of runs however long: block by block, in order, and nothing is kept.
//!
//! What the best reading of a run sees decides which of its readings are blind. As many whole runs
//! as make a wave of blocks are solved at once, each block with the best that it knows; when the
//! best of each run is known, the few chunks that counted blind readings as solved are solved
//! again. A run that is longer than a wave is looked at first, for its best reading alone. Every
//! number of threads gives the same bits.

use std::convert::Infallible;
use std::ops::Range;

use rayon::prelude::*;

use crate::campaign::record::Record;
use crate::campaign::run::Samples;
use crate::engine::blocks::in_waves;
use crate::engine::lanes::{Chunk, LANES};
use crate::engine::part::Part;
use crate::estimate::newton::Given;
use crate::estimate::newton::solved::Solved;
use crate::estimate::newton::solver::Solver;
use crate::progress::Task;

/// Samples in one block: few, so that no thread waits long for another at the end of a wave.
const BLOCK: usize = 32 * LANES;
/// Blocks that are in memory with their readings at a time.
const WAVE: usize = 64;

/// Some samples of a run.
#[derive(Clone, Debug)]
struct Block {
    run: usize,
    range: Range<usize>,
}

/// Solves every reading of one measurand in some runs of a campaign. `look` makes something of the
/// readings of a block, with their sums over the columns the run touches, on whatever thread solved
/// them; `visit` sees that of all blocks, in their order. A rotation has no single delay and shows
/// none.
///
/// # Errors
/// The first that `visit` gives; nothing more is solved then.
pub fn each_delay<T: Send, E>(
    given: &Given<'_>,
    part: usize,
    runs: &[usize],
    measurand: usize,
    look: impl Fn(usize, Solved) -> T + Sync,
    mut visit: impl FnMut(usize, T) -> Result<(), E>,
) -> Result<(), E> {
    let data = &given.problem.parts[part];
    if data.slots()[measurand].components != 1 {
        return Ok(());
    }
    let solver = |block: &Block, best: f64| {
        let place = [part, block.run, measurand];
        let mut solver = Solver::new(given, place, block.range.len());
        solver.best = best;
        solver
    };
    let all: u64 = runs.iter().map(|run| data.runs[*run].record.len() as u64).sum();
    let mut done = 0;
    let mut best = vec![f64::INFINITY; data.runs.len()];
    for wave in waves(data, runs) {
        // A part of a run that is longer than a wave.
        if let [Block { run, range }, ..] = wave.as_slice()
            && range.start == 0
            && blocks(data, *run).len() > WAVE
        {
            let best_of = |scratch: &mut Samples, block: &Block| {
                let mut solver = solver(block, f64::INFINITY);
                each_chunk(data, block.run, block.range.clone(), scratch, |chunk| {
                    solver.look(chunk)
                });
                solver.best
            };
            let all: Vec<Block> = blocks(data, *run).collect();
            let Ok(()) = in_waves(&all, WAVE, Samples::default, best_of, |block, seen| {
                best[block.run] = best[block.run].min(seen);
                Ok::<_, Infallible>(())
            });
        }
        let solve = |scratch: &mut Samples, block: &Block| {
            let mut solver = solver(block, best[block.run]);
            each_chunk(data, block.run, block.range.clone(), scratch, |chunk| solver.next(chunk));
            solver.careful();
            solver
        };
        let solved: Vec<Solver<'_>> = wave.par_iter().map_init(Samples::default, solve).collect();
        for (block, solver) in wave.iter().zip(&solved) {
            best[block.run] = best[block.run].min(solver.best);
        }
        let finish = |(mut solver, block): (Solver<'_>, &Block)| {
            solver.best = best[block.run];
            solve_stale(data, block, &mut solver);
            look(block.run, solver.finished())
        };
        let seen: Vec<T> = solved.into_par_iter().zip(&wave).map(finish).collect();
        for (block, seen) in wave.iter().zip(seen) {
            done += block.range.len() as u64;
            given.problem.progress.tell(Task::Solving, done, all);
            visit(block.run, seen)?;
        }
    }
    Ok(())
}

/// The blocks of a run.
fn blocks(data: &Part, run: usize) -> impl ExactSizeIterator<Item = Block> + use<> {
    data.runs[run].record.ranges(BLOCK).map(move |range| Block { run, range })
}

/// The blocks of some runs in waves: of as many whole runs as fit, or of a part of one that does
/// not.
fn waves(data: &Part, runs: &[usize]) -> Vec<Vec<Block>> {
    let mut waves: Vec<Vec<Block>> = Vec::new();
    for run in runs {
        let blocks: Vec<Block> = blocks(data, *run).collect();
        match waves.last_mut() {
            Some(wave) if wave.len() + blocks.len() <= WAVE => wave.extend(blocks),
            _ => waves.extend(blocks.chunks(WAVE).map(<[Block]>::to_vec)),
        }
    }
    waves
}

fn each_chunk(
    data: &Part,
    run: usize,
    range: Range<usize>,
    scratch: &mut Samples,
    mut visit: impl FnMut(&Chunk<'_>),
) {
    let record: &Record = &data.runs[run].record;
    let stretch = record.stretch(range, scratch);
    Chunk::all(stretch, data.columns()).for_each(|chunk| visit(&chunk));
}

/// Solves the chunks again in which a blind reading counts as solved.
fn solve_stale(data: &Part, block: &Block, solver: &mut Solver<'_>) {
    let mut scratch = Samples::default();
    for number in solver.stale() {
        let start = block.range.start + number * LANES;
        let range = start..block.range.end.min(start + LANES);
        each_chunk(data, block.run, range, &mut scratch, |chunk| solver.again(chunk, number));
    }
    solver.careful();
}
