//! Whether campaigns that share a rig or an instrument state the same of its parameters.

use std::collections::BTreeSet;

use super::recipe::Recipe;
use crate::diagnostic::{Diagnostic, Diagnostics, Severity};
use crate::engine::part::Part;
use crate::engine::problem::layout_with;
use crate::system::System;

/// Refuses statements on parameters in use that do not fit together; of effects that are not in
/// use, the statements that would not, as warnings.
pub(super) fn agree(parts: &[Part], recipes: &[Recipe]) -> Result<Vec<Diagnostic>, Diagnostics> {
    if parts.len() < 2 {
        return Ok(Vec::new());
    }
    let in_use = parts.iter().map(|part| &part.system);
    Diagnostics(layout_with(parts, in_use).conflicts).into_result(())?;
    let warning = |one: Diagnostic| Diagnostic { severity: Severity::Warning, ..one };
    let unused = stated_unused(recipes);
    let conflicts = unused.iter().flat_map(|effect| conflicts_with(effect, parts, recipes));
    Ok(conflicts.map(warning).collect())
}

/// Effects of which some campaign states values, but which it does not use.
fn stated_unused(recipes: &[Recipe]) -> BTreeSet<String> {
    let of_one = |recipe: &Recipe| -> Vec<String> {
        let owners = recipe.overrides.iter().filter_map(|said| said.name.split_once('.'));
        let is_unused = |name: &str| {
            recipe.library.effects().any(|effect| effect.name == name && !effect.builtin)
                && !recipe.effects.iter().any(|one| one.effect.name == name)
        };
        owners.map(|(owner, _)| owner.to_owned()).filter(|owner| is_unused(owner)).collect()
    };
    recipes.iter().flat_map(of_one).collect()
}

/// What would not fit together were an effect in use; nothing where it does not fit the models.
fn conflicts_with(effect: &str, parts: &[Part], recipes: &[Recipe]) -> Vec<Diagnostic> {
    let with = |recipe: &Recipe| -> Option<System> {
        recipe.with(&[recipe.library.select(effect).ok()?]).ok()
    };
    let systems: Option<Vec<System>> = recipes.iter().map(with).collect();
    systems.map_or_else(Vec::new, |systems| layout_with(parts, systems.iter()).conflicts)
}
