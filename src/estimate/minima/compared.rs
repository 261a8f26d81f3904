//! Whether a fit from another start is another minimum, which the readings cannot exclude.

use crate::engine::gram::{LeastSquares, RunGram};
use crate::engine::{Point, Problem};
use crate::estimate::minima::thinned::{Thinned, Tried};

use super::{EXCLUDED, NEAR};

/// Iterations on a part of the samples and where two minima are compared.
pub(super) const ITERATIONS: [usize; 2] = [40, 60];
/// Other minima are so many standard uncertainties away at least: there, a sum of squares without
/// another minimum is larger by twice what excludes it.
pub(super) const APART: f64 = 10.0;

/// Some samples on which minima are compared with the estimate.
pub(super) struct Compared {
    pub(super) problem: Problem,
    /// How many times more readings there are.
    times: f64,
    pub(super) here: Tried,
}

impl Compared {
    /// About so many samples, fitted from the estimate; `None` where the model has no values.
    pub(super) fn of(problem: &Problem, point: &Point, most: usize) -> Option<Self> {
        let thinned = Thinned::of(problem, most);
        let own = thinned.late_by(0.0, &[])?;
        let here = Tried::fit(own.clone(), point.clone(), 0.0, ITERATIONS[1])?;
        Some(Self { problem: own, times: thinned.times, here })
    }

    /// How much chi squared of these samples grows with the square of a step along a column, all
    /// else held: the diagonal of the normal matrix, which no rounding of a difference reaches.
    pub(super) fn curvature(&self, column: usize) -> f64 {
        let normal = self.problem.normal(&self.here.point);
        let of = |(run, sums): (usize, &RunGram)| {
            let at = normal.columns.touched_by(run).iter().position(|own| *own == column);
            at.map_or(0.0, |at| sums.gram[(at, at)])
        };
        normal.runs.iter().enumerate().map(of).sum()
    }

    /// How much larger chi squared of all readings is.
    pub(super) fn excess(&self, there: &Tried) -> f64 {
        self.times * (there.chi_squared - self.here.chi_squared)
    }

    /// The excess up to which the readings cannot exclude a minimum.
    fn limit(&self) -> f64 {
        EXCLUDED * self.here.variance_factor.max(1.0)
    }

    /// Whether a fit to few samples fits so well that more of them are worth a look.
    pub(super) fn may_be_another(&self, there: &Tried) -> bool {
        there.variance_factor < NEAR * self.here.variance_factor.max(1.0)
    }

    /// Whether a fit that ended elsewhere is another minimum, which the readings cannot exclude:
    /// halfway to it the fit is worse.
    pub(super) fn is_another(&self, there: &Tried) -> bool {
        let is_alike = self.excess(there) < self.limit();
        is_alike && {
            let layout = &self.problem.layout;
            let step = self.here.point.step_to(layout, &there.point) * 0.5;
            let halfway = self.here.point.moved(layout, step.as_slice());
            let worse = self.problem.cost(&halfway) - there.chi_squared.max(self.here.chi_squared);
            // A model without a value there has a barrier, too.
            self.times * worse > self.limit() || worse.is_nan()
        }
    }
}
