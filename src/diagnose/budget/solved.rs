//! Values of a budget with their covariance. The values of rows have no prior; those of a remainder in
//! which there are blocks have: normal about zero, as wide as what was found of the remainder.
//!
//! A block of the remainder may contain nearly all of a row's form. Without a prior it would take
//! the row's value with it, and what is left to the row would be a small difference of large values.
//! With it the row keeps what both may explain, with a standard uncertainty that says how much of it
//! the remainder may be. It does not say which terms are in the budget.

use std::collections::BTreeMap;
use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use crate::engine::Problem;
use crate::estimate::calibrate::{Calibration, Estimate};
use crate::estimate::covariance::of_combination;
use crate::estimate::eigen;

use super::in_fit::columns_of;
use super::linear::Linear;
use super::selection::Selection;
use super::selection::normal::Beside;
use crate::diagnose::price::Gain;

/// Least mean square of a value of the remainder, in its own standard uncertainties, that its prior
/// has.
const LEAST: f64 = 1e-3;

/// Weight of what nominal parameters absorb of a block, beside what it does beyond them.
const ABSORBED_PART: f64 = 0.1;

/// Least eigenvalue of the cosines between the columns of a block from which on the readings tell these
/// apart.
const SEPARATE: f64 = 0.1;

/// The values of a budget's columns: nominal ones, then those of its terms in order.
#[derive(Clone, Debug)]
pub struct Solved {
    pub(super) values: DVector<f64>,
    pub(super) covariance: DMatrix<f64>,
    /// The columns of each term.
    pub(super) terms: Vec<Range<usize>>,
    /// By how much blocks move values.
    shifts: DVector<f64>,
}

impl Solved {
    /// Of a model whose terms at `rest` are the remainder.
    pub fn of(selection: &Selection<'_>, model: &[usize], rest: &[usize], gains: &[Gain]) -> Self {
        let terms = selection.ranges(model);
        // Beside blocks an effect without a name may be what imitates them.
        let has_blocks = rest.iter().any(|at| !selection.terms[model[*at]].is_effect());
        let priors: Vec<(usize, DMatrix<f64>)> = rest
            .iter()
            .filter(|_| has_blocks)
            .filter_map(|at| Some((terms[*at].start, prior(selection, model[*at], gains[*at])?)))
            .collect();
        let (values, covariance) = selection.factored_under(model, &priors).solved();
        let shifts = DVector::zeros(values.len());
        Self { values, covariance, terms, shifts }
    }

    /// The values of a term, by its place in the model.
    pub fn of_term(&self, at: usize) -> &[f64] {
        &self.values.as_slice()[self.terms[at].clone()]
    }

    /// With what blocks move the values by, where residuals beside them are autocorrelated: then their form is
    /// not that of the remainder, and may be that of a row.
    pub fn with_shifts(
        mut self,
        selection: &Selection<'_>,
        model: &[usize],
        rest: &[usize],
        gains: &[Gain],
    ) -> Self {
        let is_open = |at: &usize| {
            let own = &selection.terms[model[*at]];
            rest.contains(at) && !own.is_effect() && own.change.is_none()
        };
        let kept: Vec<usize> = (0..model.len()).filter(|at| !is_open(at)).collect();
        if kept.len() == model.len() {
            return self;
        }
        let terms: Vec<usize> = kept.iter().map(|at| model[*at]).collect();
        let gains: Vec<Gain> = kept.iter().map(|at| gains[*at]).collect();
        let rest: Vec<usize> = (0..kept.len()).filter(|own| rest.contains(&kept[*own])).collect();
        let without = Self::of(selection, &terms, &rest, &gains);
        for (at, range) in kept.iter().zip(&without.terms) {
            let shift = self.values.rows(self.terms[*at].start, range.len())
                - without.values.rows(range.start, range.len());
            self.shifts.rows_mut(self.terms[*at].start, range.len()).copy_from(&shift);
        }
        self
    }

    /// The values of a row beside the whole budget.
    pub fn values(
        &self,
        linear: &Linear,
        name: &str,
        at: usize,
        explained: &Calibration,
    ) -> Vec<Estimate> {
        let Self { values, covariance, .. } = self;
        let first = self.terms[at].start;
        let own: Vec<usize> =
            columns_of(&linear.fitted, name).into_iter().map(|(column, _)| column).collect();
        let layout = &linear.fitted.problem.layout;
        let prefix = format!("{name}.");
        let mut component: BTreeMap<usize, usize> = BTreeMap::new();
        let all = explained.estimates().into_iter().filter(|one| one.name.starts_with(&prefix));
        all.map(|mut one| {
            let Some(instance) = one.instance else { return one };
            let k = component.entry(instance).or_default();
            let columns = layout.columns_of(instance, *k);
            *k += 1;
            let place = |column: usize| own.iter().position(|own| *own == column);
            let placed: Vec<(usize, f64)> = columns
                .iter()
                .filter_map(|(column, by)| Some((first + place(*column)?, *by)))
                .collect();
            if placed.is_empty() || one.value.is_none() || one.sigma.is_none() {
                return one;
            }
            let value: f64 = placed.iter().map(|(column, by)| by * values[*column]).sum();
            // The value is somewhere between that beside the blocks and that without them, uniformly (GUM,
            // type B).
            let shift: f64 = placed.iter().map(|(column, by)| by * self.shifts[*column]).sum();
            let variance = of_combination(covariance, &placed).max(0.0) + shift.powi(2) / 3.0;
            one.value = Some(value);
            one.sigma = Some(variance.sqrt());
            one
        })
        .collect()
    }
}

/// The inverse covariance of the values of a term of the remainder beforehand: in the metric of what
/// it does beyond the nominal parameters, with the mean square, per degree of freedom, of what was found beyond noise: what rows
/// hide of it is not taken to be larger than what is seen, and what nominal parameters absorb of it not to be
/// larger than ten times that. An effect that multiplies a reading is proportional to what a nominal gain
/// and a block may exchange. Columns that the readings tell apart, as waves
/// over whole turns, have values that are independent: a row of the first order keeps its value beside
/// waves of the second, however unevenly the angles were visited.
fn prior(selection: &Selection<'_>, term: usize, gain: Gain) -> Option<DMatrix<f64>> {
    let Beside { left, across, .. } = selection.alone(term);
    let alone = left + across.tr_mul(&across) * ABSORBED_PART.powi(2);
    let mean_square = (gain.excess() / gain.degrees.max(1) as f64).max(LEAST);
    if !alone.iter().all(|value| value.is_finite()) {
        return None;
    }
    let squares = alone.diagonal();
    let cosines = DMatrix::from_fn(squares.len(), squares.len(), |i, j| {
        alone[(i, j)] / (squares[i] * squares[j]).sqrt()
    });
    let least = eigen::symmetric(cosines).map_or(0.0, |own| own.eigenvalues.min());
    let metric = if least >= SEPARATE { DMatrix::from_diagonal(&squares) } else { alone };
    Some(metric / mean_square)
}

/// The ratio of the largest value to its typical magnitude.
pub fn ratio_to_typical(problem: &Problem, values: &[Estimate]) -> Option<f64> {
    let ratio = |one: &Estimate| {
        let typical = problem.layout.instances[one.instance?].setting.typical?;
        Some(one.value?.abs() / typical)
    };
    values.iter().filter_map(ratio).reduce(f64::max)
}
