//! A TOML file as a tree in which everything keeps its place, and readers of what stands in it.
//!
//! Knows texts, quantities and tables; not what a campaign is.

use toml::de::{DeTable, DeValue};

use super::faults::{Faults, known_here};
use super::parsed;
use crate::diagnostic::{Diagnostic, Diagnostics, Place, Source, Span};
use crate::formula::Formula;
use crate::units::{Unit, parse_quantity};

/// A value and where it stands.
#[derive(Clone, Debug)]
pub struct Item {
    /// Its bytes in the file.
    pub span: Span,
    /// What it is.
    pub value: Value,
}

/// What a value is.
#[derive(Clone, Debug)]
pub enum Value {
    /// A text.
    Text(String),
    /// A number or a date, as written.
    Bare(String),
    /// True or false.
    Bool(bool),
    /// A list.
    List(Vec<Item>),
    /// A table.
    Table(Vec<Entry>),
}

/// A key with its value.
#[derive(Clone, Debug)]
pub struct Entry {
    /// The key.
    pub key: String,
    /// Where the key stands.
    pub span: Span,
    /// The value.
    pub item: Item,
}

/// A number with its unit, as written.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    /// Value in SI.
    pub value: f64,
    /// Unit it was written in.
    pub unit: Unit,
    /// As written.
    pub text: String,
    /// Where.
    pub place: Place,
}

/// Something named in a file, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Named {
    /// The text.
    pub text: String,
    /// Its bytes in the file.
    pub span: Span,
    /// Its place.
    pub place: Place,
}

impl Item {
    /// What it is, in words.
    fn kind(&self) -> &'static str {
        match &self.value {
            Value::Text(_) => "a text",
            Value::Bare(_) => "a number without quotes",
            Value::Bool(_) => "true or false",
            Value::List(_) => "a list",
            Value::Table(_) => "a table",
        }
    }

    /// As free data.
    pub fn to_json(&self) -> serde_json::Value {
        match &self.value {
            Value::Text(text) => text.clone().into(),
            Value::Bare(text) => text.parse().unwrap_or_else(|_| text.clone().into()),
            Value::Bool(value) => (*value).into(),
            Value::List(items) => items.iter().map(Self::to_json).collect(),
            Value::Table(entries) => entries
                .iter()
                .map(|entry| (entry.key.clone(), entry.item.to_json()))
                .collect::<serde_json::Map<_, _>>()
                .into(),
        }
    }
}

/// A file and the faults found in it so far.
#[derive(Clone, Debug)]
pub struct Reader {
    /// The file.
    pub source: Source,
    faults: Faults,
}

impl Reader {
    /// Parses a file.
    ///
    /// # Errors
    /// It is not TOML.
    pub fn parse(source: Source) -> Result<(Self, Vec<Entry>), Diagnostics> {
        let entries = entries(parsed(&source, in_a_row)?.get_ref());
        Ok((Self::new(source), entries))
    }

    /// A reader of a file in which nothing was found yet.
    pub fn new(source: Source) -> Self {
        Self { source, faults: Faults::default() }
    }

    /// Records a fault; of many the first are kept.
    pub fn report(&mut self, fault: Diagnostic) {
        self.faults.report(fault);
    }

    /// How many faults were reported so far.
    pub fn count(&self) -> usize {
        self.faults.count()
    }

    /// The faults so far, of many the first.
    pub fn faults(&self) -> &[Diagnostic] {
        self.faults.first()
    }

    /// Nothing, if there was no fault.
    ///
    /// # Errors
    /// The faults, of many the first.
    pub fn result(&self) -> Result<(), Diagnostics> {
        self.faults.clone().all().into_result(())
    }

    /// The place of a span.
    pub fn place(&self, span: Span) -> Place {
        self.source.place(span)
    }

    /// Notes a fault.
    pub fn fault(&mut self, span: Span, message: impl Into<String>, help: impl Into<String>) {
        let fault = Diagnostic::error(message).at(self.place(span));
        let help = help.into();
        self.report(if help.is_empty() { fault } else { fault.help(help) });
    }

