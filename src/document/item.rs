//! One value of a TOML text as what the reader expects it to be.

use toml::Spanned;
use toml::de::{DeString, DeValue};

use super::{Reader, Section, kind_of};
use crate::diagnostic::{Diagnostic, Source, Span, nearest};
use crate::formula::Formula;
use crate::units::{Unit, UnitError, parse_quantity};

/// A key with its value. Every reading of a wrong value records a fault and returns `None`.
#[derive(Clone, Copy, Debug)]
pub struct Item<'r> {
    reader: &'r Reader<'r>,
    key: &'r str,
    key_span: Span,
    value: &'r Spanned<DeValue<'r>>,
}

impl<'r> Item<'r> {
    pub(super) fn new(
        reader: &'r Reader<'r>,
        key: &'r Spanned<DeString<'r>>,
        value: &'r Spanned<DeValue<'r>>,
    ) -> Self {
        let span = key.span();
        Self { reader, key: key.get_ref(), key_span: Span::new(span.start, span.end), value }
    }

    /// The key.
    pub fn key(&self) -> &'r str {
        self.key
    }

    /// Where the key stands.
    pub fn key_span(&self) -> Span {
        self.key_span
    }

    /// Where the value stands.
    pub fn span(&self) -> Span {
        let span = self.value.span();
        Span::new(span.start, span.end)
    }

    /// Records an error at the value.
    pub fn error(&self, message: impl Into<String>, help: &str) {
        self.reader.error(self.span(), message, help);
    }

    /// Records an error at the key.
    pub fn error_at_key(&self, message: impl Into<String>, help: &str) {
        self.reader.error(self.key_span, message, help);
    }

    fn expected(&self, expected: &str, help: &str) {
        let found = kind_of(self.value.get_ref());
        self.error(format!("`{}`: expected {expected}, found {found}", self.key), help);
    }

    /// Whether it is a table.
    pub fn is_table(&self) -> bool {
        self.value.get_ref().is_table()
    }

    /// Whether it is a list.
    pub fn is_list(&self) -> bool {
        self.value.get_ref().is_array()
    }

    /// A table; `what` names it in messages.
    pub fn section(&self, what: &str) -> Option<Section<'r>> {
        let Some(table) = self.value.get_ref().as_table() else {
            self.expected("a table", "");
            return None;
        };
        Some(Section {
            reader: self.reader,
            table,
            span: self.key_span,
            what: what.to_owned(),
            asked: Default::default(),
        })
    }

    /// The members of a list, each under the same key.
    pub fn list(&self) -> Option<Vec<Item<'r>>> {
        let Some(list) = self.value.get_ref().as_array() else {
            self.expected("a list", "");
            return None;
        };
        Some(list.iter().map(|value| Item { value, ..*self }).collect())
    }

    /// A text.
    pub fn string(&self) -> Option<&'r str> {
        let text = self.value.get_ref().as_str();
        if text.is_none() {
            self.expected("a text in quotes", "");
        }
        text
    }

    /// A list of texts, each with where it stands.
    pub fn strings(&self) -> Option<Vec<(String, Span)>> {
        let list = self.list()?;
        list.iter().map(|item| Some((item.string()?.to_owned(), item.span()))).collect()
    }

    /// `true` or `false`.
    pub fn boolean(&self) -> Option<bool> {
        let boolean = self.value.get_ref().as_bool();
        if boolean.is_none() {
            self.expected("true or false, without quotes", "");
        }
        boolean
    }

    /// One word of several.
    pub fn choice<T: Copy>(&self, choices: &[(&'static str, T)]) -> Option<T> {
        let word = self.string()?;
        if let Some((_, value)) = choices.iter().find(|(known, _)| *known == word) {
            return Some(*value);
        }
        let words: Vec<&str> = choices.iter().map(|(known, _)| *known).collect();
        let help = match nearest(word, words.iter().copied()) {
            Some(near) => format!("did you mean \"{near}\"?"),
            None => String::new(),
        };
        self.error(
            format!("`{}`: expected one of {}, found \"{word}\"", self.key, words.join(", ")),
            &help,
        );
        None
    }

    /// A unit.
    pub fn unit(&self) -> Option<Unit> {
        let text = self.string()?;
        Unit::parse(text).map_err(|error| self.unit_error(error)).ok()
    }

    /// A number with its unit, as in `"1.5 arcsec"`, in SI; a bare number only where the unit is
    /// `1`.
    pub fn quantity(&self, like: &Unit) -> Option<(f64, Unit)> {
        let (value, unit) = self.any_quantity(Some(like))?;
        if like.misses(&unit) {
            let help = format!("write its unit, such as `{}`", like.symbol);
            self.error(format!("`{}`: the unit `{}` has no angle", self.key, unit.symbol), &help);
            return None;
        }
        if unit.dimension != like.dimension {
            let expected = match like.symbol.as_str() {
                "1" => "a plain number".to_owned(),
                symbol => format!("a quantity like `{symbol}`"),
            };
            let found = &unit.symbol;
            self.error(
                format!("`{}`: expected {expected}, found the unit `{found}`", self.key),
                "",
            );
            return None;
        }
        Some((value, unit))
    }

    /// A quantity that is a difference or a width: `degC` is refused, its zero has no meaning
    /// there.
    pub fn difference(&self, like: &Unit) -> Option<(f64, Unit)> {
        let (value, unit) = self.quantity(like)?;
        if unit.offset != 0.0 {
            self.error(
                format!(
                    "`{}` is a difference of temperatures, `{}` has a zero of its own",
                    self.key, unit.symbol
                ),
                "write it in K",
            );
            return None;
        }
        Some((value, unit))
    }

    /// A positive [`Self::difference`].
    pub fn positive(&self, like: &Unit) -> Option<(f64, Unit)> {
        let (value, unit) = self.difference(like)?;
        if value > 0.0 {
            return Some((value, unit));
        }
        self.error(format!("`{}` must be greater than zero", self.key), "");
        None
    }

    /// A number with any unit, in SI. With `like` a bare number is told which unit is missing.
    pub fn any_quantity(&self, like: Option<&Unit>) -> Option<(f64, Unit)> {
        let (DeValue::Integer(_) | DeValue::Float(_)) = self.value.get_ref() else {
            let Some(text) = self.value.get_ref().as_str() else {
                self.expected("a number with its unit in quotes", "as in \"1.5 arcsec\"");
                return None;
            };
            return parse_quantity(text).map_err(|error| self.unit_error(error)).ok();
        };
        let digits = match self.value.get_ref() {
            DeValue::Float(float) => float.as_str(),
            DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str(),
            _ => "",
        };
        let Some(number) = digits.parse::<f64>().ok().filter(|number| number.is_finite()) else {
            self.error(format!("`{}`: not a finite decimal number", self.key), "");
            return None;
        };
        match like {
            Some(unit) if unit.symbol != "1" => {
                let help = format!("write \"{number} {}\"", unit.symbol);
                self.error(format!("`{}`: the number has no unit", self.key), &help);
                None
            }
            _ => Some((number, Unit::one())),
        }
    }

    /// One quantity, or a list of three where `count` is 3; `read` reads each.
    pub fn components<T>(
        &self,
        count: usize,
        read: impl Fn(&Item<'r>) -> Option<T>,
    ) -> Option<Vec<T>> {
        if count == 1 {
            if self.is_list() {
                self.expected(
                    "one value",
                    "lists belong to vectors and rotations: kind = \"vector\"",
                );
                return None;
            }
            return read(self).map(|value| vec![value]);
        }
        let Some(list) = self.value.get_ref().as_array().filter(|list| list.len() == count) else {
            self.error(
                format!("`{}`: expected a list of {count} quantities", self.key),
                "one for each component, as in [\"1 m\", \"1 m\", \"1 m\"]",
            );
            return None;
        };
        let read: Vec<Option<T>> =
            list.iter().map(|value| read(&Item { value, ..*self })).collect();
        read.into_iter().collect()
    }

    /// A formula.
    pub fn formula(&self) -> Option<Formula> {
        let Some(text) = self.value.get_ref().as_str() else {
            self.expected("a formula in single quotes", "as in 'norm(point)'");
            return None;
        };
        let (source, offset) = self.content(text);
        Formula::parse(source, offset, text).map_err(|fault| self.reader.report(fault)).ok()
    }

    /// Notes a fault that has its place.
    pub fn report(&self, fault: crate::diagnostic::Diagnostic) {
        self.reader.report(fault);
    }

    /// Whether it is a text that is a formula, where a quantity may stand too.
    pub fn is_formula(&self) -> bool {
        self.value.get_ref().as_str().is_some_and(Formula::is_meant)
    }

    /// Where the content of a text stands: in the file, or, where the file spells it otherwise
    /// (escapes), in a text with the content put at the same line and column.
    fn content(&self, text: &str) -> (Source, usize) {
        let source = self.reader.source();
        let span = self.span();
        let raw = source.text.get(span.start..span.end).unwrap_or("");
        let quotes = if raw.starts_with("'''") || raw.starts_with("\"\"\"") { 3 } else { 1 };
        let body = raw.get(quotes..).unwrap_or("");
        let skipped = match body {
            _ if quotes == 1 => 0,
            _ if body.starts_with("\r\n") => 2,
            _ if body.starts_with('\n') => 1,
            _ => 0,
        };
        if body.get(skipped..).is_some_and(|body| body.starts_with(text)) {
            return (source.clone(), span.start + quotes + skipped);
        }
        let place = source.place(span);
        let mut padded = "\n".repeat(place.line - 1);
        padded.push_str(&" ".repeat(place.column));
        let offset = padded.len();
        padded.push_str(text);
        (Source::new(source.file.clone(), padded), offset)
    }

    fn unit_error(&self, error: UnitError) {
        let (source, offset) = self.content(self.value.get_ref().as_str().unwrap_or(""));
        let place = source.place(Span::new(error.start, error.end).shifted(offset));
        let mut fault = Diagnostic::error(format!("`{}`: {}", self.key, error.message)).at(place);
        fault.help.extend(error.help);
        self.reader.report(fault);
    }
}
