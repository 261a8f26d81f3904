//! A text, spans of it and their places: line, column and the line itself.

use std::fmt;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

/// A range of bytes in a text.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Span {
    /// First byte.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
}

impl Span {
    /// The bytes `start..end`.
    pub fn new(start: usize, end: usize) -> Self {
        Self { start, end }
    }

    /// The smallest span that holds both.
    pub fn to(self, other: Self) -> Self {
        Self { start: self.start.min(other.start), end: self.end.max(other.end) }
    }

    /// The same span `offset` bytes further on.
    pub fn shifted(self, offset: usize) -> Self {
        Self { start: self.start + offset, end: self.end + offset }
    }
}

/// A text with the name of the file it came from.
#[derive(Clone, Debug)]
pub struct Source {
    /// File name as the user knows it.
    pub file: Arc<str>,
    /// The whole text.
    pub text: Arc<str>,
    /// Whether messages may not show the text.
    withheld: bool,
    /// Made where a place is first asked for.
    lines: Arc<OnceLock<LineStarts>>,
}

/// Where the lines of a text begin.
#[derive(Debug)]
struct LineStarts {
    starts: Vec<usize>,
    /// Columns are then differences of bytes.
    is_ascii: bool,
}

impl PartialEq for Source {
    fn eq(&self, other: &Self) -> bool {
        self.file == other.file && self.text == other.text
    }
}

impl Eq for Source {}

impl Source {
    /// A text and where it came from.
    pub fn new(file: impl Into<Arc<str>>, text: impl Into<Arc<str>>) -> Self {
        Self { file: file.into(), text: text.into(), withheld: false, lines: Arc::default() }
    }

    /// The same text; its places show none of it.
    #[must_use]
    pub fn withheld(self) -> Self {
        Self { withheld: true, ..self }
    }

    /// Whether messages may not show the text.
    pub fn is_withheld(&self) -> bool {
        self.withheld
    }

    fn lines(&self) -> &LineStarts {
        self.lines.get_or_init(|| {
            let ends = memchr::memchr_iter(b'\n', self.text.as_bytes());
            LineStarts {
                starts: std::iter::once(0).chain(ends.map(|end| end + 1)).collect(),
                is_ascii: self.text.is_ascii(),
            }
        })
    }

    /// The place of a span: line, column (in characters, from 1) and the line's text.
    pub fn place(&self, span: Span) -> Place {
        let floor = |mut at: usize| {
            at = at.min(self.text.len());
            while !self.text.is_char_boundary(at) {
                at -= 1;
            }
            at
        };
        let (start, end) = (floor(span.start), floor(span.end.max(span.start)));
        let LineStarts { starts, is_ascii } = self.lines();
        let line = starts.partition_point(|from| *from <= start);
        let line_start = starts[line - 1];
        let line_end = starts.get(line).map_or(self.text.len(), |next| next - 1);
        let content = self.text[line_start..line_end].trim_end_matches('\r').len();
        let count = |from: usize, to: usize| match is_ascii {
            true => to - from,
            false => self.text[from..to].chars().count(),
        };
        let shown = if self.withheld { 0..0 } else { line_start..line_start + content };
        Place {
            file: self.file.clone(),
            line,
            column: count(line_start, start) + 1,
            length: count(start, end.min(line_end).max(start)).max(1),
            text: self.text.clone(),
            excerpt: shown,
        }
    }
}

/// A place in a file, with the line it is on.
#[derive(Clone)]
pub struct Place {
    /// File name as the user knows it.
    pub file: Arc<str>,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// How many characters are meant.
    pub length: usize,
    /// A text that holds the line; places of one file share it.
    text: Arc<str>,
    /// The line's bytes in it.
    excerpt: Range<usize>,
}

impl Place {
    /// A place whose line is `excerpt`; empty where it is not to be shown.
    pub fn new(file: Arc<str>, line: usize, column: usize, length: usize, excerpt: &str) -> Self {
        Self { file, line, column, length, text: excerpt.into(), excerpt: 0..excerpt.len() }
    }

    /// The text of the line; empty where it is not shown.
    pub fn excerpt(&self) -> &str {
        self.text.get(self.excerpt.clone()).unwrap_or_default()
    }
}

impl PartialEq for Place {
    fn eq(&self, other: &Self) -> bool {
        let at = |place: &Self| (place.line, place.column, place.length);
        self.file == other.file && at(self) == at(other) && self.excerpt() == other.excerpt()
    }
}

impl Eq for Place {}

impl fmt::Debug for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Place")
            .field("file", &self.file)
            .field("line", &self.line)
            .field("column", &self.column)
            .field("length", &self.length)
            .field("excerpt", &self.excerpt())
            .finish()
    }
}
