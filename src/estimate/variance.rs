//! Levels of noise: standard deviations of random quantities and factors on stated uncertainties,
//! by maximum likelihood on the residuals of a fit.
//!
//! With the sample covariance `V(θ) = diag((σ f(θ))²) + Σ_k s_k² g_k g_kᵀ` the log likelihood is
//! `-½ Σ (ln det V + c rᵀ V⁻¹ r)`, maximised by Fisher scoring over `s_k²` and θ; `c = n / (n - u)`
//! makes up for the `u` unknowns fitted to the residuals. Quantities that are correlated from
//! sample to sample are not estimated here. Of long runs [`ENOUGH`] samples are looked at, spread
//! evenly: they give a level to half a percent, and that is what its standard uncertainty says.
//!
//! A level holds in every campaign that leaves it free; where a campaign fixes it, its own counts.

use nalgebra::{DMatrix, DVector};

use crate::engine::part::Part;
use crate::engine::point::Point;
use crate::engine::problem::Problem;
use crate::graph::Scope;
use crate::model::Process;
use crate::units::Unit;

pub use self::likelihood::Unknown;
use self::likelihood::{gather, score};

mod likelihood;

/// Samples that are enough for the levels.
pub const ENOUGH: usize = 1 << 17;
/// Scoring steps of one call.
const MAXIMUM_STEPS: usize = 40;

/// A level that was estimated.
#[derive(Clone, Debug)]
pub struct Level {
    /// `timestamp_jitter.jitter`, `angle_noise_level.factor`.
    pub name: String,
    /// Scope it is declared with.
    pub scope: Scope,
    /// The setup or run it holds for.
    pub of: Option<String>,
    /// Standard deviation of the random quantity, or the parameter's value (SI).
    pub value: f64,
    /// Its standard uncertainty.
    pub sigma: Option<f64>,
    /// Unit it is declared in.
    pub unit: Unit,
}

/// The levels a problem asks for: random quantities of effects, and parameters that act on noise
/// alone.
pub fn unknown_levels(problem: &Problem) -> Vec<Unknown> {
    let mut unknown = Vec::new();
    for part in &problem.parts {
        for random in &part.system.randoms {
            let wanted = Unknown::Random(random.name.clone());
            let estimable =
                random.effect.is_some() && !random.fixed && random.process == Process::White;
            if estimable && !unknown.contains(&wanted) {
                unknown.push(wanted);
            }
        }
    }
    for (index, instance) in problem.layout.instances.iter().enumerate() {
        if problem.layout.is_noise_only(index) && !instance.setting.fixed {
            unknown.push(Unknown::Instance(index));
        }
    }
    unknown
}

/// Sets every unknown random level to its stated or typical size, the largest of all campaigns.
pub fn start_levels(problem: &mut Problem, unknown: &[Unknown]) {
    for one in unknown {
        let Unknown::Random(name) = one else { continue };
        let own = |part: &Part| {
            let random = &part.system.randoms[index_of(part, name)?];
            Some(random.sigma.or(random.typical).unwrap_or(1e-6))
        };
        let largest = problem.parts.iter().filter_map(own).fold(0.0, f64::max);
        problem.set_random(name, largest);
    }
}

