//! A CSV file, plain or `.gz`, or a Parquet file, as columns in SI, rows as they are wanted.
//!
//! How a text is laid out is recognised (`recognise`) or stated (`form`): a header row, `name [unit]`
//! a column, separators, decimals. An empty cell is a reading that is not there (NaN). Every fault
//! has the file, line and column of its cell. A table knows
//! units, not models: the caller says which columns it wants; others are listed but not read. It
//! holds the rows at hand, not those before them, so a file may be larger than memory.

pub(super) mod open;
mod source;

use std::path::PathBuf;
use std::sync::Arc;

use crate::campaign::computed::Computation;
use crate::campaign::encodings::Encoding;
use crate::campaign::form::Form;
use crate::campaign::formats::Format;
use crate::campaign::header::Column;
use crate::campaign::origin::Origin;
use crate::campaign::recognise::layout::Layout;
use crate::campaign::reordered::Reordered;
use crate::campaign::repeated_rows::RepeatedRows;
use crate::campaign::repeats::Repeats;
use crate::campaign::row::Reader;
use crate::diagnostic::{Diagnostic, Diagnostics, Place};
use crate::document::files::reason;
use source::Source;

/// How many rows that are left out of a file are listed; the rest is counted.
pub const MOST_LISTED: usize = 10_000;

/// A row that was left out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Skipped {
    /// File as the user knows it.
    pub file: Arc<str>,
    /// Line of the row, from 1.
    pub row: usize,
    /// Why.
    pub reason: String,
}

/// A table being read.
#[derive(Debug)]
pub struct Table {
    /// Where it is.
    pub path: PathBuf,
    /// Its name as the user knows it.
    pub file: Arc<str>,
    /// All columns of the header in their order; only wanted ones hold values, of the rows at hand.
    pub columns: Vec<Column>,
    /// Line (from 1) of each row at hand.
    pub lines: Vec<usize>,
    /// Rows left out so far, the first [`MOST_LISTED`] of them; and how many in all.
    pub skipped: Vec<Skipped>,
    /// See [`Table::skipped`].
    pub skipped_count: usize,
    source: Source,
    pub(super) origin: Origin,
    pub(super) reader: Reader,
    /// Columns of the file; those behind were added to it.
    pub(super) width: usize,
    /// Leave bad rows out.
    skip: bool,
    /// The rows in the order of time, where they are not so in the file.
    pub(crate) sorted: Option<Reordered>,
    faults: Repeats,
    pub(super) repeated: RepeatedRows,
    /// Rows read so far.
    count: usize,
    pub(super) layout: Layout,
    pub(super) form: Form,
    /// The format in which it is, stated or recognised.
    pub(super) format: Option<&'static Format>,
    /// Columns computed from others, by their places.
    pub(super) computed: Vec<(usize, Computation)>,
}

/// Why a table could not be read.
#[derive(Clone, Debug)]
pub enum TableError {
    /// The file is missing or cannot be read; the place is where it was named, which the caller
    /// knows.
    Unreadable(String),
    /// It lies outside the campaign's folder, which is not allowed.
    Refused(String),
    /// Its content is at fault.
    Content(Diagnostics),
    /// Its rows are not in the order of time: see `Table::sort`.
    Unordered,
}

/// Adds the cells of a row to the columns that are wanted.
fn push(columns: &mut [Column], row: &[f64]) {
    let cells = columns.iter_mut().zip(row).filter(|(column, _)| column.wanted.is_some());
    cells.for_each(|(column, value)| column.values.push(*value));
}

impl Table {
    /// Puts the next rows in the place of those at hand, at most so many; whether there are any.
    ///
    /// # Errors
    /// The file cannot be read on, has no rows at all, or has up to 20 faults, which come with
    /// their places as soon as all of them are known.
    pub fn more(&mut self, most: usize) -> Result<bool, TableError> {
        let more = self.more_rows(most)?;
        // Rows that are sorted have all their values.
        if self.sorted.is_none() {
            self.compute()?;
        }
        Ok(more)
    }

    fn more_rows(&mut self, most: usize) -> Result<bool, TableError> {
        self.repeated.remember(&self.columns[..self.width]);
        self.columns.iter_mut().for_each(|column| column.values.clear());
        self.lines.clear();
        if let Some(sorted) = &mut self.sorted {
            sorted.more(most, &mut self.lines, &mut self.columns);
            return Ok(!self.lines.is_empty());
        }
        #[cfg(feature = "parquet")]
        let mut cells = Vec::new();
        while self.lines.len() < most {
            let (number, read) = match &mut self.source {
                Source::Text(lines) => {
                    let next = lines.next().map_err(|error| reason(&self.path, &error));
                    let Some((number, line)) = next.map_err(TableError::Unreadable)? else {
                        return self.end();
                    };
                    if self.repeated.is_header(number, line) {
                        continue;
                    }
                    (number, self.reader.read(number, line, &self.columns[..self.width]))
                }
                #[cfg(feature = "parquet")]
                Source::Parquet(rows) => {
                    let next = rows.next(&mut cells).map_err(TableError::Unreadable)?;
                    let Some(number) = next else { return self.end() };
                    (number, self.reader.take(number, &cells, &self.columns[..self.width]))
                }
            };
            match read {
                Ok(row) => {
                    self.count += 1;
                    // With a fault nothing of the table will be used.
                    let own = &self.columns[..self.width];
                    if self.faults.is_empty() && !self.repeated.is_repeated(own, row) {
                        self.lines.push(number);
                        push(&mut self.columns, row);
                    }
                }
                Err(mut found) => {
                    if self.reader.late().is_some() {
                        if self.faults.is_empty() {
                            return Err(TableError::Unordered);
                        }
                        continue;
                    }
                    if self.skip {
                        let why = found.swap_remove(0).what.message;
                        self.leave_out(number, why);
                        continue;
                    }
                    if self.faults.take(number, found) {
                        return self.end();
                    }
                }
            }
        }
        Ok(true)
    }

