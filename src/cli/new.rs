//! `homepoint new`: a model to start from, or a campaign begun from logs.

use std::path::{Component, Path, PathBuf};

use clap::Args;

use super::{Failure, output, render};
use crate::campaign::begin::{NamedModel, begin};
use crate::diagnostic::Diagnostic;
use crate::document::files::Files;
use crate::library::{self, Library, is_model_path};

#[derive(Debug, Args)]
pub(super) struct New {
    /// The file to write: a model, say my_instrument.toml; with `--from` a campaign, or the folder in
    /// which campaign.toml is written (`campaign` is ./campaign.toml)
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Begin a campaign from these logs: one table, or the logs of two recorders. Columns, units and a
    /// model are guessed, and marked as guesses
    #[arg(long, value_name = "LOG", num_args = 1..)]
    from: Vec<PathBuf>,
    /// The campaign's model: a name in the library, or a file
    #[arg(long, value_name = "MODEL", requires = "from")]
    model: Option<String>,
    /// Of a path of dead reckoning: the scale of its heading at which its bend is computed. Else that of
    /// the headings of both logs
    #[arg(long, value_name = "SCALE", requires = "from", allow_negative_numbers = true)]
    heading_scale: Option<f64>,
    /// No warnings, no progress
    #[arg(long)]
    pub(super) quiet: bool,
}

impl New {
    pub(super) fn run(&self) -> Result<(), Failure> {
        if !self.from.is_empty() {
            return self.campaign();
        }
        // Elsewhere a name without any ending is one in the library.
        let file = match self.file.extension() {
            Some(_) => self.file.clone(),
            None => self.file.with_extension("toml"),
        };
        // Other commands read a file of this name as a campaign.
        if file.file_name().is_some_and(|name| name == "campaign.toml") {
            let message = "`campaign.toml` is the file of a campaign, and `new` without `--from` writes a model";
            return Err(Diagnostic::error(message)
                .help("begin a campaign from logs: `homepoint new campaign --from a.csv b.csv`")
                .help("or give the model another name: `homepoint new my_instrument.toml`")
                .into());
        }
        free(&file)?;
        let stem = file.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
        let name: String = stem
            .chars()
            .map(|c| if c.is_ascii_alphanumeric() || c == '_' { c } else { '_' })
            .collect();
        let name = if name.starts_with(|c: char| c.is_ascii_alphabetic()) {
            name
        } else {
            "instrument".to_owned()
        };
        output::file(&file, &library::template(&name), &Files::default())?;
        output::text(&format!(
            "wrote {0}\nnext: `homepoint check {0}`, then `homepoint show {0}`\n",
            file.display()
        ))
    }

    /// Begins a campaign from logs.
    fn campaign(&self) -> Result<(), Failure> {
        let is_toml = self.file.extension().is_some_and(|extension| extension == "toml");
        let path = if is_toml {
            self.file.clone()
        } else if self.file == Path::new("campaign") && !self.file.is_dir() {
            PathBuf::from("campaign.toml")
        } else {
            self.file.join("campaign.toml")
        };
        free(&path)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let library = Library::builtin()?;
        let named = |name: &str| -> Result<NamedModel, Failure> {
            let model = library.model(name, Path::new(""))?;
            let is_file = is_model_path(name);
            let name = if is_file { seen_from(folder, Path::new(name)) } else { name.into() };
            Ok((name.display().to_string(), model))
        };
        let model = self.model.as_deref().map(named).transpose()?;
        let known = library.models().iter().map(|(name, _)| named(name));
        let known = known.collect::<Result<Vec<NamedModel>, Failure>>()?;
        let logs: Vec<(PathBuf, PathBuf)> =
            self.from.iter().map(|log| (log.clone(), seen_from(folder, log))).collect();
        let begun = begin(&logs, model.as_ref(), &known, self.heading_scale)?;
        if self.heading_scale.is_some() && begun.table.is_none() {
            let message = "`--heading-scale` is stated, but no bend of a path of dead reckoning is computed from these logs";
            let help = "state it for two logs of poses in a plane, one of which begins near zero";
            return Err(Diagnostic::error(message).help(help).into());
        }
        for (name, _) in begun.model.iter().chain(&begun.table) {
            free(&folder.join(name))?;
        }
        let mut said = String::new();
        if let Some((name, text)) = &begun.model {
            let file = folder.join(name);
            output::file(&file, text, &Files::default())?;
            said += &format!(
                "wrote {}: a model to begin with, no model of the library fits\n",
                file.display()
            );
        }
        if let Some((name, text)) = &begun.table {
            let file = folder.join(name);
            output::file(&file, text, &Files::default())?;
            said += &format!("wrote {}: how the path of dead reckoning bends\n", file.display());
        }
        output::file(&path, &begun.campaign, &Files::default())?;
        begun.unused.iter().for_each(|line| said += &format!("{line}\n"));
        said += &format!(
            "wrote {0}\nnext: look at every line with `guessed` or `WRITE` in it, then `homepoint check {0}`\n",
            path.display()
        );
        if !self.quiet {
            render::all(&begun.notes.iter().map(Diagnostic::warning).collect::<Vec<_>>());
        }
        output::text(&said)
    }
}

/// Refuses a file that is there already.
fn free(path: &Path) -> Result<(), Failure> {
    if path.exists() {
        return Err(Diagnostic::error(format!("{} exists already", path.display()))
            .help("choose another name; nothing was written")
            .into());
    }
    Ok(())
}

/// A path as it is named from a folder: relative where both have a folder in common, else absolute. Links
/// are followed, for `..` follows them, too.
fn seen_from(folder: &Path, path: &Path) -> PathBuf {
    if folder.as_os_str().is_empty() {
        return path.to_owned();
    }
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let (home, whole) = match (path.parent(), path.file_name()) {
        (Some(own), Some(name)) => (real(folder), real(own).join(name)),
        _ => (real(folder), path),
    };
    let common = home.components().zip(whole.components()).take_while(|(a, b)| a == b).count();
    // All that a file system has in common is its root.
    if common <= 1 {
        return whole;
    }
    let up = home.components().skip(common).map(|_| Component::ParentDir);
    up.chain(whole.components().skip(common)).collect()
}

/// An absolute path without links; what is not there yet is added as it is named.
fn real(path: &Path) -> PathBuf {
    let whole = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let there = whole.ancestors().find_map(|own| Some((own, std::fs::canonicalize(own).ok()?)));
    match there {
        Some((own, real)) => match whole.strip_prefix(own) {
            Ok(rest) if !rest.as_os_str().is_empty() => real.join(rest),
            _ => real,
        },
        None => whole,
    }
}
