//! The layout of a text table, as data: its separator, its header, its first rows.
//!
//! One name of the header may stand for two cells of a row, a date and the time of day behind it. How a
//! layout is recognised is the parent's business.

use crate::campaign::calendar::{Calendar, seeming};
use crate::campaign::dialect::{Cell, Separator, cells, names};
use crate::campaign::form::Form;
use crate::campaign::sexagesimal::degrees;

/// The header row of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Header {
    /// Its line (from 1) and its text, as written.
    pub(crate) line: usize,
    pub(crate) text: String,
    /// Byte at which its names begin, and what separates them.
    pub(crate) start: usize,
    pub(crate) separator: Separator,
    /// The column without a name: the time of day behind a date, where one name stands for both.
    pub(crate) unnamed: Option<usize>,
}

impl Header {
    /// The names of all columns, each with its bytes in the text.
    pub(crate) fn names(&self) -> Vec<Cell<'_>> {
        let moved = |(name, (from, to))| (name, (from + self.start, to + self.start));
        let all = names(&self.text[self.start..], self.separator).into_iter().map(moved);
        let mut all: Vec<Cell<'_>> = all.collect();
        if let Some(at) = self.unnamed.filter(|at| (1..=all.len()).contains(at)) {
            let end = all[at - 1].1.1;
            all.insert(at, ("", (end, end)));
        }
        all
    }

    /// The same for a row with one cell more than there are names, where one of them stands for a date
    /// and the time of day behind it.
    pub(super) fn over(self, row: &str, separator: Separator) -> Self {
        let count = self.names().len();
        let days = dated(row, separator);
        match days.as_slice() {
            [day] if cells(row, separator).count() == count + 1 && *day < count => {
                Self { unnamed: Some(day + 1), ..self }
            }
            _ => self,
        }
    }
}

/// How a file is laid out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Layout {
    pub(crate) separator: Separator,
    /// `None`: the first row holds readings.
    pub(crate) header: Option<Header>,
    /// Cells of the first row.
    pub(crate) width: usize,
    /// Line and text of the first row, the header where it is one.
    pub(crate) first: (usize, String),
    /// Rows before the header.
    pub(crate) preamble: usize,
    /// Whether the row behind the header holds the units of its names, which stand in the header then.
    pub(crate) has_units: bool,
    /// The first rows behind the header, long ones left out.
    pub(crate) rows: Vec<String>,
}

impl Layout {
    /// The header row as it stands in a text file, if there is one that is no comment.
    pub(crate) fn header_row(&self) -> Option<String> {
        let header = self.header.as_ref().filter(|header| header.line == self.first.0);
        header.map(|_| self.first.1.clone())
    }

    /// The numbers of the first rows; NaN for a cell that is none.
    pub(crate) fn numbers(&self, form: &Form) -> Vec<Vec<f64>> {
        let number = |(cell, _): (&str, _)| {
            let mut decimal = form.decimal;
            decimal.number(cell, self.separator).unwrap_or(f64::NAN)
        };
        let row = |row: &String| cells(row, self.separator).map(number).collect();
        self.rows.iter().map(row).collect()
    }

    /// A cell of the first row.
    pub(crate) fn first_cell(&self, index: usize) -> Option<&str> {
        cells(self.rows.first()?, self.separator).nth(index).map(|(cell, _)| cell)
    }

    /// Whether the first rows have degrees, minutes and seconds in a column.
    pub(crate) fn has_degrees(&self, index: usize) -> bool {
        let cell = |row| cells(row, self.separator).nth(index).map(|(cell, _)| cell);
        self.rows.iter().any(|row| cell(row).and_then(degrees).is_some())
    }

    /// The time of day behind a date, or the date before a time of day, by the first row.
    pub(crate) fn beside(&self, index: usize) -> Option<usize> {
        let days = dated(self.rows.first()?, self.separator);
        let day = days.into_iter().find(|day| *day == index || *day + 1 == index)?;
        Some(2 * day + 1 - index)
    }
}

#[cfg(feature = "parquet")]
impl Layout {
    /// Of a file that names its columns, but is no text.
    pub(crate) fn of_names(names: &[String]) -> Self {
        let quoted = names.iter().map(|name| format!("\"{}\"", name.replace('"', "\u{2033}")));
        let text = quoted.collect::<Vec<_>>().join(",");
        let separator = Separator::Comma;
        Self {
            separator,
            header: Some(Header {
                line: 1,
                text: text.clone(),
                start: 0,
                separator,
                unnamed: None,
            }),
            width: names.len(),
            first: (1, text),
            preamble: 0,
            has_units: false,
            rows: Vec::new(),
        }
    }
}

/// The cells of a row that hold dates, with a time of day behind them.
pub(super) fn dated(row: &str, separator: Separator) -> Vec<usize> {
    let kinds: Vec<_> = cells(row, separator).map(|(cell, _)| seeming(cell)).collect();
    let is_dated = |pair: &[Option<Calendar>]| {
        matches!(pair, [Some(Calendar::Day(_)), Some(Calendar::Clock(_))])
    };
    let all = kinds.windows(2).enumerate();
    all.filter(|(_, pair)| is_dated(pair)).map(|(day, _)| day).collect()
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use crate::campaign::dialect::Separator;
    use crate::campaign::form::Form;
    use crate::campaign::recognise::Head;
    use crate::campaign::recognise::tests::{found, named};

    #[test]
    fn one_name_over_a_date_and_a_time_of_day_counts_for_both() {
        let rows = "2025/03/26 12:00:00.5 1.5 7\n2025/03/26 12:00:01.0 1.6 8\n";
        for head in ["% made by a receiver\n%  GPST   x-ecef(m) Q\n", "GPST x-ecef(m) Q\n"] {
            let text = format!("{head}{rows}");
            let header = named(&["GPST", "", "x-ecef(m)", "Q"]);
            assert_eq!(found(&text), (Separator::Blanks, header, 4), "{head}");
            let layout = Head::of(text.as_bytes()).layout(&Form::default()).unwrap();
            assert_eq!(
                (layout.beside(0), layout.beside(1), layout.beside(2)),
                (Some(1), Some(0), None)
            );
        }
        let header = named(&["date", "clock", "x", "Q"]);
        assert_eq!(found(&format!("# date clock x Q\n{rows}")).1, header);
        assert_eq!(found(&format!("date clock x Q\n{rows}")).1, header);
        assert_eq!(found(rows).1, None);
    }
}