    /// A fault for a name that is not known here, with the nearest known one.
    pub fn unknown(&mut self, span: Span, what: &str, name: &str, known: &[&str]) {
        let help = if self.faults.is_full() { String::new() } else { known_here(name, known) };
        self.fault(span, format!("unknown {what} `{name}`"), help);
    }

    /// Faults all keys of a table that are not known.
    pub fn only(&mut self, entries: &[Entry], known: &[&str]) {
        for entry in entries {
            if !known.contains(&entry.key.as_str()) {
                self.unknown(entry.span, "key", &entry.key, known);
            }
        }
    }

    /// The entries of a table; a fault and none for anything else.
    pub fn table<'a>(&mut self, item: &'a Item, example: &str) -> &'a [Entry] {
        match &item.value {
            Value::Table(entries) => entries,
            _ => {
                self.wrong(item, "a table", example);
                &[]
            }
        }
    }

    /// A text.
    pub fn text(&mut self, item: &Item, example: &str) -> Option<String> {
        match &item.value {
            Value::Text(text) => Some(text.clone()),
            _ => {
                self.wrong(item, "a text", example);
                None
            }
        }
    }

    /// A list of texts, each with its span.
    pub fn texts(&mut self, item: &Item, example: &str) -> Vec<(String, Span)> {
        let Value::List(items) = &item.value else {
            self.wrong(item, "a list of texts", example);
            return Vec::new();
        };
        items
            .iter()
            .filter_map(|item| self.text(item, example).map(|text| (text, item.span)))
            .collect()
    }

    /// True or false.
    pub fn boolean(&mut self, item: &Item) -> Option<bool> {
        match item.value {
            Value::Bool(value) => Some(value),
            _ => {
                self.wrong(item, "true or false", "");
                None
            }
        }
    }

    /// A number with its unit in a text.
    pub fn quantity(&mut self, item: &Item) -> Option<Quantity> {
        let text = match &item.value {
            Value::Text(text) => text,
            Value::Bare(number) => {
                let help = format!(
                    "write the number with its unit in quotes, as in \"{number} mm\"; \"{number}\" is a number without a unit"
                );
                self.fault(item.span, format!("`{number}` has no unit"), help);
                return None;
            }
            _ => {
                self.wrong(item, "a number with its unit", "\"1.5 arcsec\"");
                return None;
            }
        };
        match parse_quantity(text) {
            Ok((value, unit)) => {
                Some(Quantity { value, unit, text: text.clone(), place: self.place(item.span) })
            }
            Err(error) => {
                let span = self.inside(item, text, error.start, error.end);
                self.fault(span, error.message, error.help.unwrap_or_default());
                None
            }
        }
    }

    /// A formula in a text where a quantity may stand, too; nothing where it is a quantity.
    pub fn formula(&self, item: &Item) -> Option<Formula> {
        let Value::Text(text) = &item.value else { return None };
        let span = self.inside(item, text, 0, text.len());
        Formula::is_meant(text)
            .then(|| Formula::parse(self.source.clone(), span.start, text).ok())
            .flatten()
    }

    /// A plain number, with or without quotes.
    pub fn number(&mut self, item: &Item, what: &str) -> Option<f64> {
        let text = match &item.value {
            Value::Text(text) | Value::Bare(text) => text.trim(),
            _ => "",
        };
        let found = text.parse().ok().filter(|number: &f64| number.is_finite());
        if found.is_none() {
            let message = format!("expected a plain number for {what}, found {}", item.kind());
            self.fault(item.span, message, format!("as in {what} = 2"));
        }
        found
    }

    /// A number with its unit, or a list of them.
    pub fn quantities(&mut self, item: &Item) -> Option<Vec<Quantity>> {
        match &item.value {
            Value::List(items) => {
                let found: Vec<_> = items.iter().filter_map(|item| self.quantity(item)).collect();
                if items.is_empty() {
                    self.wrong(item, "a number with its unit or a list of them", "");
                }
                (found.len() == items.len() && !items.is_empty()).then_some(found)
            }
            _ => self.quantity(item).map(|one| vec![one]),
        }
    }

    /// A quantity of a given unit's kind, in SI.
    pub fn quantity_of(&mut self, item: &Item, what: &str, like: &Unit) -> Option<f64> {
        let quantity = self.quantity(item)?;
        self.accept(&quantity, what, like).then_some(quantity.value)
    }

    /// Whether a quantity may stand where one of a unit's kind is asked for; a fault is noted else.
    pub fn accept(&mut self, quantity: &Quantity, what: &str, like: &Unit) -> bool {
        if like.accepts(&quantity.unit) {
            return true;
        }
        let (text, symbol) = (quantity.text.trim(), &quantity.unit.symbol);
        let message = if symbol == "1" {
            format!("{what}: `{text}` has no unit")
        } else if like.misses(&quantity.unit) {
            format!("{what}: there is no angle in the unit of `{text}`")
        } else {
            format!("`{symbol}` is not a unit of {what}")
        };
        let help = match like.symbol.as_str() {
            "1" => "expected a plain number".to_owned(),
            symbol => format!("expected a unit such as `{symbol}`"),
        };
        self.report(Diagnostic::error(message).at(quantity.place.clone()).help(help));
        false
    }

    /// A positive difference of a given unit's kind, in SI (kelvins, not degrees Celsius).
    pub fn positive_of(&mut self, item: &Item, what: &str, like: &Unit) -> Option<f64> {
        let quantity = self.quantity(item)?;
        let value = self.quantity_of(item, what, like)?;
        if quantity.unit.offset != 0.0 {
            let message =
                format!("{what} is a difference, `{}` a point on a scale", quantity.unit.symbol);
            self.fault(item.span, message, "write it in K");
            return None;
        }
        if value <= 0.0 {
            self.fault(item.span, format!("{what} must be greater than zero"), "");
            return None;
        }
        Some(value)
    }

    /// The bytes `start..end` of a text value, if the file writes it without escapes.
    fn inside(&self, item: &Item, text: &str, start: usize, end: usize) -> Span {
        let content = Span::new(item.span.start + 1, item.span.start + 1 + text.len());
        match self.source.text.get(content.start..content.end) {
            Some(written) if written == text => {
                Span::new(content.start + start, content.start + end)
            }
            _ => item.span,
        }
    }

    /// A value of another kind than is expected.
    pub(crate) fn wrong(&mut self, item: &Item, expected: &str, example: &str) {
        let message = format!("expected {expected}, found {}", item.kind());
        let help = if example.is_empty() { String::new() } else { format!("as in {example}") };
        self.fault(item.span, message, help);
    }
}

