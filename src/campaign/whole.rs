//! A file that is whole or not there: written beside its place, then renamed.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// A file in the making. Nothing stands at its place, or what stood there before, until
/// [`WholeFile::finish`]; dropped before, it leaves nothing behind.
#[derive(Debug)]
pub struct WholeFile {
    /// `None` once it is finished.
    writer: Option<BufWriter<File>>,
    beside: PathBuf,
    path: PathBuf,
}

impl WholeFile {
    /// Begins a file; its folder must be there.
    ///
    /// # Errors
    /// The disk's.
    pub fn create(path: &Path) -> io::Result<Self> {
        let name = path.file_name().map(|name| name.to_string_lossy()).unwrap_or_default();
        let beside = path.with_file_name(format!(".{name}.{}.part", std::process::id()));
        let writer = BufWriter::with_capacity(1 << 18, File::create(&beside)?);
        Ok(Self { writer: Some(writer), beside, path: path.to_owned() })
    }

    /// Puts the file in its place.
    ///
    /// # Errors
    /// The disk's; nothing is left behind then.
    pub fn finish(mut self) -> io::Result<()> {
        let renamed = self.flush().and_then(|()| fs::rename(&self.beside, &self.path));
        if renamed.is_ok() {
            self.writer = None;
        }
        renamed
    }

    fn writer(&mut self) -> io::Result<&mut BufWriter<File>> {
        self.writer.as_mut().ok_or_else(|| io::ErrorKind::NotFound.into())
    }
}

impl Write for WholeFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.writer()?.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer()?.flush()
    }
}

impl Drop for WholeFile {
    fn drop(&mut self) {
        if self.writer.take().is_some() {
            // What could not be finished is not left behind; a second failure adds nothing.
            drop(fs::remove_file(&self.beside));
        }
    }
}

/// Writes a file whole or not at all.
///
/// # Errors
/// The disk's.
pub fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = WholeFile::create(path)?;
    file.write_all(bytes)?;
    file.finish()
}
