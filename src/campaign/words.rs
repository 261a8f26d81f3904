//! What a campaign calls the columns of its files: the entries of `columns`.

use crate::campaign::declared::ColumnWord;
use crate::campaign::header::{Choice, TIME, split};
use crate::diagnostic::Diagnostic;
use crate::document::entries::{Entry, Item, Named, Reader, Value, get};
use crate::formula::{ExpressionKind, Formula};
use crate::units::Unit;

const EXAMPLE: &str = "columns = { hand_x = \"tool_x [m]\" }";
const KEYS: [&str; 3] = ["column", "unit", "formula"];

/// Reads `columns = { ... }`.
pub(crate) fn read(reader: &mut Reader, item: &Item) -> Vec<ColumnWord> {
    let mut found: Vec<ColumnWord> = Vec::new();
    for entry in reader.table(item, EXAMPLE) {
        let before = reader.count();
        let mut word = word(reader, entry);
        if reader.count() > before {
            continue;
        }
        let same = |other: &&ColumnWord| other.column.is_some() && other.column == word.column;
        if let (Some(other), Some(column)) = (found.iter().find(same), &word.column) {
            let message = format!(
                "`{}` and `{}` name the same column, `{column}`",
                other.name.text, word.name.text
            );
            let help = "a column is one input or one measurand: keep the entry that it is";
            reader.fault(entry.span, message, help);
            continue;
        }
        if word.name.text == TIME && word.formula.is_some() {
            if word.column.is_none() {
                let help = "name it with its unit: time = { column = \"stamp\", unit = \"ms\" }";
                reader.fault(entry.span, "the time is a column, not a formula", help);
                continue;
            }
            word.formula = None;
        }
        found.push(word);
    }
    found
}

/// One entry: a column with its unit in a text, or a table of both.
fn word(reader: &mut Reader, entry: &Entry) -> ColumnWord {
    let name = Named { text: entry.key.clone(), span: entry.span, place: reader.place(entry.span) };
    let written = entry.item.to_json();
    let mut word = ColumnWord { name, written, column: None, unit: None, formula: None };
    match &entry.item.value {
        Value::Table(entries) => {
            reader.only(entries, &KEYS);
            word.column = get(entries, "column").and_then(|item| column(reader, item));
            word.unit = get(entries, "unit").and_then(|item| {
                let text = reader.text(item, "unit = \"mm\"")?;
                unit(reader, item, &text)
            });
            if let Some(item) = get(entries, "formula")
                && let Some(text) = reader.text(item, "formula = \"90 deg - elevation\"")
            {
                match parsed(reader, item, &text) {
                    Ok(formula) => word.formula = Some(formula),
                    Err(fault) => reader.report(fault),
                }
                if let Some(other) = entries.iter().find(|entry| entry.key != "formula") {
                    let help = "columns that a formula names may have entries of their own";
                    reader.fault(other.span, "a formula has neither column nor unit", help);
                }
            }
            if entries.is_empty() {
                let help = "as in hand_x = { column = \"tool_x\", unit = \"m\" }";
                reader.fault(entry.item.span, "neither a column nor a unit is stated", help);
            }
        }
        _ => {
            if let Some(text) = reader.text(&entry.item, "hand_x = \"tool_x [m]\"") {
                let (header, symbol) = split(text.trim());
                word.column = Some(Choice::Name(header.to_owned()));
                word.unit = symbol.and_then(|(symbol, _)| unit(reader, &entry.item, symbol));
                word.formula = meant(parsed(reader, &entry.item, &text).ok());
            }
        }
    }
    word
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

fn unit(reader: &mut Reader, item: &Item, text: &str) -> Option<Unit> {
    match Unit::parse(text) {
        Ok(unit) => Some(unit),
        Err(error) => {
            reader.fault(item.span, error.message, error.help.unwrap_or_default());
            None
        }
    }
}
