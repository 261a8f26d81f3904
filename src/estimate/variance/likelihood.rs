//! The likelihood of the levels: what each sample contributes to its gradient and to Fisher's information.

use nalgebra::{DMatrix, DVector};

use crate::campaign::Sample as Seen;
use crate::engine::noise::{active_randoms, covariance_of};
use crate::engine::part::Part;
use crate::engine::point::Point;
use crate::engine::problem::Problem;
use crate::system::RandomSetting;

/// A level to be estimated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Unknown {
    /// Standard deviation of the random quantity of this name, in every campaign that leaves it
    /// free.
    Random(String),
    /// An instance that acts on noise alone.
    Instance(usize),
}

/// The unknown that is the level of a random quantity.
fn level_of(random: &RandomSetting, unknown: &[Unknown]) -> Option<usize> {
    let is_it = |one: &Unknown| matches!(one, Unknown::Random(name) if *name == random.name);
    unknown.iter().position(is_it).filter(|_| !random.fixed)
}

/// What the likelihood of one sample needs.
pub(super) struct Sample {
    pub(super) residual: DVector<f64>,
    /// Stated variance of each component at factor 1, and 1 where there is no reading.
    stated: DVector<f64>,
    /// Factor at the current point and its slopes by unknown.
    factor: DVector<f64>,
    slopes: DMatrix<f64>,
    /// Derivatives by random quantity.
    sensitivities: DMatrix<f64>,
    /// For each column of `sensitivities`, the index of its unknown or its fixed variance.
    source: Vec<Result<usize, f64>>,
}

pub(super) fn gather(
    problem: &Problem,
    point: &Point,
    unknown: &[Unknown],
    share: f64,
) -> Vec<Sample> {
    let mut samples = Vec::new();
    for (p, part) in problem.parts.iter().enumerate() {
        // Unknown levels that stand at zero must stay visible to the score.
        let mut visible = part.clone();
        for (k, random) in part.system.randoms.iter().enumerate() {
            if level_of(random, unknown).is_some() {
                visible.random_sigma[k] = visible.random_sigma[k].max(f64::MIN_POSITIVE.sqrt());
            }
        }
        let active = active_randoms(&visible);
        for r in 0..part.runs.len() {
            let source: Vec<Result<usize, f64>> = active
                .iter()
                .map(|k| {
                    let found = level_of(&part.system.randoms[*k], unknown);
                    found.ok_or(part.random_sigma_in(r, *k).powi(2))
                })
                .collect();
            let to = &mut samples;
            gather_run(problem, &visible, (p, r), point, unknown, &active, &source, share, to);
        }
    }
    samples
}

#[expect(clippy::too_many_arguments, reason = "one step of `gather`, cut out for reading")]
fn gather_run(
    problem: &Problem,
    part: &Part,
    (p, r): (usize, usize),
    point: &Point,
    unknown: &[Unknown],
    active: &[usize],
    source: &[Result<usize, f64>],
    share: f64,
    samples: &mut Vec<Sample>,
) {
    const STEP: f64 = 1e-4;
    let parameters = problem.parameters(p, r, point);
    let mut workspace = Vec::new();
    let factor_at = |point: &Point, sample: Seen<'_>, workspace: &mut Vec<_>| {
        let parameters = problem.parameters(p, r, point);
        let made = covariance_of(part, r, sample, &parameters, &[], workspace);
        made.covariance.diagonal()
    };
    problem.visit_share_of_residuals((p, r), point, share, &mut |sample, residual| {
        let mut stated = DVector::from_element(residual.len(), 1.0);
        for (slot, sigma) in part.slots().iter().zip(&part.sigma) {
            if part.is_present(sample, slot) {
                stated.rows_mut(slot.residual, slot.components).fill(sigma * sigma);
            }
        }
        let made = covariance_of(part, r, sample, &parameters, active, &mut workspace);
        let factor = factor_at(point, sample, &mut workspace).component_div(&stated).map(f64::sqrt);
        let mut slopes = DMatrix::zeros(residual.len(), unknown.len());
        for (i, one) in unknown.iter().enumerate() {
            if let Unknown::Instance(index) = one {
                let mut moved = point.clone();
                moved.values[*index][0] += STEP;
                let there =
                    factor_at(&moved, sample, &mut workspace).component_div(&stated).map(f64::sqrt);
                slopes.set_column(i, &((there - &factor) / STEP));
            }
        }
        samples.push(Sample {
            residual: DVector::from_iterator(
                residual.len(),
                residual.iter().map(|value| if value.is_nan() { 0.0 } else { *value }),
            ),
            stated,
            factor,
            slopes,
            sensitivities: made.sensitivities,
            source: source.to_vec(),
        });
    });
}

/// Gradient of the log likelihood and its expected negative Hessian.
pub(super) fn score(
    samples: &[Sample],
    unknown: &[Unknown],
    theta: &DVector<f64>,
    origin: &DVector<f64>,
    correction: f64,
) -> (DVector<f64>, DMatrix<f64>) {
    let n = unknown.len();
    let mut gradient = DVector::zeros(n);
    let mut information = DMatrix::zeros(n, n);
    for sample in samples {
        let factor = &sample.factor + &sample.slopes * (theta - origin);
        let mut covariance =
            DMatrix::from_diagonal(&sample.stated.component_mul(&factor).component_mul(&factor));
        for (column, source) in sample.source.iter().enumerate() {
            let g = sample.sensitivities.column(column);
            let variance = match source {
                Ok(index) => theta[*index],
                Err(fixed) => *fixed,
            };
            covariance += g * g.transpose() * variance;
        }
        let Some(inverse) = covariance.cholesky().map(|factor| factor.inverse()) else { continue };
        let weighted = &inverse * &sample.residual;
        // V⁻¹ dV for every unknown.
        let changes: Vec<DMatrix<f64>> = unknown
            .iter()
            .enumerate()
            .map(|(i, one)| match one {
                Unknown::Random(_) => {
                    let mut change = DMatrix::zeros(factor.len(), factor.len());
                    for (column, source) in sample.source.iter().enumerate() {
                        if *source == Ok(i) {
                            let g = sample.sensitivities.column(column);
                            change += g * g.transpose();
                        }
                    }
                    change
                }
                Unknown::Instance(_) => {
                    let slope = sample
                        .slopes
                        .column(i)
                        .component_mul(&factor)
                        .component_mul(&sample.stated);
                    DMatrix::from_diagonal(&(slope * 2.0))
                }
            })
            .collect();
        let scaled: Vec<DMatrix<f64>> = changes.iter().map(|change| &inverse * change).collect();
        for i in 0..n {
            let quadratic = (weighted.transpose() * &changes[i] * &weighted)[(0, 0)];
            gradient[i] += 0.5 * (correction * quadratic - scaled[i].trace());
            for j in 0..=i {
                let value = 0.5 * (&scaled[i] * &scaled[j]).trace();
                information[(i, j)] += value;
                if i != j {
                    information[(j, i)] += value;
                }
            }
        }
    }
    (gradient, information)
}
