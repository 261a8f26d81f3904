//! Random quantities that the readings of one sample share: jitter of time stamps, steps of an
//! encoder.
//!
//! They show in the products of different readings of a sample: with whitened derivatives `a` the sum
//! of `a_m a_n z_m z_n` over pairs has mean `s² Σ (a_m a_n)²` and, without the effect, the variance
//! `Σ (a_m a_n z_m z_n)²`, whatever the levels of the single readings are. So neither a wrong level nor
//! a wild reading is taken for jitter. A model with a single reading a sample shows none.

use nalgebra::{DMatrix, DVector};

use crate::engine::noise::{active_randoms, covariance_of};
use crate::engine::stretches::Left;
use crate::model::Process;
use crate::units::Unit;

use super::candidates::Candidate;
use super::stage::{Stage, rebuilt};
use super::tail::ln_normal;
use super::whiten::NoiseEffect;

/// Relative difference below which two effects explain the same.
const SAME: f64 = 0.01;
/// Samples looked at at most.
const MOST_SAMPLES: usize = 20_000;

/// The random quantity shared by the readings of a sample that shows best, if any does. `alike` is the
/// part of the samples that counts where neighbours are alike.
pub(super) fn jitter<'s>(
    stage: &'s Stage,
    left: &[Left],
    level: f64,
    alike: f64,
) -> Option<(NoiseEffect, &'s Candidate)> {
    let mut best: Option<(NoiseEffect, &Candidate, f64, f64)> = None;
    for candidate in &stage.noise {
        for (name, unit) in white_randoms(candidate) {
            let Some(Pairs { sum, weights, scatter, typical }) =
                pairs(stage, left, candidate, &name)
            else {
                continue;
            };
            let ln_p = ln_normal(sum / scatter.sqrt() * alike.sqrt());
            let variance = sum / weights;
            if ln_p > level || variance <= 0.0 {
                continue;
            }
            let value = variance.sqrt();
            let found = NoiseEffect {
                selected: Some(candidate.selected.clone()),
                name: candidate.name.clone(),
                parameter: name,
                unit,
                value,
                sigma: 0.5 * scatter.sqrt() / (weights * value),
                memory: None,
                ln_p,
            };
            // The one that explains most; of effects that look the same, the one whose usual size is
            // nearest.
            let explained = 0.5 * sum * sum / weights;
            let strange = (value / typical).ln().abs();
            let better = best.as_ref().is_none_or(|(_, _, most, least)| {
                let more = explained / most - 1.0;
                more > SAME || (more > -SAME && strange < *least)
            });
            if better {
                best = Some((found, candidate, explained, strange));
            }
        }
    }
    best.map(|(found, candidate, _, _)| (found, candidate))
}

/// The random quantities of an effect that are independent from sample to sample.
pub(super) fn white_randoms(candidate: &Candidate) -> Vec<(String, Unit)> {
    let Some(system) = candidate.systems.iter().flatten().next() else { return Vec::new() };
    let name = &candidate.name;
    let own = |effect: &Option<String>| effect.as_ref().is_some_and(|own| own == name);
    system
        .randoms
        .iter()
        .filter(|random| own(&random.effect) && random.process == Process::White)
        .map(|random| (random.name.clone(), random.unit.clone()))
        .collect()
}

impl Pairs {
    /// Adds a sample: its whitened residuals (NaN where there is no reading), the covariance that
    /// whitened them, and the derivatives that are not whitened yet.
    fn add(&mut self, z: &[f64], covariance: DMatrix<f64>, g: &DVector<f64>) {
        let Some(factor) = covariance.cholesky() else { return };
        let Some(a) = factor.l_dirty().solve_lower_triangular(g) else { return };
        for m in 0..z.len() {
            for n in 0..m {
                let (product, weight) = (z[m] * z[n], a[m] * a[n]);
                if product.is_finite() {
                    self.sum += weight * product;
                    self.weights += weight * weight;
                    self.scatter += (weight * product).powi(2);
                }
            }
        }
    }
}

/// Sums over pairs of readings of a sample.
struct Pairs {
    /// `Σ a_m a_n z_m z_n`.
    sum: f64,
    /// `Σ (a_m a_n)²`.
    weights: f64,
    /// `Σ (a_m a_n z_m z_n)²`: the variance of the sum, wild readings or not.
    scatter: f64,
    /// The usual size of the effect.
    typical: f64,
}

fn pairs(stage: &Stage, left: &[Left], candidate: &Candidate, name: &str) -> Option<Pairs> {
    let fitted = &stage.fitted;
    let mut pairs = Pairs { sum: 0.0, weights: 0.0, scatter: 0.0, typical: 1.0 };
    let samples: usize =
        fitted.problem.parts.iter().flat_map(|part| &part.runs).map(|run| run.record.len()).sum();
    let stride = samples.div_ceil(MOST_SAMPLES).max(1);
    for (p, part) in fitted.problem.parts.iter().enumerate() {
        let Some(system) = &candidate.systems[p] else { continue };
        let with = rebuilt(part, (**system).clone());
        let k = with.system.randoms.iter().position(|random| random.name == name)?;
        pairs.typical = with.system.randoms[k].typical.unwrap_or(1.0);
        // An effect that is random through and through has no parameters of its own.
        if with.system.settings.len() != part.system.settings.len() {
            return None;
        }
        let active = active_randoms(part);
        for (run, data) in part.runs.iter().enumerate() {
            let residuals = &left[fitted.problem.run_index(p, run)].residuals;
            let parameters = fitted.problem.parameters(p, run, &fitted.fit.point);
            let mut memory = Vec::new();
            data.record.walk(|stretch| {
                for sample in stretch.each().filter(|sample| sample.number % stride == 0) {
                    let z: Vec<f64> = residuals.iter().map(|row| row[sample.number]).collect();
                    let covariance =
                        covariance_of(part, run, sample, &parameters, &active, &mut memory)
                            .covariance;
                    let slopes = covariance_of(&with, run, sample, &parameters, &[k], &mut memory);
                    let g = slopes.sensitivities.column(0).into_owned();
                    pairs.add(&z, covariance, &g);
                }
            });
        }
    }
    (pairs.scatter > 0.0).then_some(pairs)
}
