//! What a user states on the command line, of a parameter everywhere or in one setup.

use crate::campaign::file::CampaignFile;
use crate::diagnostic::{Diagnostic, Diagnostics, nearest};
use crate::model::Override;
use crate::units::parse_quantity;

/// Whether a campaign has a run in this setup.
pub(super) fn has_setup(file: &CampaignFile, name: &str) -> bool {
    file.runs.iter().any(|run| run.setup == name)
}

/// Refuses what is said of a setup that no campaign has.
pub(super) fn in_setups(set: &[Override], files: &[CampaignFile]) -> Result<(), Diagnostics> {
    let nowhere = |name: &&String| !files.iter().any(|file| has_setup(file, name));
    let Some(name) = set.iter().filter_map(|one| one.setup.as_ref()).find(nowhere) else {
        return Ok(());
    };
    let mut known: Vec<&str> =
        files.iter().flat_map(|file| file.runs.iter().map(|run| run.setup.as_str())).collect();
    known.sort_unstable();
    known.dedup();
    let error = Diagnostic::error(format!("`--set`: there is no setup `{name}`"));
    Err(match nearest(name, known.iter().copied()) {
        Some(near) => error.help(format!("did you mean `{near}`?")),
        None => error.help(format!("known: {}", known.join(", "))),
    }
    .into())
}

/// Reads `NAME=VALUE` or, of what holds in one setup, `NAME@SETUP=VALUE`.
pub(super) fn stated(text: &str) -> Result<Override, Diagnostic> {
    let fault = |message: String| {
        Diagnostic::error(message).help("as in --set collimation.offset=\"4 arcsec\"")
    };
    let Some((name, value)) = text.split_once('=') else {
        return Err(fault(format!("`--set {text}` has no `=`")));
    };
    let values = value
        .split(',')
        .map(|part| parse_quantity(part).map_err(|error| fault(format!("`--set {text}`: {error}"))))
        .collect::<Result<Vec<_>, _>>()?;
    let (name, setup) = match name.split_once('@') {
        Some((name, setup)) => (name, Some(setup.trim().to_owned())),
        None => (name, None),
    };
    let name = name.trim().to_owned();
    Ok(Override { name, setup, value: Some(values), ..Override::default() })
}
