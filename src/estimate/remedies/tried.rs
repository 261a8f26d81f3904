//! Whether further rows determine a direction: the sums with them, examined again.

use nalgebra::DMatrix;

use crate::engine::gram::{Normal, PriorRow};
use crate::estimate::arrow::normal_matrix;
use crate::estimate::observability::{Direction, Kind, Limit, UNOBSERVABLE, examine};
use crate::estimate::remedies::Open;

/// The sums of a fit, to which rows can be added.
#[derive(Debug)]
pub(super) struct Tried<'a> {
    normal: &'a Normal,
    limits: &'a [Limit],
    direction: &'a Direction,
    /// Directions that are open without a remedy.
    before: usize,
    /// Length of each column.
    lengths: Vec<f64>,
}

impl<'a> Tried<'a> {
    pub(super) fn new(open: &Open<'a>, at: usize) -> Self {
        let count = open.normal.columns.len();
        let lengths = normal_matrix(open.normal).map_or_else(
            |_| vec![0.0; count],
            |(hessian, _)| (0..count).map(|i| hessian[(i, i)].max(0.0).sqrt()).collect(),
        );
        Self {
            normal: open.normal,
            limits: open.limits,
            direction: &open.directions[at],
            before: open.directions.len(),
            lengths,
        }
    }

    /// Whether values stated of these components determine the direction; each component is a sum
    /// of columns with factors. A value is as good as the readings are for the column by itself.
    pub(super) fn determined_by_values(&self, components: &[Vec<(usize, f64)>]) -> bool {
        let mut normal = self.normal.clone();
        let mut limits = self.limits.to_vec();
        limits.resize(normal.columns.len(), Limit::Unlimited);
        for component in components {
            let length = component.iter().map(|(column, _)| self.lengths[*column]);
            let length = length.fold(0.0, f64::max);
            let by = if length > 0.0 { length } else { 1.0 };
            let coefficients = component.iter().map(|(column, factor)| (*column, factor * by));
            normal.priors.push(PriorRow { coefficients: coefficients.collect(), residual: 0.0 });
            if let [(column, _)] = component[..] {
                limits[column] = Limit::Stated;
            }
        }
        self.is_determined(&normal, &limits)
    }

    /// Whether further sums of products over the first columns that a run touches determine it.
    pub(super) fn determined_by_run(&self, run: usize, more: &DMatrix<f64>) -> bool {
        let mut normal = self.normal.clone();
        let mut view = normal.runs[run].gram.view_mut((0, 0), more.shape());
        view += more;
        self.is_determined(&normal, self.limits)
    }

    fn is_determined(&self, normal: &Normal, limits: &[Limit]) -> bool {
        let Ok(after) = examine(normal, limits) else { return false };
        if after.directions.len() >= self.before {
            return false;
        }
        // Another direction may be the one that is gone. Of a plausible size that is exceeded, the
        // parameter that exceeds it says so: readings answer along the direction all the same.
        let lead = |one: &Direction| one.weights.first().map(|(column, _)| *column);
        if self.direction.is_implausible {
            return after.directions.iter().all(|one| lead(one) != lead(self.direction));
        }
        // Any other direction must be among those that answer.
        let Ok((hessian, _)) = normal_matrix(normal) else { return false };
        let length = |column: usize| hessian[(column, column)].max(0.0).sqrt();
        let weights = &self.direction.weights;
        let square: f64 =
            weights.iter().map(|(column, weight)| (weight * length(*column)).powi(2)).sum();
        let mut answer = 0.0;
        for (i, a) in weights {
            for (j, b) in weights {
                answer += a * b * hessian[(*i, *j)];
            }
        }
        let ratio = (answer.max(0.0) / square).sqrt();
        match self.direction.kind {
            Kind::Exact => ratio > UNOBSERVABLE,
            Kind::UpToNoise => ratio > 2.0 * self.direction.singular_value,
        }
    }
}
