//! Covariance and correlations of the estimates as people read them.
//!
//! Two estimates that are correlated are badly known each by itself and well in one combination:
//! the first less its regression on the second, which has the least uncertainty of all.

use nalgebra::DMatrix;

use crate::estimate::calibrate::{Calibration, Estimate};
use crate::estimate::combination::{Combination, component_names, quotient};
use crate::estimate::withheld::sensitivities;

/// Correlations beyond this are worth a word.
pub const HIGH: f64 = 0.9;
/// Estimates up to which there is a matrix of all of them.
pub const MOST: usize = 2000;

/// The estimates that vary, and their covariance (SI).
#[derive(Clone, Debug)]
pub struct Covariance {
    /// Those that were estimated and are determined, in the order of [`Calibration::estimates`].
    pub estimates: Vec<Estimate>,
    /// Their names, with `@` and the setup or run where a parameter has several values.
    pub names: Vec<String>,
    /// Row and column of each.
    pub matrix: DMatrix<f64>,
}

/// Two estimates that are correlated.
#[derive(Clone, Debug)]
pub struct Correlated {
    /// Their names.
    pub names: [String; 2],
    /// Between -1 and 1.
    pub correlation: f64,
    /// Their combination that is known best.
    pub combination: Combination,
}

/// The covariance of the estimates; `None` where the fit is no result, or there are more than
/// [`MOST`].
pub fn covariance_of_estimates(result: &Calibration) -> Option<Covariance> {
    if !result.fit.outcome.is_result() {
        return None;
    }
    let layout = &result.problem.layout;
    let (mut estimates, mut names, mut rows) = (Vec::new(), Vec::new(), Vec::new());
    for index in 0..layout.instances.len() {
        let all = result.estimates_of(index);
        if all.is_empty() {
            continue;
        }
        let own = sensitivities(layout, &result.fit.point, index);
        let called = component_names(&result.problem, index);
        for ((one, row), name) in all.into_iter().zip(own).zip(called) {
            if one.value.is_some() && one.bound.is_none() && one.sigma.is_some_and(|u| u > 0.0) {
                estimates.push(one);
                rows.push(row);
                names.push(name);
            }
        }
    }
    if rows.len() > MOST {
        return None;
    }
    let mut matrix = DMatrix::zeros(rows.len(), rows.len());
    for i in 0..rows.len() {
        for j in 0..=i {
            let mut sum = 0.0;
            for (a, p) in &rows[i] {
                for (b, q) in &rows[j] {
                    sum += p * q * result.covariance[(*a, *b)];
                }
            }
            matrix[(i, j)] = sum;
            matrix[(j, i)] = sum;
        }
    }
    Some(Covariance { estimates, names, matrix })
}

impl Covariance {
    /// Pairs whose correlation is beyond [`HIGH`], the strongest first.
    pub fn correlated(&self) -> Vec<Correlated> {
        let mut found = Vec::new();
        for i in 0..self.names.len() {
            for j in i + 1..self.names.len() {
                let sigma = |k: usize| self.matrix[(k, k)].sqrt();
                let correlation = self.matrix[(i, j)] / (sigma(i) * sigma(j));
                if correlation.abs() > HIGH && correlation.is_finite() {
                    found.push(self.pair(i, j, correlation.clamp(-1.0, 1.0)));
                }
            }
        }
        found.sort_by(|a, b| b.correlation.abs().total_cmp(&a.correlation.abs()));
        found
    }

    fn pair(&self, i: usize, j: usize, correlation: f64) -> Correlated {
        let factor = -self.matrix[(i, j)] / self.matrix[(j, j)];
        let variance = self.matrix[(i, i)] * (1.0 - correlation * correlation);
        let (first, other) = (&self.estimates[i], &self.estimates[j]);
        let unit = quotient(&first.declared, &other.declared);
        let value = |one: &Estimate| one.value.unwrap_or(f64::NAN);
        Correlated {
            names: [self.names[i].clone(), self.names[j].clone()],
            correlation,
            combination: Combination {
                terms: vec![(self.names[i].clone(), 1.0), (self.names[j].clone(), factor)],
                factor_units: vec!["1".to_owned(), unit],
                value: value(first) + factor * value(other),
                sigma: variance.max(0.0).sqrt(),
                declared: first.declared.clone(),
            },
        }
    }
}