    /// The first stamp (s), as far as it is known before any row is read.
    pub(crate) fn first_stamp(&self) -> Option<f64> {
        self.reader.stamp_of(self.layout.rows.first()?, &self.columns)
    }

    /// Lets stamps count from a moment (s), before any row is read.
    pub(crate) fn count_from(&mut self, zero: i64) {
        self.reader.count_from(zero);
    }

    /// From when stamps count (s).
    pub(crate) fn zero(&self) -> i64 {
        self.reader.zero()
    }

    /// Lists a bad row.
    pub(crate) fn leave_out(&mut self, row: usize, reason: String) {
        self.skipped_count += 1;
        if self.skipped.len() < MOST_LISTED {
            self.skipped.push(Skipped { file: self.file.clone(), row, reason });
        }
    }

    /// Whether bad rows are left out.
    pub(crate) fn is_lenient(&self) -> bool {
        self.skip
    }

    /// Begins anew, the rows in any order of time.
    pub(crate) fn rewind(&mut self) -> Result<(), TableError> {
        let again = self.source.anew(&self.path, &self.layout, &self.columns[..self.width]);
        self.source = again.map_err(TableError::Unreadable)?;
        self.reader.take_any_order();
        self.columns.iter_mut().for_each(|column| column.values.clear());
        self.repeated = self.repeated.anew();
        self.skipped.clear();
        (self.skipped_count, self.count) = (0, 0);
        Ok(())
    }

    /// What is to be said where reading stops.
    fn end(&mut self) -> Result<bool, TableError> {
        let mut faults = std::mem::take(&mut self.faults).told();
        if let Some(last) = faults.last_mut() {
            last.help.push("--skip-bad-rows leaves such rows out".into());
        } else if self.count == 0 {
            let (message, help) = match self.skipped_count {
                0 => (
                    "the file has a header but no rows".to_owned(),
                    "write at least one row; a run that is not measured yet has `plan` in place of `data`",
                ),
                1 => {
                    ("the only row of the file is bad".to_owned(), "mend it, or leave the run out")
                }
                count => (
                    format!("all {count} rows of the file are bad"),
                    "mend them, or leave the run out",
                ),
            };
            let (line, text) = self.header();
            let place = whole_line(&self.origin, line, text);
            faults.push(Diagnostic::error(message).at(place).help(help));
        }
        let found = Diagnostics(faults).into_result(!self.lines.is_empty());
        found.map_err(|faults| TableError::Content(self.origin.faults(faults)))
    }

    /// How the file is encoded, if not as UTF-8.
    pub(super) fn encoding(&self) -> Option<Encoding> {
        self.source.encoding()
    }

    /// Bytes of the file, packed as it is, read so far.
    pub(crate) fn bytes_read(&self) -> u64 {
        self.source.bytes_read()
    }

    /// The values at hand of a wanted column, if the file has it.
    pub fn values(&self, wanted: &str) -> Option<&[f64]> {
        self.column(wanted).map(|column| column.values.as_slice())
    }

    /// Drops the values at hand of a wanted column: nobody asks for them any more.
    pub(crate) fn forget(&mut self, wanted: &str) {
        let own = self.columns.iter_mut().find(|one| one.wanted.as_deref() == Some(wanted));
        own.into_iter().for_each(|one| one.values = Vec::new());
    }

    /// A wanted column, if the file has it.
    pub fn column(&self, wanted: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.wanted.as_deref() == Some(wanted))
    }

    /// Puts the values at hand of a wanted column in the place of what is there; whether the file
    /// has it.
    pub(crate) fn copy(&self, wanted: &str, into: &mut Vec<f64>) -> bool {
        let values = self.values(wanted);
        into.clear();
        into.extend_from_slice(values.unwrap_or_default());
        values.is_some()
    }

    /// Adds a column that the file does not hold; the caller fills it, for the rows at hand.
    pub(crate) fn add(&mut self, wanted: &str, like: &Column) {
        let wanted = Some(wanted.to_owned());
        self.columns.push(Column { wanted, values: Vec::new(), ..like.clone() });
    }

    /// The values at hand of a wanted column, to be changed.
    pub(crate) fn values_mut(&mut self, wanted: &str) -> Option<&mut Vec<f64>> {
        let is_it = |column: &&mut Column| column.wanted.as_deref() == Some(wanted);
        self.columns.iter_mut().find(is_it).map(|column| &mut column.values)
    }
}

fn whole_line(origin: &Origin, number: usize, text: &str) -> Place {
    origin.place(number, text, (0, text.len()))
}
