//! How large random quantities are beside all that has been found: those of the campaigns' own
//! models were estimated with the nominal fit, which takes a gap for noise, and those that were
//! found beside structure that took a part of them.
//!
//! Variances are estimated jointly: that of one random quantity, and one for each residual
//! component, whose stated uncertainty may be wrong, too. Of whitened residuals `z` with the
//! covariance `1 + Σ Δ_j b_j b_jᵀ` (`b` the whitened derivative by the random quantity, or a
//! whitened stated uncertainty) one step of Fisher scoring solves `F Δ = u` with
//! `u_j = Σ (b_jᵀz)² - b_jᵀb_j` and `F_jl = Σ (b_jᵀb_l)²`; the covariance of `Δ` is `2 F⁻¹`.
//!
//! It changes no stated uncertainty: [`super::whiten`] does.

use nalgebra::{Cholesky, DMatrix, DVector};

use crate::diagnose::fitted::Fitted;
use crate::diagnose::found::{Noise, NoiseEffect};
use crate::diagnose::stage::Stage;
use crate::engine::noise::{SampleCovariance, active_randoms, covariance_of};
use crate::engine::stretches::Left;
use crate::estimate::variance::{Unknown, unknown_levels};

/// Standard deviations by which a level must be wrong to be changed.
const MISJUDGED: f64 = 3.0;
/// Changes of levels of the campaigns' own random quantities.
const OWN_LEVELS: usize = 3;
/// Samples looked at at most.
const MOST_SAMPLES: usize = 20_000;

/// The random quantities of the campaigns' own models whose levels are to be estimated; `found` are
/// those that the diagnosis put in.
pub(super) fn own_randoms(stage: &Stage, found: &[NoiseEffect]) -> Vec<String> {
    let unknown = unknown_levels(&stage.fitted.problem).into_iter();
    let owner = |name: &str| name.split('.').next().unwrap_or_default().to_owned();
    let named = |name: &String| found.iter().any(|effect| effect.name == owner(name));
    let randoms = unknown.filter_map(|one| match one {
        Unknown::Random(name) => Some(name),
        Unknown::Instance(_) => None,
    });
    randoms.filter(|name| !named(name)).collect()
}

/// The model with a level that is not the one it was given: of the campaigns' own random
/// quantities, and once of each that was found, for structure that was taken off before it was
/// there took a part with it.
pub(super) fn judged_again(stage: &Stage, left: &[Left], noise: &mut Noise) -> Option<Fitted> {
    let mut fitted = stage.fitted.clone();
    let given = |name: &str| stage.fitted.random(name).map(|sigma| sigma * sigma);
    let of_effect =
        |one: &&mut NoiseEffect| one.selected.is_some() && given(&one.parameter).is_some();
    let grown = &mut noise.grown;
    for one in noise.effects.iter_mut().filter(of_effect) {
        if grown.contains(&one.name) {
            continue;
        }
        grown.push(one.name.clone());
        let Some((more, sigma)) = Scoring::of(stage, left, &one.parameter).step() else { continue };
        let variance = given(&one.parameter).unwrap_or(0.0) + more;
        if variance > 0.0 {
            one.value = variance.sqrt();
            one.sigma = 0.5 * sigma / one.value;
            fitted.set_random(&one.parameter, one.value);
            return Some(fitted);
        }
    }
    if noise.own_levels >= OWN_LEVELS {
        return None;
    }
    own_randoms(stage, &noise.effects).into_iter().find_map(|name| {
        let (more, sigma) = Scoring::of(stage, left, &name).step()?;
        let variance = (given(&name)? + more).max(0.0);
        if more.abs() < MISJUDGED * sigma || Some(variance) == given(&name) {
            return None;
        }
        noise.own_levels += 1;
        fitted.set_random(&name, variance.sqrt());
        Some(fitted.clone())
    })
}

/// The sums of a step: the random quantity first, then each residual component of each campaign.
struct Scoring {
    slope: DVector<f64>,
    information: DMatrix<f64>,
}

