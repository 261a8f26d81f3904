//! Columns that the cost does not bear out: derivatives that cancel to the last digit, not to zero, as
//! those of a height where an offset begins at zero. Scaled to its own length such a column asks for a
//! step of 1e16, and damping that tames it leaves all others no step at all.
//!
//! No length distinguishes rounding from an unknown in a large unit. So columns far shorter than the
//! longest are tried: a step along one of them must change the cost as its derivatives predict. A
//! column that was confirmed once stays so, for the scale of the damping has its length from then on.

use crate::engine::gram::{LeastSquares, Normal};
use crate::estimate::arrow::Arrow;

/// Squared length, in parts of the longest column's, below which a column is tried.
const SHORT: f64 = 1e-18;
/// Lengths of the steps that are tried, in parts of all residuals': long enough to change the cost
/// by more than its rounding, too short for a model to bend.
const TRIED: [f64; 2] = [1e-3, 3e-5];
/// How far a change of the cost may be off its prediction, in parts of it.
const OFF: f64 = 0.5;
/// ... and in parts of the cost: its own rounding.
const ROUNDING: f64 = 1e-11;

/// Which columns were confirmed so far.
pub(super) struct Rounding(Vec<bool>);

impl Rounding {
    pub(super) fn new(unknowns: usize) -> Self {
        Self(vec![false; unknowns])
    }

    /// Puts zeros into the columns that the cost does not bear out; whether there are any.
    pub(super) fn zero_columns<P: LeastSquares>(
        &mut self,
        problem: &P,
        point: &P::Point,
        (normal, arrow, cost): (&mut Normal, &Arrow, f64),
        evaluations: &mut usize,
    ) -> bool {
        let squares = arrow.diagonal();
        let least = SHORT * squares.max();
        let mut is_borne_out = |column: usize| {
            let mut steps = TRIED.iter().flat_map(|part| [*part, -part]);
            steps.any(|part| {
                let step = part * (cost / squares[column]).sqrt();
                let mut all = vec![0.0; squares.len()];
                all[column] = step;
                *evaluations += 1;
                let change = problem.cost(&problem.moved(point, &all)) - cost;
                let slope = 2.0 * arrow.gradient()[column];
                let predicted = squares[column] * step.powi(2) - slope * step;
                (change - predicted).abs() <= OFF * predicted.abs() + ROUNDING * cost
            })
        };
        let mut rounding = Vec::new();
        for (column, is_confirmed) in self.0.iter_mut().enumerate().filter(|one| !*one.1) {
            *is_confirmed = squares[column] >= least && squares[column] > 0.0;
            if !*is_confirmed && squares[column] > 0.0 {
                *is_confirmed = is_borne_out(column);
                rounding.extend((!*is_confirmed).then_some(column));
            }
        }
        normal.zero_columns(|column| rounding.contains(&column));
        !rounding.is_empty()
    }
}
