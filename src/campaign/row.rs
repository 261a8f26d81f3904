//! One line of a table as numbers in SI; and, where it is none, what is wrong with which cell.
//!
//! A line without quotes is cut at its separators and its cells are parsed where they stand. Only
//! what that way does not take goes the slow way, which knows quotes and finds the words for faults.

use crate::campaign::calendar::{Calendar, FORMS, is_no_day, seeming};
use crate::campaign::dialect::{Decimal, Separator, cells};
use crate::campaign::form::{Form, is_missing};
use crate::campaign::header::Column;
use crate::campaign::origin::Origin;
use crate::campaign::preamble::is_comment;
use crate::campaign::repeats::{Cause, RowFault};
use crate::campaign::sexagesimal::{EXPECTED, degrees};
use crate::campaign::stamp_columns::StampColumns;
use crate::campaign::wraps::Wraps;
use crate::diagnostic::{self, Diagnostic};

const NO_TIME: &str = "the row has no time";

fn not_finite(cell: &str, value: f64, column: &Column) -> Diagnostic {
    let what = if value.is_nan() { "is not a number" } else { "is not finite" };
    Diagnostic::error(format!("`{cell}` in column `{}` {what}", column.name))
        .help("leave the cell empty where a reading is missing, or say in the campaign what stands there: data = { file = \"...\", missing = \"nan\" }")
}

/// Reads the rows of one table in their order.
#[derive(Debug)]
pub(crate) struct Reader {
    origin: Origin,
    /// The columns that make the stamp.
    stamp: StampColumns,
    last_time: f64,
    /// Whether time may go back.
    any_order: bool,
    /// Whether nothing is wrong with the row that was read last but that its time comes before.
    is_late: bool,
    separator: Separator,
    decimal: Decimal,
    /// A counter of stamps that begins anew.
    wraps: Option<Wraps>,
    /// Cells that stand for a missing reading.
    missing: Vec<String>,
    /// The row at hand, NaN where a cell is empty or not wanted.
    row: Vec<f64>,
}

impl Reader {
    pub(crate) fn new(
        origin: Origin,
        form: &Form,
        separator: Separator,
        columns: &[Column],
    ) -> Self {
        Self {
            origin,
            stamp: StampColumns::of(columns, form.dates),
            last_time: f64::NEG_INFINITY,
            any_order: false,
            is_late: false,
            separator,
            decimal: form.decimal,
            wraps: form.wraps.map(Wraps::new),
            missing: form.missing.clone(),
            row: vec![f64::NAN; columns.len()],
        }
    }

    /// Reads a line; not empty on failure.
    pub(crate) fn read(
        &mut self,
        number: usize,
        line: &[u8],
        columns: &[Column],
    ) -> Result<&[f64], Vec<RowFault>> {
        self.is_late = false;
        if !self.plain(line, columns) {
            self.with_words(number, line, columns)?;
        }
        if let (Some(time), false) = (self.stamp.time(), self.any_order) {
            self.last_time = self.row[time];
        }
        Ok(&self.row)
    }

    /// The row that was read last, if nothing is wrong with it but that its time comes before.
    pub(crate) fn late(&self) -> Option<&[f64]> {
        self.is_late.then_some(&self.row)
    }

    /// Whether numbers were found to have decimal commas.
    pub(crate) fn has_decimal_commas(&self) -> bool {
        self.decimal == Decimal::Comma
    }

    /// Lets stamps count from a moment (s).
    pub(crate) fn count_from(&mut self, zero: i64) {
        self.stamp.count_from(zero);
    }

    /// From when stamps count (s).
    pub(crate) fn zero(&self) -> i64 {
        self.stamp.zero()
    }

    /// The stamp (s) of a row, since no moment, without reading it.
    pub(crate) fn stamp_of(&self, row: &str, columns: &[Column]) -> Option<f64> {
        let (mut stamp, mut decimal) = (self.stamp.clone(), self.decimal);
        stamp.begin();
        for (index, (cell, _)) in cells(row, self.separator).enumerate() {
            if stamp.has(index) {
                let number = decimal.number(cell, self.separator);
                stamp.take(cell, number, &columns.get(index)?.unit);
            }
        }
        stamp.whole().filter(|stamp| stamp.is_finite())
    }

    /// Lets time go back from now on, and leaves stamps of a counter as they are.
    pub(crate) fn take_any_order(&mut self) {
        (self.any_order, self.last_time) = (true, f64::NEG_INFINITY);
        self.wraps = None;
    }

