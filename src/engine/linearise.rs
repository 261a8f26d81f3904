//! Whitened residuals and Jacobians, summed by run: the only maker of Jacobians.
//!
//! The lanes compute rows, 128 samples at a time; the products of a row's columns are added up where
//! they stand. Samples are taken in fixed blocks whose sums are added in order, so every thread count
//! gives the same bits. [`super::referee`] makes the same rows sample by sample.

use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::campaign::run::Samples;
use crate::engine::gram::{Columns, LeastSquares, Normal, RunGram};
use crate::engine::lanes::arithmetic::{LANES, Lanes};
use crate::engine::lanes::products::Products;
use crate::engine::lanes::{Chunk, Code, InstructionSet, Workspace};
use crate::engine::mixing::Mixing;
use crate::engine::point::Point;
use crate::engine::problem::{ParameterLeaves, Problem};
use crate::engine::programs::RowsProgram;
use crate::graph::Kind;

/// Samples in one block.
const BLOCK: usize = 64 * LANES;
/// Blocks whose sums wait to be added at a time.
const WAVE: usize = 64;

/// What sees the Jacobian and the residuals of each sample.
pub type Visitor<'a> = dyn FnMut(usize, &DMatrix<f64>, &[f64]) + 'a;

/// One block of samples of one run.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    pub(super) part: usize,
    pub(super) run: usize,
    start: usize,
    end: usize,
}

/// What all blocks of a run have in common.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    /// Values of the parameters.
    parameters: Vec<[f64; 4]>,
    /// For each direction the columns of the run's Gram matrix that move it.
    movers: Vec<Vec<(usize, f64)>>,
    /// Columns of the run's Gram matrix, the residual included.
    pub(super) size: usize,
}

/// What one thread keeps between blocks.
#[derive(Debug, Default)]
pub(super) struct Memory {
    /// For each campaign: residuals, rows.
    workspaces: Vec<[Option<Workspace>; 2]>,
    weights: Vec<Lanes>,
    mixed: Mixing,
    /// Of a run that is not in memory.
    samples: Samples,
}

impl Memory {
    /// The workspace for a program of a campaign.
    fn workspace(
        &mut self,
        part: usize,
        which: usize,
        code: &Code,
        set: InstructionSet,
    ) -> Workspace {
        self.workspaces.resize_with(self.workspaces.len().max(part + 1), Default::default);
        let kept = self.workspaces[part][which].take();
        kept.unwrap_or_else(|| Workspace::new(code, set))
    }
}

impl Problem {
    fn blocks(&self) -> Vec<Block> {
        let mut blocks = Vec::new();
        for (part, data) in self.parts.iter().enumerate() {
            for (run, data) in data.runs.iter().enumerate() {
                let samples = data.record.len();
                for start in (0..samples).step_by(BLOCK) {
                    blocks.push(Block { part, run, start, end: samples.min(start + BLOCK) });
                }
            }
        }
        blocks
    }

    /// Index of a run among all runs.
    pub fn run_index(&self, part: usize, run: usize) -> usize {
        self.layout.first_run[part] + run
    }

    fn plans(&self, point: &Point) -> Vec<Plan> {
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
        Plan { parameters, movers, size: touched + more + 1 }
    }

    /// Computes something of every wanted block, many at a time, and takes the results in order.
    pub(super) fn in_order<T: Send>(
        &self,
        wanted: impl Fn(Block) -> bool,
        compute: impl Fn(&mut Memory, Block) -> T + Sync,
        mut take: impl FnMut(Block, T),
    ) {
        let mut blocks = self.blocks();
        blocks.retain(|block| wanted(*block));
        for wave in blocks.chunks(WAVE) {
            let made: Vec<T> = wave
                .par_iter()
                .map_init(Memory::default, |memory, block| compute(memory, *block))
                .collect();
            wave.iter().zip(made).for_each(|(block, one)| take(*block, one));
        }
    }

    /// Puts 1 where there is a reading and 0 where there is none.
    fn weigh(&self, part: usize, chunk: &Chunk<'_>, weights: &mut Vec<Lanes>) -> Weighed {
        let slots = self.parts[part].slots();
        weights.resize_with(slots.len(), || [0.0; LANES]);
        let mut readings = 0;
        for (slot, weight) in slots.iter().zip(&mut *weights) {
            let mut there = 0_u64;
            for (weight, reading) in weight.iter_mut().zip(chunk.readings(slot.column)) {
                *weight = if reading.is_nan() { 0.0 } else { 1.0 };
                there += u64::from(!reading.is_nan());
            }
            weight[chunk.len..].fill(0.0);
            readings += there as usize;
        }
        Weighed { readings, complete: readings == slots.len() * LANES }
    }

