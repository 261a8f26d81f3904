//! What a campaign states of a file's form: separator, decimals, header row, dates, missing readings.
//!
//! `data` and each of `signals` is the name of a file, or a table with the name and these keys.
//! What is not stated is recognised from the file.

use crate::campaign::date::DateOrder;
use crate::campaign::dialect::{Decimal, Separator};
use crate::campaign::formats::{FORMATS, Format};
use crate::document::entries::{Entry, Item, Reader, Value, get};
use crate::units::Unit;

/// The last line in which a header row may be.
pub(crate) const MOST_LINE: usize = 1000;

/// The keys of a file's form.
pub(crate) const KEYS: [&str; 8] =
    ["format", "separator", "decimal", "header", "dates", "missing", "wraps", "unused"];

/// Where the header row of a file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeaderRow {
    /// There is none.
    None,
    /// In the first row.
    First,
    /// In a line, counted from 1 as an editor shows them.
    In(usize),
}

/// A file's form as far as it is stated.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Form {
    /// A format that other programs share.
    pub format: Option<&'static Format>,
    /// What separates its cells.
    pub separator: Option<Separator>,
    /// How decimals are written; `Open` where it is not stated.
    pub decimal: Decimal,
    /// Where its header row is.
    pub header: Option<HeaderRow>,
    /// In which order dates have day, month and year.
    pub dates: Option<DateOrder>,
    /// Cells that stand for a reading that is missing.
    pub missing: Vec<String>,
    /// After which time its stamps begin anew (s).
    pub wraps: Option<f64>,
    /// Columns that count as not there: nothing uses them, and no warning names them.
    pub unused: Vec<String>,
}

/// Whether a cell stands for a reading that is missing: a word in capitals or not, a number however
/// it is written (`-1`, `-1.000`, `-1,0`).
pub(crate) fn is_missing(stated: &[String], cell: &str) -> bool {
    let number = |text: &str| text.replace(',', ".").parse::<f64>().ok();
    stated.iter().any(|one| {
        let is_number = || number(one).is_some_and(|stated| number(cell) == Some(stated));
        one.eq_ignore_ascii_case(cell) || is_number()
    })
}

impl Form {
    /// Whether the column of a name counts as not there.
    pub(crate) fn is_unused(&self, name: &str) -> bool {
        self.unused.iter().any(|unused| unused == name)
    }

    /// Reads the keys of a file's form among others.
    pub(crate) fn read(reader: &mut Reader, entries: &[Entry]) -> Self {
        let mut form = Self::default();
        if let Some(item) = get(entries, "format")
            && let Some(name) = reader.text(item, "format = \"tum\"")
        {
            form.format = Format::of(&name);
            if form.format.is_none() {
                let known: Vec<&str> = FORMATS.iter().map(|format| format.name).collect();
                reader.unknown(item.span, "format", &name, &known);
            }
        }
        if let Some(item) = get(entries, "separator") {
            form.separator =
                character(reader, item, "separator", "\",\", \";\", \"\\t\" or \" \"", |text| {
                    Separator::of(text)
                });
        }
        if let Some(item) = get(entries, "decimal") {
            let decimal = character(reader, item, "decimal", "\".\" or \",\"", |text| match text {
                "." => Some(Decimal::Point),
                "," => Some(Decimal::Comma),
                _ => None,
            });
            form.decimal = decimal.unwrap_or_default();
        }
        form.wraps = get(entries, "wraps")
            .and_then(|item| reader.positive_of(item, "wraps", &Unit::second()));
        form.header = get(entries, "header").and_then(|item| header(reader, item));
        if let Some(item) = get(entries, "dates") {
            let orders = DateOrder::ALL.map(DateOrder::words).join("\", \"");
            form.dates = word(
                reader,
                item,
                ("dates", DateOrder::DayFirst.words(), "an order of dates"),
                &format!("\"{orders}\""),
                DateOrder::of,
            );
        }
        if let Some(item) = get(entries, "missing") {
            form.missing = match &item.value {
                Value::List(_) => list(reader, item, "missing = [\"nan\", \"-999\"]"),
                _ => reader.text(item, "missing = \"nan\"").into_iter().collect(),
            };
        }
        if let Some(item) = get(entries, "unused") {
            form.unused = list(reader, item, "unused = [\"frame\", \"battery\"]");
        }
        form
    }
}

fn list(reader: &mut Reader, item: &Item, example: &str) -> Vec<String> {
    reader.texts(item, example).into_iter().map(|(text, _)| text).collect()
}

fn header(reader: &mut Reader, item: &Item) -> Option<HeaderRow> {
    let line = match &item.value {
        Value::Bool(true) => return Some(HeaderRow::First),
        Value::Bool(false) => return Some(HeaderRow::None),
        Value::Bare(line) => line.parse().ok(),
        _ => {
            reader.wrong(item, "true, false or the number of its line", "header = 4");
            return None;
        }
    };
    let found = line.filter(|line| (1..=MOST_LINE).contains(line)).map(HeaderRow::In);
    if found.is_none() {
        let message = "there is no such line for a header row";
        let help =
            format!("expected true, false, or the number of its line, from 1 to {MOST_LINE}");
        reader.fault(item.span, message, help);
    }
    found
}

fn character<T>(
    reader: &mut Reader,
    item: &Item,
    key: &str,
    expected: &str,
    known: impl Fn(&str) -> Option<T>,
) -> Option<T> {
    word(reader, item, (key, ";", &format!("a {key}")), expected, known)
}

/// One of the words that a key may have; with an example, and what it should be.
fn word<T>(
    reader: &mut Reader,
    item: &Item,
    (key, example, what): (&str, &str, &str),
    expected: &str,
    known: impl Fn(&str) -> Option<T>,
) -> Option<T> {
    let text = reader.text(item, &format!("{key} = \"{example}\""))?;
    let found = known(&text);
    if found.is_none() {
        let message = format!("`{text}` is not {what}");
        reader.fault(item.span, message, format!("expected {expected}"));
    }
    found
}
