//! A problem of which some unknowns stay where they are.
//!
//! Far from the solution a step of a delay absorbs errors of other parameters: beside a gain that starts a tenth of
//! what it is, a step in the delay is ten times too long, and the fit ends in another period of the
//! motion. A start is tried with its delays held first, so that the others follow the readings
//! before the delays move.

use crate::engine::gram::{Columns, LeastSquares, Normal, PriorRow};
use crate::engine::{Point, Problem};

/// The weight that holds a column: far above that of any readings, in whatever unit.
const HOLDING: f64 = 1e15;

/// A problem with some of its instances held where they are.
pub(super) struct Held<'p> {
    problem: &'p mut Problem,
    columns: Vec<usize>,
}

impl<'p> Held<'p> {
    pub(super) fn new(problem: &'p mut Problem, instances: &[usize]) -> Self {
        let layout = &problem.layout;
        let own = |index: &usize| layout.own_columns(*index).map(|(_, column)| column);
        let columns = instances.iter().flat_map(own).collect();
        Self { problem, columns }
    }

    pub(super) fn of_columns(problem: &'p mut Problem, columns: Vec<usize>) -> Self {
        Self { problem, columns }
    }
}

impl LeastSquares for Held<'_> {
    type Point = Point;

    fn columns(&self) -> &Columns {
        self.problem.columns()
    }

    fn reweight(&mut self, point: &Point) {
        self.problem.reweight(point);
    }

    fn weights_move(&self) -> bool {
        self.problem.weights_move()
    }

    fn cost(&self, point: &Point) -> f64 {
        self.problem.cost(point)
    }

    /// With knowledge of each column held: its step is none. It adds nothing to the cost.
    fn normal(&self, point: &Point) -> Normal {
        let mut normal = self.problem.normal(point);
        let held = self
            .columns
            .iter()
            .map(|column| PriorRow { coefficients: vec![(*column, HOLDING)], residual: 0.0 });
        normal.priors.extend(held);
        normal
    }

    fn moved(&self, point: &Point, step: &[f64]) -> Point {
        self.problem.moved(point, step)
    }

    fn step_bounds(&self, point: &Point) -> Vec<(f64, f64)> {
        self.problem.step_bounds(point)
    }
}