    /// The sums over a block of what a program computes.
    pub(super) fn block_gram(
        &self,
        block: Block,
        program: &RowsProgram,
        plan: &Plan,
        memory: &mut Memory,
    ) -> RunGram {
        let part = &self.parts[block.part];
        let mut scratch = std::mem::take(&mut memory.samples);
        let record = &part.runs[block.run].record;
        let stretch = record.stretch(block.start..block.end, &mut scratch);
        let whitening =
            self.whitening[block.part][block.run].of(self, block.part, block.run, stretch);
        let code = &program.code;
        let set = self.set;
        let mut workspace = memory.workspace(block.part, 1, code, self.set);
        workspace.hold_still(code, &ParameterLeaves(&plan.parameters));
        let directions: Vec<&[usize]> =
            program.rows.iter().map(|row| row.directions.as_slice()).collect();
        memory.mixed.prepare(&directions, whitening.is_correlated());
        let mut products: Vec<Products> =
            (0..program.rows.len()).map(|row| Products::new(memory.mixed.count(row))).collect();
        let mut readings = 0;
        for (number, chunk) in Chunk::all(stretch, part.columns()).enumerate() {
            let weighed = self.weigh(block.part, &chunk, &mut memory.weights);
            readings += weighed.readings;
            whitening.weigh(number, &mut memory.weights);
            workspace.load(code, &chunk, &memory.weights);
            for group in 0..code.group_count() {
                workspace.compute(code, group, &chunk);
                for (index, row) in
                    program.rows.iter().enumerate().filter(|(_, r)| r.group == group)
                {
                    let outputs = row.first..row.first + 1 + row.directions.len();
                    if !weighed.complete {
                        let weight = &memory.weights[part.measurand_of(index)];
                        workspace.silence(code, group, outputs.clone(), weight);
                    }
                    let lanes = workspace.lanes(code, group, outputs);
                    match whitening.triangles(number, program.rows.len()) {
                        None => products[index].add(set, &lanes),
                        Some(triangles) => memory.mixed.add(set, index, &lanes, triangles),
                    }
                }
            }
            if whitening.is_correlated() {
                for (row, products) in products.iter_mut().enumerate() {
                    memory.mixed.take(row, |lanes| products.add(set, lanes));
                }
            }
        }
        memory.workspaces[block.part][1] = Some(workspace);
        memory.samples = scratch;
        let mut gram = DMatrix::zeros(plan.size, plan.size);
        let residual = [(plan.size - 1, 1.0)];
        for (row, products) in products.iter().enumerate() {
            let columns: Vec<&[(usize, f64)]> = std::iter::once(&residual[..])
                .chain(memory.mixed.directions(row).iter().map(|d| plan.movers[*d].as_slice()))
                .collect();
            scatter(&mut gram, products, &columns);
        }
        RunGram { gram, readings }
    }

    fn block_cost(&self, block: Block, plan: &Plan, memory: &mut Memory) -> f64 {
        let part = &self.parts[block.part];
        let mut scratch = std::mem::take(&mut memory.samples);
        let record = &part.runs[block.run].record;
        let stretch = record.stretch(block.start..block.end, &mut scratch);
        let whitening =
            self.whitening[block.part][block.run].of(self, block.part, block.run, stretch);
        let code = self.programs[block.part].residuals(&part.system.assembly);
        let set = self.set;
        let mut workspace = memory.workspace(block.part, 0, code, self.set);
        workspace.hold_still(code, &ParameterLeaves(&plan.parameters));
        let rows = part.residual_count();
        memory.mixed.prepare(&vec![&[][..]; rows], whitening.is_correlated());
        let mut squares = Products::new(1);
        for (number, chunk) in Chunk::all(stretch, part.columns()).enumerate() {
            let weighed = self.weigh(block.part, &chunk, &mut memory.weights);
            whitening.weigh(number, &mut memory.weights);
            workspace.load(code, &chunk, &memory.weights);
            workspace.compute(code, 0, &chunk);
            for row in 0..rows {
                if !weighed.complete {
                    let weight = &memory.weights[part.measurand_of(row)];
                    workspace.silence(code, 0, row..row + 1, weight);
                }
                let lanes = workspace.lanes(code, 0, row..row + 1);
                match whitening.triangles(number, rows) {
                    None => squares.add(set, &lanes),
                    Some(triangles) => memory.mixed.add(set, row, &lanes, triangles),
                }
            }
            if whitening.is_correlated() {
                for row in 0..rows {
                    memory.mixed.take(row, |lanes| squares.add(set, lanes));
                }
            }
        }
        memory.workspaces[block.part][0] = Some(workspace);
        memory.samples = scratch;
        squares.sum(0, 0)
    }

