//! The rows of a table in the order of time, where the file has them in another one.
//!
//! A file is read block by block as long as its rows are in order. Where time goes back it is read
//! once more, whole, and sorted in memory; a file too large for that is to be sorted beforehand.

use crate::campaign::header::{Column, TIME};
use crate::campaign::order::{self, Order};
use crate::campaign::reordered::Reordered;
use crate::campaign::table::{Table, TableError};
use crate::campaign::wraps;
use crate::diagnostic::{Diagnostic, Diagnostics, counted, decimals, number};

/// The most numbers that are sorted in memory.
const MOST_NUMBERS: usize = 100_000_000;
/// Rows with a time far from all others that are reported.
const MOST_FAR: usize = 20;
/// Rows that repeat rows before, from which on they were written twice.
const REPEATED: usize = 3;

impl Table {
    /// Whether the rows at hand are the first ones in the order of time, of a file that has them in
    /// another one: those before do not count.
    pub(crate) fn begins_sorted(&self) -> bool {
        self.sorted.as_ref().is_some_and(|sorted| sorted.begins)
    }

    /// Reads the whole file and sorts its rows by time; [`Table::more`] then begins anew. What is
    /// to be reported.
    ///
    /// # Errors
    /// The file cannot be read again, is too large, or should not be sorted: its clock was set.
    pub(crate) fn sort(&mut self) -> Result<Option<Diagnostic>, TableError> {
        self.rewind()?;
        let wanted = self.columns.iter().filter(|column| column.wanted.is_some()).count();
        let most = MOST_NUMBERS / wanted.max(1);
        self.more(most.saturating_add(1))?;
        let Some(mut time) = self.column(TIME).cloned() else { return Err(TableError::Unordered) };
        if self.lines.len() > most {
            let message = format!("the rows are not in the order of time, and more than {most}");
            let help = "so many are not sorted in memory: sort the file by time, e.g. with `sort -t, -k1,1g`";
            let fault = Diagnostic::error(message).at(self.header_place(&time)).help(help);
            return Err(TableError::Content(fault.into()));
        }
        let bad = self.unwrap(&mut time)?;
        let (mut order, far, back, largest) = match order::judge(&time.values) {
            Order::Sort { order, far, back, largest } => (order, far, back, largest),
            Order::Set { row, count, by } => {
                let fault = self.set(&time, row, count, by);
                return Err(TableError::Content(fault.into()));
            }
        };
        self.take_far_out(&time, &far)?;
        let is_bad = order::marked(time.values.len(), &bad);
        order.retain(|row| !is_bad[*row]);
        let before = order.len();
        let columns: Vec<Vec<f64>> =
            self.columns.iter_mut().map(|column| std::mem::take(&mut column.values)).collect();
        let same = |a: usize, b: usize| {
            columns.iter().all(|column| match (column.get(a), column.get(b)) {
                (Some(a), Some(b)) => a.to_bits() == b.to_bits(),
                _ => true,
            })
        };
        order.dedup_by(|row, before| same(*row, *before));
        self.repeated.add(before - order.len());
        let lines = std::mem::take(&mut self.lines);
        let count = lines.len();
        self.sorted = Some(Reordered { lines, columns, order, shown: 0, begins: false });
        let message = match (back, far.len()) {
            (0, 0) => return Ok(None),
            (0, far) => format!(
                "`{}`: the times of {} are far from all others",
                self.name(),
                counted(far, "row")
            ),
            _ => order::told(&self.name(), count, back, largest),
        };
        Ok(Some(Diagnostic::warning(message)))
    }

    /// Lets the stamps of a counter go on where it begins anew; the rows whose stamps are bad.
    fn unwrap(&mut self, time: &mut Column) -> Result<Vec<usize>, TableError> {
        let Some(size) = self.form.wraps else { return Ok(Vec::new()) };
        let (values, bad) = wraps::unwrapped(&time.values, size);
        if let Some(own) = self.values_mut(TIME) {
            own.clone_from(&values);
        }
        let stamps = std::mem::replace(&mut time.values, values);
        let (is_outside, zero) = (self.is_outside(), self.zero() as f64);
        self.take_out(time, &bad, |row| match is_outside {
            true => "the stamp leaps, and the rows behind it go on from before it".to_owned(),
            false => format!(
                "the stamp {} s leaps, and the rows behind it go on from before it",
                number(stamps[row] + zero)
            ),
        })?;
        Ok(bad)
    }

