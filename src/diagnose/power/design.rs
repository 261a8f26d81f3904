//! A campaign as a design: the readings that its model predicts, without noise, and what a fit to
//! them would give, of the model, its delays and each effect of the library. Nothing is fitted; of
//! readings that were recorded it only matters which of them there are.

use std::convert::Infallible;

use crate::diagnose::evidence::Evidence;
use crate::diagnose::evidence::sampling::{ALL_BLIND, distinguishable};
use crate::diagnose::fitted::Fitted;
use crate::diagnose::library::candidate::{Candidate, NotTestable};
use crate::diagnose::library::offer::offer;
use crate::diagnose::library::wanted::Wanted;
use crate::engine::gram::LeastSquares;
use crate::engine::open::Recipe;
use crate::engine::simulate::draw_run;
use crate::engine::{Point, Problem};
use crate::estimate::batch::{Fit, Outcome};
use crate::estimate::calibrate::Calibration;

/// Effects before a design.
#[derive(Clone, Debug)]
pub struct Prospect {
    /// The design, as if just fitted.
    pub fitted: Fitted,
    /// Effects at every head with every member of their families.
    pub candidates: Vec<Candidate>,
    /// Effects on the noise.
    pub noise: Vec<Candidate>,
    /// Effects that cannot be tested.
    pub not_testable: Vec<NotTestable>,
    /// What the pass over the design gives for each candidate.
    pub evidence: Evidence,
}

/// How well a delay will be known.
#[derive(Clone, Debug, PartialEq)]
pub struct DelaySigma {
    /// The measurand.
    pub measurand: String,
    /// The parameter that is its delay; measurands may share one.
    pub parameter: String,
    /// Its delay's largest standard uncertainty over the scope (s); `None` if it is not determined.
    pub sigma: Option<f64>,
}

/// Campaigns with the readings that are predicted at a point, as if just fitted. Runs that are not
/// measured yet have every reading; others those that were recorded. Noise levels that are not
/// stated are the usual ones.
pub fn design(recipes: Vec<Recipe>, mut problem: Problem, point: Point) -> Fitted {
    for part in &mut problem.parts {
        for (sigma, random) in part.random_sigma.iter_mut().zip(&part.system.randoms) {
            if *sigma == 0.0 {
                *sigma = random.sigma.or(random.typical).unwrap_or(0.0);
            }
        }
    }
    let mut silent = problem.clone();
    for part in &mut silent.parts {
        part.sigma.fill(0.0);
        part.random_sigma.fill(0.0);
    }
    for p in 0..problem.parts.len() {
        for r in 0..problem.parts[p].runs.len() {
            let planned = !problem.parts[p].has_readings(r);
            let mut columns: Vec<Vec<f64>> = Vec::new();
            let Ok(()) = draw_run(&silent, (p, r), &point, 1, planned, &mut |_, drawn| {
                columns.resize(drawn.len(), Vec::new());
                columns.iter_mut().zip(drawn).for_each(|(all, drawn)| all.extend(drawn));
                Ok::<_, Infallible>(())
            });
            problem.parts[p].runs[r].record.edit(|samples| samples.readings = columns);
        }
    }
    let mut problem = Problem::new(problem.parts);
    problem.reweight(&point);
    let (normal, cost) = (problem.normal(&point), problem.cost(&point));
    let outcome = if cost.is_finite() { Outcome::Converged } else { Outcome::NotFinite };
    let fit = Fit { point, cost, normal, iterations: 0, evaluations: 0, remaining: 0.0, outcome };
    Fitted { recipes, problem, fit }
}

/// The library before a design: every effect at every head with every member of its families, and
/// no unknown structure. `None` where the model's own parameters are not determined.
pub fn prospect(fitted: Fitted, wanted: &Wanted) -> Option<Prospect> {
    let mut offer = wanted.of(offer(&fitted.recipes)).of_runs(&fitted.recipes, &fitted.problem);
    let mut candidates = Vec::new();
    for family in offer.effects.chunk_by(|a, b| a.name == b.name) {
        let distinct = distinguishable(&fitted.problem, family);
        if distinct.is_empty() {
            offer.not_testable.push(NotTestable::here(&family[0].name, ALL_BLIND));
        }
        candidates.extend(distinct.into_iter().cloned());
    }
    let all: Vec<_> = candidates.iter().collect();
    let evidence = Evidence::new(&fitted.problem, &fitted.fit.normal, &fitted.fit.point, &all)?;
    let (noise, not_testable) = (offer.noise, offer.not_testable);
    Some(Prospect { fitted, candidates, noise, not_testable, evidence })
}

/// Each free delay with its columns and their coefficients.
pub(super) fn delay_rows(stage: &Prospect) -> Vec<(String, Vec<(usize, f64)>)> {
    let layout = &stage.fitted.problem.layout;
    let delays = layout.instances.iter().enumerate();
    let delays = delays.filter(|(_, instance)| instance.is_delay());
    let rows = delays.map(|(index, instance)| {
        let of = instance.of.as_ref().map_or_else(String::new, |of| format!(" ({of})"));
        (format!("{}{of}", instance.name), layout.columns_of(index, 0))
    });
    rows.filter(|(_, row)| !row.is_empty()).collect()
}

/// The standard uncertainty of each measurand's delay, the largest where there are several.
pub(super) fn delays(nominal: &Calibration) -> Vec<DelaySigma> {
    let estimates = nominal.estimates();
    let mut found: Vec<DelaySigma> = Vec::new();
    for part in &nominal.problem.parts {
        let names = &part.system.assembly.names;
        for (parameter, declared) in names.parameters.iter().zip(&part.system.declared) {
            for measurand in &declared.delay_of {
                let own = estimates.iter().filter(|one| one.name == parameter.name);
                let sigmas: Option<Vec<f64>> = own.map(|one| one.sigma).collect();
                let sigma = sigmas.map(|all| all.into_iter().fold(0.0, f64::max));
                let measurand = names.measurands[*measurand].name.clone();
                if !found.iter().any(|one| one.measurand == measurand) {
                    let parameter = parameter.name.clone();
                    found.push(DelaySigma { measurand, parameter, sigma });
                }
            }
        }
    }
    found
}
