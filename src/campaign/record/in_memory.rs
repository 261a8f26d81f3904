//! Samples of a record in memory: all of them, a part, and samples that are changed there.

use std::ops::Range;
use std::sync::Arc;

use super::{Kept, Record};
use crate::campaign::samples::Samples;

impl Record {
    /// Whether all samples are in memory: from the beginning, or since [`Record::whole`] read them
    /// back.
    pub fn is_in_memory(&self) -> bool {
        !self.is_spilled() || self.whole.get().is_some()
    }

    /// All samples in memory, read back once if need be: for small runs.
    pub fn whole(&self) -> &Samples {
        match &self.kept {
            Kept::Held(samples) if self.is_as_recorded(&(0..self.len)) => samples,
            _ => self.whole.get_or_init(|| Arc::new(self.head(self.len))),
        }
    }

    /// The first samples, at most so many.
    pub fn head(&self, most: usize) -> Samples {
        self.cut(0..most.min(self.len))
    }

    /// About so many samples, in stretches of at most `step` spread evenly over the run.
    pub fn spread(&self, most: usize, step: usize) -> Samples {
        let mut ranges = self.share(most as f64 / self.len.max(1) as f64, step);
        // Without samples there are its inputs.
        let mut spread = self.cut(ranges.next().unwrap_or_default());
        ranges.for_each(|range| spread.append(self.cut(range)));
        spread
    }

    /// The samples of a range within the run, in memory.
    pub fn cut(&self, range: Range<usize>) -> Samples {
        let mut samples = Samples::default();
        self.copy(range, &mut samples);
        samples
    }

    /// Changes the samples; they are in memory from then on.
    pub fn edit(&mut self, change: impl FnOnce(&mut Samples)) {
        let as_recorded = self.is_as_recorded(&(0..self.len));
        let held = match std::mem::take(self) {
            Self { kept: Kept::Held(samples), .. } if as_recorded => Some(samples),
            other => {
                other.whole();
                other.whole.into_inner()
            }
        };
        let mut samples = Arc::unwrap_or_clone(held.unwrap_or_default());
        change(&mut samples);
        *self = Self::held(samples);
    }
}