    /// Takes a row of a file that is no text: the cells of the wanted columns, `None` where empty;
    /// not empty on failure.
    #[cfg(feature = "parquet")]
    pub(crate) fn take(
        &mut self,
        number: usize,
        cells: &[Option<f64>],
        columns: &[Column],
    ) -> Result<&[f64], Vec<RowFault>> {
        self.is_late = false;
        self.stamp.begin();
        let mut faults = Vec::new();
        let wanted = columns.iter().filter(|column| column.wanted.is_some());
        for (column, cell) in wanted.zip(cells.iter().copied()) {
            let value = cell.map_or(f64::NAN, |cell| column.unit.to_si(cell));
            let is_time = self.stamp.has(column.index);
            self.row[column.index] = if is_time { f64::NAN } else { value };
            let stamp = cell.filter(|_| is_time && value.is_finite());
            let stamp = stamp.and_then(|cell| self.part(&cell.to_string(), Some(cell), column));
            let (cause, fault) = match cell {
                Some(cell) if !value.is_finite() => {
                    let word = diagnostic::number(cell);
                    (Cause::NotFinite, not_finite(&self.origin.word(&word), cell, column))
                }
                None if is_time => (Cause::NoTime, Diagnostic::error(NO_TIME)),
                Some(_) if stamp.is_some_and(|stamp| stamp < self.last_time) => {
                    (Cause::Backwards, self.backwards())
                }
                _ => continue,
            };
            let mut place = self.origin.place(number, "", (0, 0));
            place.column = column.index + 1;
            faults.push(RowFault { cause: (cause, column.index), what: fault.at(place) });
        }
        if !faults.is_empty() {
            self.is_late = faults.len() == 1 && self.is_before();
            return Err(faults);
        }
        if let (Some(time), false) = (self.stamp.time(), self.any_order) {
            self.last_time = self.row[time];
        }
        Ok(&self.row)
    }

    /// Reads a line of plain cells; whether there is nothing to say about it.
    fn plain(&mut self, line: &[u8], columns: &[Column]) -> bool {
        let Ok(text) = std::str::from_utf8(line) else { return false };
        self.stamp.begin();
        let found = match self.separator.byte() {
            Some(byte) => {
                let ends = memchr::memchr_iter(byte, line).chain(std::iter::once(line.len()));
                let mut start = 0;
                let mut found = 0;
                for end in ends {
                    let cell = text[start..end].trim();
                    start = end + 1;
                    if !self.cell(found, cell, columns) {
                        return false;
                    }
                    found += 1;
                }
                found
            }
            None => {
                let mut found = 0;
                for cell in text.split_ascii_whitespace() {
                    if !self.cell(found, cell, columns) {
                        return false;
                    }
                    found += 1;
                }
                found
            }
        };
        // A time that is missing is not in order, either.
        let is_whole = found == columns.len() || found == columns.len() + 1;
        is_whole && self.stamp.time().is_none_or(|time| self.row[time] >= self.last_time)
    }

    /// The number of a cell, in the unit of its column.
    fn number(&mut self, cell: &str, column: &Column) -> Option<f64> {
        let plain = self.decimal.number(cell, self.separator);
        plain.or_else(|| degrees(cell).filter(|_| column.is_sexagesimal))
    }

    /// Takes a plain cell; whether there is nothing to say about it.
    fn cell(&mut self, index: usize, cell: &str, columns: &[Column]) -> bool {
        let Some(column) = columns.get(index) else {
            // What a separator at the end of a line leaves.
            return index == columns.len() && cell.is_empty();
        };
        self.row[index] = f64::NAN;
        if cell.starts_with('"') {
            return false;
        }
        if column.wanted.is_none() || cell.is_empty() {
            return true;
        }
        let number = self.number(cell, column);
        let si = number.map_or(f64::NAN, |number| column.unit.to_si(number));
        let is_finite = if self.stamp.has(index) {
            (number.is_none() || si.is_finite()) && self.part(cell, number, column).is_some()
        } else {
            self.row[index] = si;
            si.is_finite()
        };
        is_finite && (self.missing.is_empty() || !is_missing(&self.missing, cell))
    }

    /// Takes a part of a stamp, and puts the stamp into its column when it is whole, as if its counter
    /// had no end: the stamp, infinite as long as parts lack; `None` for what is no time.
    fn part(&mut self, cell: &str, number: Option<f64>, column: &Column) -> Option<f64> {
        if !self.stamp.take(cell, number, &column.unit) {
            return None;
        }
        let (Some(time), Some(stamp)) = (self.stamp.time(), self.stamp.whole()) else {
            return Some(f64::INFINITY);
        };
        let stamp = self.wraps.as_mut().map_or(stamp, |wraps| wraps.next(stamp));
        self.row[time] = stamp;
        stamp.is_finite().then_some(stamp)
    }

