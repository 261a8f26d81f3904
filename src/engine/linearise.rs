//! Whitened residuals and Jacobians, summed by run: the only maker of Jacobians.
//!
//! Forward mode in chunks of tangents over the pointwise engine. Samples are taken in fixed blocks
//! whose sums are added in order, so every thread count gives the same bits.

use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::engine::gram::{Columns, LeastSquares, Normal, RunGram};
use crate::engine::point::Point;
use crate::engine::problem::{Problem, SampleLeaves};
use crate::graph::Kind;
use crate::number::{Gradient, Number, partials};

/// Tangents in one pass of the engine.
const CHUNK: usize = 8;
/// Samples in one block.
const BLOCK: usize = 512;

/// What sees the Jacobian and the residuals of each sample.
type Visitor<'a> = dyn FnMut(usize, &DMatrix<f64>, &[f64]) + 'a;

/// One block of samples of one run.
#[derive(Clone, Copy, Debug)]
struct Block {
    part: usize,
    run: usize,
    start: usize,
    end: usize,
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

    /// Calls `visit(sample, jacobian, residual)` for each sample of a run: the Jacobian of the
    /// predictions (rows: residual components; columns: those the run touches, in their order) and
    /// `reading - prediction`, neither whitened, missing readings as zero rows.
    pub fn visit_run(&self, part: usize, run: usize, point: &Point, visit: &mut Visitor<'_>) {
        let samples = self.parts[part].runs[run].record.len();
        self.visit_block(Block { part, run, start: 0, end: samples }, point, visit);
    }

    fn visit_block(&self, block: Block, point: &Point, visit: &mut Visitor<'_>) {
        let part = &self.parts[block.part];
        let tangents = self.tangents(block.part, block.run);
        let touched = self.layout.columns.touched_by(self.run_index(block.part, block.run));
        // For each tangent, the local columns that move it.
        let movers: Vec<Vec<(usize, f64)>> = tangents
            .iter()
            .map(|(instance, component)| {
                self.layout
                    .columns_of(*instance, *component)
                    .into_iter()
                    .filter_map(|(column, coefficient)| {
                        Some((touched.iter().position(|t| *t == column)?, coefficient))
                    })
                    .collect()
            })
            .collect();
        let chunks: Vec<Vec<[Gradient<CHUNK>; 4]>> = chunked(&tangents)
            .map(|chunk| self.seeded_parameters(block.part, block.run, point, chunk))
            .collect();
        let randoms = vec![Gradient::<CHUNK>::constant(0.0); part.random_sigma.len()];
        let mut workspace = Vec::new();
        let mut jacobian = DMatrix::zeros(part.residual_count(), touched.len());
        let mut values = vec![0.0; part.residual_count()];
        for sample in block.start..block.end {
            jacobian.fill(0.0);
            values.fill(0.0);
            for (number, parameters) in chunks.iter().enumerate() {
                let leaves = SampleLeaves {
                    parameters,
                    randoms: &randoms,
                    columns: part.columns(),
                    run: &part.runs[block.run],
                    sample,
                };
                let outputs = part.evaluate(&leaves, &mut workspace);
                for slot in part.slots() {
                    if !part.is_present(block.run, sample, slot) {
                        continue;
                    }
                    let residual = part.residual(block.run, sample, slot, outputs);
                    for (component, residual) in residual.iter().take(slot.components).enumerate() {
                        let row = slot.residual + component;
                        values[row] = residual.value();
                        let first = number * CHUNK;
                        for (movers, slope) in movers.iter().skip(first).zip(partials(residual)) {
                            for (column, coefficient) in movers {
                                jacobian[(row, *column)] -= coefficient * slope;
                            }
                        }
                    }
                }
            }
            visit(sample, &jacobian, &values);
        }
    }

