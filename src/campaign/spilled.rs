//! The columns of a run in a temporary file, as samples.
//!
//! Answers: the samples of a stretch, with the clocks that are straight lines over time or sample
//! number computed on the way. Where the numbers lie in the file is [`super::spill`]'s business.

use std::ops::Range;
use std::sync::OnceLock;

use crate::campaign::samples::{Samples, Starts, shape};
use crate::campaign::signal::Track;
use crate::campaign::spill::{self, BLOCK};
use crate::campaign::uniform::Uniform;

/// A spilled record's columns: times, captured inputs, readings, rows.
#[derive(Debug)]
pub(crate) struct Spilled {
    pub(crate) table: spill::Table,
    /// Shape of the inputs.
    pub(crate) inputs: Vec<Track>,
    /// Number of reading columns.
    pub(crate) readings: usize,
    /// For each captured column, the value of samples before its first one.
    pub(crate) lead: Vec<f64>,
    /// Time of the first sample (s).
    pub(crate) first_time: f64,
    /// Whether the data have no times.
    pub(crate) is_untimed: bool,
    pub(crate) uniform: Uniform,
    pub(crate) fault: OnceLock<String>,
}

impl Spilled {
    /// Shows the times in their order.
    pub(crate) fn each_time(&self, visit: &mut dyn FnMut(f64)) {
        let mut times = Vec::with_capacity(BLOCK);
        for begin in (0..self.table.len()).step_by(BLOCK) {
            times.clear();
            self.column(0, begin..self.table.len().min(begin + BLOCK), &mut times);
            times.iter().for_each(|time| visit(*time));
        }
    }

    fn column(&self, column: usize, range: Range<usize>, into: &mut Vec<f64>) {
        let len = range.len();
        into.clear();
        if let Err(error) = self.table.read(column, range, into) {
            // The first reason is the one that is told.
            self.fault.get_or_init(|| error.to_string());
            into.clear();
            into.resize(len, f64::NAN);
        }
    }

    pub(crate) fn fill(
        &self,
        range: Range<usize>,
        starts: Starts,
        inputs: &[Track],
        into: &mut Samples,
    ) {
        shape(into, inputs, self.readings);
        into.is_untimed = self.is_untimed;
        let mut number = 0;
        for column in into.columns_mut() {
            self.column(number, range.clone(), column);
            if let Some(lead) = number.checked_sub(1).and_then(|k| self.lead.get(k)) {
                column.iter_mut().filter(|value| value.is_nan()).for_each(|value| *value = *lead);
            }
            number += 1;
        }
        let mut rows = Vec::with_capacity(range.len());
        self.column(number, range.clone(), &mut rows);
        let Samples {
            time,
            elapsed_time,
            run_time,
            setup_time,
            uniform_time,
            jump_time,
            jump_ends,
            rows: row_numbers,
            ..
        } = into;
        replace(row_numbers, rows.iter().map(|row| *row as usize));
        replace(run_time, time.iter().map(|time| time - self.first_time));
        replace(setup_time, time.iter().map(|time| time - starts.setup));
        replace(elapsed_time, time.iter().map(|time| time - starts.all));
        replace(uniform_time, range.clone().map(|sample| self.uniform.at(sample)));
        *jump_time = self.uniform.jumps_at(range);
        *jump_ends = self.uniform.jump_ends();
    }
}

fn replace<T>(column: &mut Vec<T>, values: impl Iterator<Item = T>) {
    column.clear();
    column.extend(values);
}