    /// Leaves rows out whose time is far from all others, or faults them.
    fn take_far_out(&mut self, time: &Column, far: &[usize]) -> Result<(), TableError> {
        let is_far = order::marked(time.values.len(), far);
        let others = time.values.iter().zip(&is_far).filter(|(_, is_far)| !**is_far);
        let others = others.map(|(time, _)| *time);
        let (from, to) = others.fold((f64::INFINITY, f64::NEG_INFINITY), |(from, to), time| {
            (from.min(time), to.max(time))
        });
        let zero = self.zero() as f64;
        let (is_outside, times) = (self.is_outside(), &time.values);
        self.take_out(time, far, |row| match is_outside {
            true => "the time is far from all others".to_owned(),
            false => format!(
                "the time {} s is far from all others, which go from {} s to {} s",
                number(times[row] + zero),
                number(from + zero),
                number(to + zero)
            ),
        })
    }

    /// Leaves rows out for a reason, or faults them.
    fn take_out(
        &mut self,
        time: &Column,
        rows: &[usize],
        why: impl Fn(usize) -> String,
    ) -> Result<(), TableError> {
        let mut faults = Vec::new();
        for row in rows.iter().copied() {
            if self.is_lenient() {
                self.leave_out(self.lines[row], why(row));
            } else if faults.len() < MOST_FAR {
                faults.push(Diagnostic::error(why(row)).at(self.cell_place(row, time)));
            }
        }
        if let Some(last) = faults.last_mut().filter(|_| rows.len() > MOST_FAR) {
            last.message += &format!(" (and {} more)", counted(rows.len() - MOST_FAR, "row"));
        }
        if let Some(last) = faults.last_mut() {
            last.help.push("--skip-bad-rows leaves such rows out".into());
        }
        self.skipped.sort_by_key(|one| one.row);
        Diagnostics(faults).into_result(()).map_err(TableError::Content)
    }

    /// The first of the rows that those from one on repeat, stamp and values, and how many do.
    fn repeats(&self, time: &Column, row: usize) -> Option<(usize, usize)> {
        let same = |a: usize, b: usize| {
            let of =
                |column: &Column, at: usize| column.values.get(at).map(|value| value.to_bits());
            self.columns.iter().all(|column| of(column, a) == of(column, b))
        };
        let stamp = time.values[row].to_bits();
        let is_first = |at: &usize| time.values[*at].to_bits() == stamp && same(*at, row);
        let first = (0..row).find(is_first)?;
        let rows = (0..row - first).zip(row..self.lines.len());
        let count = rows.take_while(|(at, other)| same(first + at, *other)).count();
        // Readings that do not change are the same at other moments, too.
        let differs =
            |values: &[f64]| values.iter().any(|one| one.to_bits() != values[0].to_bits());
        let moves = |column: &Column| {
            let is_time = column.wanted.as_deref() == Some(TIME);
            !is_time && column.values.get(row..row + count).is_some_and(differs)
        };
        (count >= REPEATED && self.columns.iter().any(moves)).then_some((first, count))
    }

    /// The fault of a clock that was set back, of a counter that began anew, or of rows that were written
    /// twice.
    fn set(&self, time: &Column, row: usize, count: usize, by: f64) -> Diagnostic {
        if let Some((first, count)) = self.repeats(time, row) {
            let rows = |from: usize| (self.lines[from], self.lines[from + count - 1]);
            let ((from, to), (other, last)) = (rows(row), rows(first));
            let message = format!(
                "rows {from} to {to} repeat rows {other} to {last}, stamps and values: they were written twice"
            );
            let help = format!("delete rows {from} to {to}: each reading would count twice");
            return Diagnostic::error(message).at(self.cell_place(row, time)).help(help);
        }
        let times = order::times(count);
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
