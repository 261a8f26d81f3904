//! Files that users name, opened in one way by every reader.
//!
//! Regular files alone are read: a pipe would keep a reader waiting, a device may never end.
//! [`Files`] knows the folder that a campaign's files belong to and which files were read: messages
//! show nothing of a file outside the folder, and nobody writes over a file that was read.

use std::fs::{self, File};
use std::io;
use std::path::{Component, Path, PathBuf};

use crate::diagnostic::Diagnostic;

/// The files of a campaign, or of a folder of effects.
#[derive(Clone, Debug, Default)]
pub struct Files {
    /// The folder they belong to, as named and without links; none for files that stand alone.
    home: Option<(PathBuf, PathBuf)>,
    /// Files outside the folder are refused.
    confined: bool,
    /// Messages show what stands in files outside, too.
    shown: bool,
    read: Vec<(PathBuf, Identity)>,
}

/// A file that is open.
#[derive(Debug)]
pub struct Input {
    /// Its path as named.
    pub path: PathBuf,
    /// Open for reading.
    pub file: File,
    /// Whether it lies outside the folder that it is read for, so that messages show nothing of it.
    pub is_outside: bool,
}

/// Why a file is not read although it could be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refused {
    /// A folder, a pipe, a device.
    #[error("is not a file")]
    NotAFile,
    /// Only files of the campaign's folder are read.
    #[error("lies outside the campaign's folder, and `--confined` allows no such file")]
    Outside,
}

/// What stays the same of a file by whatever path it is named.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Identity {
    /// Its path without links.
    path: PathBuf,
    /// Its number on its device: other names of the same file have it, too.
    #[cfg(unix)]
    node: (u64, u64),
}

impl Identity {
    /// `None`: there is no such file.
    fn of(path: &Path) -> Option<Self> {
        #[cfg(unix)]
        let node = {
            use std::os::unix::fs::MetadataExt as _;
            let metadata = fs::metadata(path).ok()?;
            (metadata.dev(), metadata.ino())
        };
        Some(Self {
            path: fs::canonicalize(path).ok()?,
            #[cfg(unix)]
            node,
        })
    }

    #[cfg(unix)]
    fn is(&self, other: &Self) -> bool {
        self.path == other.path || self.node == other.node
    }

    #[cfg(not(unix))]
    fn is(&self, other: &Self) -> bool {
        self.path == other.path
    }
}

impl Files {
    /// Files that belong to a folder.
    pub fn of(folder: &Path) -> Self {
        let named = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let real = fs::canonicalize(named).or_else(|_| std::path::absolute(named));
        let home = (folder.to_owned(), real.unwrap_or_else(|_| named.to_owned()));
        Self { home: Some(home), ..Self::default() }
    }

    /// Whether files outside the folder are refused.
    pub fn confine(&mut self, confined: bool) {
        self.confined = confined;
    }

    /// Whether messages show what stands in files outside the folder.
    pub fn show_outside(&mut self, shown: bool) {
        self.shown = shown;
    }

    /// Opens a file for reading and remembers it.
    ///
    /// # Errors
    /// The disk's, or [`Refused`] (see [`reason`]).
    pub fn open(&mut self, path: &Path) -> io::Result<Input> {
        let is_outside = self.is_outside(path);
        if is_outside && self.confined {
            return Err(io::Error::other(Refused::Outside));
        }
        let file = open_regular(path)?;
        self.note(path);
        Ok(Input { path: path.to_owned(), file, is_outside: is_outside && !self.shown })
    }

    /// Remembers a file that others read.
    pub fn note(&mut self, path: &Path) {
        self.read.extend(Identity::of(path).map(|identity| (path.to_owned(), identity)));
    }

    /// Remembers the files of others, too.
    pub fn extend(&mut self, other: &Self) {
        self.read.extend_from_slice(&other.read);
    }

    /// The file read that writing to a path would replace, by whatever name it was read.
    pub fn replaced_by(&self, target: &Path) -> Option<&Path> {
        let target = Identity::of(target)?;
        let found = self.read.iter().find(|(_, identity)| identity.is(&target));
        found.map(|(path, _)| path.as_path())
    }

    /// Whether a file may be written: not if one that was read would be replaced.
    ///
    /// # Errors
    /// It would be.
    pub fn refuse_replacing(&self, target: &Path) -> Result<(), Diagnostic> {
        let Some(read) = self.replaced_by(target) else { return Ok(()) };
        let target = target.display();
        let message = match read.display().to_string() {
            read if read == target.to_string() => {
                format!("`{target}` would be written over, but the campaign reads it")
            }
            read => {
                format!("`{target}` would be written over, but the campaign reads it as `{read}`")
            }
        };
        Err(Diagnostic::error(message).help("name another folder with `--out`"))
    }

    /// Whether a link leads to a file outside the folder although the path itself does not.
    pub fn is_linked_outside(&self, path: &Path) -> bool {
        let Some((folder, _)) = &self.home else { return false };
        let is_named_inside = path.strip_prefix(folder).is_ok_and(|path| !leads_out(path));
        is_named_inside && self.is_outside(path)
    }

    /// Whether a file lies outside the folder, or would; links are followed.
    pub fn is_outside(&self, path: &Path) -> bool {
        let Some((folder, home)) = &self.home else { return false };
        match fs::canonicalize(path) {
            Ok(real) => !real.starts_with(home),
            Err(_) => path.strip_prefix(folder).map_or(true, leads_out),
        }
    }
}

/// Whether a relative path leaves the folder that it counts from.
fn leads_out(path: &Path) -> bool {
    let mut depth = 0_usize;
    for component in path.components() {
        match component {
            Component::Normal(_) => depth += 1,
            Component::CurDir => {}
            Component::ParentDir if depth > 0 => depth -= 1,
            _ => return true,
        }
    }
    false
}

/// Opens a regular file for reading.
///
/// # Errors
/// The disk's, or [`Refused::NotAFile`].
pub fn open_regular(path: &Path) -> io::Result<File> {
    let regular = |metadata: fs::Metadata| match metadata.is_file() {
        true => Ok(()),
        false => Err(io::Error::other(Refused::NotAFile)),
    };
    // Before it is opened, for opening a pipe waits; and after, for the path may have changed.
    regular(fs::metadata(path)?)?;
    let file = File::open(path)?;
    regular(file.metadata()?)?;
    Ok(file)
}

/// What a file was refused for, if that is why it cannot be read.
pub fn refused(error: &io::Error) -> Option<Refused> {
    error.get_ref()?.downcast_ref().copied()
}

/// Why a file cannot be read, in words.
pub fn reason(path: &Path, error: &io::Error) -> String {
    let path = path.display();
    if let Some(refused) = refused(error) {
        return format!("`{path}` {refused}");
    }
    match error.kind() {
        io::ErrorKind::NotFound => format!("the file `{path}` does not exist"),
        // What a decoder says of its input.
        io::ErrorKind::InvalidData | io::ErrorKind::InvalidInput | io::ErrorKind::UnexpectedEof => {
            format!("`{path}` cannot be unpacked: {error}")
        }
        _ => format!("the file `{path}` cannot be read: {error}"),
    }
}
