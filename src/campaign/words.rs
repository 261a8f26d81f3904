//! What a campaign calls the columns of its files: the entries of `columns`.

use crate::campaign::declared::ColumnWord;
use crate::campaign::header::{Choice, ONE_COLUMN, TIME, split};
use crate::diagnostic::Diagnostic;
use crate::document::entries::{Entry, Item, Named, Reader, Value, get};
use crate::formula::{ExpressionKind, Formula};
use crate::units::{Dimension, Unit, parse_quantity};

const EXAMPLE: &str = "columns = { hand_x = \"tool_x [m]\" }";
/// What the time is not.
pub(crate) const NO_FORMULA: &str = "the time is a column, not a formula";
/// How the time is stated.
pub(crate) const OF_TIME: &str = "name it with its unit: time = { column = \"stamp\", unit = \"ms\" }; columns in a list are added: time = [\"sec [s]\", \"nanosec [ns]\"]";
const KEYS: [&str; 3] = ["column", "unit", "formula"];

/// Reads `columns = { ... }`.
pub(crate) fn read(reader: &mut Reader, item: &Item) -> Vec<ColumnWord> {
    let mut found: Vec<ColumnWord> = Vec::new();
    for entry in reader.table(item, EXAMPLE) {
        let before = reader.count();
        let word = word(reader, entry);
        if reader.count() > before {
            continue;
        }
        let same = |other: &ColumnWord| {
            let column = word.columns().find(|column| other.columns().any(|one| one == *column));
            column.map(|column| (other.name.text.clone(), column.clone()))
        };
        if let Some((other, column)) = found.iter().find_map(same) {
            let message =
                format!("`{}` and `{}` name the same column, `{column}`", other, word.name.text);
            reader.fault(entry.span, message, ONE_COLUMN);
            continue;
        }
        let is_of_column = word.formula.is_none() || word.column.is_some();
        if word.name.text == TIME && !is_of_column {
            reader.fault(entry.span, NO_FORMULA, OF_TIME);
            continue;
        }
        found.push(word);
    }
    found
}

/// One entry: a column with its unit in a text, or a table of both.
fn word(reader: &mut Reader, entry: &Entry) -> ColumnWord {
    let name = Named { text: entry.key.clone(), span: entry.span, place: reader.place(entry.span) };
    let written = entry.item.to_json();
    let mut word =
        ColumnWord { name, written, column: None, unit: None, formula: None, added: Vec::new() };
    match &entry.item.value {
        Value::Table(entries) => {
            reader.only(entries, &KEYS);
            word.column = get(entries, "column").and_then(|item| column(reader, item));
            word.unit = get(entries, "unit").and_then(|item| {
                let text = reader.text(item, "unit = \"mm\"")?;
                unit(reader, item, &text, entry.key == TIME)
            });
            if let Some(item) = get(entries, "formula")
                && let Some(text) = reader.text(item, "formula = \"90 deg - elevation\"")
            {
                match parsed(reader, item, &text) {
                    Ok(formula) => word.formula = Some(formula),
                    Err(fault) => reader.report(fault),
                }
                if let Some(other) = entries.iter().find(|entry| entry.key != "formula") {
                    let help = "its unit is that of the columns that it names, which may have entries of their own, as in raw = { column = \"raw\", unit = \"mm\" }";
                    reader.fault(other.span, "a formula has neither column nor unit", help);
                }
            }
            if entries.is_empty() {
                let help = "as in hand_x = { column = \"tool_x\", unit = \"m\" }";
                reader.fault(entry.item.span, "neither a column nor a unit is stated", help);
            }
        }
        Value::List(items) => return sum(reader, entry, items, word),
        _ => {
            if let Some(text) = reader.text(&entry.item, "hand_x = \"tool_x [m]\"") {
                let (header, symbol) = split(text.trim());
                word.column = Some(Choice::Name(header.to_owned()));
                word.unit = symbol
                    .and_then(|(symbol, _)| unit(reader, &entry.item, symbol, entry.key == TIME));
                word.formula = meant(parsed(reader, &entry.item, &text).ok());
            }
        }
    }
    word
}

/// The time as a sum: a list of columns, each as it is stated alone.
fn sum(reader: &mut Reader, entry: &Entry, items: &[Item], mut sum: ColumnWord) -> ColumnWord {
    if entry.key != TIME {
        let help = format!(
            "the columns of a list are added, of the time alone; write a formula: {} = \"a + b\"",
            entry.key
        );
        reader.fault(entry.item.span, format!("`{}` is a list", entry.key), help);
        return sum;
    }
    if items.is_empty() {
        reader.fault(entry.item.span, "the list of columns is empty", OF_TIME);
    }
    for item in items {
        if let Value::List(_) = &item.value {
            reader.fault(item.span, "a list in a list", OF_TIME);
            continue;
        }
        let part = Entry { item: item.clone(), ..entry.clone() };
        let part = word(reader, &part);
        let known = part.column.as_ref().filter(|own| sum.columns().any(|known| known == *own));
        match (known, part.column.clone()) {
            (Some(column), _) => {
                let message = format!("the list has the column `{column}` twice");
                reader.fault(item.span, message, "keep one of them");
            }
            (None, Some(column)) if sum.column.is_some() => sum.added.push((column, part.unit)),
            (None, Some(column)) => (sum.column, sum.unit) = (Some(column), part.unit),
            (None, None) => reader.fault(item.span, "no column is named here", OF_TIME),
        }
    }
    sum
}

fn parsed(reader: &Reader, item: &Item, text: &str) -> Result<Formula, Diagnostic> {
    Formula::parse(reader.source.clone(), item.span.start + 1, text)
}

/// A formula, but for a name alone, which is a column, and a number.
fn meant(formula: Option<Formula>) -> Option<Formula> {
    formula.filter(|formula| {
        let is_name =
            matches!(formula.root.kind, ExpressionKind::Name(_) | ExpressionKind::Member(..));
        !is_name && !formula.root.names().is_empty()
    })
}

/// A column by its name, or by its number as a number without quotes.
fn column(reader: &mut Reader, item: &Item) -> Option<Choice> {
    match &item.value {
        Value::Bare(number) => match number.parse() {
            Ok(number) if number > 0 => Some(Choice::Number(number)),
            _ => {
                let help = "columns count from 1: column = 1";
                reader.fault(item.span, format!("`{number}` is not the number of a column"), help);
                None
            }
        },
        _ => Some(Choice::Name(reader.text(item, "column = \"tool_x\"")?.trim().to_owned())),
    }
}

/// A unit; of the time also an interval, as `10 ms` from count to count.
fn unit(reader: &mut Reader, item: &Item, text: &str, is_time: bool) -> Option<Unit> {
    let interval = || {
        let (factor, unit) = parse_quantity(text).ok()?;
        let is_interval = is_time && factor > 0.0 && unit.dimension == Dimension::TIME;
        is_interval.then(|| Unit { symbol: text.trim().to_owned(), factor, ..unit })
    };
    match Unit::parse(text).or_else(|error| interval().ok_or(error)) {
        Ok(unit) => Some(unit),
        Err(error) => {
            reader.fault(item.span, error.message, error.help.unwrap_or_default());
            None
        }
    }
}
