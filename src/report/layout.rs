//! Tables as the terminal shows them: columns without lines, two blanks between them.

use comfy_table::{CellAlignment, Table, presets};

/// An empty table without lines.
pub(crate) fn table(header: &[&str]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_header(header.iter().copied());
    for column in table.column_iter_mut() {
        column.set_padding((0, 2));
    }
    table
}

pub(crate) fn align_right(table: &mut Table, columns: &[usize]) {
    for index in columns {
        if let Some(column) = table.column_mut(*index) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
}

/// The table without blanks at the ends of its lines.
pub(crate) fn drawn(table: &Table) -> String {
    let lines: Vec<String> = table.lines().map(|line| line.trim_end().to_owned()).collect();
    lines.join("\n") + "\n"
}

/// Names that share a reason in one line each, in the order in which the reasons come.
pub(crate) fn by_reason<'a>(all: impl Iterator<Item = (&'a str, &'a str)>) -> String {
    let mut lines: Vec<(String, &str)> = Vec::new();
    for (name, why) in all {
        match lines.iter_mut().find(|(_, known)| *known == why) {
            Some((names, _)) => names.push_str(&format!(", {name}")),
            None => lines.push((name.to_owned(), why)),
        }
    }
    lines.into_iter().map(|(names, why)| format!("- {names}: {why}\n")).collect()
}
