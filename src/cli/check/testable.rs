//! How much of the library a model lets be tested.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

use crate::effect::Effect;
use crate::engine::open::Recipe;
use crate::model::Model;
use crate::system::testable;

/// How many sets of roles that would let more effects be tested are listed, and how many effects of
/// each are named.
const MOST_ROLES: usize = 3;
const MOST_NAMED: usize = 4;
/// For so many of the names a model may have nothing yet.
const MOST_UNMATCHED: usize = 1;

/// How many effects of the library can be tested, and which roles would let more be.
pub(super) fn testable_in(recipe: &Recipe) -> String {
    let models = recipe.library.models().iter();
    let known: Vec<Model> =
        models.filter_map(|(name, _)| recipe.library.model(name, Path::new("")).ok()).collect();
    let own: BTreeSet<&str> =
        recipe.library.own_effects().map(|effect| effect.name.as_str()).collect();
    let is_own = |effect: &&Arc<Effect>| own.contains(effect.name.as_str());
    let of = |effects: Vec<&Arc<Effect>>| {
        testable(&recipe.model, effects.into_iter(), &recipe.overrides, &known)
    };
    let (own, shipped): (Vec<_>, Vec<_>) = recipe.library.effects().partition(is_own);
    let (own, found) = (of(own), of(shipped));
    let mut said = format!(
        "\n  {} of the {} effects of the library can be tested here",
        found.effects.len(),
        found.of
    );
    if own.of > 0 {
        said.push_str(&format!(", and {} of {} of your own", own.effects.len(), own.of));
    }
    let several =
        found.lacking.iter().filter(|one| one.effects.len() > 1 && one.unmatched <= MOST_UNMATCHED);
    for one in several.take(MOST_ROLES) {
        let roles: Vec<String> = one.names.iter().map(|name| format!("{name} = \"...\"")).collect();
        let count = one.effects.len();
        let more = if count > MOST_NAMED { ", ..." } else { "" };
        said.push_str(&format!(
            "\n    {count} more with [roles] {} in the model: {}{more}",
            roles.join(", "),
            one.effects.iter().take(MOST_NAMED).cloned().collect::<Vec<_>>().join(", "),
        ));
    }
    said
}
