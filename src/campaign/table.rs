//! A CSV file, plain or `.gz`, as columns in SI.
//!
//! One header row, `name [unit]` a column; UTF-8, commas, `#` comments; an empty cell is a reading
//! that is not there (NaN). Every fault has the file, line and column of its cell. A table knows
//! units, not models: the caller says which columns it wants; others are listed but not read.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::campaign::header::{self, Column, Wanted};
use crate::campaign::lines::{self, Lines};
use crate::diagnostic::{Diagnostic, Diagnostics, Place};

/// How many faults are reported before reading stops.
const MOST_FAULTS: usize = 20;

/// The column that must be there in every row and must not run backwards.
pub const TIME: &str = "time";

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

/// A table that was read.
#[derive(Clone, Debug)]
pub struct Table {
    /// Where it is.
    pub path: PathBuf,
    /// Its name as the user knows it.
    pub file: Arc<str>,
    /// All columns of the header in their order; only wanted ones hold values.
    pub columns: Vec<Column>,
    /// Line (from 1) of each row.
    pub lines: Vec<usize>,
    /// Rows left out.
    pub skipped: Vec<Skipped>,
}

/// Why a table could not be read.
#[derive(Clone, Debug)]
pub enum TableError {
    /// The file is missing or cannot be read; the place is where it was named, which the caller knows.
    Unreadable(String),
    /// Its content is at fault.
    Content(Diagnostics),
}

impl Table {
    /// Reads the wanted columns of a file.
    ///
    /// With `skip_bad_rows`, rows of the wrong length, with cells that are no numbers or with a time
    /// that is missing or runs backwards are left out and listed in [`Table::skipped`].
    ///
    /// # Errors
    /// The file cannot be read, or up to 20 faults with their places.
    pub fn read(path: &Path, wanted: &[Wanted], skip_bad_rows: bool) -> Result<Self, TableError> {
        let bytes = lines::read_bytes(path).map_err(TableError::Unreadable)?;
        let file: Arc<str> = path.display().to_string().into();
        let mut table = Self {
            path: path.to_owned(),
            file,
            columns: Vec::new(),
            lines: Vec::new(),
            skipped: Vec::new(),
        };
        table.fill(&bytes, wanted, skip_bad_rows).map_err(TableError::Content)?;
        Ok(table)
    }

    fn fill(&mut self, bytes: &[u8], wanted: &[Wanted], skip: bool) -> Result<(), Diagnostics> {
        let mut lines = Lines::new(bytes);
        let Some((number, line)) = lines.next() else {
            let place = whole_line(&self.file, 1, "");
            return Err(Diagnostic::error("the file has no header row")
                .at(place)
                .help(
                    "start the file with a row of column names, `name [unit]`, separated by commas",
                )
                .into());
        };
        let header = std::str::from_utf8(line)
            .map_err(|_| Diagnostics::from(not_utf8(&self.file, number, line)))?;
        self.columns = header::read(&self.file, number, header, wanted)?;
        let width = self.columns.len();
        let time = self.columns.iter().position(|column| column.wanted.as_deref() == Some(TIME));
        let mut faults = Vec::new();
        let mut row = vec![f64::NAN; width];
        let mut last_time = f64::NEG_INFINITY;
        for (number, line) in lines {
            let read = self.row(number, line, time, last_time, &mut row);
            match read {
                Ok(()) => {
                    if let Some(time) = time {
                        last_time = row[time];
                    }
                    self.lines.push(number);
                    for (column, value) in self.columns.iter_mut().zip(&row) {
                        if column.wanted.is_some() {
                            column.values.push(*value);
                        }
                    }
                }
                Err(mut found) if skip => {
                    let reason = found.swap_remove(0).message;
                    self.skipped.push(Skipped { file: self.file.clone(), row: number, reason });
                }
                Err(found) => {
                    faults.extend(found);
                    if faults.len() >= MOST_FAULTS {
                        break;
                    }
                }
            }
        }
        if !faults.is_empty() {
            faults.truncate(MOST_FAULTS);
            if let Some(last) = faults.last_mut() {
                last.help.push("--skip-bad-rows leaves such rows out".into());
            }
            return Err(Diagnostics(faults));
        }
        if self.lines.is_empty() {
            let message = match self.skipped.len() {
                0 => "the file has a header but no rows".to_owned(),
                count => format!("all {count} rows of the file are bad"),
            };
            return Err(Diagnostic::error(message)
                .at(whole_line(&self.file, number, header))
                .into());
        }
        Ok(())
    }

