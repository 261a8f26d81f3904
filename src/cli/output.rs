//! Standard output and files.

use std::io::{self, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use serde_json::Value;

use super::{Failure, clean};
use crate::campaign::whole::WholeFile;
use crate::document::files::Files;

/// Whether standard output has a result.
static HAS_RESULT: AtomicBool = AtomicBool::new(false);

/// Whether a result was written to standard output.
pub(super) fn has_result() -> bool {
    HAS_RESULT.load(Ordering::Relaxed)
}

/// Writes text to standard output.
pub(super) fn text(text: &str) -> Result<(), Failure> {
    raw(&clean::text(text))
}

fn raw(text: &str) -> Result<(), Failure> {
    super::progress::clear();
    HAS_RESULT.store(true, Ordering::Relaxed);
    let mut out = anstream::stdout();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(broken)
}

/// Writes a JSON value to standard output.
pub(super) fn json(value: &Value) -> Result<(), Failure> {
    let mut whole = serde_json::to_string_pretty(value)
        .map_err(|error| Failure::Could(format!("cannot write the result as JSON: {error}")))?;
    whole.push('\n');
    raw(&clean::json(&whole))
}

/// Writes a file whole or not at all, and over none that was read.
pub(super) fn file(path: &Path, content: &str, read: &Files) -> Result<(), Failure> {
    written(path, read, |file| file.write_all(content.as_bytes()))
}

/// The same for one that may be larger than memory.
pub(super) fn written<T>(
    path: &Path,
    read: &Files,
    fill: impl FnOnce(&mut WholeFile) -> io::Result<T>,
) -> Result<T, Failure> {
    read.refuse_replacing(path)?;
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let write = || {
        folder.map_or(Ok(()), std::fs::create_dir_all)?;
        let mut file = WholeFile::create(path)?;
        let filled = fill(&mut file)?;
        file.finish()?;
        Ok(filled)
    };
    write().map_err(|error: io::Error| {
        Failure::Could(format!("cannot write {}: {error}", path.display()))
    })
}

fn broken(error: std::io::Error) -> Failure {
    if error.kind() == std::io::ErrorKind::BrokenPipe {
        Failure::Reported
    } else {
        Failure::Could(format!("cannot write to standard output: {error}"))
    }
}
