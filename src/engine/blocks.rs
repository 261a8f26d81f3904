//! Samples in fixed blocks, computed by many threads and added up in order: every thread count
//! gives the same bits.
//!
//! Answers: which blocks there are, and each chunk of a block loaded with its weights. What is
//! summed is the caller's business.

use std::convert::Infallible;
use std::sync::Arc;

use rayon::prelude::*;

use crate::campaign::record::BLOCK as STRETCH;
use crate::engine::gauss_markov::Gains;
use crate::engine::kept::{Memories, Memory, Own};
use crate::engine::lanes::{Chunk, Code, LANES, Lanes, Workspace};
use crate::engine::mixing::Mixing;
use crate::engine::part::ParameterLeaves;
use crate::engine::point::Point;
use crate::engine::problem::Problem;
use crate::engine::programs::RowsProgram;
use crate::engine::whitening::Whitened;
use crate::progress::Task;

/// Samples in one block.
pub(super) const BLOCK: usize = 64 * LANES;
// Where a run is walked over, its stretches begin with chunks.
const _: () = assert!(STRETCH.is_multiple_of(LANES), "a stretch is whole chunks");
/// Blocks whose sums wait to be added at a time, at most.
const WAVE: usize = 64;
/// Numbers that may wait to be added: large sums wait in fewer blocks.
const WAITING: usize = 1 << 22;

/// One block of samples of one run.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    pub(super) part: usize,
    pub(super) run: usize,
    pub(super) start: usize,
    end: usize,
}

/// What all blocks of a run have in common.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    /// Values of the parameters.
    parameters: Vec<[f64; 4]>,
    /// For each direction the columns of the run's Gram matrix that move it.
    pub(super) movers: Arc<[Vec<(usize, f64)>]>,
    /// Columns of the run's Gram matrix, the residual included.
    pub(super) size: usize,
}

impl Plan {
    /// The plan with further values after those of the parameters.
    pub(super) fn given(&self, constants: &[f64]) -> Self {
        let constants = constants.iter().map(|value| [*value, 0.0, 0.0, 0.0]);
        let parameters = self.parameters.iter().copied().chain(constants).collect();
        Self { parameters, movers: Arc::clone(&self.movers), size: self.size }
    }
}

/// A chunk with everything that its rows need.
#[derive(Debug)]
pub(super) struct Loaded<'a> {
    pub(super) workspace: &'a mut Workspace,
    pub(super) chunk: &'a Chunk<'a>,
    /// Its number in the block.
    pub(super) number: usize,
    /// The weight of each measurand: 0 where there is no reading.
    pub(super) weights: &'a [Lanes],
    /// Whether every lane has every reading.
    pub(super) complete: bool,
    pub(super) whitened: &'a Whitened<'a>,
}

/// One whitened row of the samples of a chunk.
#[derive(Clone, Copy, Debug)]
pub(super) struct WhitenedRow<'a> {
    /// Which residual component.
    pub(super) index: usize,
    /// The residual, then the derivatives along the directions.
    pub(super) lanes: &'a [&'a Lanes],
    /// Of the filter along time, where the noise of the row is autocorrelated.
    pub(super) gains: Option<&'a [Gains; LANES]>,
    pub(super) directions: &'a [usize],
    /// The samples; lanes beyond them are zero.
    pub(super) chunk: &'a Chunk<'a>,
    /// 0 where there is no reading.
    pub(super) weights: &'a Lanes,
}

/// Computes something of every item, so many at a time, and takes the results in order: the same
/// whatever that number is. A thread keeps its memory as long as it can.
///
/// # Errors
/// The first that `take` gives; nothing more is computed then.
pub(crate) fn in_waves<I: Sync, M, T: Send, E>(
    items: &[I],
    wave: usize,
    memory: impl Fn() -> M + Sync,
    compute: impl Fn(&mut M, &I) -> T + Sync,
    mut take: impl FnMut(&I, T) -> Result<(), E>,
) -> Result<(), E> {
    for wave in items.chunks(wave.max(1)) {
        let made: Vec<T> = wave.par_iter().map_init(&memory, &compute).collect();
        wave.iter().zip(made).try_for_each(|(item, one)| take(item, one))?;
    }
    Ok(())
}

impl Problem {
    pub(super) fn blocks(&self) -> Vec<Block> {
        let mut blocks = Vec::new();
        for (part, data) in self.parts.iter().enumerate() {
            for (run, data) in data.runs.iter().enumerate() {
                blocks.extend(data.record.ranges(BLOCK).map(|range| Block {
                    part,
                    run,
                    start: range.start,
                    end: range.end,
                }));
            }
        }
        blocks
    }

    /// The plans of all runs.
    pub(super) fn plans(&self, point: &Point) -> Vec<Plan> {
        let runs = |part: usize| (0..self.parts[part].runs.len()).map(move |run| (part, run));
        (0..self.parts.len())
            .flat_map(runs)
            .map(|(part, run)| self.plan(part, run, point, 0))
            .collect()
    }

    /// The plan of a run, with so many further columns before the residual's.
    pub(super) fn plan(&self, part: usize, run: usize, point: &Point, more: usize) -> Plan {
        let touched = self.layout.columns.touched_by(self.run_index(part, run)).len();
        let mut movers = self.movers(part, run);
        movers.extend((0..more).map(|column| vec![(touched + column, 1.0)]));
        let parameters = self.parameters(part, run, point);
        Plan { parameters, movers: movers.into(), size: touched + more + 1 }
    }

