//! The rows of a table in the order of time, where the file has them in another one.
//!
//! A file is read block by block as long as its rows are in order. Where time goes back it is read
//! once more, whole, and sorted in memory; a file too large for that is to be sorted beforehand.

use crate::campaign::header::{Column, TIME};
use crate::campaign::order::{self, Order};
use crate::campaign::reordered::Reordered;
use crate::campaign::table::{Table, TableError};
use crate::diagnostic::{Diagnostic, Diagnostics, decimals, number};

/// The most numbers that are sorted in memory.
const MOST_NUMBERS: usize = 100_000_000;
/// Rows with a time far from all others that are reported.
const MOST_FAR: usize = 20;

impl Table {
    /// Whether the rows at hand are the first ones in the order of time, of a file that has them in
    /// another one: those before do not count.
    pub(crate) fn begins_sorted(&self) -> bool {
        self.sorted.as_ref().is_some_and(|sorted| sorted.begins)
    }

    /// Reads the whole file and sorts its rows by time; [`Table::more`] then begins anew. What is
    /// to be said of it.
    ///
    /// # Errors
    /// The file cannot be read again, is too large, or should not be sorted: its clock was set.
    pub(crate) fn sort(&mut self) -> Result<Diagnostic, TableError> {
        self.rewind()?;
        let wanted = self.columns.iter().filter(|column| column.wanted.is_some()).count();
        let most = MOST_NUMBERS / wanted.max(1);
        self.more(most.saturating_add(1))?;
        let Some(time) = self.column(TIME).cloned() else { return Err(TableError::Unordered) };
        if self.lines.len() > most {
            let message = format!("the rows are not in the order of time, and more than {most}");
            let help = "so many are not sorted in memory: sort the file by time, e.g. with `sort -t, -k1,1g`";
            let fault = Diagnostic::error(message).at(self.header_place(&time)).help(help);
            return Err(TableError::Content(fault.into()));
        }
        let (mut order, far, back, largest) = match order::judge(&time.values) {
            Order::Sort { order, far, back, largest } => (order, far, back, largest),
            Order::Set { row, count, by } => {
                let fault = self.set(&time, row, count, by);
                return Err(TableError::Content(fault.into()));
            }
        };
        self.take_far_out(&time, &far)?;
        let sorted = order.len();
        let columns: Vec<Vec<f64>> =
            self.columns.iter_mut().map(|column| std::mem::take(&mut column.values)).collect();
        let same = |a: usize, b: usize| {
            columns.iter().all(|column| match (column.get(a), column.get(b)) {
                (Some(a), Some(b)) => a.to_bits() == b.to_bits(),
                _ => true,
            })
        };
        order.dedup_by(|row, before| same(*row, *before));
        let repeated = sorted - order.len();
        let lines = std::mem::take(&mut self.lines);
        let count = lines.len();
        self.sorted = Some(Reordered { lines, columns, order, shown: 0, begins: false });
        let mut message = match back {
            0 => format!("{} rows have times far from all others", far.len()),
            _ => order::told(&self.name(), count, back, largest),
        };
        if repeated > 0 {
            message += &format!("; {repeated} that repeat the row before were left out");
        }
        Ok(Diagnostic::warning(message))
    }

    /// Leaves rows out whose time is far from all others, or faults them.
    fn take_far_out(&mut self, time: &Column, far: &[usize]) -> Result<(), TableError> {
        let others = |row: &usize| !far.contains(row);
        let others = (0..time.values.len()).filter(others).map(|row| time.values[row]);
        let (from, to) = others.fold((f64::INFINITY, f64::NEG_INFINITY), |(from, to), time| {
            (from.min(time), to.max(time))
        });
        let zero = self.zero() as f64;
        let mut faults = Vec::new();
        for row in far.iter().copied() {
            let why = match self.is_outside() {
                true => "the time is far from all others".to_owned(),
                false => format!(
                    "the time {} s is far from all others, which go from {} s to {} s",
                    number(time.values[row] + zero),
                    number(from + zero),
                    number(to + zero)
                ),
            };
            if self.is_lenient() {
                self.leave_out(self.lines[row], why);
            } else if faults.len() < MOST_FAR {
                faults.push(Diagnostic::error(why).at(self.cell_place(row, time)));
            }
        }
        if let Some(last) = faults.last_mut() {
            last.help.push("--skip-bad-rows leaves such rows out".into());
        }
        self.skipped.sort_by_key(|one| one.row);
        Diagnostics(faults).into_result(()).map_err(TableError::Content)
    }

    /// The fault of a clock that was set back, or of a counter that began anew.
    fn set(&self, time: &Column, row: usize, count: usize, by: f64) -> Diagnostic {
        let times = if count == 1 { "once".to_owned() } else { format!("{count} times") };
        let message = format!(
            "time goes back {times}, here by {} s, and goes on from there: the clock was set or began anew",
            decimals(by, 6)
        );
        let fault = Diagnostic::error(message).at(self.cell_place(row, time));
        match order::counter(by, &time.unit) {
            Some(size) => fault.help(format!(
                "a counter that begins anew after {size} does that; if it is one, say so: {{ file = \"{}\", wraps = \"{size}\" }}",
                self.name()
            )),
            None => fault.help("split the file there into two runs, or mend the times: sorted rows would mix moments"),
        }
    }
}
