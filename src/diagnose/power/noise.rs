//! What a campaign sees of effects on the noise: they show in the scatter and not in the mean.
//!
//! Each has a statistic that is normal of variance one without it and has a mean with it: shared
//! errors `s² √W` with `W = Σ (a_m a_n)²` over pairs of readings of a sample
//! ([`crate::diagnose::budget::noise`]), a level `((1 + k)² - 1) √(n / 2)`, memory its correlation
//! times `√n`. Where the mean exceeds the bar by the quantile of [`CAUGHT`] the effect is declared
//! with that probability.

use std::collections::BTreeSet;

use nalgebra::DVector;
use statrs::function::gamma::gamma_lr;

use crate::diagnose::fitted::Fitted;
use crate::diagnose::library::candidate::Candidate;
use crate::diagnose::library::offer::effects_of;
use crate::diagnose::library::wanted::Wanted;
use crate::diagnose::thresholds::{NOISE, OUTLIERS, SCALE, SCALE_DIFFERENCE};
use crate::effect::{Effect, Target};
use crate::engine::noise::covariance_of;
use crate::graph::MeasurandKind;
use crate::model::{ParameterDeclaration, Process};
use crate::statistics::ln_normal;
use crate::units::Unit;

use super::design::Prospect;
use super::detection::{leads, solved};
use super::sight::{CAUGHT, FAR};
use super::{Row, State, not_testable};

/// Samples that are looked at, at most.
const MOST_SAMPLES: usize = 100_000;
/// Squared cosine from which on two patterns of scatter are one.
const SAME: f64 = 0.99;

/// The built-in detector whose size can be foretold.
const OUTLIERS_EFFECT: &str = "outliers";
const NOT_FORETOLD: &str = "`diagnose` looks for it in the readings; its size is not foretold here";

/// The rows of the effects on the noise, and of the built-in detectors.
pub(super) fn rows(stage: &Prospect, wanted: &Wanted) -> Vec<Row> {
    let bar = NOISE + quantile();
    let shared: Vec<Shared<'_>> =
        stage.noise.iter().filter_map(|one| Shared::new(stage, one)).collect();
    let row = |candidate: &Candidate| {
        let own = shared.iter().find(|one| one.candidate.name == candidate.name);
        let row = own.map(|own| own.row(&shared, bar)).or_else(|| scatter(stage, candidate));
        row.unwrap_or_else(|| {
            let process = |one: &ParameterDeclaration| one.process != Process::White;
            let slow = candidate.selected.effect.parameters.iter().any(process);
            let why =
                if slow { NOT_FORETOLD } else { "the readings of a sample share nothing of it" };
            not_testable(&candidate.name, why.to_owned())
        })
    };
    let mut named = BTreeSet::new();
    let first = stage.noise.iter().filter(|one| named.insert(&one.name));
    let mut rows: Vec<Row> = first.map(row).collect();
    let detectors = effects_of(&stage.fitted.recipes).filter(|one| one.builtin);
    let detectors = detectors.filter(|one| wanted.includes(&one.name, None));
    rows.extend(detectors.map(|one| match one.name.as_str() {
        OUTLIERS_EFFECT => outliers(stage, one),
        name => not_testable(name, NOT_FORETOLD.to_owned()),
    }));
    rows
}

/// The standard score that a normal number exceeds `-` of with probability [`CAUGHT`].
fn quantile() -> f64 {
    solved(|z| ln_normal(z) <= (1.0 - CAUGHT).ln())
}

/// A random quantity that the readings of a sample share.
struct Shared<'a> {
    candidate: &'a Candidate,
    unit: Unit,
    typical: f64,
    /// `√W`.
    strength: f64,
    /// In each campaign; empty where it does not fit.
    products: Vec<Vec<f64>>,
}

impl<'a> Shared<'a> {
    fn new(stage: &'a Prospect, candidate: &'a Candidate) -> Option<Self> {
        let (name, unit) = white_random(candidate)?;
        let (products, typical) = pattern(stage, candidate, &name)?;
        let strength = products.iter().flatten().map(|one| one * one).sum::<f64>().sqrt();
        (strength > 0.0).then_some(Self { candidate, unit, typical, strength, products })
    }

    fn row(&self, others: &[Self], bar: f64) -> Row {
        let detectable = (bar / self.strength).sqrt();
        let cosine = |other: &Self| {
            let both = self.products.iter().zip(&other.products);
            let sum: f64 = both.flat_map(|(a, b)| a.iter().zip(b)).map(|(a, b)| a * b).sum();
            sum / (self.strength * other.strength)
        };
        let mut near: Vec<(&str, f64)> = others
            .iter()
            .filter(|other| other.candidate.name != self.candidate.name)
            .map(|other| (other.candidate.name.as_str(), cosine(other).powi(2).min(1.0)))
            .collect();
        near.sort_by(|a, b| b.1.total_cmp(&a.1));
        let nearest = near.first().map_or(0.0, |(_, square)| *square);
        let named = solved(|size| {
            let length = (size * self.typical).powi(2) * self.strength;
            length >= bar && leads(length * (1.0 - nearest).sqrt(), 1, 1) >= CAUGHT
        });
        let named = named * self.typical;
        let most = FAR * self.typical.max(detectable);
        let identifiable = (nearest < SAME && named <= most).then_some(named);
        near.retain(|(_, square)| *square >= if identifiable.is_none() { SAME } else { 0.81 });
        Row {
            state: if identifiable.is_some() { State::Visible } else { State::Alias },
            unit: self.unit.clone(),
            typical: Some(self.typical),
            detectable: Some(detectable),
            identifiable,
            with: near.into_iter().map(|(name, _)| name.to_owned()).collect(),
            root: 4.0,
            ..Row::new(&self.candidate.name)
        }
    }
}

