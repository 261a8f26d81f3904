//! Errors for people: where, what was found, what was expected, what to do.
//!
//! A [`Diagnostic`] is a value; how it is drawn is the faces' business.

use std::fmt;

mod quoted;
mod source;

use quoted::short_quotes;
pub use quoted::{counted, decimals, number, shortened};
pub use source::{Place, Source, Span};

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
