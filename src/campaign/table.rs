//! A CSV file, plain or `.gz`, or a Parquet file, as columns in SI, rows as they are wanted.
//!
//! How a text is laid out is recognised (`recognise`) or stated (`form`): a header row, `name [unit]`
//! a column, separators, decimals. An empty cell is a reading that is not there (NaN). Every fault
//! has the file, line and column of its cell. A table knows
//! units, not models: the caller says which columns it wants; others are listed but not read. It
//! holds the rows at hand, not those before them, so a file may be larger than memory.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::campaign::computed::Computation;
use crate::campaign::date_order;
use crate::campaign::encodings::Encoding;
use crate::campaign::form::{Form, HeaderRow};
use crate::campaign::formats::Format;
use crate::campaign::header::{self, Column, Header, Wanted};
use crate::campaign::lines::Lines;
use crate::campaign::origin::Origin;
#[cfg(feature = "parquet")]
use crate::campaign::parquet::Rows;
use crate::campaign::preamble::{head_lines, pass_header};
use crate::campaign::recognise::Head;
use crate::campaign::recognise::layout::Layout;
use crate::campaign::reordered::Reordered;
use crate::campaign::repeated_rows::RepeatedRows;
use crate::campaign::repeats::Repeats;
use crate::campaign::row::Reader;
use crate::diagnostic::{Diagnostic, Diagnostics, Place};
use crate::document::files::{Files, Input, Refused, open_regular, reason, refused};

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

/// Where rows come from.
#[derive(Debug)]
enum Source {
    Text(Lines),
    #[cfg(feature = "parquet")]
    Parquet(Box<Rows>),
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
    /// Reads the wanted columns of a whole file.
    ///
    /// # Errors
    /// Those of [`Table::open`] and [`Table::more`].
    pub fn read(path: &Path, wanted: &[Wanted], skip_bad_rows: bool) -> Result<Self, TableError> {
        let mut table = Self::open(path, &Form::default(), wanted, skip_bad_rows)?;
        table.more(usize::MAX)?;
        Ok(table)
    }

    /// Reads the header of a file; no row is at hand yet.
    ///
    /// With `skip_bad_rows`, rows of the wrong length, with cells that are no numbers or with a
    /// time that is missing or runs backwards are left out and listed in [`Table::skipped`].
    ///
    /// # Errors
    /// The file cannot be read, or the header is at fault.
    pub fn open(
        path: &Path,
        form: &Form,
        wanted: &[Wanted],
        skip_bad_rows: bool,
    ) -> Result<Self, TableError> {
        Self::open_of(&mut Files::default(), path, form, wanted, skip_bad_rows)
    }

    /// The same of a file that is one of others: messages show nothing of one outside their folder.
    ///
    /// # Errors
    /// As for [`Table::open`]; a file outside the folder where none is allowed.
    pub fn open_of(
        files: &mut Files,
        path: &Path,
        form: &Form,
        wanted: &[Wanted],
        skip_bad_rows: bool,
    ) -> Result<Self, TableError> {
        let unreadable = |error: std::io::Error| match refused(&error) {
            Some(Refused::Outside) => TableError::Refused(reason(path, &error)),
            _ => TableError::Unreadable(reason(path, &error)),
        };
        let Input { file, is_outside, .. } = files.open(path).map_err(unreadable)?;
        let origin = Origin { file: path.display().to_string().into(), is_outside };
        if is_parquet(path) {
            return Self::open_parquet(path, file, origin, wanted, skip_bad_rows);
        }
        let content = |faults| TableError::Content(origin.faults(faults));
        let mut source = Lines::of(file).map_err(unreadable)?;
        let head = Head::of(source.head(head_lines(form)).map_err(unreadable)?);
        let nothing = header::no_rows(&origin, &head);
        let layout = head.layout(form);
        let Some(layout) = layout else {
            // Nothing is there, or the first row is no text.
            let fault = match source.next().map_err(unreadable)? {
                Some((number, line)) => origin.not_utf8(number, line),
                None => nothing,
            };
            return Err(content(fault.into()));
        };
        if let Some(HeaderRow::In(line)) = form.header
            && layout.first.0 != line
        {
            return Err(content(no_row_in(&origin, line).into()));
        }
        let header = header::read(&origin, &layout, form, wanted).map_err(content)?;
        let Header { columns, format, computed } = header;
        let is_used = !computed.is_empty() || columns.iter().any(|column| column.wanted.is_some());
        if layout.header.is_none() && !is_used {
            return Err(content(header::no_header(&origin, &layout).into()));
        }
        let settled = date_order::settled(path, form, (&origin, &layout), &columns);
        let form = &settled.map_err(unreadable)?.map_err(|fault| content(fault.into()))?;
        pass_header(&mut source, &layout).map_err(unreadable)?;
        let source = Source::Text(source);
        let table = Self::new(path, origin, form, columns, layout, source, skip_bad_rows);
        Ok(Self { format, ..table }.with(computed, wanted))
    }

