//! `homepoint new`: a model to start from.

use std::path::PathBuf;

use clap::Args;

use super::{Failure, output};
use crate::diagnostic::Diagnostic;
use crate::document::files::Files;
use crate::library;

#[derive(Debug, Args)]
pub(super) struct New {
    /// The file to write, say my_instrument.toml
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// No warnings, no progress
    #[arg(long)]
    pub(super) quiet: bool,
}

impl New {
    pub(super) fn run(&self) -> Result<(), Failure> {
        if self.file.exists() {
            return Err(Diagnostic::error(format!("{} exists already", self.file.display()))
                .help("choose another name; nothing was written")
                .into());
        }
        let stem = self.file.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
        let name: String = stem
            .chars()
            .map(|c| if c.is_ascii_alphanumeric() || c == '_' { c } else { '_' })
            .collect();
        let name = if name.starts_with(|c: char| c.is_ascii_alphabetic()) {
            name
        } else {
            "instrument".to_owned()
        };
        output::file(&self.file, &library::template(&name), &Files::default())?;
        output::text(&format!(
            "wrote {0}\nnext: `homepoint check {0}`, then `homepoint show {0}`\n",
            self.file.display()
        ))
    }
}
