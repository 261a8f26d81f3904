//! The gap of a campaign that the fit never saw.
//!
//! What belongs to the instrument and the rig is held at the values of the first campaign, with and
//! without the effects; only parameters of setups and runs are estimated. The drop is that of the whole
//! campaign, run by run.

use crate::engine::open::Opened;
use crate::engine::{Point, Problem};
use crate::estimate::batch::{FitError, Options, fit};
use crate::estimate::calibrate::rms;
use crate::estimate::start::start;
use crate::graph::Scope;
use crate::system::{Selected, System};

use super::candidates::Wanted;
use super::gap::{Gap, closed, floor};
use super::stage::{Fitted, Stage, rebuilt};
use super::verdict::leftover;

/// The gap of a held-out campaign, without and with the effects that were adopted elsewhere.
///
/// # Errors
/// [`FitError`] where the campaign cannot be fitted at all.
pub fn holdout(
    opened: &Opened,
    before: &Fitted,
    after: &Fitted,
    wanted: &Wanted,
    options: &Options,
) -> Result<Gap, FitError> {
    let known: Vec<&Selected> = after.recipes.iter().flat_map(|recipe| &recipe.effects).collect();
    let nominal: Vec<&Selected> =
        before.recipes.iter().flat_map(|recipe| &recipe.effects).collect();
    let without = judged(opened, before, &nominal, options)?;
    let with = judged(opened, after, &known, options)?;
    let drops: Vec<f64> = costs(&without).iter().zip(costs(&with)).map(|(a, b)| a - b).collect();
    let mut left = 0.0;
    let gain = without.cost() - with.cost();
    let (rms_before, rms_after) =
        (rms(&without.problem, &without.fit.point), rms(&with.problem, &with.fit.point));
    let floor = floor(&with);
    if let Some(mut stage) = Stage::new(with, wanted) {
        let structure = stage.structure();
        let problem = &stage.fitted.problem;
        let samples: usize =
            problem.parts.iter().flat_map(|part| &part.runs).map(|run| run.record.len()).sum();
        let length = samples.div_ceil(60).max(1);
        let remains = stage.evidence.left(problem, &stage.fitted.fit.point, &structure, length);
        stage.judge_scatter(&remains);
        left = leftover(&stage);
    }
    let (part, interval) = closed(&drops, left);
    Ok(Gap {
        before: rms_before,
        after: rms_after,
        floor,
        lambda: gain.max(0.0).sqrt(),
        held_out_drop: drops.iter().sum(),
        leftover: left,
        closed: Some(part),
        closed_interval: Some(interval),
        folds: drops.len(),
    })
}

/// Sum of squares of each run.
fn costs(fitted: &Fitted) -> Vec<f64> {
    let runs = fitted.fit.normal.runs.iter();
    runs.map(|run| run.gram[(run.gram.nrows() - 1, run.gram.nrows() - 1)]).collect()
}

/// The held-out campaign with some effects; what is global is held at the values of a fit.
fn judged(
    opened: &Opened,
    values: &Fitted,
    effects: &[&Selected],
    options: &Options,
) -> Result<Fitted, FitError> {
    let mut recipes = opened.recipes.clone();
    let mut parts = Vec::new();
    for (recipe, part) in recipes.iter_mut().zip(&opened.problem.parts) {
        for effect in effects {
            let known =
                |one: &&Selected| one.effect.name == effect.effect.name && one.head == effect.head;
            if !recipe.effects.iter().any(|one| known(&one)) {
                recipe.effects.push((*effect).clone());
            }
        }
        parts.push(match recipe.with(&[]) {
            Ok(mut system) => {
                hold(&mut system, values);
                rebuilt(part, system)
            }
            Err(_) => part.clone(),
        });
    }
    let mut problem = Problem::new(parts);
    let (point, _) = start(&problem);
    let fit = fit(&mut problem, point, options)?;
    Ok(Fitted { recipes, problem, fit })
}

/// Holds what belongs to instrument and rig at the values of a fit, random levels with it.
fn hold(system: &mut System, values: &Fitted) {
    let layout = &values.problem.layout;
    let point: &Point = &values.fit.point;
    let names = &system.assembly.names.parameters;
    for (parameter, setting) in names.iter().zip(&mut system.settings) {
        if !matches!(setting.scope, Scope::Rig | Scope::Instrument) {
            continue;
        }
        if let Some(index) = layout.instances.iter().position(|one| one.name == parameter.name) {
            setting.value = Some(point.components(layout, index));
            setting.sigma = None;
            setting.start = None;
            setting.fixed = true;
        }
    }
    for random in &mut system.randoms {
        let level = values.problem.parts.iter().find_map(|part| {
            let index = part.system.randoms.iter().position(|one| one.name == random.name)?;
            Some(part.random_sigma[index])
        });
        random.sigma = level.or(random.sigma);
    }
}
