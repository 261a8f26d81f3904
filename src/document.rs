//! Typed access to a TOML text, with the place of every key and value.
//!
//! Answers: what a table says under a key, as a string, a quantity in SI, a formula; and collects
//! what is wrong with it, so that one reading reports every fault. Keys that nobody asked for are
//! faults too. It does not know what the tables mean.
//!
//! ```text
//! let reader = Reader::new(&source);
//! let table = reader.parse()?;                 // the TOML itself
//! let root = reader.root(&table, "a model");
//! let title = root.get("title").and_then(|item| item.string());
//! root.finish();                               // unknown keys
//! reader.into_result(title)
//! ```

use std::cell::RefCell;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::diagnostic::{Diagnostic, Diagnostics, Source, Span};

pub mod entries;
mod faults;
mod file;
pub mod files;
mod item;

use faults::{Faults, known_here};
pub(crate) use file::{COPY_INTO_FOLDER, OUTSIDE, text, withhold};
pub use item::Item;

/// Largest text that is read, in bytes; the files written by people are below 20 kB.
pub const MAXIMUM_LENGTH: usize = 256 * 1024;

/// One text being read, and the faults found in it so far.
#[derive(Debug)]
pub struct Reader<'a> {
    source: &'a Source,
    faults: RefCell<Faults>,
}

impl<'a> Reader<'a> {
    /// Starts reading a text.
    pub fn new(source: &'a Source) -> Self {
        Self { source, faults: RefCell::default() }
    }

    /// The text.
    pub fn source(&self) -> &'a Source {
        self.source
    }

    /// Reads the TOML itself.
    ///
    /// # Errors
    /// The first fault of its syntax, or a text longer than [`MAXIMUM_LENGTH`].
    pub fn parse(&self) -> Result<Spanned<DeTable<'a>>, Diagnostics> {
        let length = self.source.text.len();
        if length > MAXIMUM_LENGTH {
            let message = format!(
                "`{}` is {length} bytes long; at most {MAXIMUM_LENGTH} are read",
                self.source.file
            );
            return Err(Diagnostic::error(message).into());
        }
        parsed(self.source, |message| format!("not TOML: {message}"))
    }

    /// The outermost table; `what` names it in messages ("a model").
    pub fn root<'r>(
        &'r self,
        table: &'r Spanned<DeTable<'a>>,
        what: impl Into<String>,
    ) -> Section<'r> {
        Section {
            reader: self,
            table: table.get_ref(),
            span: Span::new(0, 0),
            what: what.into(),
            asked: RefCell::default(),
        }
    }

    /// Records a fault.
    pub fn report(&self, fault: Diagnostic) {
        self.faults.borrow_mut().report(fault);
    }

    /// Records an error at a place; `help` may be empty.
    pub fn error(&self, span: Span, message: impl Into<String>, help: &str) {
        let error = Diagnostic::error(message).at(self.source.place(span));
        self.report(if help.is_empty() { error } else { error.help(help) });
    }

    /// Whether a fault was found.
    pub fn has_faults(&self) -> bool {
        self.faults.borrow().count() > 0
    }

    /// The value, if there was no fault and it is there.
    ///
    /// # Errors
    /// Every fault found, in the order of the text.
    pub fn into_result<T>(self, value: Option<T>) -> Result<T, Diagnostics> {
        let faults = self.faults.into_inner().in_order().all();
        match value {
            Some(value) if faults.0.is_empty() => Ok(value),
            _ if faults.0.is_empty() => {
                Err(Diagnostic::error(format!("`{}` could not be read", self.source.file)).into())
            }
            _ => Err(faults),
        }
    }
}

/// One table being read.
#[derive(Debug)]
pub struct Section<'r> {
    reader: &'r Reader<'r>,
    table: &'r DeTable<'r>,
    span: Span,
    what: String,
    asked: RefCell<Vec<&'static str>>,
}

impl<'r> Section<'r> {
    /// Where it stands.
    pub fn span(&self) -> Span {
        self.span
    }

    /// The value of a key that is allowed here; `None` if it is not there.
    pub fn get(&self, key: &'static str) -> Option<Item<'r>> {
        let mut asked = self.asked.borrow_mut();
        if !asked.contains(&key) {
            asked.push(key);
        }
        let (found, value) = self.table.get_key_value(key)?;
        Some(Item::new(self.reader, found, value))
    }

    /// The value of a key that must be there.
    pub fn require(&self, key: &'static str) -> Option<Item<'r>> {
        let item = self.get(key);
        if item.is_none() {
            self.reader.error(self.span, format!("{} needs `{key}`", self.what), "");
        }
        item
    }

    /// A table under a key, if it is there.
    pub fn section(&self, key: &'static str) -> Option<Section<'r>> {
        self.get(key)?.section(&format!("[{key}]"))
    }

    /// Every entry, for tables whose keys are names.
    pub fn entries(&self) -> impl Iterator<Item = Item<'r>> {
        let reader = self.reader;
        self.table.iter().map(move |(key, value)| Item::new(reader, key, value))
    }

    /// Reports the keys that nobody asked for.
    pub fn finish(&self) {
        let asked = self.asked.borrow();
        for item in self.entries().filter(|item| !asked.contains(&item.key())) {
            let help = known_here(item.key(), &asked);
            let message = format!("`{}` is not a key of {}", item.key(), self.what);
            self.reader.error(item.key_span(), message, &help);
        }
    }
}

/// The TOML of a text; `words` makes the message of its first fault.
fn parsed(
    source: &Source,
    words: impl Fn(&str) -> String,
) -> Result<Spanned<DeTable<'_>>, Diagnostics> {
    DeTable::parse(&source.text).map_err(|error| {
        let span = error.span().unwrap_or_default();
        Diagnostic::error(words(error.message()))
            .at(source.place(Span::new(span.start, span.end)))
            .into()
    })
}

/// How a value of the wrong type is called in messages.
fn kind_of(value: &DeValue<'_>) -> &'static str {
    match value {
        DeValue::String(_) => "a text",
        DeValue::Integer(_) | DeValue::Float(_) => "a plain number",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "a list",
        DeValue::Table(_) => "a table",
    }
}
