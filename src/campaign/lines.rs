//! A text file, plain or `.gz`, by its lines; comments (`#`, `%`) and empty lines are passed over. Other
//! encodings than UTF-8 are decoded ([`super::encodings`]).
//!
//! Lines come one after the other from a buffer of fixed size: a file may be larger than memory.

use std::fs::File;
use std::io::{self, Read};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use flate2::read::MultiGzDecoder;
use memchr::memchr;

use crate::campaign::encodings::{Decoded, Encoding};
use crate::campaign::foreign::foreign;

/// The most bytes of one line.
const MOST_LINE: usize = 1 << 24;
/// Bytes read at a time.
const BUFFER: usize = 1 << 18;
/// Bytes looked at before the first line is shown, where lines are short.
const HEAD: usize = 1 << 16;
/// ... and where two lines take long.
const LONG_HEAD: usize = MOST_LINE / 2;

/// The bytes of a file, unpacked if it is gzip (by its first bytes): at most so many, and one more
/// if there are more.
///
/// # Errors
/// Unreadable, or not a gzip file after all.
pub(crate) fn read_bytes(file: File, most: usize) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open(file, &Arc::default())?.take(most as u64 + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// A file that counts what is read of it.
struct Counted {
    file: File,
    count: Arc<AtomicU64>,
}

impl Read for Counted {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let count = self.file.read(into)?;
        self.count.fetch_add(count as u64, Ordering::Relaxed);
        Ok(count)
    }
}

/// A file's bytes, unpacked if it is gzip; `count` grows with the bytes read, packed.
fn open(file: File, count: &Arc<AtomicU64>) -> io::Result<Box<dyn Read + Send>> {
    let mut file = Counted { file, count: count.clone() };
    let mut start = Vec::new();
    (&mut file).take(2).read_to_end(&mut start)?;
    let is_packed = start == [0x1f, 0x8b];
    let whole = io::Cursor::new(start).chain(file);
    Ok(if is_packed {
        Box::new(MultiGzDecoder::new(io::BufReader::with_capacity(BUFFER, whole)))
    } else {
        Box::new(whole)
    })
}

/// The lines that hold something: their number from 1 and their bytes without the line's end. A
/// byte order mark is dropped.
pub(crate) struct Lines {
    source: Box<dyn Read + Send>,
    buffer: Vec<u8>,
    /// What of the buffer is still to be shown.
    start: usize,
    end: usize,
    /// Lines shown or passed over.
    number: usize,
    ended: bool,
    /// Bytes of the file read, packed.
    count: Arc<AtomicU64>,
    /// How the file is encoded, if not as UTF-8.
    pub(crate) encoding: Option<Encoding>,
}

impl std::fmt::Debug for Lines {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Lines").field("number", &self.number).finish_non_exhaustive()
    }
}

impl Lines {
    /// The lines of a file.
    ///
    /// # Errors
    /// It cannot be read, or is no text.
    pub(crate) fn of(file: File) -> io::Result<Self> {
        let count = Arc::default();
        let mut lines = Self::new(open(file, &count)?, BUFFER);
        lines.count = count;
        while lines.end < HEAD && !lines.ended {
            lines.fill()?;
        }
        let head = lines.buffer[..lines.end].to_vec();
        if let Some(what) = foreign(&head) {
            return Err(io::Error::other(what));
        }
        if let Some(encoding) = Encoding::of(&head) {
            let source = std::mem::replace(&mut lines.source, Box::new(io::empty()));
            let whole = io::Cursor::new(head).chain(source);
            let count = lines.count;
            lines = Self::new(Box::new(Decoded::new(whole, encoding)), BUFFER);
            (lines.count, lines.encoding) = (count, Some(encoding));
        }
        if lines.buffer[..lines.end].starts_with(b"\xef\xbb\xbf") {
            lines.start = 3;
        }
        Ok(lines)
    }

    fn new(source: Box<dyn Read + Send>, buffer: usize) -> Self {
        let (buffer, count) = (vec![0; buffer], Arc::default());
        let encoding = None;
        Self { source, buffer, start: 0, end: 0, number: 0, ended: false, count, encoding }
    }

