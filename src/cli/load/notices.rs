//! Notices before any result: values stated of effects that are not in the model, a problem in which
//! nothing moves.

use serde_json::json;

use super::{Loaded, merge};
use crate::cli::arguments::Format;
use crate::cli::{Failure, output, render};
use crate::diagnostic::Diagnostic;
use crate::report;

/// Warns of values that are stated of effects which are not in the model. Where the library is
/// tried, constants and members of families say what to look for: of other values those that are
/// found count.
pub(in crate::cli) fn tell_not_put_in(loaded: &Loaded, tries: bool) {
    let Some(recipe) = loaded.recipes.first().filter(|_| !loaded.quiet) else { return };
    let warnings = loaded.stated.iter().filter_map(|name| {
        let (owner, value) = name.split_once('.')?;
        let effect = recipe.library.effects().find(|effect| effect.name == owner)?;
        let value = value.rsplit('.').next()?;
        let is_free = effect.parameters.iter().any(|one| one.name == value && !one.setting.fixed);
        if recipe.effects.iter().any(|one| one.effect.name == owner) || (tries && !is_free) {
            return None;
        }
        let message = format!("`{name}` is stated, but that effect is not put in");
        let help = format!("put it into the model: --with {owner}");
        Some(Diagnostic::warning(message).help(help))
    });
    render::all(&warnings.collect::<Vec<_>>());
}

/// Says that nothing moves, for a command that asks for delays; `None` where something does.
pub(in crate::cli) fn nothing_moves(
    loaded: &Loaded,
    format: Format,
) -> Option<Result<(), Failure>> {
    if loaded.problem.moves() {
        return None;
    }
    Some(match format {
        Format::Json => {
            let mut whole = loaded.head.clone();
            merge(&mut whole, json!({ "nothing_moves": true }));
            output::json(&whole)
        }
        Format::Text => output::text(&format!(
            "{}\n\n{} `homepoint calibrate` estimates everything else.\n",
            loaded.title,
            report::text::NOTHING_MOVES
        )),
    })
}
