//! A stated value that is wrong altogether: another unit, a slip of the pen.
//!
//! It bends a fit so much that nothing else can be judged, and readings that are right look like outliers.
//! Each value that is stated is set free in turn; it is wrong where that alone makes a spoilt fit
//! sound, and no effect of the user's own does; or where a search found it contradicted by far, and one
//! with the value free explains far more. The search then goes on with the value free. What is wrong
//! by a few standard uncertainties is judged with everything else
//! ([`mod@crate::estimate::contradicted`]).

use std::collections::BTreeSet;

use crate::diagnose::fitted::Fitted;
use crate::diagnose::library::wanted::Wanted;
use crate::engine::Problem;
use crate::engine::layout::Instance;
use crate::engine::open::Recipe;
use crate::estimate::batch::{FitError, Options};
use crate::estimate::calibrate::{Calibration, calibrate};
use crate::estimate::contradicted::{BY_FAR, Contradicted, against};
use crate::graph::Kind;
use crate::model::Override;
use crate::units::Unit;

use super::settle::{SOUND_WITHOUT, is_spoilt};

/// A stated value that is wrong altogether.
#[derive(Clone, Debug)]
pub(in crate::diagnose) struct WrongValue {
    /// What is stated against what the readings say.
    pub(in crate::diagnose) contradicted: Contradicted,
    /// The fit with the value free.
    pub(in crate::diagnose) without: Calibration,
    /// That nothing is known of the value.
    free: Override,
}

impl WrongValue {
    /// The same recipes with the value free.
    pub(in crate::diagnose) fn recipes(&self, mut recipes: Vec<Recipe>) -> Vec<Recipe> {
        for (recipe, part) in recipes.iter_mut().zip(&self.without.problem.parts) {
            let mut parameters = part.system.assembly.names.parameters.iter();
            if parameters.any(|one| one.name == self.free.name) {
                recipe.overrides.push(self.free.clone());
            }
        }
        recipes
    }
}

/// The stated value without which a spoilt fit is sound, if there is one.
pub(in crate::diagnose) fn wrong_value(
    whole: &Calibration,
    recipes: &[Recipe],
    wanted: &Wanted,
    options: &Options,
) -> Result<Option<WrongValue>, FitError> {
    if !is_spoilt(whole) && whole.is_sound() {
        return Ok(None);
    }
    let spoilt = whole.variance_factor().unwrap_or(f64::INFINITY);
    let instances = &whole.problem.layout.instances;
    let is_stated = |index: &usize| {
        instances[*index].setting.value.is_some() && !whole.problem.layout.is_noise_only(*index)
    };
    let stated = (0..instances.len()).filter(is_stated);
    let names: BTreeSet<&String> = stated.map(|index| &instances[index].name).collect();
    let mut all = Vec::new();
    for name in names {
        all.extend(set_free(whole, name, options)?);
    }
    all.retain(|(factor, one)| SOUND_WITHOUT * factor < spoilt && !is_spoilt(&one.without));
    let Some((_, found)) = least(all) else { return Ok(None) };
    let is_an_effect = own_effect_does_as_much(whole, &found, recipes, wanted, options)?;
    Ok((!is_an_effect).then_some(found))
}

/// The stated value that the readings contradict by far beside what explains them best. Effects that
/// are there, too, may keep the fit without it from being sound.
pub(in crate::diagnose) fn wrong_value_beside(
    whole: &Calibration,
    contradicted: &[Contradicted],
    options: &Options,
) -> Result<Option<WrongValue>, FitError> {
    let by_far = contradicted.first().filter(|one| one.deviations > BY_FAR);
    let found = by_far.map(|one| set_free(whole, &one.parameter, options)).transpose()?;
    Ok(found.flatten().map(|(_, found)| found))
}

/// The best sound fit in which nothing is stated of a value, with its variance factor.
fn set_free(
    whole: &Calibration,
    name: &str,
    options: &Options,
) -> Result<Option<(f64, WrongValue)>, FitError> {
    let mut all = Vec::new();
    for start in starts(whole, name) {
        let free = Override { name: name.to_owned(), start, free: true, ..Override::default() };
        let without = calibrate(freed(whole, &free), options)?;
        if let Some(factor) = without.variance_factor().filter(|_| without.is_sound())
            && let Some(contradicted) = against(whole, &without, name)
        {
            all.push((factor, WrongValue { contradicted, without, free }));
        }
    }
    Ok(least(all))
}

/// That of the least variance factor.
fn least(all: Vec<(f64, WrongValue)>) -> Option<(f64, WrongValue)> {
    all.into_iter().min_by(|a, b| a.0.total_cmp(&b.0))
}

/// A fit with an effect does as much as one with a value free at so many times its cost at most.
const AS_MUCH: f64 = 1.5;

/// Whether an effect of the user's own makes the fit as sound: whoever describes it asks for it.
fn own_effect_does_as_much(
    whole: &Calibration,
    found: &WrongValue,
    recipes: &[Recipe],
    wanted: &Wanted,
    options: &Options,
) -> Result<bool, FitError> {
    let own = recipes.iter().flat_map(|recipe| recipe.library.own_effects());
    let own: BTreeSet<&str> = own.map(|effect| effect.name.as_str()).collect();
    let (problem, fit) = (whole.problem.clone(), whole.fit.clone());
    let stated = Fitted { recipes: recipes.to_vec(), problem, fit };
    let made = wanted.catalogue.of(recipes);
    for one in &wanted.of(made.offer.clone()).effects {
        if own.contains(one.selected.effect.name.as_str())
            && let Some(with) = stated.with(&one.selected, &[], options)?
            && with.is_sound()
            && with.fit.cost <= AS_MUCH * found.without.fit.cost
        {
            return Ok(true);
        }
    }
    Ok(false)
}

/// A thousand of one unit are one of another.
const PREFIX: f64 = 1e3;

/// Where a parameter of which nothing is stated may start: a number where the fit left it, or at what
/// is stated in a unit next to the one that is said; vectors and rotations as the model has it.
fn starts(whole: &Calibration, name: &str) -> Vec<Option<Vec<(f64, Unit)>>> {
    let mut all = whole.problem.layout.instances.iter().zip(&whole.fit.point.values);
    let is_own = |(one, _): &(&Instance, _)| one.name == name && one.kind == Kind::Scalar;
    let Some((one, left)) = all.find(is_own) else { return vec![None] };
    let stated = one.setting.value.as_ref().and_then(|all| all.first());
    let other = stated.into_iter().flat_map(|one| [one * PREFIX, one / PREFIX]);
    let finite = std::iter::once(left[0]).chain(other).filter(|one| one.is_finite());
    finite.map(|start| Some(vec![(start, one.unit.clone())])).collect()
}

/// The same problem with nothing stated of a parameter.
fn freed(whole: &Calibration, free: &Override) -> Problem {
    let mut parts = whole.problem.parts.clone();
    for part in &mut parts {
        let names = &part.system.assembly.names.parameters;
        let Some(parameter) = names.iter().position(|one| one.name == free.name) else { continue };
        part.system.settings_mut(parameter).for_each(|setting| free.apply(setting));
    }
    whole.problem.with_parts(parts)
}
