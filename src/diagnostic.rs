//! Errors for people: where, what was found, what was expected, what to do.
//!
//! A [`Diagnostic`] is a value; how it is drawn is the faces' business.

use std::borrow::Cow;
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

/// How grave it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// The input cannot be used.
    Error,
    /// The input can be used, but look here.
    Warning,
}

/// One message to the user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// How grave it is.
    pub severity: Severity,
    /// What was found and what was expected.
    pub message: String,
    /// Where, if it has a place.
    pub place: Option<Place>,
    /// Short words beside the place (may be empty).
    pub label: String,
    /// What to do, a sentence each.
    pub help: Vec<String>,
}

impl Diagnostic {
    /// An error with this message.
    pub fn error(message: impl Into<String>) -> Self {
        Self {
            severity: Severity::Error,
            message: short_quotes(message.into()),
            place: None,
            label: String::new(),
            help: Vec::new(),
        }
    }

    /// A warning with this message.
    pub fn warning(message: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, ..Self::error(message) }
    }

    /// The same, at a place.
    pub fn at(mut self, place: Place) -> Self {
        self.place = Some(place);
        self
    }

    /// The same, at a place if there is one.
    pub fn at_maybe(mut self, place: Option<&Place>) -> Self {
        self.place = place.cloned();
        self
    }

    /// The same, with words beside the place.
    pub fn label(mut self, label: impl Into<String>) -> Self {
        self.label = label.into();
        self
    }

    /// The same, with one more sentence of help.
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help.push(short_quotes(help.into()));
        self
    }
}

/// The most characters of a text that a message quotes.
const LONGEST_QUOTE: usize = 40;
/// A message with a longer part in backticks quotes it in part: paths are shorter.
const LONGEST_WORD: usize = 500;
/// The same of a part that is not in backticks: lists of names are shorter.
const LONGEST_PART: usize = 4000;

/// A text for a message: its beginning where it is long.
pub fn shortened(text: &str) -> Cow<'_, str> {
    shortened_to(text, LONGEST_QUOTE)
}

fn shortened_to(text: &str, most: usize) -> Cow<'_, str> {
    match text.char_indices().nth(most) {
        None => Cow::Borrowed(text),
        Some((end, _)) => Cow::Owned(format!("{}...", &text[..end])),
    }
}

/// A message whose parts in backticks are not longer than [`LONGEST_WORD`], whoever wrote it.
fn short_quotes(message: String) -> String {
    if message.len() <= LONGEST_WORD {
        return message;
    }
    let parts: Vec<Cow<'_, str>> = message
        .split('`')
        .enumerate()
        .map(|(number, part)| match number % 2 {
            0 => shortened_to(part, LONGEST_PART),
            _ => shortened_to(part, LONGEST_WORD),
        })
        .collect();
    parts.join("`")
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(place) = &self.place {
            write!(f, "{}:{}:{}: ", place.file, place.line, place.column)?;
        }
        let kind = match self.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
        };
        write!(f, "{kind}: {}", self.message)?;
        for help in &self.help {
            write!(f, "\n  help: {help}")?;
        }
        Ok(())
    }
}

/// One or more messages; what a reader of user input returns when it fails.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Diagnostics(pub Vec<Diagnostic>);

impl Diagnostics {
    /// Fails with these messages if there are any.
    ///
    /// # Errors
    /// Itself, if not empty.
    pub fn into_result<T>(self, value: T) -> Result<T, Self> {
        if self.0.is_empty() { Ok(value) } else { Err(self) }
    }

    /// What they say, without places and help.
    pub fn messages(&self) -> String {
        let messages: Vec<&str> = self.0.iter().map(|one| one.message.as_str()).collect();
        messages.join("; ")
    }
}

impl From<Diagnostic> for Diagnostics {
    fn from(diagnostic: Diagnostic) -> Self {
        Self(vec![diagnostic])
    }
}

impl fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, diagnostic) in self.0.iter().enumerate() {
            if index > 0 {
                writeln!(f)?;
            }
            write!(f, "{diagnostic}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Diagnostics {}

/// A number for a message: a power of ten in place of many zeros.
pub fn number(value: f64) -> String {
    let is_short = value == 0.0 || (1e-9..1e18).contains(&value.abs());
    if is_short { value.to_string() } else { format!("{value:e}") }
}

/// The same with so many decimals.
pub fn decimals(value: f64, places: usize) -> String {
    if value.abs() < 1e15 { format!("{value:.places$}") } else { format!("{value:.places$e}") }
}

/// The known name nearest to a misspelt one, if one is near enough.
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let count = name.chars().count();
    let most = |candidate: &str| 1 + candidate.chars().count() / 4;
    known
        .into_iter()
        // Names are at least as far apart as their lengths; a long one need not be compared.
        .filter(|candidate| candidate.chars().count().abs_diff(count) <= most(candidate))
        .map(|candidate| (strsim::damerau_levenshtein(name, candidate), candidate))
        .filter(|(distance, candidate)| *distance <= most(candidate))
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}
