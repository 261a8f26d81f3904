//! The square of what times are off by: where that is so large that readings are no longer straight
//! in it.
//!
//! A reading `f` whose time is off by a random `e` of variance `σ²` is `f + f' e + ½ f'' e²`. The
//! first order enters the covariance as an effect on the noise. Left alone, the mean of the second,
//! `½ σ² f''`, passes for a lag in proportion to acceleration, and how it scatters about that,
//! `½ f'' σ² √(κ - 1)` with the kurtosis `κ` and without correlation to `e`, for a level. Both are
//! put into the model beside the effect: the mean as a value that is known to a quarter, for `σ` is
//! an estimate, and the scatter as a random quantity of each sample.
//!
//! Random quantities that do not shift the times of all readings are taken as small.

use std::sync::Arc;

use crate::diagnose::evidence::Evidence;
use crate::diagnose::found::{Noise, NoiseEffect};
use crate::diagnose::library::candidate::fitting;
use crate::diagnose::stage::Stage;
use crate::diagnostic::Source;
use crate::effect::{Effect, Target};
use crate::graph::MeasurandKind;
use crate::model::{Model, Shape};
use crate::system::Selected;

/// Length of what the mean does, in units of the noise, from which on it counts.
const COUNTS: f64 = 1.0;
/// Relative standard uncertainty of the mean.
const KNOWN: f64 = 0.25;

/// The square of the first of the effects on times that were found, once its size was judged beside
/// all else, if it counts beside a stage's noise.
pub(super) fn square(stage: &Stage, noise: &Noise) -> Option<Selected> {
    let is_judged = |one: &&NoiseEffect| noise.grown.contains(&one.name);
    let one = noise.effects.iter().filter(is_judged).find(|one| shifts_all_times(one))?;
    let shape = stage.fitted.problem.parts.iter().find_map(|part| {
        let mut randoms = part.system.randoms.iter();
        randoms.find(|random| random.name == one.parameter).map(|random| random.shape)
    })?;
    let recipes = &stage.fitted.recipes;
    let model = &recipes.first()?.model;
    let effect = Arc::new(effect(model, one, shape)?);
    let selected = Selected { effect, head: None, member: Default::default() };
    let candidate = fitting(recipes, &selected, None)?;
    let (problem, fit) = (&stage.fitted.problem, &stage.fitted.fit);
    let evidence = Evidence::new(problem, &fit.normal, &fit.point, &[&candidate])?;
    let length = evidence.entries[0].lengths.norm() * mean(one.value);
    (length >= COUNTS).then_some(selected)
}

/// `½ σ²`.
fn mean(sigma: f64) -> f64 {
    0.5 * sigma * sigma
}

/// Whether an effect adds one random quantity to the times of all readings, and does nothing else.
fn shifts_all_times(found: &NoiseEffect) -> bool {
    let Some(selected) = &found.selected else { return false };
    let local = found.parameter.rsplit('.').next().unwrap_or_default();
    match &selected.effect.patches[..] {
        [line] => {
            line.target == Target::AllTimes && line.formula.text.trim() == format!("t + {local}")
        }
        _ => false,
    }
}

/// The square as an effect of a model's readings.
fn effect(model: &Model, found: &NoiseEffect, shape: Shape) -> Option<Effect> {
    let mean = mean(found.value);
    // √(κ - 1) of a normal and of a rectangular distribution.
    let scatter = mean * if shape == Shape::Uniform { 0.8_f64.sqrt() } else { 2.0_f64.sqrt() };
    let known = KNOWN * mean;
    let name = format!("{}_square", found.name.replace('.', "_"));
    let line = |name: &str| format!("{name} = '{name} + (mean + scatter) * rate(rate({name}))'\n");
    let readings = model.measurands.iter().filter(|one| one.kind != MeasurandKind::Rotation);
    let patches: String = readings.map(|one| line(&one.name)).collect();
    let text = format!(
        "name = \"{name}\"\ntitle = \"Square of times that are off\"\nacts = \"noise\"\n[parameters]\n\
         mean = {{ unit = \"s^2\", value = \"{mean:e} s^2\", sigma = \"{known:e} s^2\", typical = \"{mean:e} s^2\", scope = \"instrument\" }}\n\
         scatter = {{ unit = \"s^2\", value = \"{scatter:e} s^2\", fixed = true, scope = \"sample\" }}\n\
         [patch]\n{patches}"
    );
    let effect = Effect::parse(Source::new(name.as_str(), text));
    debug_assert!(effect.is_ok(), "{effect:?}");
    effect.ok()
}
