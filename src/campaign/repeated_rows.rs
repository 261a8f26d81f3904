//! Rows that repeat the row before, stamp and values: a log that was written twice. They hold nothing
//! new, and would count twice. And rows that repeat the header row: logs that were put together.

use crate::campaign::header::{Column, TIME};
use crate::diagnostic::Diagnostic;

/// How many rows of a table repeat another one, and what is needed to see it.
#[derive(Clone, Debug, Default)]
pub(crate) struct RepeatedRows {
    /// The column of stamps.
    time: Option<usize>,
    /// The last row before those at hand.
    last: Vec<f64>,
    count: usize,
    /// The header row, and the lines that repeat it.
    header: Option<String>,
    headers: Vec<usize>,
}

impl RepeatedRows {
    /// Of a table with these columns, and a header row if it has one.
    pub(crate) fn of(columns: &[Column], header: Option<String>) -> Self {
        let is_time = |column: &Column| column.wanted.as_deref() == Some(TIME);
        let header = header.map(|header| header.trim_end().to_owned());
        Self { time: columns.iter().position(is_time), header, ..Self::default() }
    }

    /// The same before any row is read.
    pub(crate) fn anew(&self) -> Self {
        Self { time: self.time, header: self.header.clone(), ..Self::default() }
    }

    /// Whether a line repeats the header row; notes it.
    pub(crate) fn is_header(&mut self, number: usize, line: &[u8]) -> bool {
        // The second log may begin with a byte order mark.
        let line = line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(line).trim_ascii_end();
        let is_header = self.header.as_ref().is_some_and(|header| header.as_bytes() == line);
        if is_header {
            self.headers.push(number);
        }
        is_header
    }

    /// The warning of repeated header rows, once.
    pub(crate) fn header_warning(&mut self, file: &str) -> Option<Diagnostic> {
        let lines = std::mem::take(&mut self.headers);
        let message = match lines.as_slice() {
            [] => return None,
            [one] => format!("`{file}`: line {one} repeats the header row and was passed over"),
            [first, .., last] => format!(
                "`{file}`: {} lines from line {first} to line {last} repeat the header row and were passed over",
                lines.len()
            ),
        };
        let help =
            "logs that were put together may have gaps between them, or times that begin anew";
        Some(Diagnostic::warning(message).help(help))
    }

    /// Remembers the last one of the rows at hand, before others take their place.
    pub(crate) fn remember(&mut self, columns: &[Column]) {
        if columns.iter().any(|column| !column.values.is_empty()) {
            let last = |column: &Column| column.values.last().copied().unwrap_or(f64::NAN);
            self.last = columns.iter().map(last).collect();
        }
    }

    /// Whether a row repeats the last one of those at hand; counts it. Rows without stamps may well be
    /// alike, and those without values say nothing.
    pub(crate) fn is_repeated(&mut self, columns: &[Column], row: &[f64]) -> bool {
        let last = |at: usize| columns[at].values.last().or(self.last.get(at)).copied();
        let same = |at: usize| last(at).is_some_and(|last| last.to_bits() == row[at].to_bits());
        let Some(time) = self.time.filter(|time| same(*time)) else { return false };
        let mut wanted = (0..row.len()).filter(|at| columns[*at].wanted.is_some());
        let holds_values = wanted.clone().any(|at| at != time && !row[at].is_nan());
        let is_repeated = holds_values && wanted.all(same);
        self.count += usize::from(is_repeated);
        is_repeated
    }

    /// Counts rows that repeat another one, though not the row before in the file.
    pub(crate) fn add(&mut self, count: usize) {
        self.count += count;
    }

    /// What is to be reported, once.
    pub(crate) fn told(&mut self, file: &str) -> Option<Diagnostic> {
        let rows = match std::mem::take(&mut self.count) {
            0 => return None,
            1 => "1 row that repeats another one, stamp and values, was left out".to_owned(),
            count => {
                format!("{count} rows that repeat another one, stamp and values, were left out")
            }
        };
        let message = format!("`{file}`: {rows}");
        let help = "where they are readings of their own, write their stamps with more decimals";
        Some(Diagnostic::warning(message).help(help))
    }
}
