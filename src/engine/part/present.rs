//! The readings that are there: of a measurand, of a run, of a column.

use super::{Part, Slot};
use crate::campaign::Sample;

impl Part {
    /// All readings of a column, run after run.
    pub fn readings_of(&self, column: usize) -> Vec<Vec<f64>> {
        self.runs.iter().map(|run| run.record.column(column)).collect()
    }

    /// Whether a measurand of a sample was read.
    pub fn is_present(&self, sample: Sample<'_>, slot: &Slot) -> bool {
        !sample.reading(slot.column).is_nan()
    }

    /// Number of readings of each measurand.
    pub fn present(&self) -> Vec<usize> {
        let runs = (0..self.runs.len()).map(|run| self.present_in(run));
        runs.fold(vec![0; self.slots.len()], |sum, run| {
            sum.iter().zip(run).map(|(sum, own)| sum + own).collect()
        })
    }

    /// Number of residual components of each measurand that there are readings of: of a rotation
    /// three times that of its readings.
    pub fn components_present(&self) -> Vec<usize> {
        let all = self.slots.iter().zip(self.present());
        all.map(|(slot, readings)| slot.components * readings).collect()
    }

    /// Whether a run has readings.
    pub fn has_readings(&self, run: usize) -> bool {
        self.present_in(run).iter().any(|count| *count > 0)
    }

    /// Number of readings of each measurand in a run.
    pub fn present_in(&self, run: usize) -> Vec<usize> {
        let mut counts = vec![0; self.slots.len()];
        self.runs[run].record.walk(|stretch| {
            for (slot, count) in self.slots.iter().zip(&mut counts) {
                let readings = &stretch.samples.readings[slot.column][stretch.range()];
                *count += readings.iter().filter(|reading| !reading.is_nan()).count();
            }
        });
        counts
    }
}
