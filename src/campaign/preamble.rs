//! Lines before the header of a table: title, settings, names of bodies, as measuring programs write
//! them.
//!
//! The header is the last row before the first rows that are alike: as many cells, mostly numbers.
//! It has as many names, and no numbers. No row is passed over that may be one of the table: where the
//! first row has as many names, or rows of numbers come before, there is no preamble. Where a campaign says in which line it is, it is there. A table
//! that begins with its header, or has none, has no preamble.

use std::io;

use crate::campaign::dialect::{Separator, cells, names};
use crate::campaign::form::{Form, HeaderRow, is_missing};
use crate::campaign::lines::Lines;
use crate::campaign::recognise::layout::Layout;
use crate::campaign::recognise::separators::{candidates, numbers};
use crate::campaign::recognise::units::are_units;
use crate::campaign::recognise::{Head, ROWS};

/// Rows in which the header is looked for.
pub(crate) const MOST: usize = 100;
/// Rows behind it that are alike, unless the file ends.
const ALIKE: usize = 5;

/// Lines by which a file's form is recognised.
pub(crate) fn head_lines(form: &Form) -> usize {
    match form.header {
        Some(HeaderRow::In(line)) => line + ROWS,
        _ => MOST + ROWS,
    }
}

impl Head<'_> {
    /// How many rows come before the header, as stated or as they look.
    pub(super) fn preamble(&self, form: &Form) -> usize {
        match form.header {
            Some(HeaderRow::In(line)) => self.rows.partition_point(|(number, _)| *number < line),
            Some(HeaderRow::First | HeaderRow::None) => 0,
            None => {
                (1..self.rows.len().min(MOST)).find_map(|at| self.before(at, form)).unwrap_or(0)
            }
        }
    }

    /// The number of the header, of all rows, if rows begin at a place.
    fn before(&self, at: usize, form: &Form) -> Option<usize> {
        let rows = &self.rows[at..self.rows.len().min(at + ALIKE)];
        candidates(form).find_map(|separator| {
            // Remarks at the end of rows need not be there.
            let before = names(self.rows[at - 1].1, separator);
            let has_comment = before.last().is_some_and(|(name, _)| is_comment(name));
            let width = match has_comment {
                true => before.len(),
                false => cells(rows[0].1, separator).count(),
            };
            let is_alike = |row: &str| {
                let filled =
                    |(cell, _): &(&str, _)| !cell.is_empty() && !is_missing(&form.missing, cell);
                let count = cells(row, separator).count();
                let found = numbers(row, separator, form);
                let filled = cells(row, separator).filter(filled).count();
                let fits = count == width || has_comment && count + 1 == width;
                fits && found > 0 && 2 * found > filled
            };
            if width < 2 || !rows.iter().all(|(_, row)| is_alike(row)) {
                return None;
            }
            let has_units = at > 1 && are_units(self.rows[at - 1].1, separator);
            let header = at - 1 - usize::from(has_units);
            // How many names a row has, if it is as wide and has no numbers.
            let named = |row: usize| {
                let text = self.rows[row].1;
                let found = names(text, separator);
                let is_header = found.len() == width && numbers(text, separator, form) == 0;
                is_header.then(|| found.iter().filter(|(name, _)| !name.is_empty()).count())
            };
            // Behind a row of as many names, or behind rows of numbers, words are a bad row: units,
            // readings that are missing, the header of a recorder that was started again.
            let is_named = named(0) == Some(width);
            // A setting (`Samples,300,300`) has a word where the rows have a number.
            let is_behind_rows = self.rows[..header]
                .iter()
                .any(|(_, row)| is_alike(row) && has_numbers_of(row, rows[0].1, separator, form));
            let is_header = named(header).is_some_and(|count| 2 * count >= width);
            is_header.then_some(if is_named || is_behind_rows { 0 } else { header })
        })
    }
}

/// Whether a column holds remarks by its name, as LabVIEW writes one behind the values: rows without a
/// remark end before it.
pub(crate) fn is_comment(name: &str) -> bool {
    name.eq_ignore_ascii_case("comment")
}

/// Whether a row has numbers, or nothing, wherever another one has numbers.
fn has_numbers_of(row: &str, other: &str, separator: Separator, form: &Form) -> bool {
    let is_number = |cell: &str| numbers(cell, separator, form) > 0;
    let is_open = |cell: &str| cell.is_empty() || is_missing(&form.missing, cell);
    let mut pairs = cells(row, separator).zip(cells(other, separator));
    pairs.all(|((own, _), (other, _))| !is_number(other) || is_number(own) || is_open(own))
}

/// Passes over everything before the first row of a table. A header behind a comment sign is passed
/// over like all comments.
pub(crate) fn pass_header(lines: &mut Lines, layout: &Layout) -> io::Result<()> {
    let has_header = layout.header.as_ref().is_some_and(|header| header.line == layout.first.0);
    let rows = layout.preamble + usize::from(has_header) + usize::from(layout.has_units);
    for _ in 0..rows {
        lines.next()?;
    }
    Ok(())
}
