//! Effects that another campaign of a command has beside its file: a campaign does not have them
//! because another one does.

use std::path::{Path, PathBuf};

use crate::campaign::file::CampaignFile;
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::library::Library;
use crate::model::Override;

/// Refuses an effect, by itself or with a stated value, that this campaign lacks and one of `others`
/// (folders) has.
pub(super) fn refuse_elsewhere(
    (path, file): (&Path, &CampaignFile),
    library: &Library,
    others: &[PathBuf],
    (with, set): (&[String], &[Override]),
) -> Result<(), Diagnostics> {
    let owner = |name: &str| name.split('.').next().unwrap_or(name).to_owned();
    let asked = with.iter().map(|name| (owner(name), name));
    let of_values = set.iter().filter(|one| one.name.contains('.'));
    let of_values = of_values.map(|one| (owner(&one.name), &one.name));
    for (effect, name) in asked.chain(of_values) {
        if library.effect(&effect).is_ok() {
            continue;
        }
        let Some(folder) = others.iter().find_map(|other| found_beside(other, &effect)) else {
            continue;
        };
        let what = match effect == *name {
            true => format!("there is no effect `{effect}`"),
            false => format!("there is no effect `{effect}` for `{name}`"),
        };
        let message = format!("{what} beside the campaign `{}`", path.display());
        let help = format!(
            "`{0}` has it, which counts for that campaign alone: `--effects {0}` gives it to all",
            folder.display()
        );
        return Err(Diagnostic::error(message).at(file.model.place.clone()).help(help).into());
    }
    Ok(())
}

/// The folder of effects beside a campaign, if it has this one.
fn found_beside(campaign: &Path, effect: &str) -> Option<PathBuf> {
    let folder = campaign.join("effects");
    let library = Library::builtin().ok()?.with_effects_beside(campaign).ok()?;
    let is_own = library.own_effects().any(|one| one.name == effect);
    is_own.then_some(folder)
}