impl Scoring {
    fn of(stage: &Stage, left: &[Left], name: &str) -> Self {
        let (problem, point) = (&stage.fitted.problem, &stage.fitted.fit.point);
        let rows: usize = problem.parts.iter().map(|part| part.residual_count()).sum();
        let mut scoring = Self {
            slope: DVector::zeros(1 + rows),
            information: DMatrix::zeros(1 + rows, 1 + rows),
        };
        let runs = problem.parts.iter().flat_map(|part| &part.runs);
        let samples: usize = runs.map(|run| run.record.len()).sum();
        let stride = samples.div_ceil(MOST_SAMPLES).max(1);
        let mut first = 1;
        for (p, part) in problem.parts.iter().enumerate() {
            let own = part.system.randoms.iter().position(|random| random.name == name);
            let mut active = active_randoms(part);
            // One that does not act yet has a derivative, and adds nothing.
            active.extend(own.filter(|own| !active.contains(own)));
            let own = active.iter().position(|random| Some(*random) == own);
            let mut memory = Vec::new();
            for (run, data) in part.runs.iter().enumerate() {
                let residuals = &left[problem.run_index(p, run)].residuals;
                let parameters = problem.parameters(p, run, point);
                let sigma_of = |k: &usize| part.random_sigma_in(run, *k);
                let sigmas: Vec<f64> = active.iter().map(sigma_of).collect();
                data.record.walk(|stretch| {
                    for sample in stretch.each().filter(|sample| sample.number % stride == 0) {
                        let z: Vec<f64> = residuals.iter().map(|row| row[sample.number]).collect();
                        let made =
                            covariance_of(part, run, sample, &parameters, &active, &mut memory);
                        scoring.add(&z, &made, &sigmas, own, first);
                    }
                });
            }
            first += part.residual_count();
        }
        scoring
    }

    /// Adds a sample of the campaign whose components begin with number `first`: its whitened
    /// residuals (NaN where there is no reading), the covariance that whitened them with the levels
    /// in it, and the random quantity's number among those (`None` where the campaign lacks it).
    fn add(
        &mut self,
        z: &[f64],
        made: &SampleCovariance,
        sigmas: &[f64],
        own: Option<usize>,
        first: usize,
    ) {
        let Some(factor) = Cholesky::new(made.covariance.clone()) else { return };
        let mut columns: Vec<(usize, DVector<f64>)> = Vec::with_capacity(1 + z.len());
        columns.extend(own.map(|own| (0, made.sensitivities.column(own).into_owned())));
        for row in (0..z.len()).filter(|row| z[*row].is_finite()) {
            let shared = made.sensitivities.row(row);
            let shared: f64 = shared.iter().zip(sigmas).map(|(by, s)| (by * s).powi(2)).sum();
            let stated = (made.covariance[(row, row)] - shared).max(0.0).sqrt();
            let mut column = DVector::zeros(z.len());
            column[row] = stated;
            columns.push((first + row, column));
        }
        for (_, column) in &mut columns {
            factor.l_dirty().solve_lower_triangular_mut(column);
        }
        let seen =
            DVector::from_iterator(z.len(), z.iter().map(|z| if z.is_finite() { *z } else { 0.0 }));
        for (i, (at, column)) in columns.iter().enumerate() {
            self.slope[*at] += column.dot(&seen).powi(2) - column.norm_squared();
            for (other, with) in &columns[..=i] {
                let both = column.dot(with).powi(2);
                self.information[(*at, *other)] += both;
                if at != other {
                    self.information[(*other, *at)] += both;
                }
            }
        }
    }

    /// How much larger the random quantity's variance is than given, with its standard uncertainty.
    fn step(mut self) -> Option<(f64, f64)> {
        // A component without readings keeps its level.
        for k in 0..self.slope.len() {
            if self.information[(k, k)] == 0.0 {
                self.information[(k, k)] = 1.0;
            }
        }
        let scale = self.information.diagonal().map(f64::sqrt);
        let scaled = DMatrix::from_fn(scale.len(), scale.len(), |i, j| {
            self.information[(i, j)] / (scale[i] * scale[j])
        });
        let factor = Cholesky::new(scaled)?;
        let step = factor.solve(&self.slope.component_div(&scale))[0] / scale[0];
        let mut unit = DVector::zeros(scale.len());
        unit[0] = 1.0;
        let variance = 2.0 * factor.solve(&unit)[0] / (scale[0] * scale[0]);
        Some((step, variance.sqrt()))
    }
}
