//! A small text file from disk, with faults a user can mend.

use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::Path;

use super::MAXIMUM_LENGTH;
use crate::diagnostic::{Diagnostic, Diagnostics, Source, Span, nearest};

impl Source {
    /// Reads a UTF-8 text file of at most [`MAXIMUM_LENGTH`] bytes; a byte order mark is left out.
    ///
    /// # Errors
    /// A missing or unreadable file, one that is too long or is not text.
    pub fn read(path: &Path) -> Result<Self, Diagnostics> {
        let shown = path.display();
        let failed = |error: std::io::Error| match error.kind() {
            ErrorKind::NotFound => not_there(path),
            _ => Diagnostic::error(format!("cannot read `{shown}`: {error}")),
        };
        let metadata = path.metadata().map_err(failed)?;
        if !metadata.is_file() {
            return Err(Diagnostic::error(format!("`{shown}` is not a file")).into());
        }
        let mut bytes = Vec::new();
        let limit = MAXIMUM_LENGTH as u64 + 1;
        File::open(path).map_err(failed)?.take(limit).read_to_end(&mut bytes).map_err(failed)?;
        if bytes.len() > MAXIMUM_LENGTH {
            let message = format!("`{shown}` is longer than {MAXIMUM_LENGTH} bytes");
            return Err(Diagnostic::error(message).help("is it the right file?").into());
        }
        let text = String::from_utf8(bytes).map_err(|error| {
            let valid = error.utf8_error().valid_up_to();
            let lossy = String::from_utf8_lossy(error.as_bytes());
            let place =
                Source::new(shown.to_string(), lossy.as_ref()).place(Span::new(valid, valid + 1));
            Diagnostics::from(
                Diagnostic::error("not UTF-8 text").at(place).help("save the file as UTF-8"),
            )
        })?;
        let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
        Ok(Self::new(shown.to_string(), text))
    }
}

/// A file that does not exist, with the one beside it whose name is nearest.
fn not_there(path: &Path) -> Diagnostic {
    let error = Diagnostic::error(format!("the file `{}` does not exist", path.display()));
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let beside = std::fs::read_dir(folder.unwrap_or(Path::new("."))).into_iter().flatten();
    let mut names: Vec<String> =
        beside.filter_map(|one| one.ok()?.file_name().into_string().ok()).collect();
    names.sort();
    let name = path.file_name().map(|name| name.to_string_lossy());
    match name.and_then(|name| nearest(&name, names.iter().map(String::as_str)).map(str::to_owned))
    {
        Some(near) => {
            error.help(format!("did you mean `{}`?", path.with_file_name(near).display()))
        }
        None => error,
    }
}
