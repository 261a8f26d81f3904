//! What a user states on the command line, of a parameter everywhere or in one setup: a value that
//! holds exactly, a value with its standard uncertainty, or where a fit starts.

use crate::campaign::file::CampaignFile;
use crate::diagnostic::{Diagnostic, Diagnostics, nearest};
use crate::library::Library;
use crate::model::Override;
use crate::system::Selected;
use crate::units::{Unit, parse_quantity};

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
    let is_start = |one: &&Override| one.setup.as_ref() == Some(name) && one.start.is_some();
    let option = if set.iter().any(|one| is_start(&one)) { "--start" } else { "--set" };
    let error = Diagnostic::error(format!("`{option}`: there is no setup `{name}`"));
    Err(match nearest(name, known.iter().copied()) {
        Some(near) => error.help(format!("did you mean `{near}`?")),
        None => error.help(format!("known: {}", known.join(", "))),
    }
    .into())
}

/// Reads `NAME=VALUE`, which holds exactly, or `NAME=VALUE~SIGMA`.
pub(super) fn stated(text: &str) -> Result<Override, Diagnostic> {
    let (name, setup, values) = said("--set", text)?;
    let of = |part: &str| quantity("--set", text, part);
    let (with, without): (Vec<&str>, Vec<&str>) =
        values.split(',').partition(|part| part.contains('~'));
    if without.is_empty() {
        let pairs = with.into_iter().filter_map(|part| part.split_once('~'));
        let pairs = pairs.map(|(value, sigma)| Ok((of(value)?, of(sigma)?)));
        let (value, sigma) = pairs.collect::<Result<(Vec<_>, Vec<_>), Diagnostic>>()?;
        let (value, sigma) = (Some(value), Some(sigma));
        return Ok(Override { name, setup, value, sigma, ..Override::default() });
    }
    if !with.is_empty() {
        let message = format!("`--set {text}`: some components have a sigma, others have none");
        let help = "state components one by one, as in --set lever.z=\"10 mm~1 mm\"";
        return Err(Diagnostic::error(message).help(help));
    }
    let value = Some(without.into_iter().map(of).collect::<Result<Vec<_>, _>>()?);
    Ok(Override { name, setup, value, fixed: Some(true), ..Override::default() })
}

/// Reads `NAME=VALUE` of `--start`.
pub(super) fn started(text: &str) -> Result<Override, Diagnostic> {
    let (name, setup, values) = said("--start", text)?;
    let values = values.split(',').map(|part| quantity("--start", text, part));
    let start = Some(values.collect::<Result<Vec<_>, _>>()?);
    Ok(Override { name, setup, start, ..Override::default() })
}

/// What is said of a parameter of an effect that is not put in says where to look, as of a family's
/// member or a constant; what the effect leaves free stays free.
pub(super) fn held(said: &Override, library: &Library, put_in: &[Selected]) -> Override {
    let mut said = said.clone();
    let effect = said.name.split_once('.').map(|(owner, _)| owner).filter(|owner| {
        library.effects().any(|effect| effect.name == *owner)
            && !put_in.iter().any(|one| one.effect.name == *owner)
    });
    if effect.is_some() {
        said.fixed = None;
    }
    said
}

/// The name, the setup if one is said, and the values of `NAME=VALUES` or `NAME@SETUP=VALUES`.
fn said<'t>(option: &str, text: &'t str) -> Result<(String, Option<String>, &'t str), Diagnostic> {
    let Some((name, values)) = text.split_once('=') else {
        return Err(fault(option, format!("`{option} {text}` has no `=`")));
    };
    let (name, setup) = match name.split_once('@') {
        Some((name, setup)) => (name, Some(setup.trim().to_owned())),
        None => (name, None),
    };
    Ok((name.trim().to_owned(), setup, values))
}

fn quantity(option: &str, text: &str, part: &str) -> Result<(f64, Unit), Diagnostic> {
    parse_quantity(part.trim())
        .map_err(|error| fault(option, format!("`{option} {text}`: {error}")))
}

fn fault(option: &str, message: String) -> Diagnostic {
    let help = match option {
        _ if message.contains("=[") => {
            "components are separated by commas, without brackets, as in --set lever=\"0 m,0 m,10 mm\""
        }
        "--start" => "as in --start camera.delay=\"-40 ms\"",
        _ => "as in --set collimation.offset=\"4 arcsec\"",
    };
    Diagnostic::error(message).help(help)
}
