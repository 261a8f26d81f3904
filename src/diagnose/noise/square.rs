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
use crate::diagnose::library::candidate::{fitting, with_only};
use crate::diagnose::stage::Stage;
use crate::diagnostic::Source;
use crate::effect::Effect;
use crate::engine::open::Recipe;
use crate::graph::MeasurandKind;
use crate::graph::recognise::time_shift;
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
    let recipes = &stage.fitted.recipes;
    let shift = |one| recipes.iter().find_map(|recipe| shift_of_times(recipe, one));
    let mut judged = noise.effects.iter().filter(is_judged);
    let (one, shift) = judged.find_map(|one| Some((one, shift(one)?)))?;
    let shape = stage.fitted.problem.parts.iter().find_map(|part| {
        let mut randoms = part.system.randoms.iter();
        randoms.find(|random| random.name == one.parameter).map(|random| random.shape)
    })?;
    let model = &recipes.first()?.model;
    let effect = Arc::new(effect(model, &one.name, mean(one.value * shift), shape)?);
    let selected = Selected { effect, head: None, member: Default::default() };
    let candidate = fitting(recipes, &selected, None)?;
    let (problem, fit) = (&stage.fitted.problem, &stage.fitted.fit);
    let evidence = Evidence::new(problem, &fit.normal, &fit.point, &[&candidate])?;
    let length = evidence.entries[0].lengths.norm() * mean(one.value * shift);
    (length >= COUNTS).then_some(selected)
}

/// `½ σ²`.
fn mean(sigma: f64) -> f64 {
    0.5 * sigma * sigma
}

/// The factor by which an effect shifts the times of all readings, if it has one random quantity
/// and does nothing else, see [`time_shift`].
fn shift_of_times(recipe: &Recipe, found: &NoiseEffect) -> Option<f64> {
    let system = with_only(recipe, Some(found.selected.as_ref()?))?;
    let [effect] = &system.effects[..] else { return None };
    match effect.randoms[..] {
        [random]
            if effect.parameters.is_empty() && system.randoms[random].name == found.parameter =>
        {
            time_shift(&system.assembly, random as u32)
        }
        _ => None,
    }
}

/// The square as an effect of a model's readings.
fn effect(model: &Model, found: &str, mean: f64, shape: Shape) -> Option<Effect> {
    // √(κ - 1) of a normal and of a rectangular distribution.
    let scatter = mean * if shape == Shape::Uniform { 0.8_f64.sqrt() } else { 2.0_f64.sqrt() };
    let known = KNOWN * mean;
    let name = format!("{}_square", found.replace('.', "_"));
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

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use std::path::Path;

    use super::*;
    use crate::library::Library;
    use crate::units::Unit;

    /// What is recognised of an effect with the random quantity `jitter` and these patches.
    fn recognised(more: &str, patches: &str) -> Option<f64> {
        let library = Library::builtin().unwrap();
        let model = library.model("polar_two_rotations", Path::new(".")).unwrap();
        let text = format!(
            "name = \"own\"\ntitle = \"own\"\nacts = \"noise\"\n[parameters]\n\
             jitter = {{ unit = \"s\", typical = \"10 us\", scope = \"sample\" }}\n{more}\n\
             [patch]\n{patches}\n"
        );
        let effect = Arc::new(Effect::parse(Source::new("own", text)).unwrap());
        let input_sigma = vec![None; model.inputs.len()];
        let (effects, overrides) = (Vec::new(), Vec::new());
        let recipe = Recipe { library, model, effects, overrides, input_sigma };
        let found = NoiseEffect {
            name: "own".to_owned(),
            selected: Some(Selected { effect, head: None, member: Default::default() }),
            parameter: "own.jitter".to_owned(),
            of: None,
            unit: Unit::second(),
            value: 1e-5,
            sigma: 1e-6,
            also: Vec::new(),
            aliases: Vec::new(),
            memory: None,
            ln_p: -100.0,
        };
        assert!(with_only(&recipe, found.selected.as_ref()).is_some(), "{patches}");
        shift_of_times(&recipe, &found)
    }

    #[test]
    fn jitter_is_recognised_however_it_is_written() {
        for formula in [
            "t + jitter",
            "jitter + t",
            "t+jitter",
            "  t  +  jitter ",
            "(jitter) + (t)",
            "t - (-jitter)",
            "1 * jitter + t",
            "t + jitter / 1",
            "self + jitter",
            "t + 0.5 * jitter + jitter / 2",
            "-(-t - jitter)",
        ] {
            assert_eq!(recognised("", &format!("t = '{formula}'")), Some(1.0), "{formula}");
        }
        for (formula, factor) in
            [("t - jitter", -1.0), ("-jitter + t", -1.0), ("t + 2 * jitter", 2.0)]
        {
            assert_eq!(recognised("", &format!("t = '{formula}'")), Some(factor), "{formula}");
        }
        let each = "\"horizontal.t\" = 't + jitter'\n\"vertical.t\" = 'jitter + t'\n\
                    \"distance.t\" = 'self + jitter'";
        assert_eq!(recognised("", each), Some(1.0));
    }

    #[test]
    fn what_does_more_or_less_than_shift_all_times_is_no_jitter() {
        for patches in [
            "\"horizontal.t\" = 't + jitter'",
            "t = 't + jitter * abs(rate(arm_angle)) * 1 s'",
            "t = 't + jitter * cos(arm_angle)'",
            "t = 't + abs(jitter)'",
            "distance = 'distance + jitter * 1 m / 1 s'",
            "t = 't + jitter'\ndistance = 'distance + jitter * 1 m / 1 s'",
            "\"horizontal.t\" = 't + jitter'\n\"vertical.t\" = 't + 2 * jitter'\n\
             \"distance.t\" = 't + jitter'",
        ] {
            assert_eq!(recognised("", patches), None, "{patches}");
        }
        let gate = "gate = { unit = \"s\", typical = \"10 us\", scope = \"instrument\" }";
        assert_eq!(recognised(gate, "t = 't + jitter + gate'"), None);
        let other = "other = { unit = \"s\", typical = \"10 us\", scope = \"sample\" }";
        assert_eq!(recognised(other, "t = 't + jitter + other'"), None);
    }
}