    /// Bytes of the file, packed as it is, read so far.
    pub(crate) fn bytes_read(&self) -> u64 {
        self.count.load(Ordering::Relaxed)
    }

    /// The beginning of what is still to be shown: so many lines, if the file has as many and they
    /// are short; one at least.
    ///
    /// # Errors
    /// The file cannot be read on, or has a line that is too long.
    pub(crate) fn head(&mut self, lines: usize) -> io::Result<&[u8]> {
        loop {
            let own = &self.buffer[self.start..self.end];
            let least = match own.len() {
                ..HEAD => lines,
                HEAD..LONG_HEAD => 2,
                _ => 0,
            };
            if self.ended || memchr::memchr_iter(b'\n', own).nth(least).is_some() {
                break;
            }
            self.fill()?;
        }
        Ok(&self.buffer[self.start..self.end])
    }

    /// The next line that holds something; `None` at the end.
    ///
    /// # Errors
    /// The file cannot be read on, or has a line that is too long.
    pub(crate) fn next(&mut self) -> io::Result<Option<(usize, &[u8])>> {
        let (begin, end) = loop {
            let Some((begin, end)) = self.line()? else { return Ok(None) };
            let line = &self.buffer[begin..end];
            let first = line.iter().find(|byte| !byte.is_ascii_whitespace());
            if !matches!(first, None | Some(b'#' | b'%')) {
                break (begin, end);
            }
        };
        Ok(Some((self.number, &self.buffer[begin..end])))
    }

    /// Where the next line is in the buffer.
    fn line(&mut self) -> io::Result<Option<(usize, usize)>> {
        let mut looked = 0;
        let length = loop {
            let rest = &self.buffer[self.start..self.end];
            if let Some(at) = memchr(b'\n', &rest[looked..]) {
                break looked + at;
            }
            looked = rest.len();
            if self.ended {
                if looked == 0 {
                    return Ok(None);
                }
                break looked;
            }
            self.fill()?;
        };
        self.number += 1;
        let begin = self.start;
        let end = begin + length;
        self.start = self.end.min(end + 1);
        Ok(Some((begin, if self.buffer[begin..end].ends_with(b"\r") { end - 1 } else { end })))
    }

    /// Reads on.
    fn fill(&mut self) -> io::Result<()> {
        self.buffer.copy_within(self.start..self.end, 0);
        (self.start, self.end) = (0, self.end - self.start);
        if self.end == self.buffer.len() {
            if self.end >= MOST_LINE {
                let message = format!("line {} is longer than 16 MB", self.number + 1);
                return Err(io::Error::new(io::ErrorKind::FileTooLarge, message));
            }
            self.buffer.resize(2 * self.end, 0);
        }
        let count = loop {
            match self.source.read(&mut self.buffer[self.end..]) {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                other => break other?,
            }
        };
        self.ended = count == 0;
        self.end += count;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use super::*;

    /// Gives a few bytes at a time.
    struct Drops(Vec<u8>);

    impl Read for Drops {
        fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
            let count = self.0.len().min(into.len()).min(3);
            into[..count].copy_from_slice(&self.0[..count]);
            self.0.drain(..count);
            Ok(count)
        }
    }

    fn all(text: &[u8]) -> Vec<(usize, String)> {
        // A small buffer has to grow.
        let mut lines = Lines::new(Box::new(Drops(text.to_vec())), 4);
        let mut found = Vec::new();
        while let Some((number, line)) = lines.next().unwrap() {
            found.push((number, String::from_utf8(line.to_vec()).unwrap()));
        }
        found
    }

    #[test]
    fn lines_come_whole_whatever_the_pieces_they_are_read_in() {
        let text = b"one,two\r\n\n # not this\n a longer line than the buffer \nlast";
        let expected = [(1, "one,two"), (4, " a longer line than the buffer "), (5, "last")];
        assert_eq!(all(text), expected.map(|(number, line)| (number, line.to_owned())));
        assert!(all(b"").is_empty() && all(b"\n\r\n").is_empty());
        assert_eq!(all(b"x\n"), [(1, "x".to_owned())]);
    }
}
