//! A small text file from disk, with faults a user can mend.

use std::io::{ErrorKind, Read};
use std::path::Path;

use super::MAXIMUM_LENGTH;
use super::files::{Files, Input, Refused, refused};
use crate::diagnostic::{Diagnostic, Diagnostics, Source, Span, nearest};

impl Source {
    /// Reads a UTF-8 text file of at most [`MAXIMUM_LENGTH`] bytes; a byte order mark is left out.
    ///
    /// # Errors
    /// A missing or unreadable file, one that is too long or is not text.
    pub fn read(path: &Path) -> Result<Self, Diagnostics> {
        Self::read_of(&mut Files::default(), path, MAXIMUM_LENGTH)
    }

    /// The same of a file that is one of others, with another bound (bytes). Places in a file
    /// outside their folder show none of it.
    ///
    /// # Errors
    /// As for [`Source::read`]; a file outside the folder where none is allowed.
    pub fn read_of(files: &mut Files, path: &Path, most: usize) -> Result<Self, Diagnostics> {
        let shown = path.display();
        let failed = |error: std::io::Error| match (refused(&error), error.kind()) {
            (Some(why @ Refused::NotAFile), _) => Diagnostic::error(format!("`{shown}` {why}")),
            (Some(why @ Refused::Outside), _) => {
                Diagnostic::error(format!("`{shown}` {why}")).help(COPY_INTO_FOLDER)
            }
            (None, ErrorKind::NotFound) => not_there(path),
            _ => Diagnostic::error(format!("cannot read `{shown}`: {error}")),
        };
        let Input { file, is_outside, .. } = files.open(path).map_err(failed)?;
        let mut bytes = Vec::new();
        file.take(most as u64 + 1).read_to_end(&mut bytes).map_err(failed)?;
        text(path, bytes, is_outside, most)
    }
}

/// What to do about a file that is refused for its place.
pub(crate) const COPY_INTO_FOLDER: &str =
    "copy it into the campaign's folder, or leave `--confined` out for a campaign that you trust";

/// The bytes of a file as text of at most `most` bytes; a byte order mark is left out.
///
/// # Errors
/// It is longer, or not UTF-8.
pub(crate) fn text(
    path: &Path,
    bytes: Vec<u8>,
    is_outside: bool,
    most: usize,
) -> Result<Source, Diagnostics> {
    let shown = path.display().to_string();
    let source = |text: &str| match is_outside {
        true => Source::new(shown.clone(), text).withheld(),
        false => Source::new(shown.clone(), text),
    };
    if bytes.len() > most {
        let message = format!("`{shown}` is longer than {most} bytes");
        return Err(Diagnostic::error(message).help("is it the right file?").into());
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        let lossy = String::from_utf8_lossy(error.as_bytes());
        let place = source(&lossy).place(Span::new(valid, valid + 1));
        Diagnostics::from(
            Diagnostic::error("not UTF-8 text").at(place).help("save the file as UTF-8"),
        )
    })?;
    Ok(source(text.strip_prefix('\u{feff}').unwrap_or(&text)))
}

/// The faults of a text that messages may not show: the place of the first, and nothing of it.
pub(crate) fn withhold(source: &Source, faults: Diagnostics, help: &str) -> Diagnostics {
    if !source.is_withheld() {
        return faults;
    }
    let message =
        format!("`{}` is at fault, but its content is not shown: it {OUTSIDE}", source.file);
    let place = faults.0.into_iter().find_map(|fault| fault.place);
    Diagnostic::error(message).at_maybe(place.as_ref()).help(help).into()
}

/// Why messages show nothing of a file.
pub(crate) const OUTSIDE: &str = "lies outside the campaign's folder";

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
