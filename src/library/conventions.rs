//! The conventions that are there: those of the project, and those in `conventions/` beside
//! campaigns.

use std::path::Path;

use crate::convention::Convention;
use crate::diagnostic::{Diagnostic, Diagnostics, Source, Span};
use crate::document::MAXIMUM_LENGTH;
use crate::document::files::Files;
use crate::library::{effect_files, embedded};

/// All conventions, those of these folders' `conventions/` after those of the project.
///
/// # Errors
/// A folder that cannot be read, every fault of its files.
pub fn conventions<'p>(
    folders: impl IntoIterator<Item = &'p Path>,
) -> Result<Vec<Convention>, Diagnostics> {
    let (mut all, mut faults) = (Vec::new(), Vec::new());
    let mut add = |read: Result<Convention, Diagnostics>| match read {
        Ok(one) if all.iter().any(|other: &Convention| other.name == one.name) => {
            let message = format!("the convention `{}` is there already", one.name);
            let error = Diagnostic::error(message).at(one.source.place(Span::default()));
            faults.push(error.help("choose another name for it"));
        }
        Ok(one) => all.push(one),
        Err(found) => faults.extend(found.0),
    };
    for (stem, text) in embedded::CONVENTIONS {
        add(Convention::parse(Source::new(format!("models/conventions/{stem}.toml"), *text)));
    }
    for base in folders {
        let folder = base.join("conventions");
        if !folder.is_dir() {
            continue;
        }
        let mut files = Files::of(base);
        for file in effect_files(&folder)? {
            add(Source::read_of(&mut files, &file, MAXIMUM_LENGTH).and_then(Convention::parse));
        }
    }
    Diagnostics(faults).into_result(all)
}
