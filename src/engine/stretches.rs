//! What a step leaves of the readings, and its products with all columns summed over stretches.
//!
//! Sums over stretches of consecutive samples say how scores scatter, whatever the noise is like
//! within a stretch: what a sandwich estimate of uncertainty needs (Huber 1967; Liang and Zeger
//! 1986).

use std::sync::Arc;

use nalgebra::DVector;

use crate::engine::blocks::{BLOCK, Block, Plan, WhitenedRow};
use crate::engine::kept::{Memories, Memory};
use crate::engine::lanes::{LANES, Lanes};
use crate::engine::point::Point;
use crate::engine::problem::Problem;
use crate::engine::signatures::Signatures;

/// What a step leaves of one run.
#[derive(Clone, Debug, Default)]
pub struct Left {
    /// For each residual component its whitened residuals, one a sample; NaN where there is no
    /// reading. Shared by all that look at them: there is one for each reading.
    pub residuals: Vec<Arc<Vec<f64>>>,
    /// For each stretch the products of what is left with the columns that the run touches and
    /// those of the signatures.
    pub scores: Vec<DVector<f64>>,
}

impl Problem {
    /// Takes a step off the residuals of every run of a campaign (`residual - J step`, whitened)
    /// and sums over stretches of so many samples. `steps` holds for each run one number for each
    /// column that it touches, then one for each of the signatures.
    pub fn left(
        &self,
        signatures: &Signatures,
        point: &Point,
        steps: &[Vec<f64>],
        length: usize,
    ) -> Vec<Left> {
        let part = signatures.part();
        let rows = self.parts[part].residual_count();
        let more = signatures.columns.len();
        let plans: Vec<Plan> =
            (0..self.parts[part].runs.len()).map(|run| self.plan(part, run, point, more)).collect();
        let mut left: Vec<Left> = plans
            .iter()
            .zip(&self.parts[part].runs)
            .map(|(plan, run)| Left {
                residuals: (0..rows)
                    .map(|_| Arc::new(Vec::with_capacity(run.record.len())))
                    .collect(),
                scores: vec![
                    DVector::zeros(plan.size - 1);
                    run.record.len().div_ceil(length.max(1))
                ],
            })
            .collect();
        self.in_order(
            &Memories::default(),
            rows * BLOCK,
            |block| block.part == part,
            |memory, block| {
                let plan = &plans[block.run];
                self.block_left(block, signatures, plan, &steps[block.run], length.max(1), memory)
            },
            |block, made| {
                let whole = &mut left[block.run];
                for (all, own) in whole.residuals.iter_mut().zip(made.residuals) {
                    Arc::make_mut(all).extend_from_slice(&own);
                }
                for (number, own) in made.scores.iter().enumerate() {
                    whole.scores[block.start / length.max(1) + number] += own;
                }
            },
        );
        left
    }

    fn block_left(
        &self,
        block: Block,
        signatures: &Signatures,
        plan: &Plan,
        step: &[f64],
        length: usize,
        memory: &mut Memory,
    ) -> Left {
        let program = &signatures.program;
        let mut made = Summing {
            left: Left {
                residuals: program.rows.iter().map(|_| Arc::default()).collect(),
                scores: Vec::new(),
            },
            plan,
            step,
            length,
            // Number of the block's first stretch.
            first: block.start / length,
        };
        self.walk_rows(block, program, plan, memory, &mut |row| made.add(row));
        made.left
    }
}

/// Sums of one block as they grow.
struct Summing<'a> {
    left: Left,
    plan: &'a Plan,
    step: &'a [f64],
    length: usize,
    first: usize,
}

impl Summing<'_> {
    fn add(&mut self, row: WhitenedRow<'_>) {
        let WhitenedRow { lanes, directions, chunk, weights, .. } = row;
        let (start, len) = (chunk.first, chunk.len);
        let mut left: Lanes = *lanes[0];
        let slope = |direction: usize| -> f64 {
            self.plan.movers[direction].iter().map(|(column, by)| by * self.step[*column]).sum()
        };
        for (direction, column) in directions.iter().zip(&lanes[1..]) {
            let by = slope(*direction);
            if by != 0.0 {
                for lane in 0..LANES {
                    left[lane] -= by * column[lane];
                }
            }
        }
        let read = left[..len].iter().zip(weights);
        Arc::make_mut(&mut self.left.residuals[row.index])
            .extend(read.map(|(value, weight)| if *weight == 0.0 { f64::NAN } else { *value }));
        let mut from = 0;
        while from < len {
            let stretch = (start + from) / self.length;
            let to = len.min((stretch + 1) * self.length - start);
            let number = stretch - self.first;
            while self.left.scores.len() <= number {
                self.left.scores.push(DVector::zeros(self.plan.size - 1));
            }
            let scores = &mut self.left.scores[number];
            for (direction, column) in directions.iter().zip(&lanes[1..]) {
                let sum: f64 =
                    left[from..to].iter().zip(&column[from..to]).map(|(a, b)| a * b).sum();
                for (place, by) in &self.plan.movers[*direction] {
                    scores[*place] += by * sum;
                }
            }
            from = to;
        }
    }
}