/// The lines of a message in one.
fn in_a_row(message: &str) -> String {
    message.lines().collect::<Vec<_>>().join("; ")
}

/// The value of a key.
pub fn get<'a>(entries: &'a [Entry], key: &str) -> Option<&'a Item> {
    entries.iter().find(|entry| entry.key == key).map(|entry| &entry.item)
}

fn entries(table: &DeTable<'_>) -> Vec<Entry> {
    table
        .iter()
        .map(|(key, value)| Entry {
            key: key.get_ref().to_string(),
            span: Span::new(key.span().start, key.span().end),
            item: item(value.get_ref(), value.span()),
        })
        .collect()
}

fn item(value: &DeValue<'_>, span: std::ops::Range<usize>) -> Item {
    let value = match value {
        DeValue::String(text) => Value::Text(text.to_string()),
        DeValue::Integer(number) => Value::Bare(number.to_string()),
        DeValue::Float(number) => Value::Bare(number.to_string()),
        DeValue::Datetime(date) => Value::Bare(date.to_string()),
        DeValue::Boolean(value) => Value::Bool(*value),
        DeValue::Array(items) => {
            Value::List(items.iter().map(|value| item(value.get_ref(), value.span())).collect())
        }
        DeValue::Table(table) => Value::Table(entries(table)),
    };
    Item { span: Span::new(span.start, span.end), value }
}
