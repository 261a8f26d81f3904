//! What a campaign calls the columns of its files: the entries of `columns`.

use crate::campaign::declared::ColumnWord;
use crate::campaign::header::{Choice, split};
use crate::document::entries::{Entry, Item, Named, Reader, Value, get};
use crate::units::Unit;

const EXAMPLE: &str = "columns = { hand_x = \"tool_x [m]\" }";
const KEYS: [&str; 2] = ["column", "unit"];

/// Reads `columns = { ... }`.
pub(crate) fn read(reader: &mut Reader, item: &Item) -> Vec<ColumnWord> {
    let mut found: Vec<ColumnWord> = Vec::new();
    for entry in reader.table(item, EXAMPLE) {
        let before = reader.count();
        let word = word(reader, entry);
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
        found.push(word);
    }
    found
}

/// One entry: a column with its unit in a text, or a table of both.
fn word(reader: &mut Reader, entry: &Entry) -> ColumnWord {
    let name = Named { text: entry.key.clone(), span: entry.span, place: reader.place(entry.span) };
    let mut word = ColumnWord { name, written: entry.item.to_json(), column: None, unit: None };
    match &entry.item.value {
        Value::Table(entries) => {
            reader.only(entries, &KEYS);
            word.column = get(entries, "column").and_then(|item| column(reader, item));
            word.unit = get(entries, "unit").and_then(|item| {
                let text = reader.text(item, "unit = \"mm\"")?;
                unit(reader, item, &text)
            });
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
            }
        }
    }
    word
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
