//! What has been made of models and effects, kept for the next time: the same models are looked at
//! again after each round of judging the noise, and in every trial of one design.
//!
//! To put an effect into a model, derive its signature and compile that takes longer than to use it. What
//! is made depends on the models, what is stated of them, and the effects in use: never on readings.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use indexmap::IndexMap;

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
///
/// Models by what is written of them, the one used last at the end.
#[derive(Clone, Debug, Default)]
pub struct Catalogue(Arc<Mutex<IndexMap<String, Arc<Made>>>>);

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
        if let Some(known) = last(&mut locked(&self.0), &key) {
            return known;
        }
        let (offer, blocks) = rayon::join(|| offer(recipes), || blocks(recipes));
        let made = Arc::new(Made { offer, blocks, signatures: Mutex::default() });
        let mut all = locked(&self.0);
        if all.insert(key, made.clone()).is_none() && all.len() > MOST_MODELS {
            all.shift_remove_index(0);
        }
        made
    }
}

/// What is kept under a key, which is then the last.
fn last(all: &mut IndexMap<String, Arc<Made>>, key: &str) -> Option<Arc<Made>> {
    let at = all.get_index_of(key)?;
    all.move_index(at, all.len() - 1);
    all.get(key).cloned()
}

/// What is kept, also where a thread that had it stopped.
fn locked<T>(kept: &Mutex<T>) -> MutexGuard<'_, T> {
    kept.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Made {
    /// The signatures of candidates in each campaign of a problem with the models of which this was made.
    pub fn signatures(&self, problem: &Problem, candidates: &[&Candidate]) -> Arc<Vec<Signatures>> {
        // Held parameters have no directions, whatever the models.
        let directions = |part| problem.programs(part).directions();
        let held: Vec<_> = (0..problem.parts.len()).map(directions).collect();
        let key = format!("{held:?} {}", key(candidates));
        if let Some(known) = locked(&self.signatures).get(&key) {
            return known.clone();
        }
        let made = sign(problem, candidates);
        let mut all = locked(&self.signatures);
        if all.len() < MOST_LISTS {
            all.insert(key, made.clone());
        }
        made
    }
}

/// The signatures of candidates in each campaign that they fit.
pub(in crate::diagnose) fn sign(
    problem: &Problem,
    candidates: &[&Candidate],
) -> Arc<Vec<Signatures>> {
    let of_part = |part: usize| {
        let signed = candidates.iter().enumerate().filter_map(|(number, one)| {
            Some(Signed { number, system: one.systems[part].as_deref()? })
        });
        Signatures::new(problem, part, &signed.collect::<Vec<_>>())
    };
    Arc::new((0..problem.parts.len()).map(of_part).collect())
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
    let written = |Selected { effect, head, member }: &Selected| {
        // Effects made while noise is judged differ in their text alone.
        format!("{} {} {head:?} {member:?}", effect.name, effect.source.text)
    };
    let effects: Vec<String> = recipe.effects.iter().map(written).collect();
    // Where a value is stated is no matter of what it is.
    let stated = |one: &Override| Override { place: None, ..one.clone() };
    let overrides: Vec<Override> = recipe.overrides.iter().map(stated).collect();
    let library: Vec<&str> = recipe.library.effects().map(|one| one.source.text.as_ref()).collect();
    format!(
        "{}|{effects:?}|{:?}|{:?}|{library:?}\n",
        recipe.model.source.text, overrides, recipe.input_sigma
    )
}