/// Estimates the unknown levels from the residuals at a point; writes them into the problem and the
/// point. Returns them and the largest relative change; `None`, and nothing is written, where
/// residuals are too large for their squares to be finite.
pub fn estimate(
    problem: &mut Problem,
    point: &mut Point,
    unknown: &[Unknown],
) -> Option<(Vec<Level>, f64)> {
    let old: Vec<f64> = unknown.iter().map(|one| current(problem, point, one)).collect();
    let all = problem.parts.iter().flat_map(|part| &part.runs).map(|run| run.record.len());
    let all = all.sum::<usize>().max(1) as f64;
    let samples = gather(problem, point, unknown, ENOUGH as f64 / all);
    let readings: usize =
        samples.iter().map(|s| s.residual.iter().filter(|r| **r != 0.0).count()).sum();
    // The unknowns were fitted to all samples; a part of them has its share of the unknowns.
    let unknowns = problem.layout.columns.len() as f64 * samples.len() as f64 / all;
    let correction = readings as f64 / (readings as f64 - unknowns).max(1.0);
    // Random levels are scored as variances.
    let mut theta: DVector<f64> = DVector::from_iterator(
        unknown.len(),
        unknown.iter().zip(&old).map(|(one, value)| match one {
            Unknown::Random(_) => value * value,
            Unknown::Instance(_) => *value,
        }),
    );
    let origin = theta.clone();
    let mut fisher = DMatrix::identity(unknown.len(), unknown.len());
    for _ in 0..MAXIMUM_STEPS {
        let (gradient, information) = score(&samples, unknown, &theta, &origin, correction);
        if !gradient.iter().chain(information.iter()).all(|value| value.is_finite()) {
            return None;
        }
        fisher = information;
        let Some(step) = fisher.clone().cholesky().map(|factor| factor.solve(&gradient)) else {
            break;
        };
        if !step.iter().all(|value| value.is_finite()) {
            return None;
        }
        let mut largest: f64 = 0.0;
        for (i, one) in unknown.iter().enumerate() {
            let next = match one {
                // A variance may fall to zero, or tenfold, at a time.
                Unknown::Random(_) => {
                    (theta[i] + step[i]).clamp(0.0, 10.0 * theta[i] + step[i].abs())
                }
                Unknown::Instance(_) => theta[i] + step[i].clamp(-0.5, 0.5),
            };
            largest =
                largest.max((next - theta[i]).abs() / next.abs().max(theta[i].abs()).max(1e-300));
            theta[i] = next;
        }
        if largest < 1e-9 {
            break;
        }
    }
    if !theta.iter().all(|value| value.is_finite()) {
        return None;
    }
    let covariance = fisher.try_inverse();
    let mut change: f64 = 0.0;
    let mut levels = Vec::new();
    for (i, one) in unknown.iter().enumerate() {
        let spread = covariance.as_ref().map(|c| c[(i, i)].max(0.0).sqrt());
        let (value, sigma) = match one {
            Unknown::Random(_) => {
                let value = theta[i].max(0.0).sqrt();
                // Near zero the variance is what is known: σ(s) from s² + σ(s²).
                let sigma = spread.map(|u| {
                    if value > 0.0 { (u / (2.0 * value)).min(u.sqrt()) } else { u.sqrt() }
                });
                (value, sigma)
            }
            Unknown::Instance(_) => (theta[i], spread),
        };
        change = change.max((value - old[i]).abs() / value.abs().max(old[i].abs()).max(1e-300));
        store(problem, point, one, value);
        levels.push(level(problem, one, value, sigma));
    }
    problem.refresh_weights(point);
    Some((levels, change))
}

/// The present value of a level.
pub(crate) fn current(problem: &Problem, point: &Point, unknown: &Unknown) -> f64 {
    match unknown {
        Unknown::Random(name) => problem
            .parts
            .iter()
            .find_map(|part| Some(part.random_sigma[index_of(part, name)?]))
            .unwrap_or(0.0),
        Unknown::Instance(index) => point.values[*index][0],
    }
}

/// The random quantity of a campaign that has this level, if the campaign leaves it free.
fn index_of(part: &Part, name: &str) -> Option<usize> {
    part.system.randoms.iter().position(|random| random.name == name && !random.fixed)
}

fn store(problem: &mut Problem, point: &mut Point, unknown: &Unknown, value: f64) {
    match unknown {
        Unknown::Random(name) => problem.set_random(name, value),
        Unknown::Instance(index) => point.values[*index][0] = value,
    }
}

fn level(problem: &Problem, unknown: &Unknown, value: f64, sigma: Option<f64>) -> Level {
    match unknown {
        Unknown::Random(name) => {
            let unit = problem
                .parts
                .iter()
                .find_map(|part| Some(part.system.randoms[index_of(part, name)?].unit.clone()))
                .unwrap_or_else(Unit::one);
            Level { name: name.clone(), scope: Scope::Sample, of: None, value, sigma, unit }
        }
        Unknown::Instance(index) => {
            let instance = &problem.layout.instances[*index];
            Level {
                name: instance.name.clone(),
                scope: instance.setting.scope,
                of: instance.of.clone(),
                value,
                sigma,
                unit: instance.unit.clone(),
            }
        }
    }
}