    /// Reads any line; not empty on failure.
    fn with_words(
        &mut self,
        number: usize,
        line: &[u8],
        columns: &[Column],
    ) -> Result<(), Vec<RowFault>> {
        let fault = |cause, column, what| RowFault { cause: (cause, column), what };
        let Ok(text) = std::str::from_utf8(line) else {
            return Err(vec![fault(Cause::NotText, 0, self.origin.not_utf8(number, line))]);
        };
        let mut faults = Vec::new();
        let mut found = 0;
        self.stamp.begin();
        for (index, (cell, span)) in cells(text, self.separator).enumerate() {
            let Some(column) = columns.get(index) else {
                // A separator at the end of the line begins no cell.
                found += usize::from(index > columns.len() || !cell.is_empty());
                continue;
            };
            found += 1;
            self.row[index] = f64::NAN;
            if column.wanted.is_none() {
                continue;
            }
            let at = self.origin.place(number, text, span);
            let is_time = self.stamp.has(index);
            if cell.is_empty() || is_missing(&self.missing, cell) {
                if is_time {
                    faults.push(fault(Cause::NoTime, index, Diagnostic::error(NO_TIME).at(at)));
                }
                continue;
            }
            let value = self.number(cell, column);
            match value.map(|value| (value, column.unit.to_si(value))) {
                Some((value, si)) if !si.is_finite() => {
                    let what = not_finite(&self.origin.word(cell), value, column).at(at);
                    faults.push(fault(Cause::NotFinite, index, what));
                }
                Some((_, si)) if !is_time => self.row[index] = si,
                None if !is_time => {
                    let what = self.not_a_number(cell, column).at(at);
                    faults.push(fault(Cause::NotANumber, index, what));
                }
                _ => match self.part(cell, value, column) {
                    Some(stamp) if stamp < self.last_time => {
                        faults.push(fault(Cause::Backwards, index, self.backwards().at(at)));
                    }
                    Some(_) => {}
                    None => {
                        let what = self.not_a_number(cell, column).at(at);
                        faults.push(fault(Cause::NotANumber, index, what));
                    }
                },
            }
        }
        let may_lack = |column: &Column| {
            !column.is_named || column.wanted.is_none() && is_comment(&column.name)
        };
        if found < columns.len() && columns[found..].iter().all(may_lack) {
            // The header ends with separators, or with a column of remarks.
            self.row[found..].fill(f64::NAN);
        } else if found != columns.len() {
            let message =
                format!("expected {} cells as in the header, found {found}", columns.len());
            let at = self.origin.place(number, text, (0, text.len()));
            return Err(vec![fault(Cause::Cells, 0, Diagnostic::error(message).at(at))]);
        }
        self.is_late = faults.len() == 1 && self.is_before();
        if faults.is_empty() { Ok(()) } else { Err(faults) }
    }

    /// The fault of the row at hand, whose time lies before the last one: either may be wrong.
    fn backwards(&self) -> Diagnostic {
        let own = self.stamp.time().map_or(f64::NAN, |time| self.row[time]);
        let [time, last] = [own, self.last_time].map(|time| time + self.zero() as f64);
        let message = match self.origin.is_outside {
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

    fn not_a_number(&self, cell: &str, column: &Column) -> Diagnostic {
        let word = self.origin.word(cell);
        let is_stamp = self.stamp.has(column.index);
        let time = seeming(cell).filter(|_| is_stamp);
        if time.is_some() && self.stamp.is_sum() {
            let message = format!(
                "column `{}` has a second date or time of day of the stamp: `{word}`",
                column.name
            );
            return Diagnostic::error(message)
                .help("keep one column of the list for each: time = [\"date\", \"clock\"]");
        }
        if is_stamp && is_no_day(cell) {
            let message = format!("there is no such date: `{word}` in column `{}`", column.name);
            return Diagnostic::error(message);
        }
        let what = Diagnostic::error(format!(
            "expected a number in column `{}`, found `{word}`",
            column.name
        ));
        if let Some(Calendar::Day(_)) = time {
            return what.help("a date alone is no moment: name the column of the time of day, too: columns = { time = [\"date\", \"clock\"] }");
        }
        let what = match self.decimal.without_thousands(cell) {
            Some(plain) => {
                what.help(format!("write it without separators of thousands: `{plain}`"))
            }
            None => what,
        };
        match self.decimal {
            Decimal::Comma if cell.contains('.') => {
                what.help("the numbers of this file have decimal commas, this one has a point")
            }
            Decimal::Open if self.separator == Separator::Comma && cell.contains(',') => what.help(
                "thousands or decimals? Where they are decimals, state both in the campaign: separator = \",\", decimal = \",\"",
            ),
            Decimal::Point if cell.contains(',') => {
                what.help("the numbers of this file have decimal points, this one has a comma")
            }
            _ if is_stamp => what.help(FORMS),
            _ if column.is_sexagesimal || degrees(cell).is_some() => what.help(EXPECTED),
            _ if matches!(cell, "+" | "-" | "±") => {
                what.help("a sign alone is no number: write 1 for `+` and -1 for `-` in the file")
            }
            _ => what,
        }
    }

    /// Whether the row at hand has a time before that of the last one.
    fn is_before(&self) -> bool {
        self.stamp.time().is_some_and(|time| self.row[time] < self.last_time)
    }
}
