//! Where a table's cells are from, for messages: their places, and as much of them as is shown.

use std::borrow::Cow;
use std::sync::Arc;

use crate::campaign::dialect::{Separator, cells};
use crate::diagnostic::{Diagnostic, Diagnostics, Place, shortened};
use crate::document::OUTSIDE;

/// The longest line (bytes) shown with a message.
const LONGEST_EXCERPT: usize = 4000;
/// The most names that a message lists.
const MOST_NAMES: usize = 30;

/// The file of a table.
#[derive(Clone, Debug)]
pub(crate) struct Origin {
    /// Its name as the user knows it.
    pub(crate) file: Arc<str>,
    /// Whether it lies outside the campaign's folder: messages show nothing of it.
    pub(crate) is_outside: bool,
}

impl Origin {
    /// A cell or a name for a message.
    pub(crate) fn word<'a>(&self, cell: &'a str) -> Cow<'a, str> {
        if self.is_outside { Cow::Borrowed("...") } else { shortened(cell) }
    }

    /// Names of the file for a message: the first of them, and how many there are beside.
    pub(crate) fn names<'a>(&self, names: impl ExactSizeIterator<Item = &'a str>) -> String {
        if self.is_outside {
            return format!("(not shown, for the file {OUTSIDE})");
        }
        listed(names, MOST_NAMES, "")
    }

    /// The place of a part of a line.
    pub(crate) fn place(&self, line: usize, text: &str, span: (usize, usize)) -> Place {
        let before = text.get(..span.0).unwrap_or(text);
        let inside = text.get(span.0..span.1).unwrap_or("");
        let is_shown = !self.is_outside && text.len() <= LONGEST_EXCERPT;
        let (column, length) = (before.chars().count() + 1, inside.chars().count().max(1));
        Place::new(self.file.clone(), line, column, length, if is_shown { text } else { "" })
    }

    /// The place of a cell of a line, by its column.
    pub(crate) fn cell(&self, line: usize, text: &str, by: Separator, index: usize) -> Place {
        let span = cells(text, by).nth(index).map_or((0, 0), |(_, span)| span);
        self.place(line, text, span)
    }

    /// Faults of the file's content; says why nothing of it is shown.
    pub(crate) fn faults(&self, mut faults: Diagnostics) -> Diagnostics {
        if let (Some(last), true) = (faults.0.last_mut(), self.is_outside) {
            last.help.push(format!(
                "its content is not shown, for the file {OUTSIDE}; --show-outside shows it"
            ));
        }
        faults
    }

    /// A line that is not UTF-8: the fault, at the first byte that is none.
    pub(crate) fn not_utf8(&self, number: usize, line: &[u8]) -> Diagnostic {
        let valid = std::str::from_utf8(line).err().map_or(0, |error| error.valid_up_to());
        let text = String::from_utf8_lossy(line);
        // Bytes that are no characters at all say nothing to the reader.
        let is_shown = !text.contains(|c: char| c.is_control() && !c.is_whitespace());
        let place = match is_shown {
            true => self.place(number, &text, (valid, valid)),
            false => self.place(number, "", (0, 0)),
        };
        Diagnostic::error("the file is not UTF-8 here").at(place).help("save the file as UTF-8")
    }
}

/// Names in a row, each between `quote`, at most so many; and how many there are beside.
pub(crate) fn listed<'a>(
    names: impl ExactSizeIterator<Item = &'a str>,
    most: usize,
    quote: &str,
) -> String {
    let more = names.len().saturating_sub(most);
    let shown: Vec<String> =
        names.take(most).map(|name| format!("{quote}{}{quote}", shortened(name))).collect();
    match more {
        0 => shown.join(", "),
        _ => format!("{} and {more} more", shown.join(", ")),
    }
}
