//! The samples of readings, looked up in any order, wherever a run's samples are.
//!
//! A run in memory lends the sample. Of a spilled run the block around the last sample stays at
//! hand, so that neighbours cost one read.

use crate::campaign::record::{BLOCK, Sample};
use crate::campaign::run::Samples;
use crate::engine::part::Part;
use crate::estimate::newton::ReadingDelay;

/// One sample of a run after another, wherever they are kept.
#[derive(Debug, Default)]
pub(crate) struct Nearby {
    scratch: Samples,
    /// Run, first sample and number of samples in the scratch.
    held: Option<(usize, usize, usize)>,
}

impl Nearby {
    pub(crate) fn sample<'a>(&'a mut self, part: &'a Part, reading: &ReadingDelay) -> Sample<'a> {
        let ReadingDelay { run, sample: number, .. } = *reading;
        let record = &part.runs[run].record;
        if !record.is_spilled() {
            self.held = None;
            return record.sample(number, &mut self.scratch);
        }
        let is_held = |(of, first, len): (usize, usize, usize)| {
            of == run && (first..first + len).contains(&number)
        };
        if !self.held.is_some_and(is_held) {
            let first = number / BLOCK * BLOCK;
            let len = record.stretch(first..first + BLOCK, &mut self.scratch).len;
            self.held = Some((run, first, len));
        }
        let first = self.held.map_or(0, |(_, first, _)| first);
        Sample { samples: &self.scratch, at: number - first, number }
    }
}
