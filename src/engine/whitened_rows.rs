//! The whitened rows of a campaign shown one after the other: for sums that are grouped otherwise
//! than by run, and for the residuals of a linearised model.
//!
//! It sums nothing.

use crate::campaign::Stretch;
use crate::engine::gauss_markov::Gains;
use crate::engine::kept::Memory;
use crate::engine::lanes::{LANES, Lanes};
use crate::engine::point::Point;
use crate::engine::problem::Problem;
use crate::engine::signatures::Signatures;

/// One whitened row of the samples of a chunk.
#[derive(Clone, Copy, Debug)]
pub struct WhitenedLanes<'a> {
    /// Index of the run in its campaign.
    pub run: usize,
    /// Which residual component.
    pub row: usize,
    /// Number of columns: those that the run touches, then those of the signatures.
    pub columns: usize,
    /// The samples; lanes beyond them are zero.
    pub stretch: Stretch<'a>,
    /// 0 where there is no reading.
    pub weights: &'a Lanes,
    /// Of the filter along time, where the noise of the row is autocorrelated.
    pub gains: Option<&'a [Gains; LANES]>,
    /// The whitened residual.
    pub residual: &'a Lanes,
    /// The directions on which the row hangs.
    pub directions: &'a [usize],
    /// For each direction of the program the columns that move it, and by how much: those that the
    /// run touches, then those of the signatures.
    pub movers: &'a [Vec<(usize, f64)>],
    /// The derivatives along the directions.
    pub slopes: &'a [&'a Lanes],
}

impl WhitenedLanes<'_> {
    /// Whether there is a reading.
    pub fn is_present(&self, lane: usize) -> bool {
        lane < self.stretch.len && self.weights[lane] != 0.0
    }

    /// Of the filter at a sample.
    pub fn gains_at(&self, lane: usize) -> Option<&Gains> {
        self.gains.map(|gains| &gains[lane])
    }

    /// Puts the row of one sample into a vector: one number a column, then the residual.
    pub fn put(&self, lane: usize, into: &mut Vec<f64>) {
        into.clear();
        into.resize(self.columns, 0.0);
        for (direction, slope) in self.directions.iter().zip(self.slopes) {
            for (column, by) in &self.movers[*direction] {
                into[*column] += by * slope[lane];
            }
        }
        into.push(self.residual[lane]);
    }
}

impl Problem {
    /// Shows the whitened rows of a campaign at a point, the signatures' columns after those that
    /// the run touches.
    pub fn visit_whitened(
        &self,
        signatures: &Signatures,
        point: &Point,
        visit: &mut dyn FnMut(WhitenedLanes<'_>),
    ) {
        let plans = self.plans_with(signatures, point);
        let mut memory = Memory::default();
        for block in self.blocks() {
            if block.part != signatures.part() {
                continue;
            }
            let plan = &plans[block.run];
            self.walk_rows(block, &signatures.program, plan, &mut memory, &mut |row| {
                visit(WhitenedLanes {
                    run: block.run,
                    row: row.index,
                    columns: plan.size - 1,
                    stretch: row.chunk.stretch(),
                    weights: row.weights,
                    gains: row.gains,
                    residual: row.lanes[0],
                    directions: row.directions,
                    movers: &plan.movers,
                    slopes: &row.lanes[1..],
                });
            });
        }
    }
}
