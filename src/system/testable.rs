//! Which effects of a library can be tested on a model, and which names would let more be.

use std::sync::Arc;

use crate::effect::Effect;
use crate::model::{Model, Override};
use crate::system::needs::{heads_for, lacks_of, missing_at, roles_at};
use crate::system::stand_ins;

/// What of a library can be tested on a model.
#[derive(Clone, Debug, Default)]
pub struct Testable {
    /// The effects that can be, by name.
    pub effects: Vec<String>,
    /// How many there are.
    pub of: usize,
    /// Names that the model lacks, those that would add most effects first.
    pub lacking: Vec<Lacking>,
}

/// Names that a model lacks, and the effects that need these and no others.
#[derive(Clone, Debug)]
pub struct Lacking {
    /// As the library calls them.
    pub names: Vec<String>,
    /// By name.
    pub effects: Vec<String>,
}

/// What of these effects can be tested on a model. Constants that only a campaign can state count
/// as stated; built-in detectors need no names and look at every campaign.
pub fn testable<'e>(
    model: &Model,
    effects: impl Iterator<Item = &'e Arc<Effect>>,
    overrides: &[Override],
) -> Testable {
    let mut found = Testable::default();
    for effect in effects {
        found.of += 1;
        if effect.builtin {
            found.effects.push(effect.name.clone());
            continue;
        }
        let heads = heads_for(model, effect);
        let fits = |head: &Option<String>| lacks_of(model, effect, head.as_deref()).is_empty();
        let stated = [overrides, stand_ins(effect).as_slice()].concat();
        if heads.iter().any(fits) {
            if super::candidates(model, effect, &stated).is_ok() {
                found.effects.push(effect.name.clone());
            }
            continue;
        }
        let missing =
            |head: &Option<String>| missing_at(model, effect, &roles_at(model, head.as_deref()));
        let Some(mut names) = heads.iter().map(missing).min_by_key(Vec::len) else { continue };
        names.sort_unstable();
        names.dedup();
        if names.is_empty() {
            continue;
        }
        match found.lacking.iter_mut().find(|one| one.names == names) {
            Some(one) => one.effects.push(effect.name.clone()),
            None => found.lacking.push(Lacking { names, effects: vec![effect.name.clone()] }),
        }
    }
    found.lacking.sort_by_key(|one| std::cmp::Reverse(one.effects.len()));
    found
}