    /// Computes something of every wanted block, many at a time, and takes the results in order.
    /// What waits of a block are so many numbers.
    pub(super) fn in_order<T: Send>(
        &self,
        memories: &Memories,
        numbers: usize,
        wanted: impl Fn(Block) -> bool,
        compute: impl Fn(&mut Memory, Block) -> T + Sync,
        mut take: impl FnMut(Block, T),
    ) {
        let mut blocks = self.blocks();
        blocks.retain(|block| wanted(*block));
        let samples = |block: &Block| (block.end - block.start) as u64;
        let (mut done, all) = (0, blocks.iter().map(samples).sum());
        let task = Task::Fitting { iteration: self.iteration };
        let take = |block: &Block, one| {
            take(*block, one);
            done += samples(block);
            self.progress.tell(task, done, all);
            Ok::<_, Infallible>(())
        };
        let busy = 2 * rayon::current_num_threads();
        let wave = (WAITING / numbers.max(1)).clamp(busy.min(WAVE), WAVE);
        let Ok(()) = in_waves(
            &blocks,
            wave,
            || memories.lend(),
            |memory, block| compute(memory, *block),
            take,
        );
    }

    /// Puts 1 where there is a reading and 0 where there is none; the number of readings.
    pub(super) fn present(
        &self,
        part: usize,
        chunk: &Chunk<'_>,
        weights: &mut Vec<Lanes>,
    ) -> usize {
        let slots = self.parts[part].slots();
        weights.resize(slots.len(), [0.0; LANES]);
        let mut readings = 0;
        for (slot, weight) in slots.iter().zip(&mut *weights) {
            readings += chunk.mark_readings(slot.column, self.set, weight);
        }
        readings
    }

    /// Computes the whitened rows of a block, chunk after chunk, those of a chunk in order; the
    /// number of readings. What is kept then says which directions the rows have.
    pub(super) fn walk_rows(
        &self,
        block: Block,
        program: &RowsProgram,
        plan: &Plan,
        memory: &mut Memory,
        each: &mut dyn FnMut(WhitenedRow<'_>),
    ) -> usize {
        let part = &self.parts[block.part];
        let correlated = self.whitening[block.part][block.run].is_correlated();
        let rows = program.rows.iter().map(|row| row.directions.as_slice());
        self.own(block.part, &program.code, memory).mixed.prepare(rows, correlated);
        let mut filtering = std::mem::take(&mut memory.filtering);
        filtering.begin(&part.gauss_markov);
        let readings = self.walk_block(block, &program.code, plan, memory, &mut |loaded, mixed| {
            let Loaded { workspace, chunk, weights, whitened, .. } = loaded;
            let triangles = whitened.triangles(loaded.number, program.rows.len());
            for group in 0..program.code.group_count() {
                workspace.compute(&program.code, group, chunk.inputs());
                for (index, row) in program.rows_of(group) {
                    let weights = &weights[part.measurand_of(index)];
                    if !loaded.complete {
                        // Without a reading a row is zero, whatever the model says there.
                        workspace.silence(&program.code, group, row.outputs(), weights);
                    }
                    let lanes = &workspace.lanes(&program.code, group, row.outputs());
                    let directions = &row.directions;
                    match triangles {
                        None => filtering.pass(index, lanes, chunk, weights, |lanes, gains| {
                            each(WhitenedRow { index, lanes, gains, directions, chunk, weights });
                        }),
                        Some(triangles) => mixed.add(self.set, index, lanes, triangles),
                    }
                }
            }
            if triangles.is_some() {
                for index in 0..program.rows.len() {
                    let weights = &weights[part.measurand_of(index)];
                    let (directions, lanes) = mixed.row(index);
                    filtering.pass(index, &lanes, chunk, weights, |lanes, gains| {
                        each(WhitenedRow { index, lanes, gains, directions, chunk, weights });
                    });
                }
            }
        });
        memory.filtering = filtering;
        readings
    }

    /// Loads each chunk of a block into the program's workspace; the number of readings comes back.
    pub(super) fn walk_block(
        &self,
        block: Block,
        code: &Code,
        plan: &Plan,
        memory: &mut Memory,
        each: &mut dyn FnMut(&mut Loaded<'_>, &mut Mixing),
    ) -> usize {
        let part = &self.parts[block.part];
        self.own(block.part, code, memory);
        let Memory { own, weights, samples, .. } = memory;
        let Some(Own { workspace, mixed, .. }) = own[block.part].as_mut() else { return 0 };
        workspace.hold_still(code, &ParameterLeaves(&plan.parameters));
        let stretch = part.runs[block.run].record.stretch(block.start..block.end, samples);
        let whitening = &self.whitening[block.part][block.run];
        let whitened = whitening.of(self.run_programs(block.part, block.run), stretch);
        let mut readings = 0;
        for (number, chunk) in Chunk::all(stretch, part.columns()).enumerate() {
            let there = self.present(block.part, &chunk, weights);
            readings += there;
            whitened.weigh(number, weights);
            let complete = there == LANES * part.slots().len();
            workspace.load(code, &chunk, weights, complete);
            let chunk = &chunk;
            let (weights, whitened) = (weights.as_slice(), &whitened);
            each(&mut Loaded { workspace, chunk, number, weights, complete, whitened }, mixed);
        }
        readings
    }
}
