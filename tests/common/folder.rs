//! A temporary folder of a test's own.

use std::fs;
use std::ops::Deref;
use std::path::Path;

use tempfile::TempDir;

/// A temporary folder, gone when the test is; it serves as a path.
pub(crate) struct Folder(TempDir);

impl Folder {
    /// A folder whose name begins with `name`, with files: path below it, and text.
    pub(crate) fn new(name: &str, files: &[(&str, &str)]) -> Self {
        let own = tempfile::Builder::new().prefix(&format!("homepoint-{name}-")).tempdir().unwrap();
        for (file, text) in files {
            let path = own.path().join(file);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        Self(own)
    }
}

impl Deref for Folder {
    type Target = Path;

    fn deref(&self) -> &Path {
        self.0.path()
    }
}

impl AsRef<Path> for Folder {
    fn as_ref(&self) -> &Path {
        self
    }
}
