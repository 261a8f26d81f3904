//! Whether an effect of the user's own is off where its parameters are zero: the readings must be those of
//! the model without it there, for what it does is judged by their slope from there on.

use crate::campaign::Samples;
use crate::diagnose::fitted::{Fitted, carried, rebuilt};
use crate::engine::part::SampleLeaves;
use crate::engine::{Part, Point, Problem};
use crate::graph::Kind;

use super::candidates::{Candidate, NotTestable, Wanted};

/// Samples of each run that are looked at.
const SAMPLES: usize = 3;
/// Change of a reading, in its standard uncertainties, below which it is none.
const NOTHING: f64 = 0.01;

/// The wanted effects of the user's own that are not off where their parameters are zero.
pub(in crate::diagnose) fn never_off(fitted: &Fitted, wanted: &Wanted) -> Vec<NotTestable> {
    let own: Vec<&str> = fitted
        .recipes
        .iter()
        .flat_map(|recipe| recipe.library.own_effects().map(|effect| effect.name.as_str()))
        .collect();
    if own.is_empty() {
        return Vec::new();
    }
    let made = wanted.catalogue.of(&fitted.recipes);
    let mut found: Vec<NotTestable> = Vec::new();
    for one in made.offer.effects.iter().filter(|one| own.contains(&&*one.selected.effect.name)) {
        let is_wanted = wanted.includes(&one.selected.effect.name, one.selected.head.as_deref());
        let is_known = found.iter().any(|known| known.name == one.name);
        if is_wanted
            && !is_known
            && let Some(measurand) = changed(fitted, one)
        {
            let why = format!(
                "it changes `{measurand}` where its parameters are zero: it must be off there, as `x + size * ...` is"
            );
            found.push(NotTestable::here(&one.name, why));
        }
    }
    found
}

/// The first measurand that an effect changes where its parameters are zero.
fn changed(fitted: &Fitted, candidate: &Candidate) -> Option<String> {
    let Fitted { problem, fit, .. } = fitted;
    problem.parts.iter().zip(&candidate.systems).enumerate().find_map(|(p, (part, system))| {
        let system = (**system.as_ref()?).clone();
        let mut parts = problem.parts.clone();
        parts[p] = rebuilt(part, system);
        let with = Problem::new(parts);
        let mut point = carried(problem, &fit.point, &with);
        for (instance, value) in with.layout.instances.iter().zip(&mut point.values) {
            let known = problem.layout.instances.iter().any(|one| one.name == instance.name);
            if !known && !instance.setting.fixed {
                let identity = f64::from(u8::from(instance.kind == Kind::Rotation));
                *value = [identity, 0.0, 0.0, 0.0];
            }
        }
        let runs = 0..part.runs.len();
        runs.into_iter().find_map(|run| {
            let before = first_residuals(problem, (p, run), &fit.point);
            let after = first_residuals(&with, (p, run), &point);
            let row = before.iter().zip(&after).find_map(|(before, after)| {
                let apart = |row: &usize| {
                    let sigma = part.sigma_in(run, part.measurand_of(*row));
                    (before[*row] - after[*row]).abs() > NOTHING * sigma
                };
                (0..before.len()).find(apart)
            })?;
            let names = &part.system.assembly.names.measurands;
            Some(names[part.measurand_of(row)].name.clone())
        })
    })
}

/// Residuals of the first samples of a run.
fn first_residuals(problem: &Problem, (p, r): (usize, usize), point: &Point) -> Vec<Vec<f64>> {
    let part: &Part = &problem.parts[p];
    let parameters = problem.parameters::<f64>(p, r, point);
    let randoms = vec![0.0; part.random_sigma.len()];
    let (mut workspace, mut scratch) = (Vec::new(), Samples::default());
    let mut all = Vec::new();
    for sample in part.runs[r].record.stretch(0..SAMPLES, &mut scratch).each() {
        let (randoms, columns) = (&randoms[..], part.columns());
        let leaves = SampleLeaves { parameters: &parameters, randoms, columns, sample };
        let outputs = part.evaluate(&leaves, &mut workspace);
        let mut row = vec![0.0; part.residual_count()];
        for slot in part.slots().iter().filter(|slot| part.is_present(sample, slot)) {
            let residual = part.residual(sample, slot, outputs);
            row[slot.residual..slot.residual + slot.components]
                .copy_from_slice(&residual[..slot.components]);
        }
        all.push(row);
    }
    all
}
