//! A text file, plain or `.gz`, by its lines; comments and empty lines are passed over.

use std::io::Read;
use std::path::Path;

use flate2::read::MultiGzDecoder;

/// The most bytes read from one file, unpacked.
const MOST_BYTES: u64 = 16 << 30;

/// All bytes of a file, unpacked if it is gzip (by its first bytes).
///
/// # Errors
/// In words: missing, unreadable, not a gzip file after all, or too long.
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>, String> {
    let packed = std::fs::read(path).map_err(|error| reason(path, &error))?;
    if !packed.starts_with(&[0x1f, 0x8b]) {
        return Ok(packed);
    }
    let mut bytes = Vec::new();
    MultiGzDecoder::new(packed.as_slice())
        .take(MOST_BYTES + 1)
        .read_to_end(&mut bytes)
        .map_err(|error| format!("`{}` cannot be unpacked: {error}", path.display()))?;
    if bytes.len() as u64 > MOST_BYTES {
        return Err(format!("`{}` is too long when unpacked", path.display()));
    }
    Ok(bytes)
}

/// Why a file cannot be read, in words.
pub(crate) fn reason(path: &Path, error: &std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::NotFound => format!("the file `{}` does not exist", path.display()),
        _ => format!("the file `{}` cannot be read: {error}", path.display()),
    }
}

/// The lines that hold something: their number from 1 and their bytes without the line's end.
pub(crate) struct Lines<'a> {
    rest: Option<&'a [u8]>,
    number: usize,
}

impl<'a> Lines<'a> {
    /// The lines of a text; a byte order mark is dropped.
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        Self { rest: Some(bytes), number: 0 }
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = (usize, &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let rest = self.rest?;
            let line = match rest.iter().position(|byte| *byte == b'\n') {
                Some(at) => {
                    self.rest = Some(&rest[at + 1..]);
                    &rest[..at]
                }
                None => {
                    self.rest = None;
                    rest
                }
            };
            self.number += 1;
            let line = line.strip_suffix(b"\r").unwrap_or(line);
            let first = line.iter().find(|byte| !byte.is_ascii_whitespace());
            if !matches!(first, None | Some(b'#')) {
                return Some((self.number, line));
            }
        }
    }
}