    fn new(
        path: &Path,
        origin: Origin,
        form: &Form,
        columns: Vec<Column>,
        layout: Layout,
        source: Source,
        skip: bool,
    ) -> Self {
        Self {
            path: path.to_owned(),
            reader: Reader::new(origin.clone(), form, layout.separator, &columns),
            file: origin.file.clone(),
            origin,
            width: columns.len(),
            repeated: RepeatedRows::of(&columns, layout.header_row()),
            columns,
            lines: Vec::new(),
            skipped: Vec::new(),
            skipped_count: 0,
            source,
            skip,
            sorted: None,
            faults: Repeats::default(),
            count: 0,
            layout,
            form: form.clone(),
            format: None,
            computed: Vec::new(),
        }
    }

    #[cfg(not(feature = "parquet"))]
    fn open_parquet(
        path: &Path,
        _: File,
        _: Origin,
        _: &[Wanted],
        _: bool,
    ) -> Result<Self, TableError> {
        Err(TableError::Unreadable(format!(
            "`{}` cannot be read: this program was built without the feature `parquet` (build it with `--features parquet`, or write the table as CSV, plain or .gz)",
            path.display()
        )))
    }

    /// The names of columns are taken as the header of a text file would be.
    #[cfg(feature = "parquet")]
    fn open_parquet(
        path: &Path,
        file: File,
        origin: Origin,
        wanted: &[Wanted],
        skip: bool,
    ) -> Result<Self, TableError> {
        let content = |faults| TableError::Content(origin.faults(faults));
        let mut rows = Rows::of(path, file).map_err(TableError::Unreadable)?;
        let layout = Layout::of_names(&rows.names());
        let Header { columns, .. } =
            header::read(&origin, &layout, &Form::default(), wanted).map_err(content)?;
        let read = columns.iter().filter(|column| column.wanted.is_some());
        rows.want(read.map(|column| column.index).collect()).map_err(|(column, found)| {
            let message = format!("the column `{}` holds {found}", columns[column].name);
            let place = origin.cell(1, &layout.first.1, layout.separator, column);
            let fault = Diagnostic::error(message).at(place).help("write it as numbers");
            content(fault.into())
        })?;
        let source = Source::Parquet(Box::new(rows));
        Ok(Self::new(path, origin, &Form::default(), columns, layout, source, skip))
    }

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
        let unreadable = |error: std::io::Error| TableError::Unreadable(reason(&self.path, &error));
        let file = open_regular(&self.path).map_err(unreadable)?;
        self.source = match &self.source {
            Source::Text(_) => {
                let mut lines = Lines::of(file).map_err(unreadable)?;
                pass_header(&mut lines, &self.layout).map_err(unreadable)?;
                Source::Text(lines)
            }
            #[cfg(feature = "parquet")]
            Source::Parquet(_) => {
                let mut rows = Rows::of(&self.path, file).map_err(TableError::Unreadable)?;
                let columns = self.columns[..self.width].iter();
                let read = columns.filter(|column| column.wanted.is_some());
                let wanted = rows.want(read.map(|column| column.index).collect());
                wanted.map_err(|(_, found)| TableError::Unreadable(found.to_owned()))?;
                Source::Parquet(Box::new(rows))
            }
        };
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
        match &self.source {
            Source::Text(lines) => lines.encoding,
            #[cfg(feature = "parquet")]
            Source::Parquet(_) => None,
        }
    }

    /// Bytes of the file, packed as it is, read so far.
    pub(crate) fn bytes_read(&self) -> u64 {
        match &self.source {
            Source::Text(lines) => lines.bytes_read(),
            #[cfg(feature = "parquet")]
            Source::Parquet(rows) => rows.bytes_read(),
        }
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

/// The columns of a file; none where it cannot be read.
pub(crate) fn columns_in(path: &Path, form: &Form) -> Vec<Column> {
    let layout = || {
        let mut lines = open_regular(path).and_then(Lines::of).ok()?;
        let layout = Head::of(lines.head(head_lines(form)).ok()?).layout(form)?;
        let origin = Origin { file: "".into(), is_outside: false };
        header::read(&origin, &layout, form, &[]).ok().map(|header| header.columns)
    };
    match is_parquet(path) {
        true => Table::open(path, form, &[], false).map(|table| table.columns).unwrap_or_default(),
        false => layout().unwrap_or_default(),
    }
}

pub(super) fn is_parquet(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "parquet")
}

/// The fault of a stated header that is none.
fn no_row_in(origin: &Origin, line: usize) -> Diagnostic {
    Diagnostic::error(format!("there is no header row in line {line}"))
        .at(whole_line(origin, line, ""))
        .help("it is empty, a comment, or beyond the end: lines count from 1, as an editor shows them")
}

fn whole_line(origin: &Origin, number: usize, text: &str) -> Place {
    origin.place(number, text, (0, text.len()))
}