    /// `reading - prediction` of each sample of a run at a point, not whitened; one vector a sample,
    /// NaN where there is no reading.
    pub fn residuals(&self, p: usize, run: usize, point: &Point) -> Vec<Vec<f64>> {
        let part = &self.parts[p];
        let parameters = self.parameters::<f64>(p, run, point);
        let randoms = vec![0.0; part.random_sigma.len()];
        let mut workspace = Vec::new();
        (0..part.runs[run].record.len())
            .map(|sample| {
                let leaves = SampleLeaves {
                    parameters: &parameters,
                    randoms: &randoms,
                    columns: part.columns(),
                    run: &part.runs[run],
                    sample,
                };
                let outputs = part.evaluate(&leaves, &mut workspace);
                let mut values = vec![f64::NAN; part.residual_count()];
                for slot in part.slots() {
                    if part.is_present(run, sample, slot) {
                        let residual = part.residual(run, sample, slot, outputs);
                        values[slot.residual..slot.residual + slot.components]
                            .copy_from_slice(&residual[..slot.components]);
                    }
                }
                values
            })
            .collect()
    }

    /// Sum of squares of the whitened residuals of a run.
    fn run_cost(&self, part: usize, run: usize, point: &Point) -> f64 {
        let whitening = &self.whitening[part][run];
        self.residuals(part, run, point)
            .into_iter()
            .enumerate()
            .map(|(sample, mut values)| {
                for (slot, present) in self.parts[part]
                    .slots()
                    .iter()
                    .map(|slot| (slot, self.parts[part].is_present(run, sample, slot)))
                {
                    if !present {
                        values[slot.residual..slot.residual + slot.components].fill(0.0);
                    }
                }
                whitening.apply_to(sample, &mut values);
                values.iter().map(|value| value * value).sum::<f64>()
            })
            .sum()
    }

    fn block_gram(&self, block: Block, point: &Point) -> RunGram {
        let part = &self.parts[block.part];
        let size = self.layout.columns.touched_by(self.run_index(block.part, block.run)).len();
        let whitening = &self.whitening[block.part][block.run];
        let mut rows = DMatrix::zeros(part.residual_count(), size + 1);
        let mut gram = DMatrix::zeros(size + 1, size + 1);
        let mut readings = 0;
        self.visit_block(block, point, &mut |sample, jacobian, residual| {
            rows.view_mut((0, 0), (residual.len(), size)).copy_from(jacobian);
            for (row, value) in residual.iter().enumerate() {
                rows[(row, size)] = *value;
            }
            whitening.apply(sample, &mut rows);
            gram.gemm_tr(1.0, &rows, &rows, 1.0);
            readings +=
                part.slots().iter().filter(|slot| part.is_present(block.run, sample, slot)).count();
        });
        RunGram { gram, readings }
    }
}

/// Tangents by chunks of the engine; one empty chunk where there are none, for the values.
fn chunked(tangents: &[(usize, usize)]) -> impl Iterator<Item = &[(usize, usize)]> {
    let empty = tangents.is_empty().then_some(tangents);
    tangents.chunks(CHUNK).chain(empty)
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
        let runs: Vec<(usize, usize)> = (0..self.parts.len())
            .flat_map(|part| (0..self.parts[part].runs.len()).map(move |run| (part, run)))
            .collect();
        let costs: Vec<f64> =
            runs.par_iter().map(|(part, run)| self.run_cost(*part, *run, point)).collect();
        let priors: f64 = point.priors(&self.layout).iter().map(|row| row.residual.powi(2)).sum();
        costs.iter().sum::<f64>() + priors
    }

    fn normal(&self, point: &Point) -> Normal {
        let blocks = self.blocks();
        let grams: Vec<RunGram> =
            blocks.par_iter().map(|block| self.block_gram(*block, point)).collect();
        let columns = self.layout.columns.clone();
        let mut runs: Vec<RunGram> = (0..columns.runs.len())
            .map(|run| {
                let size = columns.touched_by(run).len() + 1;
                RunGram { gram: DMatrix::zeros(size, size), readings: 0 }
            })
            .collect();
        for (block, gram) in blocks.iter().zip(grams) {
            let run = &mut runs[self.run_index(block.part, block.run)];
            run.gram += gram.gram;
            run.readings += gram.readings;
        }
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
