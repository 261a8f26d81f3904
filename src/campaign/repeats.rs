//! Faults of rows, each cause once: its first row with its place, and how many rows are like it.

use crate::diagnostic::Diagnostic;

/// How many causes are reported.
const MOST_CAUSES: usize = 20;
/// After so many bad rows reading stops.
const MOST_ROWS: usize = 10_000;

/// What can be wrong with a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cause {
    /// It is no UTF-8.
    NotText,
    /// It has too many or too few cells.
    Cells,
    /// A cell is no number.
    NotANumber,
    /// A number is infinite or none.
    NotFinite,
    /// It has no time.
    NoTime,
    /// Its time is before that of the row before.
    Backwards,
}

/// A fault of a row.
#[derive(Clone, Debug)]
pub(crate) struct RowFault {
    /// The cause, and the column where it is one of a cell.
    pub(crate) cause: (Cause, usize),
    /// What is said of it.
    pub(crate) what: Diagnostic,
}

/// Faults by their causes.
#[derive(Debug, Default)]
pub(crate) struct Repeats {
    /// The first fault of each cause, how many there are, and the line of the last.
    found: Vec<(RowFault, usize, usize)>,
    rows: usize,
}

impl Repeats {
    /// Takes the faults of a row; whether enough is known.
    pub(crate) fn take(&mut self, line: usize, faults: Vec<RowFault>) -> bool {
        self.rows += 1;
        for fault in faults {
            match self.found.iter_mut().find(|(known, ..)| known.cause == fault.cause) {
                Some((_, count, last)) => (*count, *last) = (*count + 1, line),
                None => self.found.push((fault, 1, line)),
            }
        }
        self.found.truncate(MOST_CAUSES);
        self.rows >= MOST_ROWS
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.found.is_empty()
    }

    /// What is said of each cause.
    pub(crate) fn told(self) -> Vec<Diagnostic> {
        let is_all = self.rows < MOST_ROWS;
        let told = |(fault, count, last): (RowFault, usize, usize)| {
            let mut what = fault.what;
            if count > 1 {
                let more = if is_all { "" } else { " and more" };
                what.message += &format!(" ({count} rows{more} like this, to line {last})");
            }
            what
        };
        self.found.into_iter().map(told).collect()
    }
}
