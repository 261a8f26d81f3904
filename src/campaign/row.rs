//! One line of a table as numbers in SI; and, where it is none, what is wrong with which cell.
//!
//! A line without quotes is cut at its commas and its cells are parsed where they stand. Only what
//! that way does not take goes the slow way, which knows quotes and finds the words for faults.

use crate::campaign::header::{self, Column, TIME};
use crate::campaign::origin::Origin;
use crate::diagnostic::{self, Diagnostic};

const NO_TIME: &str = "the row has no time";

fn not_finite(cell: &str, value: f64, column: &Column) -> Diagnostic {
    let what = if value.is_nan() { "is not a number" } else { "is not finite" };
    Diagnostic::error(format!("`{cell}` in column `{}` {what}", column.name))
        .help("leave the cell empty where a reading is missing")
}

/// A row before the one that came last: either may have the wrong time.
fn backwards(origin: &Origin, time: f64, last: f64) -> Diagnostic {
    let message = match origin.is_outside {
        true => "time runs backwards here".to_owned(),
        false => {
            format!(
                "time runs backwards here: {} s comes after {} s",
                diagnostic::number(time),
                diagnostic::number(last)
            )
        }
    };
    Diagnostic::error(message).help(
        "the rows of a file are in the order of time; the row before may be the one that is off",
    )
}

/// Reads the rows of one table in their order.
#[derive(Debug)]
pub(crate) struct Reader {
    origin: Origin,
    /// The column of times.
    time: Option<usize>,
    last_time: f64,
    /// Whether time may go back.
    any_order: bool,
    /// Whether nothing is wrong with the row that was read last but that its time comes before.
    is_late: bool,
    /// The row at hand, NaN where a cell is empty or not wanted.
    row: Vec<f64>,
}

impl Reader {
    pub(crate) fn new(origin: Origin, columns: &[Column]) -> Self {
        let time = columns.iter().position(|column| column.wanted.as_deref() == Some(TIME));
        let row = vec![f64::NAN; columns.len()];
        Self { origin, time, last_time: f64::NEG_INFINITY, any_order: false, is_late: false, row }
    }

    /// Reads a line; not empty on failure.
    pub(crate) fn read(
        &mut self,
        number: usize,
        line: &[u8],
        columns: &[Column],
    ) -> Result<&[f64], Vec<Diagnostic>> {
        self.is_late = false;
        if !self.plain(line, columns) {
            self.with_words(number, line, columns)?;
        }
        if let (Some(time), false) = (self.time, self.any_order) {
            self.last_time = self.row[time];
        }
        Ok(&self.row)
    }

    /// The row that was read last, if nothing is wrong with it but that its time comes before.
    pub(crate) fn late(&self) -> Option<&[f64]> {
        self.is_late.then_some(&self.row)
    }

    /// Lets time go back from now on.
    pub(crate) fn take_any_order(&mut self) {
        (self.any_order, self.last_time) = (true, f64::NEG_INFINITY);
    }

    /// Takes a row of a file that is no text: the cells of the wanted columns, `None` where empty;
    /// not empty on failure.
    #[cfg(feature = "parquet")]
    pub(crate) fn take(
        &mut self,
        number: usize,
        cells: &[Option<f64>],
        columns: &[Column],
    ) -> Result<&[f64], Vec<Diagnostic>> {
        self.is_late = false;
        let mut faults = Vec::new();
        let wanted = columns.iter().filter(|column| column.wanted.is_some());
        for (column, cell) in wanted.zip(cells.iter().copied()) {
            let value = cell.map_or(f64::NAN, |cell| column.unit.to_si(cell));
            self.row[column.index] = value;
            let is_time = Some(column.index) == self.time;
            let fault = match cell {
                Some(cell) if !value.is_finite() => {
                    not_finite(&self.origin.word(&diagnostic::number(cell)), cell, column)
                }
                None if is_time => Diagnostic::error(NO_TIME),
                Some(_) if is_time && value < self.last_time => {
                    backwards(&self.origin, value, self.last_time)
                }
                _ => continue,
            };
            let mut place = self.origin.place(number, "", (0, 0));
            place.column = column.index + 1;
            faults.push(fault.at(place));
        }
        if !faults.is_empty() {
            self.is_late = faults.len() == 1 && self.is_before();
            return Err(faults);
        }
        if let (Some(time), false) = (self.time, self.any_order) {
            self.last_time = self.row[time];
        }
        Ok(&self.row)
    }

    /// Reads a line of plain cells; whether there is nothing to say about it.
    fn plain(&mut self, line: &[u8], columns: &[Column]) -> bool {
        let Ok(text) = std::str::from_utf8(line) else { return false };
        let ends = memchr::memchr_iter(b',', line).chain(std::iter::once(line.len()));
        let mut start = 0;
        let mut found = 0;
        for (index, end) in ends.enumerate() {
            let Some(column) = columns.get(index) else { return false };
            let cell = text[start..end].trim();
            start = end + 1;
            found += 1;
            self.row[index] = f64::NAN;
            if cell.starts_with('"') {
                return false;
            }
            if column.wanted.is_some() && !cell.is_empty() {
                match cell.parse::<f64>().map(|value| column.unit.to_si(value)) {
                    Ok(value) if value.is_finite() => self.row[index] = value,
                    _ => return false,
                }
            }
        }
        // A time that is missing is not in order, either.
        found == columns.len() && self.time.is_none_or(|time| self.row[time] >= self.last_time)
    }

    /// Reads any line; not empty on failure.
    fn with_words(
        &mut self,
        number: usize,
        line: &[u8],
        columns: &[Column],
    ) -> Result<(), Vec<Diagnostic>> {
        let Ok(text) = std::str::from_utf8(line) else {
            return Err(vec![self.origin.not_utf8(number, line)]);
        };
        let fault = |message: String, cell: (usize, usize)| {
            Diagnostic::error(message).at(self.origin.place(number, text, cell))
        };
        let mut faults = Vec::new();
        let mut found = 0;
        for (index, (cell, span)) in header::cells(text).enumerate() {
            found += 1;
            let Some(column) = columns.get(index) else {
                continue;
            };
            self.row[index] = f64::NAN;
            if column.wanted.is_none() {
                continue;
            }
            if cell.is_empty() {
                if Some(index) == self.time {
                    faults.push(fault(NO_TIME.into(), span));
                }
                continue;
            }
            match cell.parse::<f64>() {
                Ok(value) if column.unit.to_si(value).is_finite() => {
                    self.row[index] = column.unit.to_si(value);
                }
                Ok(value) => {
                    let at = self.origin.place(number, text, span);
                    faults.push(not_finite(&self.origin.word(cell), value, column).at(at));
                }
                Err(_) => {
                    let message = format!(
                        "expected a number in column `{}`, found `{}`",
                        column.name,
                        self.origin.word(cell)
                    );
                    faults.push(fault(message, span));
                }
            }
            if Some(index) == self.time && self.is_before() {
                let at = self.origin.place(number, text, span);
                let fault = backwards(&self.origin, self.row[index], self.last_time);
                faults.push(fault.at(at));
            }
        }
        if found != columns.len() {
            let message =
                format!("expected {} cells as in the header, found {found}", columns.len());
            return Err(vec![fault(message, (0, text.len()))]);
        }
        self.is_late = faults.len() == 1 && self.is_before();
        if faults.is_empty() { Ok(()) } else { Err(faults) }
    }

    /// Whether the row at hand has a time before that of the last one.
    fn is_before(&self) -> bool {
        self.time.is_some_and(|time| self.row[time] < self.last_time)
    }
}
