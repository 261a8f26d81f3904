//! What may be added to the model: every effect of the library, at every head, with every member of
//! its families; and why the rest cannot be tested here.
//!
//! It does not look at readings. An effect that acts on noise alone is set apart: it has no signature
//! and is looked for in the variance.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::effect::{Effect, Members, Target};
use crate::engine::open::Recipe;
use crate::graph::Scope;
use crate::model::Process;
use crate::system::{Selected, System, candidates, lacks, wanted_constants};
use crate::units::Unit;

use super::catalogue::Catalogue;
use super::prior::Prior;
use super::structure::Place;

/// Members tried of a family that is a range.
const MEMBERS: usize = 25;

/// Something that may be added to the model.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// `collimation`, at a head `collimation.a`.
    pub name: String,
    /// The effect, its head and the members of its families.
    pub selected: Selected,
    /// Where unknown structure would sit; `None` for an effect of the library.
    pub place: Option<Place>,
    /// The model with it, campaign by campaign; `None` where it does not fit.
    pub systems: Vec<Option<Arc<System>>>,
}

impl Candidate {
    /// Whether it is a random walk.
    pub fn is_walk(&self) -> bool {
        let parameters = &self.selected.effect.parameters;
        !parameters.is_empty() && parameters.iter().all(|one| one.process == Process::Walk)
    }

    /// Whether both fit some campaign.
    pub(in crate::diagnose) fn is_beside(&self, other: &Self) -> bool {
        let mut both = self.systems.iter().zip(&other.systems);
        both.any(|(own, other)| own.is_some() && other.is_some())
    }

    /// The usual size (SI) of one of its parameters, by full name.
    pub fn typical(&self, parameter: &str) -> Option<f64> {
        self.find(parameter).and_then(|(system, index)| system.settings[index].typical)
    }

    /// The unit in which one of its parameters is declared, by full name.
    pub fn unit(&self, parameter: &str) -> Unit {
        let found = self.find(parameter);
        found.map_or_else(Unit::one, |(s, index)| s.assembly.names.parameters[index].unit.clone())
    }

    /// The measurand (by index) for which a parameter is, if there is one for each.
    pub fn measurand(&self, parameter: &str) -> Option<usize> {
        self.find(parameter).and_then(|(system, index)| system.declared[index].measurand)
    }

    /// Whether its values sum to zero over their scope.
    pub fn sums_to_zero(&self) -> bool {
        self.selected.effect.parameters.iter().any(|one| one.setting.sum_zero)
    }

    fn find(&self, parameter: &str) -> Option<(&System, usize)> {
        self.systems.iter().flatten().find_map(|system| {
            let names = &system.assembly.names.parameters;
            let index = names.iter().position(|one| one.name == parameter)?;
            Some((&**system, index))
        })
    }
}

/// An effect that cannot be tested here.
#[derive(Clone, Debug, PartialEq)]
pub struct NotTestable {
    /// The effect.
    pub name: String,
    /// A sentence.
    pub why: String,
    /// Whether it acts on what no campaign's model has.
    pub of_other_models: bool,
    /// The constants that a campaign need only state for it to be tested.
    pub wants: Vec<String>,
}

impl NotTestable {
    /// An effect that these models have a place for.
    pub(in crate::diagnose) fn here(name: &str, why: impl Into<String>) -> Self {
        Self { name: name.to_owned(), why: why.into(), of_other_models: false, wants: Vec::new() }
    }
}

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

/// Which effects are wanted.
#[derive(Clone, Debug, Default)]
pub struct Wanted {
    /// None but these, if any are named: effects at all heads, or as `EFFECT.HEAD` at one.
    pub only: Vec<String>,
    /// Not these.
    pub without: Vec<String>,
    /// How probable each cause is before the readings are looked at.
    pub prior: Prior,
    /// What has been made of the models so far: one for several diagnoses of campaigns with the same
    /// models saves its making.
    pub catalogue: Catalogue,
}

impl Wanted {
    /// As asked for.
    pub fn new(only: &[String], without: &[String]) -> Self {
        let (only, without) = (only.to_vec(), without.to_vec());
        Self { only, without, ..Self::default() }
    }

    /// Whether an effect at a head is; without a head, whether it is at any.
    pub fn includes(&self, name: &str, head: Option<&str>) -> bool {
        let means = |one: &String| match one.split_once('.') {
            None => one == name,
            Some((own, at)) => own == name && head.is_none_or(|head| head == at),
        };
        let excludes = |one: &String| means(one) && (head.is_some() || !one.contains('.'));
        (self.only.is_empty() || self.only.iter().any(means)) && !self.without.iter().any(excludes)
    }
}

