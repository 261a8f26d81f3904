//! What the library offers, whatever the readings: every effect, at every head, with every member of its
//! families; and why the rest cannot be tested here. Effects on noise alone are set apart: they have no
//! signature and are looked for in the variance.

use std::collections::{BTreeMap, HashSet};
use std::sync::Arc;

use crate::effect::{Acts, Effect, Target};
use crate::engine::Problem;
use crate::engine::open::Recipe;
use crate::engine::part::Part;
use crate::graph::Scope;
use crate::system::{Selected, candidates, lacks, wanted_constants};

use super::candidate::{Candidate, Joined, NotTestable};

/// Members tried of a family that is a range.
const MEMBERS: usize = 25;

/// Why an effect over the time of all runs is not tested.
const NO_SEQUENCE: &str =
    "no run begins after another one has ended: the times of the runs are not in sequence";

/// Why an effect on times is not tested.
const NO_TIMES: &str = "the data have no times";

/// All that a library offers.
#[derive(Clone, Debug, Default)]
pub struct Offer {
    /// Effects with a signature.
    pub effects: Vec<Candidate>,
    /// Effects on the noise.
    pub noise: Vec<Candidate>,
    /// The rest.
    pub not_testable: Vec<NotTestable>,
}

impl Offer {
    /// What the runs of a problem can test: an effect on times only where there are times, and one over the
    /// time of all only where they are in sequence.
    #[must_use]
    pub fn of_runs(mut self, recipes: &[Recipe], problem: &Problem) -> Self {
        if problem.parts.iter().all(Part::is_untimed) {
            let on_times: HashSet<&str> = effects_of(recipes)
                .filter(|effect| effect.acts == Acts::Timing)
                .map(|effect| effect.name.as_str())
                .collect();
            let is_out = |name: &str| on_times.contains(name);
            self.not_testable.retain(|one| !is_out(&one.name));
            let out = self.effects.extract_if(.., |one| is_out(&one.name));
            self.not_testable.extend(out.map(|one| NotTestable::here(&one.name, NO_TIMES)));
        }
        if problem.runs_in_sequence() {
            return self;
        }
        let out = self.effects.extract_if(.., |one| one.selected.effect.runs_in_sequence);
        self.not_testable.extend(out.map(|one| NotTestable::here(&one.name, NO_SEQUENCE)));
        self
    }
}

/// Everything that the campaigns' libraries offer beside the effects in use.
pub fn offer(recipes: &[Recipe]) -> Offer {
    let mut offer = Offer::default();
    // Built-in detectors look for themselves.
    for effect in effects_of(recipes).filter(|effect| !effect.builtin) {
        let in_use =
            |recipe: &Recipe| recipe.effects.iter().any(|one| one.effect.name == effect.name);
        if recipes.iter().all(in_use) {
            continue;
        }
        match ways(recipes, effect) {
            Err(why) => {
                let of_other_models = recipes.iter().all(|recipe| lacks(&recipe.model, effect));
                let mut wants =
                    recipes.iter().map(|one| wanted_constants(&one.model, effect, &one.overrides));
                let wants = wants.find(|wants| !wants.is_empty()).unwrap_or_default();
                let name = effect.name.clone();
                offer.not_testable.push(NotTestable { name, why, of_other_models, wants });
            }
            Ok(ways) if is_noise(effect) => offer.noise.extend(ways),
            Ok(ways) => offer.effects.extend(ways),
        }
    }
    offer
}

/// The effects of all the campaigns' libraries, each name once.
pub fn effects_of(recipes: &[Recipe]) -> impl Iterator<Item = &Arc<Effect>> {
    let mut known = HashSet::new();
    let all = recipes.iter().flat_map(|recipe| recipe.library.effects());
    all.filter(move |effect| known.insert(effect.name.as_str()))
}

/// One candidate for each head and member, or why there is none.
fn ways(recipes: &[Recipe], effect: &Arc<Effect>) -> Result<Vec<Candidate>, String> {
    let mut joined = Joined::new(recipes.len());
    let mut why: Vec<String> = Vec::new();
    let mut own = recipes.iter().flat_map(|recipe| recipe.library.own_effects());
    let is_own = own.any(|one| one.name == effect.name);
    for (campaign, recipe) in recipes.iter().enumerate() {
        let heads = match candidates(&recipe.model, effect, &recipe.overrides) {
            Ok(heads) => heads,
            Err(reasons) => {
                why.extend(reasons.0.into_iter().map(|reason| reason.message));
                continue;
            }
        };
        for selected in heads {
            // Those of the library are known to be absent at zero.
            if is_own && let Some(remains) = recipe.remains(&selected, &recipe.overrides) {
                why.push(remains.message);
                continue;
            }
            for member in members(recipe, effect) {
                let selected = Selected { member, ..selected.clone() };
                match recipe.with(std::slice::from_ref(&selected)) {
                    Ok(system) => joined.add(campaign, selected, None, system),
                    Err(faults) => why.extend(faults.0.into_iter().map(|fault| fault.message)),
                }
            }
        }
    }
    why.dedup();
    if joined.found.is_empty() { Err(why.join("; ")) } else { Ok(joined.found) }
}

/// Every combination of members; of a family of which a campaign chose one, with that alone.
fn members(recipe: &Recipe, effect: &Effect) -> Vec<BTreeMap<String, f64>> {
    let chosen = |family: &String| {
        let name = format!("{}.{family}", effect.name);
        let line = recipe.overrides.iter().rev().find(|said| said.name == name)?;
        line.value.as_ref()?.first().map(|(value, _)| *value)
    };
    let mut all = vec![BTreeMap::new()];
    for (family, declared) in &effect.shape {
        let values = match chosen(family) {
            Some(value) => vec![value],
            None => declared.members.series(MEMBERS),
        };
        let with = |mut one: BTreeMap<String, f64>, value: f64| {
            one.insert(family.clone(), value);
            one
        };
        let each = |one| values.iter().map(move |value| with(BTreeMap::clone(one), *value));
        all = all.iter().flat_map(each).collect();
    }
    all
}

/// Whether an effect acts on noise alone: its parameters are random, or it patches noise levels alone.
pub fn is_noise(effect: &Effect) -> bool {
    let random = effect.parameters.iter().all(|one| one.setting.scope == Scope::Sample);
    let levels = effect
        .patches
        .iter()
        .all(|line| matches!(line.target, Target::Sigma(_) | Target::EachAngleSigma));
    random || levels
}
