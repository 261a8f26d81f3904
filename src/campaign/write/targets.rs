//! The files of a written campaign: their names, what is copied, and what must not be replaced.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::campaign::loaded::Campaign;
use crate::campaign::run::Run;
use crate::diagnostic::{Diagnostic, Diagnostics, Source};
use crate::effect::Effect;
use crate::library::{effect_files, is_model_path, model_file};

pub(super) const CAMPAIGN: &str = "campaign.toml";

/// The files of a written campaign, by their places in its folder.
pub(super) struct Targets {
    /// The table of each run.
    pub(super) tables: Vec<String>,
    /// Streams as the campaign names them, with their names there.
    pub(super) streams: Vec<(String, String)>,
    /// The campaign's own model and the effects beside it, with their texts.
    pub(super) declarations: Vec<(PathBuf, Arc<str>)>,
}

impl Targets {
    pub(super) fn of(
        folder: &Path,
        campaign: &Campaign,
        runs: &[Run],
    ) -> Result<Self, Diagnostics> {
        let tables = file_names(runs);
        let mut streams: Vec<(String, String)> = Vec::new();
        for stream in campaign.entries.iter().flat_map(|entry| &entry.signals) {
            let stream = &stream.name;
            if streams.iter().any(|(from, _)| *from == stream.text) {
                continue;
            }
            let base = Path::new(&stream.text)
                .file_name()
                .map_or("stream.csv".into(), |n| n.to_string_lossy());
            let taken = |name: &str| {
                tables.iter().any(|f| f == name) || streams.iter().any(|(_, to)| to == name)
            };
            let name = free_name(&base, taken);
            refuse_link(campaign, &campaign.folder.join(&stream.text))?;
            streams.push((stream.text.clone(), name));
        }
        let declarations = declarations(campaign)?;
        let places = declarations.iter().map(|(place, _)| folder.join(place));
        let names = tables.iter().chain(streams.iter().map(|(_, name)| name));
        let all = places.chain(names.map(|name| folder.join(name)));
        for target in all.chain([folder.join(CAMPAIGN)]) {
            campaign.files.refuse_replacing(&target)?;
        }
        Ok(Self { tables, streams, declarations })
    }
}

/// Refuses to copy what a link shows of a place outside the campaign's folder.
fn refuse_link(campaign: &Campaign, path: &Path) -> Result<(), Diagnostic> {
    if !campaign.files.is_linked_outside(path) {
        return Ok(());
    }
    let message = format!("`{}` is a link that leads out of the campaign's folder", path.display());
    Err(Diagnostic::error(message)
        .help("no such file is copied: put the file itself in the place of the link"))
}

/// The model as the written campaign names it, and the place of its file there if it is one of the
/// campaign's own: a name stays, a path becomes that of a file beside the campaign.
pub(super) fn model_reference(campaign: &Campaign) -> (String, Option<PathBuf>) {
    let text = &campaign.model.text;
    let own = model_file(text, &campaign.folder);
    match own.as_ref().and_then(|path| path.file_name()) {
        Some(file) if is_model_path(text) => {
            let name = file.to_string_lossy();
            let said = if is_model_path(&name) { name.into_owned() } else { format!("./{name}") };
            (said, Some(file.into()))
        }
        Some(file) => (text.clone(), Some(Path::new("models").join(file))),
        None => (text.clone(), None),
    }
}

/// The model of the campaign's own and the effects beside it: their places in a written campaign,
/// and their texts. Of what stands beside effects nothing else is copied.
fn declarations(campaign: &Campaign) -> Result<Vec<(PathBuf, Arc<str>)>, Diagnostics> {
    let read = |path: &Path| {
        refuse_link(campaign, path)?;
        Source::read(path)
    };
    let mut found = Vec::new();
    if let (Some(path), (_, Some(place))) =
        (model_file(&campaign.model.text, &campaign.folder), model_reference(campaign))
    {
        found.push((place, read(&path)?.text));
    }
    let effects = campaign.folder.join("effects");
    if effects.is_dir() {
        for path in effect_files(&effects)? {
            let source = read(&path)?;
            let text = source.text.clone();
            Effect::parse(source)?;
            let name = path.file_name().unwrap_or_default();
            found.push((Path::new("effects").join(name), text));
        }
    }
    Ok(found)
}

/// A file for each run, by its name; what a file name cannot hold becomes `_`.
fn file_names(runs: &[Run]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for run in runs {
        let safe: String = run
            .name
            .chars()
            .map(|c| if c.is_alphanumeric() || "_-+.".contains(c) { c } else { '_' })
            .collect();
        let safe = safe.trim_start_matches('.');
        let name = free_name(&format!("{safe}.csv"), |name| {
            names.iter().any(|other| other.eq_ignore_ascii_case(name))
        });
        names.push(name);
    }
    names
}

fn free_name(wish: &str, taken: impl Fn(&str) -> bool) -> String {
    let mut name = wish.to_owned();
    let mut count = 1;
    while taken(&name) {
        count += 1;
        name = format!("{count}_{wish}");
    }
    name
}
