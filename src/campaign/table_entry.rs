//! `data` and `signals` of a run: a file's name, or a table of its name and what is stated of it.

use crate::campaign::declared::TableEntry;
use crate::campaign::form::{self, Form};
use crate::campaign::words;
use crate::document::entries::{Item, Named, Reader, Value, get};

/// Reads one file of a run; `example` shows how it is written.
pub(crate) fn read(reader: &mut Reader, item: &Item, example: &str) -> Option<TableEntry> {
    let named = |reader: &mut Reader, item: &Item| {
        let text = reader.text(item, example)?;
        Some(Named { text, span: item.span, place: reader.place(item.span) })
    };
    let Value::Table(entries) = &item.value else {
        let name = named(reader, item)?;
        let (form, columns, written) = Default::default();
        return Some(TableEntry { name, form, columns, written });
    };
    reader.only(entries, &[&["file", "columns"][..], &form::KEYS[..]].concat());
    let Some(file) = get(entries, "file") else {
        reader.fault(item.span, "the file has no name", "write file = \"slow.csv\"");
        return None;
    };
    let name = named(reader, file)?;
    let form = Form::read(reader, entries);
    let columns = get(entries, "columns").map(|item| words::read(reader, item));
    let stated = entries.iter().filter(|entry| entry.key != "file");
    Some(TableEntry {
        name,
        form,
        columns: columns.unwrap_or_default(),
        written: stated.map(|entry| (entry.key.clone(), entry.item.to_json())).collect(),
    })
}

/// Reads the streams of a run.
pub(crate) fn list(reader: &mut Reader, item: &Item) -> Vec<TableEntry> {
    let example = "signals = [\"joints.csv\"]";
    match &item.value {
        Value::List(items) => items.iter().filter_map(|item| read(reader, item, example)).collect(),
        // The words of a list that is none.
        _ => {
            reader.texts(item, example);
            Vec::new()
        }
    }
}
