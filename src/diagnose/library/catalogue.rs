//! What has been made of models and effects, kept for the next time: the same models are looked at
//! again after each round of judging the noise, and in every trial of one design.
//!
//! To put an effect into a model, derive its signature and compile that takes longer than to use
//! it. What is made depends on the models, what is stated of them, and the effects in use: never on
//! readings.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use crate::engine::Problem;
use crate::engine::open::Recipe;
use crate::engine::signatures::{Candidate as Signed, Signatures};
use crate::model::Override;
use crate::system::Selected;

use super::candidate::Candidate;
use super::offer::{Offer, offer};
use super::structure::blocks;
use super::variant::scopes_of;

/// Models with certain effects that are kept at most: those used last. Each takes some 50 MB.
const MOST_MODELS: usize = 8;
/// Families whose signatures are kept at most for each.
const MOST_LISTS: usize = 8;

/// What has been made so far; clones share it.
#[derive(Clone, Debug, Default)]
pub struct Catalogue(Arc<Mutex<Recent>>);

/// Models by what is written of them, the one used last at the end.
type Recent = Vec<(String, Arc<Made>)>;

/// What has been made of models with certain effects.
#[derive(Debug)]
pub struct Made {
    /// All that the library offers, whatever is wanted of it.
    pub offer: Offer,
    /// Blocks of unknown structure.
    pub blocks: Vec<Candidate>,
    signatures: Mutex<HashMap<String, Arc<Vec<Signatures>>>>,
}

impl Catalogue {
    /// What there is beside the effects in use.
    pub fn of(&self, recipes: &[Recipe]) -> Arc<Made> {
        // Relaxed forms differ in no text.
        let forms = |one: &Recipe| -> String {
            one.effects.iter().map(|own| scopes_of(&own.effect)).collect()
        };
        let key: String = recipes.iter().map(|one| written(one) + &forms(one)).collect();
        if let Some(known) = self.known(&key) {
            return known;
        }
        let made = Arc::new(Made {
            offer: offer(recipes),
            blocks: blocks(recipes),
            signatures: Mutex::default(),
        });
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if !all.iter().any(|(known, _)| *known == key) {
            if all.len() >= MOST_MODELS {
                all.remove(0);
            }
            all.push((key, made.clone()));
        }
        drop(all);
        made
    }

    fn known(&self, key: &str) -> Option<Arc<Made>> {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let at = all.iter().position(|(known, _)| known == key)?;
        let used = all.remove(at);
        let made = used.1.clone();
        all.push(used);
        Some(made)
    }
}

impl Made {
    /// The signatures of some candidates in each campaign of a problem that has the models of which
    /// this was made.
    pub fn signatures(&self, problem: &Problem, candidates: &[&Candidate]) -> Arc<Vec<Signatures>> {
        // Held parameters have no directions, whatever the models.
        let directions = |part| problem.programs(part).directions();
        let held: Vec<_> = (0..problem.parts.len()).map(directions).collect();
        let key = format!("{held:?} {}", key(candidates));
        let known =
            self.signatures.lock().unwrap_or_else(PoisonError::into_inner).get(&key).cloned();
        if let Some(known) = known {
            return known;
        }
        let made = sign(problem, candidates);
        let mut all = self.signatures.lock().unwrap_or_else(PoisonError::into_inner);
        if all.len() < MOST_LISTS {
            all.insert(key, made.clone());
        }
        made
    }
}

/// The signatures of candidates in each campaign.
pub(in crate::diagnose) fn sign(
    problem: &Problem,
    candidates: &[&Candidate],
) -> Arc<Vec<Signatures>> {
    let parts = 0..problem.parts.len();
    Arc::new(parts.map(|part| sign_in(problem, part, candidates)).collect())
}

/// Those of the candidates that fit a campaign; an effect is called by its number.
fn sign_in(problem: &Problem, part: usize, candidates: &[&Candidate]) -> Signatures {
    let names: Vec<String> = (0..candidates.len()).map(|number| number.to_string()).collect();
    let signed: Vec<Signed<'_>> = candidates
        .iter()
        .zip(&names)
        .filter_map(|(one, name)| Some(Signed { name, system: one.systems[part].as_deref()? }))
        .collect();
    Signatures::new(problem, part, &signed)
}

/// All that the signatures of candidates hang on, for the same models.
pub(in crate::diagnose) fn key(candidates: &[&Candidate]) -> String {
    let of = |one: &&Candidate| {
        let Selected { effect, member, .. } = &one.selected;
        format!("{} {} {member:?};", one.name, scopes_of(effect))
    };
    candidates.iter().map(of).collect()
}

/// All that a model with effects hangs on.
pub fn written(recipe: &Recipe) -> String {
    let effects: Vec<String> = recipe
        .effects
        .iter()
        .map(|one| {
            let Selected { effect, head, member } = one;
            // Effects made while noise is judged differ in their text alone.
            format!("{} {} {head:?} {member:?}", effect.name, effect.source.text)
        })
        .collect();
    // Where a value is stated is no matter of what it is.
    let stated = |one: &Override| Override { place: None, ..one.clone() };
    let overrides: Vec<Override> = recipe.overrides.iter().map(stated).collect();
    let library: Vec<&str> = recipe.library.effects().map(|one| one.source.text.as_ref()).collect();
    format!(
        "{}|{effects:?}|{:?}|{:?}|{library:?}\n",
        recipe.model.source.text, overrides, recipe.input_sigma
    )
}
