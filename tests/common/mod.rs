//! What integration tests share: where recordings are that do not ship with the project.
#![expect(clippy::print_stderr, reason = "a skipped test says so")]

use std::path::{Path, PathBuf};

/// A folder of recordings that do not ship with the project; `None`, with a message, where absent.
pub(crate) fn shared(folder: &str) -> Option<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let found = ["..", "../.."]
        .iter()
        .map(|up| root.join(up).join("shared/data").join(folder))
        .find(|path| path.is_dir());
    if found.is_none() {
        eprintln!("skipped: the recordings {folder} are not here");
    }
    found
}