    /// Calls `visit` for each chunk of a run.
    fn visit_chunks(&self, part: usize, run: usize, visit: &mut dyn FnMut(&Chunk<'_>)) {
        let data = &self.parts[part];
        data.runs[run].record.walk(|stretch| {
            Chunk::all(stretch, data.columns()).for_each(|chunk| visit(&chunk));
        });
    }

    /// Shows the rows of a run a chunk at a time, not whitened.
    pub fn visit_rows(
        &self,
        part: usize,
        run: usize,
        point: &Point,
        visit: &mut dyn FnMut(&ChunkRows<'_>),
    ) {
        let data = &self.parts[part];
        let program = self.programs[part].rows(&data.system.assembly);
        let code = &program.code;
        let mut workspace = Workspace::new(code, self.set);
        workspace.hold_still(code, &ParameterLeaves(&self.parameters(part, run, point)));
        let mut weights = Vec::new();
        self.visit_chunks(part, run, &mut |chunk| {
            self.weigh(part, chunk, &mut weights);
            workspace.load(code, chunk, &weights);
            for group in 0..code.group_count() {
                workspace.compute(code, group, chunk);
                for (number, row) in
                    program.rows.iter().enumerate().filter(|(_, r)| r.group == group)
                {
                    let outputs = row.first..row.first + 1 + row.directions.len();
                    visit(&ChunkRows {
                        first: chunk.first,
                        len: chunk.len,
                        row: number,
                        present: &weights[data.measurand_of(number)],
                        directions: &row.directions,
                        lanes: &workspace.lanes(code, group, outputs),
                    });
                }
            }
        });
    }

    /// Calls `visit(sample, jacobian, residual)` for each sample of a run: the Jacobian of the
    /// predictions (rows: residual components; columns: those the run touches, in their order) and
    /// `reading - prediction`, neither whitened, missing readings as zero rows.
    pub fn visit_run(&self, part: usize, run: usize, point: &Point, visit: &mut Visitor<'_>) {
        let rows = self.parts[part].residual_count();
        let movers = self.movers(part, run);
        let size = self.layout.columns.touched_by(self.run_index(part, run)).len();
        let mut jacobians = vec![DMatrix::zeros(rows, size); LANES];
        let mut values = vec![vec![0.0; rows]; LANES];
        self.visit_rows(part, run, point, &mut |chunk| {
            for lane in 0..chunk.len {
                let there = chunk.present[lane] != 0.0;
                let jacobian = &mut jacobians[lane];
                jacobian.row_mut(chunk.row).fill(0.0);
                values[lane][chunk.row] = if there { chunk.lanes[0][lane] } else { 0.0 };
                for (direction, slope) in chunk.directions.iter().zip(&chunk.lanes[1..]) {
                    for (column, by) in movers[*direction].iter().filter(|_| there) {
                        jacobian[(chunk.row, *column)] += by * slope[lane];
                    }
                }
                if chunk.row + 1 == rows {
                    visit(chunk.first + lane, jacobian, &values[lane]);
                }
            }
        });
    }

    /// Calls `visit(sample, residual)` for each sample of a run: `reading - prediction` at a point,
    /// not whitened, NaN where there is no reading.
    pub fn visit_residuals(
        &self,
        part: usize,
        run: usize,
        point: &Point,
        visit: &mut dyn FnMut(usize, &[f64]),
    ) {
        let data = &self.parts[part];
        let code = self.programs[part].residuals(&data.system.assembly);
        let mut workspace = Workspace::new(code, self.set);
        workspace.hold_still(code, &ParameterLeaves(&self.parameters(part, run, point)));
        let rows = data.residual_count();
        let mut values = vec![0.0; rows];
        let mut weights = Vec::new();
        self.visit_chunks(part, run, &mut |chunk| {
            self.weigh(part, chunk, &mut weights);
            workspace.load(code, chunk, &weights);
            workspace.compute(code, 0, chunk);
            let lanes = workspace.lanes(code, 0, 0..rows);
            for lane in 0..chunk.len {
                for (row, value) in values.iter_mut().enumerate() {
                    let there = weights[data.measurand_of(row)][lane] != 0.0;
                    *value = if there { lanes[row][lane] } else { f64::NAN };
                }
                visit(chunk.first + lane, &values);
            }
        });
    }

    /// The residuals of [`Problem::visit_residuals`], one vector a sample.
    pub fn residuals(&self, part: usize, run: usize, point: &Point) -> Vec<Vec<f64>> {
        let mut all = Vec::with_capacity(self.parts[part].runs[run].record.len());
        self.visit_residuals(part, run, point, &mut |_, values| all.push(values.to_vec()));
        all
    }
}

/// One row of the samples of a chunk, not whitened.
#[derive(Clone, Copy, Debug)]
pub struct ChunkRows<'a> {
    /// Number of the first sample in its run.
    pub first: usize,
    /// Number of samples; further lanes mean nothing.
    pub len: usize,
    /// Which residual component.
    pub row: usize,
    /// 1 where there is a reading, else 0.
    pub present: &'a Lanes,
    /// The directions on which it hangs, by index.
    pub directions: &'a [usize],
    /// The residual, then its prediction's derivatives along those directions.
    pub lanes: &'a [&'a Lanes],
}

