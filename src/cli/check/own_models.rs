//! The models of one's own for which effects may be: those that are checked with them, and those of the
//! campaign in whose folder `effects` they lie.

use std::path::{Path, PathBuf};

use super::{is_campaign, is_effect};
use crate::campaign::file::CampaignFile;
use crate::diagnostic::Source;
use crate::library::Library;
use crate::model::Model;

/// These models with their names, each once.
pub(super) fn own_models(library: &Library, what: &[String]) -> Vec<(String, Model)> {
    let stated = what.iter().map(|one| (one.clone(), PathBuf::from(one)));
    let stated = stated.filter(|(_, path)| is_toml(path));
    let mut found: Vec<(String, Model)> = Vec::new();
    for (name, path) in stated.flat_map(|own| [vec![own.clone()], beside(&own.1)].concat()) {
        let own = Source::read(&path).ok().and_then(|source| model(library, name, &path, source));
        found.extend(own.filter(|(_, own)| found.iter().all(|(_, known)| known.name != own.name)));
    }
    found
}

fn is_toml(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "toml")
}

/// The files beside the folder `effects` in which an effect lies, with their names, in their order.
fn beside(path: &Path) -> Vec<(String, PathBuf)> {
    let whole = path.canonicalize().ok();
    let folder = whole.as_deref().and_then(Path::parent).filter(|own| own.ends_with("effects"));
    let entries = folder.and_then(Path::parent).and_then(|above| std::fs::read_dir(above).ok());
    let files = entries.into_iter().flatten().filter_map(|entry| {
        let entry = entry.ok()?;
        Some((entry.file_name().into_string().ok()?, entry.path()))
    });
    let mut files: Vec<_> = files.filter(|(_, path)| is_toml(path)).collect();
    files.sort();
    files
}

/// The model that a file is, or that it names as a campaign, with its name; none of the library.
fn model(library: &Library, name: String, path: &Path, source: Source) -> Option<(String, Model)> {
    if is_effect(&source) {
        return None;
    }
    if !is_campaign(&source) {
        return Some((name, Model::parse(source).ok()?));
    }
    let file = CampaignFile::read(path).ok()?;
    let named = file.model.text;
    let is_shipped = library.models().iter().any(|(shipped, _)| *shipped == named);
    let own = library.model(&named, &file.folder).ok().filter(|_| !is_shipped)?;
    Some((named, own))
}
