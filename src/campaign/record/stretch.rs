//! Consecutive samples of a run, and one of them, in the columns that hold them.

use std::ops::Range;

use crate::campaign::samples::Samples;

/// Consecutive samples of a run.
#[derive(Clone, Copy, Debug)]
pub struct Stretch<'a> {
    /// Columns that hold the stretch.
    pub samples: &'a Samples,
    /// Index of the stretch's first sample within those columns.
    pub start: usize,
    /// Number of that sample in its run.
    pub first: usize,
    /// How many samples.
    pub len: usize,
}

/// One sample of a run.
#[derive(Clone, Copy, Debug)]
pub struct Sample<'a> {
    /// Columns that hold it.
    pub samples: &'a Samples,
    /// Its index within those columns.
    pub at: usize,
    /// Its number in its run.
    pub number: usize,
}

impl<'a> Stretch<'a> {
    /// Where the stretch stands in the columns.
    pub fn range(&self) -> Range<usize> {
        self.start..self.start + self.len
    }

    /// Its samples.
    pub fn each(self) -> impl ExactSizeIterator<Item = Sample<'a>> {
        let Self { samples, start, first, len } = self;
        (0..len).map(move |i| Sample { samples, at: start + i, number: first + i })
    }
}

impl Sample<'_> {
    /// Its reference time (s).
    pub fn time(&self) -> f64 {
        self.samples.time[self.at]
    }

    /// The row of the data file that it is from (line number, from 1).
    pub fn row(&self) -> usize {
        self.samples.rows.get(self.at).copied().unwrap_or(self.number + 1)
    }

    /// A reading column's value; NaN where it is missing.
    pub fn reading(&self, column: usize) -> f64 {
        self.samples.readings[column][self.at]
    }
}
