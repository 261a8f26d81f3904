//! An input recorded with each sample, taken from its table block by block: jumps by whole periods
//! are taken out, samples that lack it are told.

use crate::campaign::header::TIME;
use crate::campaign::signal::{Track, Unwrapper};
use crate::campaign::table::Table;

/// What a table calls the value, the rate and the acceleration of an input.
pub(crate) fn columns_of(input: &str) -> [String; 3] {
    ["", "_rate", "_acceleration"].map(|suffix| format!("{input}{suffix}"))
}

/// Value and rate a while later, at constant acceleration.
pub(crate) fn moved(value: f64, rate: f64, acceleration: f64, by: f64) -> (f64, f64) {
    (value + by * (rate + 0.5 * by * acceleration), rate + by * acceleration)
}

/// What is known of an input from the blocks before.
#[derive(Debug)]
pub(crate) struct Captured {
    names: [String; 3],
    unwrapper: Option<Unwrapper>,
    /// Time (s) and rate at the last value.
    last: (f64, f64),
    /// Whether any value was there, by column.
    seen: [bool; 3],
}

impl Captured {
    /// No block yet.
    pub(crate) fn new(input: &str, period: Option<f64>) -> Self {
        let unwrapper = period.map(Unwrapper::new);
        Self { names: columns_of(input), unwrapper, last: (f64::NAN, f64::NAN), seen: [false; 3] }
    }

    /// Takes the columns of the rows at hand into a track. A sample that lacks one is not usable.
    pub(crate) fn take(
        &mut self,
        table: &Table,
        time: &[f64],
        track: &mut Track,
        usable: &mut [bool],
    ) {
        let is_timed = table.column(TIME).is_some();
        let Track::Captured { value, rate, acceleration } = track else { return };
        let columns = [Some(&mut *value), rate.as_mut(), acceleration.as_mut()];
        for ((name, seen), column) in self.names.iter().zip(&mut self.seen).zip(columns) {
            let Some(column) = column else { continue };
            table.copy(name, column);
            for (usable, value) in usable.iter_mut().zip(column.iter()) {
                *usable &= !value.is_nan();
                *seen |= !value.is_nan();
            }
        }
        let Some(unwrapper) = &mut self.unwrapper else { return };
        for (row, value) in value.iter_mut().enumerate().filter(|(_, value)| value.is_finite()) {
            let rate = rate.as_ref().filter(|_| is_timed).map_or(f64::NAN, |rate| rate[row]);
            let (last_time, last_rate) = self.last;
            let expected = 0.5 * (last_rate + rate) * (time[row] - last_time);
            *value = unwrapper.next(*value, if expected.is_finite() { expected } else { 0.0 });
            self.last = (time[row], rate);
        }
    }

    /// The columns of a table in which no value was.
    pub(crate) fn without_value(&self, table: &Table) -> impl Iterator<Item = &String> {
        let columns = self.names.iter().zip(self.seen);
        columns.filter(|(name, seen)| !seen && table.column(name).is_some()).map(|(name, _)| name)
    }
}