/// What a chunk's readings are.
#[derive(Clone, Copy, Debug)]
struct Weighed {
    readings: usize,
    /// Every lane has every reading.
    complete: bool,
}

/// Adds products of columns that stand for the given columns of a Gram matrix.
fn scatter(gram: &mut DMatrix<f64>, products: &Products, columns: &[&[(usize, f64)]]) {
    for (i, left) in columns.iter().enumerate() {
        for (j, right) in columns.iter().enumerate().skip(i) {
            let sum = products.sum(i, j);
            for (a, p) in *left {
                for (b, q) in *right {
                    let value = p * q * sum;
                    gram[(*a, *b)] += value;
                    if i != j {
                        gram[(*b, *a)] += value;
                    }
                }
            }
        }
    }
}

impl LeastSquares for Problem {
    type Point = Point;

    fn columns(&self) -> &Columns {
        &self.layout.columns
    }

    fn reweight(&mut self, point: &Point) {
        self.refresh_weights(point);
    }

    fn cost(&self, point: &Point) -> f64 {
        let plans = self.plans(point);
        let mut sum = 0.0;
        self.in_order(
            |_| true,
            |memory, block| {
                self.block_cost(block, &plans[self.run_index(block.part, block.run)], memory)
            },
            |_, cost| sum += cost,
        );
        let priors: f64 = point.priors(&self.layout).iter().map(|row| row.residual.powi(2)).sum();
        sum + priors
    }

    fn normal(&self, point: &Point) -> Normal {
        let columns = self.layout.columns.clone();
        let plans = self.plans(point);
        let mut runs: Vec<RunGram> = plans.iter().map(|plan| RunGram::empty(plan.size)).collect();
        self.in_order(
            |_| true,
            |memory, block| {
                let plan = &plans[self.run_index(block.part, block.run)];
                let program =
                    self.programs[block.part].rows(&self.parts[block.part].system.assembly);
                self.block_gram(block, program, plan, memory)
            },
            |block, made| runs[self.run_index(block.part, block.run)].add(&made),
        );
        Normal { columns, runs, priors: point.priors(&self.layout) }
    }

    fn moved(&self, point: &Point, step: &[f64]) -> Point {
        point.moved(&self.layout, step)
    }

    fn step_bounds(&self, point: &Point) -> Vec<(f64, f64)> {
        let mut bounds = vec![(f64::NEG_INFINITY, f64::INFINITY); self.layout.columns.len()];
        for (index, instance) in self.layout.instances.iter().enumerate() {
            // Bounds of a rotation vector or of contrasts are not bounds of a column.
            if instance.kind == Kind::Rotation {
                continue;
            }
            for (component, column) in self.layout.range_of(index).enumerate() {
                let value = point.values[index][component];
                let at =
                    |side: &Option<Vec<f64>>| side.as_ref().and_then(|b| b.get(component).copied());
                if let Some(lower) = at(&instance.setting.lower) {
                    bounds[column].0 = lower - value;
                }
                if let Some(upper) = at(&instance.setting.upper) {
                    bounds[column].1 = upper - value;
                }
            }
        }
        bounds
    }
}