/// Name and unit of the first random quantity of an effect that is independent between samples.
fn white_random(candidate: &Candidate) -> Option<(String, Unit)> {
    let mut randoms = candidate.systems.iter().flatten().next()?.randoms.iter();
    let name = Some(&candidate.name);
    let own = randoms.find(|one| one.effect.as_ref() == name && one.process == Process::White)?;
    Some((own.name.clone(), own.unit.clone()))
}

/// `a_m a_n` of the whitened derivatives along a random quantity, for every pair of readings of
/// every sample that is looked at, in each campaign, and its usual size.
fn pattern(stage: &Prospect, candidate: &Candidate, name: &str) -> Option<(Vec<Vec<f64>>, f64)> {
    let Fitted { problem, fit, .. } = &stage.fitted;
    let (mut all, mut typical) = (vec![Vec::new(); problem.parts.len()], 1.0);
    let stride = problem.sample_count().div_ceil(MOST_SAMPLES).max(1);
    for ((p, part), products) in problem.parts.iter().enumerate().zip(&mut all) {
        let Some(system) = &candidate.systems[p] else { continue };
        let with = part.with_system((**system).clone());
        let k = with.system.randoms.iter().position(|random| random.name == name)?;
        typical = with.system.randoms[k].typical.unwrap_or(1.0);
        if with.system.settings.len() != part.system.settings.len() {
            return None;
        }
        let mut memory = Vec::new();
        for run in 0..part.runs.len() {
            let parameters = problem.parameters(p, run, &fit.point);
            problem.visit_covariances((p, run), &fit.point, stride, |sample, made| {
                let own = covariance_of(&with, run, sample, &parameters, &[k], &mut memory);
                let g: DVector<f64> = own.sensitivities.column(0).into_owned();
                let Some(factor) = made.covariance.cholesky() else { return };
                let Some(a) = factor.l_dirty().solve_lower_triangular(&g) else { return };
                for m in 0..a.len() {
                    products.extend((0..m).map(|n| a[m] * a[n]));
                }
            });
        }
    }
    Some((all, typical))
}

/// A level of the noise.
fn scatter(stage: &Prospect, candidate: &Candidate) -> Option<Row> {
    let parameter = candidate.selected.effect.parameters.first()?;
    let parts = stage.fitted.problem.parts.iter().enumerate();
    let readings = parts.flat_map(|(p, part)| {
        let present = part.present().into_iter().enumerate();
        present.filter(move |(m, _)| patches_level(candidate, &stage.fitted, (p, *m)))
    });
    let readings = readings.map(|(_, count)| count).max().filter(|count| *count > 0)? as f64;
    let z = SCALE + quantile();
    let least = SCALE_DIFFERENCE + quantile() / (2.0 * readings).sqrt();
    let size = ((1.0 + z * (2.0 / readings).sqrt()).sqrt() - 1.0).max(least);
    Some(Row {
        state: State::Visible,
        unit: parameter.unit.clone(),
        typical: parameter.setting.typical,
        detectable: Some(size),
        identifiable: Some(size),
        ..Row::new(&candidate.name)
    })
}

/// Whether an effect patches the noise level of a measurand of a campaign.
fn patches_level(
    candidate: &Candidate,
    fitted: &Fitted,
    (campaign, measurand): (usize, usize),
) -> bool {
    let Fitted { problem, recipes, .. } = fitted;
    let one = &problem.parts[campaign].system.assembly.names.measurands[measurand];
    let model = &recipes[campaign].model;
    let head = candidate.selected.head.as_ref().and_then(|head| model.heads.get(head));
    let role = |name: &String| head.and_then(|own| own.get(name)).or_else(|| model.roles.get(name));
    let is_called = |name: &String| role(name).map_or(name, |role| &role.owner) == &one.name;
    let is_read = || head.is_none_or(|own| own.values().any(|role| role.owner == one.name));
    candidate.selected.effect.patches.iter().any(|line| match &line.target {
        Target::Sigma(name) => is_called(name),
        Target::EachAngleSigma => matches!(one.kind, MeasurandKind::Angle { .. }) && is_read(),
        _ => false,
    })
}

/// Outliers: Poisson, enough of them are there with probability [`CAUGHT`] if the mean is larger.
fn outliers(stage: &Prospect, effect: &Effect) -> Row {
    let readings = stage.fitted.problem.reading_count();
    let mean = solved(|mean| gamma_lr(OUTLIERS as f64, mean) >= CAUGHT);
    let share = (readings >= OUTLIERS).then(|| mean / readings as f64);
    Row {
        state: if share.is_some() { State::Visible } else { State::NotTestable },
        typical: effect.parameters.first().and_then(|one| one.setting.typical),
        detectable: share,
        identifiable: share,
        root: 1.0,
        ..Row::new(&effect.name)
    }
}