    /// Reads one line into `row`; not empty on failure.
    fn row(
        &self,
        number: usize,
        line: &[u8],
        time: Option<usize>,
        last_time: f64,
        row: &mut [f64],
    ) -> Result<(), Vec<Diagnostic>> {
        let Ok(text) = std::str::from_utf8(line) else {
            return Err(vec![not_utf8(&self.file, number, line)]);
        };
        let fault = |message: String, cell: (usize, usize)| {
            Diagnostic::error(message).at(self.place_in(number, text, cell))
        };
        let mut faults = Vec::new();
        let mut found = 0;
        for (index, (cell, span)) in header::cells(text).enumerate() {
            found += 1;
            let Some(column) = self.columns.get(index) else {
                continue;
            };
            row[index] = f64::NAN;
            if column.wanted.is_none() {
                continue;
            }
            if cell.is_empty() {
                if Some(index) == time {
                    faults.push(fault("the row has no time".into(), span));
                }
                continue;
            }
            match cell.parse::<f64>() {
                Ok(value) if column.unit.to_si(value).is_finite() => {
                    row[index] = column.unit.to_si(value);
                }
                Ok(value) => {
                    let what = if value.is_nan() { "is not a number" } else { "is not finite" };
                    faults.push(
                        fault(format!("`{cell}` in column `{}` {what}", column.name), span)
                            .help("leave the cell empty where a reading is missing"),
                    );
                }
                Err(_) => {
                    let shown: String = cell.chars().take(40).collect();
                    let message =
                        format!("expected a number in column `{}`, found `{shown}`", column.name);
                    faults.push(fault(message, span));
                }
            }
            if Some(index) == time && row[index] < last_time {
                faults.push(
                    fault("time runs backwards here".into(), span)
                        .help("the rows of a file are in the order of time"),
                );
            }
        }
        if found != row.len() {
            let message = format!("expected {} cells as in the header, found {found}", row.len());
            return Err(vec![fault(message, (0, text.len()))]);
        }
        if faults.is_empty() { Ok(()) } else { Err(faults) }
    }

    /// The values of a wanted column, if the file has it.
    pub fn values(&self, wanted: &str) -> Option<&[f64]> {
        self.column(wanted).map(|column| column.values.as_slice())
    }

    /// A wanted column, if the file has it.
    pub fn column(&self, wanted: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.wanted.as_deref() == Some(wanted))
    }

    /// Names of all columns, for messages.
    pub fn names(&self) -> String {
        let names: Vec<_> = self.columns.iter().map(|column| column.name.as_str()).collect();
        names.join(", ")
    }

    /// The place of a header cell.
    pub fn header_place(&self, column: &Column) -> Place {
        self.place_on_line(column.line, column.index)
    }

    /// The place of a cell by its row (index into [`Table::lines`]) and column. The file is read
    /// once more; where that fails, the place has no excerpt.
    pub fn cell_place(&self, row: usize, column: &Column) -> Place {
        self.place_on_line(self.lines.get(row).copied().unwrap_or(1), column.index)
    }

    fn place_on_line(&self, number: usize, index: usize) -> Place {
        let bytes = lines::read_bytes(&self.path).unwrap_or_default();
        let line = Lines::new(&bytes).find(|(at, _)| *at == number);
        let text = line.and_then(|(_, line)| std::str::from_utf8(line).ok()).unwrap_or("");
        let span = header::cells(text).nth(index).map_or((0, 0), |(_, span)| span);
        self.place_in(number, text, span)
    }

    fn place_in(&self, number: usize, text: &str, span: (usize, usize)) -> Place {
        header::place(&self.file, number, text, span)
    }
}

fn whole_line(file: &Arc<str>, number: usize, text: &str) -> Place {
    header::place(file, number, text, (0, text.len()))
}

fn not_utf8(file: &Arc<str>, number: usize, line: &[u8]) -> Diagnostic {
    let valid = std::str::from_utf8(line).err().map_or(0, |error| error.valid_up_to());
    let text = String::from_utf8_lossy(line);
    let place = header::place(file, number, &text, (valid, valid));
    Diagnostic::error("the file is not UTF-8 here").at(place).help("save the file as UTF-8")
}
