//! The stamp of a row: the value of one column, or the sum of several (`sec` and `nanosec`, a date and
//! a time of day).
//!
//! The parts are added as exact numbers, so that a sum has all the digits that they have.

use crate::campaign::calendar::{Calendar, calendar};
use crate::campaign::date::DateOrder;
use crate::campaign::header::{ADDED, Column, TIME};
use crate::campaign::stamps::Exact;
use crate::units::Unit;

/// The columns of a file that make its stamps, and the parts of the row at hand so far.
#[derive(Clone, Debug)]
pub(crate) struct StampColumns {
    /// The column that holds the sum.
    time: Option<usize>,
    /// The columns that are added to it.
    added: Vec<usize>,
    /// From when stamps count (s).
    zero: i64,
    /// In which order dates have day, month and year.
    order: Option<DateOrder>,
    sum: Exact,
    /// Parts that are no exact numbers (s).
    rest: f64,
    /// Parts of the row that are there.
    count: usize,
    /// Whether a date and a time of day are among them.
    taken: [bool; 2],
}

impl StampColumns {
    /// Those among the columns of a file.
    pub(crate) fn of(columns: &[Column], order: Option<DateOrder>) -> Self {
        let are = |name: &'static str| {
            let all = columns.iter().enumerate();
            all.filter(move |(_, column)| column.wanted.as_deref() == Some(name))
        };
        Self {
            time: are(TIME).next().map(|(place, _)| place),
            added: are(ADDED).map(|(place, _)| place).collect(),
            zero: 0,
            order,
            sum: Exact::ZERO,
            rest: 0.0,
            count: 0,
            taken: [false; 2],
        }
    }

    /// The column of stamps, which holds the sum.
    pub(crate) fn time(&self) -> Option<usize> {
        self.time
    }

    /// Whether a column is part of the stamp.
    pub(crate) fn has(&self, column: usize) -> bool {
        self.time == Some(column) || self.added.contains(&column)
    }

    /// Begins a row.
    pub(crate) fn begin(&mut self) {
        (self.sum, self.rest, self.count, self.taken) = (Exact::ZERO, 0.0, 0, [false; 2]);
    }

    /// Lets stamps count from a moment (s).
    pub(crate) fn count_from(&mut self, zero: i64) {
        self.zero = zero;
    }

    /// From when stamps count (s).
    pub(crate) fn zero(&self) -> i64 {
        self.zero
    }

    /// Whether the stamp is the sum of several columns.
    pub(crate) fn is_sum(&self) -> bool {
        !self.added.is_empty()
    }

    /// Takes a part: its cell, and the number that it is, if it is one; whether it is a time. A date
    /// and a time of day are taken once.
    pub(crate) fn take(&mut self, cell: &str, number: Option<f64>, unit: &Unit) -> bool {
        let is_one = !self.is_sum();
        let exact = match number {
            // Like any other column, where nothing is added and nothing taken off.
            Some(_) if is_one && self.zero == 0 => None,
            Some(_) => Exact::of_number(cell, unit),
            None => {
                let (part, own) = match calendar(cell, self.order) {
                    Some(Calendar::Moment(part)) => (part, [true, true]),
                    Some(Calendar::Clock(part)) => (part, [false, true]),
                    // A date without time of day is no moment.
                    Some(Calendar::Day(part)) if !is_one => (part, [true, false]),
                    _ => return false,
                };
                if (0..2).any(|kind| self.taken[kind] && own[kind]) {
                    return false;
                }
                self.taken = [0, 1].map(|kind| self.taken[kind] || own[kind]);
                Some(part)
            }
        };
        self.count += 1;
        match exact.and_then(|part| self.sum.plus(part)) {
            Some(sum) => self.sum = sum,
            None => self.rest += number.map_or(f64::NAN, |number| unit.to_si(number)),
        }
        true
    }

    /// The stamp (s) since the moment from which stamps count, as soon as all of its parts are there.
    pub(crate) fn whole(&self) -> Option<f64> {
        let is_whole = self.time.is_some() && self.count == 1 + self.added.len();
        is_whole.then(|| self.sum.since(self.zero).unwrap_or(f64::NAN) + self.rest)
    }
}