/// Everything that the campaigns' libraries offer beside the effects in use.
pub fn offer(recipes: &[Recipe], wanted: &Wanted) -> Offer {
    let mut offer = Offer::default();
    let Some(first) = recipes.first() else { return offer };
    // Built-in detectors look for themselves.
    let offered = |effect: &&Arc<Effect>| !effect.builtin && wanted.includes(&effect.name, None);
    for effect in first.library.effects().filter(offered) {
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

/// One candidate for each head and member, or why there is none.
fn ways(recipes: &[Recipe], effect: &Arc<Effect>) -> Result<Vec<Candidate>, String> {
    let mut found: Vec<Candidate> = Vec::new();
    let mut why: Vec<String> = Vec::new();
    for (campaign, recipe) in recipes.iter().enumerate() {
        let heads = match candidates(&recipe.model, effect, &recipe.overrides) {
            Ok(heads) => heads,
            Err(reasons) => {
                why.extend(reasons.0.into_iter().map(|reason| reason.message));
                continue;
            }
        };
        let is_own = recipe.library.own_effects().any(|one| one.name == effect.name);
        for selected in heads {
            // Those of the library are known to be absent at zero.
            if let Some(remains) =
                is_own.then(|| recipe.remains(&selected, &recipe.overrides)).flatten()
            {
                why.push(remains.message);
                continue;
            }
            let chosen = chosen_members(recipe, effect);
            for member in members(effect, &chosen) {
                let selected = Selected { member, ..selected.clone() };
                match recipe.with(std::slice::from_ref(&selected)) {
                    Ok(system) => {
                        join(&mut found, (campaign, recipes.len()), selected, None, system)
                    }
                    Err(faults) => why.extend(faults.0.into_iter().map(|fault| fault.message)),
                }
            }
        }
    }
    why.dedup();
    if found.is_empty() { Err(why.join("; ")) } else { Ok(found) }
}

/// Adds a campaign's system to the candidate that is the same in other campaigns.
pub(in crate::diagnose) fn join(
    found: &mut Vec<Candidate>,
    (campaign, campaigns): (usize, usize),
    selected: Selected,
    place: Option<Place>,
    system: System,
) {
    let name = match &selected.head {
        Some(head) => format!("{}.{head}", selected.effect.name),
        None => selected.effect.name.clone(),
    };
    let system = Some(Arc::new(system));
    let same = |one: &&mut Candidate| one.name == name && one.selected.member == selected.member;
    match found.iter_mut().find(same) {
        Some(one) => one.systems[campaign] = system,
        None => {
            let mut systems = vec![None; campaigns];
            systems[campaign] = system;
            found.push(Candidate { name, selected, place, systems });
        }
    }
}

/// An effect as it fits campaigns of these models; `None` where it fits none.
pub fn fitting(
    recipes: &[Recipe],
    selected: &Selected,
    place: Option<&Place>,
) -> Option<Candidate> {
    let mut found = Vec::new();
    for (campaign, recipe) in recipes.iter().enumerate() {
        if let Ok(system) = recipe.with(std::slice::from_ref(selected)) {
            let at = (campaign, recipes.len());
            join(&mut found, at, selected.clone(), place.cloned(), system);
        }
    }
    found.pop()
}

/// The members that a campaign chose.
fn chosen_members(recipe: &Recipe, effect: &Effect) -> BTreeMap<String, f64> {
    let said = |family: &String| {
        let name = format!("{}.{family}", effect.name);
        let line = recipe.overrides.iter().rev().find(|said| said.name == name)?;
        line.value.as_ref()?.first().map(|(value, _)| *value)
    };
    effect.shape.keys().filter_map(|family| Some((family.clone(), said(family)?))).collect()
}

/// Every combination of members.
fn members(effect: &Effect, chosen: &BTreeMap<String, f64>) -> Vec<BTreeMap<String, f64>> {
    let mut all = vec![BTreeMap::new()];
    for (family, declared) in &effect.shape {
        let values = match chosen.get(family) {
            Some(value) => vec![*value],
            None => values(&declared.members),
        };
        let with = |one: &BTreeMap<String, f64>, value: f64| {
            let mut one = one.clone();
            one.insert(family.clone(), value);
            one
        };
        all =
            all.iter().flat_map(|one| values.iter().map(move |value| with(one, *value))).collect();
    }
    all
}

/// The members of a family that are tried: all of a list, a geometric or (through zero) even series
/// of a range.
pub fn values(members: &Members) -> Vec<f64> {
    match members {
        Members::List(list) => list.clone(),
        Members::Range { from, to } => (0..MEMBERS)
            .map(|k| {
                let share = k as f64 / (MEMBERS - 1) as f64;
                if *from > 0.0 {
                    from * (to / from).powf(share)
                } else {
                    from + (to - from) * share
                }
            })
            .collect(),
    }
}

/// Whether an effect acts on noise alone: all its parameters are random, or all its patches are of
/// noise levels.
pub fn is_noise(effect: &Effect) -> bool {
    let random = effect.parameters.iter().all(|one| one.setting.scope == Scope::Sample);
    let levels = effect
        .patches
        .iter()
        .all(|line| matches!(line.target, Target::Sigma(_) | Target::EachAngleSigma));
    random || levels
}

#[cfg(test)]
mod tests {
    use super::Wanted;

    #[test]
    fn an_effect_is_wanted_at_all_heads_or_at_one() {
        let names = |names: &[&str]| names.iter().map(|one| (*one).to_owned()).collect::<Vec<_>>();
        let all = Wanted::default();
        assert!(all.includes("collimation", Some("a")) && all.includes("clock_drift", None));
        let only = Wanted::new(&names(&["collimation.a"]), &[]);
        assert!(only.includes("collimation", Some("a")) && only.includes("collimation", None));
        assert!(!only.includes("collimation", Some("b")) && !only.includes("clock_drift", None));
        let without = Wanted::new(&[], &names(&["collimation.a", "clock_drift"]));
        assert!(
            without.includes("collimation", Some("b")) && without.includes("collimation", None)
        );
        assert!(
            !without.includes("collimation", Some("a")) && !without.includes("clock_drift", None)
        );
    }
}
