//! What was recorded of a run, however long: held in memory, or spilled to a temporary file and
//! read back a stretch at a time.
//!
//! Who walks a run asks for stretches: a held record lends its columns, a spilled one fills the
//! caller's scratch; the numbers are the same, bit by bit. A spilled record keeps times, captured
//! inputs, readings and rows; the other clocks are straight lines over time or sample number and
//! computed on the way. A record can be looked at with a [`Change`], or with readings left out,
//! which costs memory for these alone.
//!
//! A temporary file that cannot be read any more does not stop a walk: the stretch is filled with
//! NaN and [`Record::fault`] says why. Whoever uses the result asks for it.

pub(super) mod change;
mod in_memory;
mod in_place;
mod stretch;

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

pub use crate::campaign::spill::BLOCK;
pub use change::Change;
pub use stretch::{Sample, Stretch};

use crate::campaign::samples::{Samples, Starts, shape};
use crate::campaign::signal::Track;
use crate::campaign::spilled::Spilled;

/// The samples of a run.
#[derive(Clone, Debug)]
pub struct Record {
    len: usize,
    /// Where each input comes from; columns are empty.
    inputs: Vec<Track>,
    kept: Kept,
    change: Option<Change>,
    /// Samples and their reading columns that are looked at as missing, by block of samples.
    left_out: Arc<BTreeMap<usize, Vec<LeftOut>>>,
    /// All samples, where somebody wanted them in memory although they are not held.
    whole: OnceLock<Arc<Samples>>,
}

#[derive(Clone, Debug)]
enum Kept {
    Held(Arc<Samples>),
    /// With the inputs as they are read: streams may be other ones than when it was written.
    Spilled {
        columns: Arc<Spilled>,
        starts: Starts,
        inputs: Vec<Track>,
    },
}

/// Samples of one block, and their reading columns.
type LeftOut = (Range<usize>, Range<usize>);

impl Default for Record {
    fn default() -> Self {
        Self::held(Samples::default())
    }
}

impl From<Samples> for Record {
    fn from(samples: Samples) -> Self {
        Self::held(samples)
    }
}

impl Record {
    /// Samples that stay in memory.
    pub fn held(samples: Samples) -> Self {
        Self::shared(Arc::new(samples))
    }

    fn shared(samples: Arc<Samples>) -> Self {
        Self {
            len: samples.len(),
            inputs: samples.inputs.iter().map(Track::without_values).collect(),
            kept: Kept::Held(samples),
            change: None,
            left_out: Arc::default(),
            whole: OnceLock::new(),
        }
    }

    /// Samples in a temporary file.
    pub(crate) fn spilled(columns: Spilled) -> Self {
        Self {
            len: columns.table.len(),
            inputs: columns.inputs.clone(),
            kept: Kept::Spilled {
                starts: Starts::at(columns.first_time),
                inputs: columns.inputs.clone(),
                columns: Arc::new(columns),
            },
            change: None,
            left_out: Arc::default(),
            whole: OnceLock::new(),
        }
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Where each input of the model comes from. Constants and streams are whole; the columns of
    /// captured inputs are empty, for they may be longer than memory.
    pub fn inputs(&self) -> &[Track] {
        &self.inputs
    }

    /// Time of the first sample (s).
    pub fn first_time(&self) -> Option<f64> {
        match &self.kept {
            Kept::Held(samples) => samples.time.first().copied(),
            Kept::Spilled { columns, .. } => (self.len > 0).then_some(columns.first_time),
        }
    }

    /// Whether the data have no times.
    pub fn is_untimed(&self) -> bool {
        match &self.kept {
            Kept::Held(samples) => samples.is_untimed,
            Kept::Spilled { columns, .. } => columns.is_untimed,
        }
    }

    /// A clock at the first and at the last sample; `None` where there is none.
    pub fn ends(&self, clock: fn(&Samples) -> &[f64]) -> Option<[f64; 2]> {
        let mut scratch = Samples::default();
        let mut at = |sample: usize| {
            let one = self.stretch(sample..sample + 1, &mut scratch);
            clock(one.samples)[one.range()].first().copied()
        };
        Some([at(0)?, at(self.len.checked_sub(1)?)?])
    }

    /// Whether the samples are in a temporary file.
    pub fn is_spilled(&self) -> bool {
        matches!(self.kept, Kept::Spilled { .. })
    }

    /// Why samples could not be read back, if that happened.
    pub fn fault(&self) -> Option<&str> {
        match &self.kept {
            Kept::Held(_) => None,
            Kept::Spilled { columns, .. } => columns.fault.get().map(String::as_str),
        }
    }

    /// Some of the samples; `scratch` may be used for them. What of the range goes beyond the last
    /// sample is left out.
    pub fn stretch<'a>(&'a self, range: Range<usize>, scratch: &'a mut Samples) -> Stretch<'a> {
        let range = range.start.min(self.len)..range.end.min(self.len);
        let (first, len) = (range.start, range.len());
        match &self.kept {
            Kept::Held(samples) if self.is_as_recorded(&range) => {
                return Stretch { samples, start: first, first, len };
            }
            _ => self.copy(range, scratch),
        }
        Stretch { samples: scratch, start: 0, first, len }
    }

    fn is_as_recorded(&self, range: &Range<usize>) -> bool {
        self.change.is_none() && self.left_out_of(range).next().is_none()
    }

    /// The readings left out of a range, clipped to it.
    fn left_out_of(&self, range: &Range<usize>) -> impl Iterator<Item = LeftOut> {
        let (from, to) = (range.start, range.end);
        let blocks = from / BLOCK..to.div_ceil(BLOCK).max(from / BLOCK);
        let all = self.left_out.range(blocks).flat_map(|(_, all)| all);
        all.map(move |(out, columns)| (out.start.max(from)..out.end.min(to), columns.clone()))
            .filter(|(out, _)| !out.is_empty())
    }

    fn copy(&self, range: Range<usize>, into: &mut Samples) {
        match &self.kept {
            Kept::Held(samples) => copy(samples, range.clone(), into),
            Kept::Spilled { columns, starts, inputs } => {
                columns.fill(range.clone(), *starts, inputs, into);
            }
        }
        if let Some(change) = self.change {
            change.apply(into);
        }
        for (out, columns) in self.left_out_of(&range) {
            for column in &mut into.readings[columns] {
                column[out.start - range.start..out.end - range.start].fill(f64::NAN);
            }
        }
    }

    /// Ranges of at most `step` samples that make up the run.
    pub fn ranges(&self, step: usize) -> impl ExactSizeIterator<Item = Range<usize>> + use<> {
        let (len, step) = (self.len, step.max(1));
        (0..len.div_ceil(step)).map(move |k| k * step..len.min((k + 1) * step))
    }

    /// Shows the whole run, a stretch at a time.
    pub fn walk(&self, mut visit: impl FnMut(Stretch<'_>)) {
        let visit = |stretch: Stretch<'_>| {
            visit(stretch);
            Ok::<_, std::convert::Infallible>(())
        };
        let Ok(()) = self.try_walk(visit);
    }

    /// The same for what may fail.
    ///
    /// # Errors
    /// The first that `visit` gives; nothing more is shown then.
    pub fn try_walk<E>(
        &self,
        mut visit: impl FnMut(Stretch<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut scratch = Samples::default();
        self.ranges(BLOCK).try_for_each(|range| visit(self.stretch(range, &mut scratch)))
    }

    /// Time of the last sample (s).
    pub fn last_time(&self) -> Option<f64> {
        let mut scratch = Samples::default();
        let last = self.stretch(self.len.saturating_sub(1)..self.len, &mut scratch);
        last.each().next().map(|sample| sample.time())
    }

    /// One sample, by its number.
    pub fn sample<'a>(&'a self, number: usize, scratch: &'a mut Samples) -> Sample<'a> {
        let stretch = self.stretch(number..number + 1, scratch);
        Sample { samples: stretch.samples, at: stretch.start, number }
    }

    /// All values of a reading column; NaN where one is missing.
    pub fn column(&self, column: usize) -> Vec<f64> {
        let mut all = Vec::with_capacity(self.len);
        self.walk(|stretch| {
            all.extend_from_slice(&stretch.samples.readings[column][stretch.range()]);
        });
        all
    }

    /// Row of the data file (line number, from 1) of a sample.
    pub fn row(&self, sample: usize) -> usize {
        self.sample(sample, &mut Samples::default()).row()
    }

    /// The same of some samples, in ascending order.
    pub fn rows(&self, samples: &[usize]) -> Vec<usize> {
        let mut scratch = Samples::default();
        let mut rows = Vec::with_capacity(samples.len());
        for group in samples.chunk_by(|a, b| a / BLOCK == b / BLOCK) {
            let (first, last) = (group[0], group[group.len() - 1]);
            let stretch = self.stretch(first..last + 1, &mut scratch);
            let at = |sample: &usize| stretch.start + sample - first;
            rows.extend(group.iter().map(|sample| {
                Sample { samples: stretch.samples, at: at(sample), number: *sample }.row()
            }));
        }
        rows
    }

    /// Ranges of at most `step` samples, spread evenly over the run, that hold about this share of
    /// it: for those whom a part of a long run tells enough.
    pub fn share(&self, share: f64, step: usize) -> impl Iterator<Item = Range<usize>> + use<> {
        let due = move |number: usize| (number as f64 * share.min(1.0)).ceil() as usize;
        self.ranges(step)
            .enumerate()
            .filter(move |(number, _)| due(number + 1) > due(*number))
            .map(|(_, range)| range)
    }
}

fn copy(from: &Samples, range: Range<usize>, into: &mut Samples) {
    fn part<T: Copy>(to: &mut Vec<T>, from: &[T], range: Range<usize>) {
        to.clear();
        to.extend_from_slice(from.get(range).unwrap_or(&[]));
    }
    shape(into, &from.inputs, from.readings.len());
    for (to, from) in into.columns_mut().zip(from.columns()) {
        part(to, from, range.clone());
    }
    part(&mut into.elapsed_time, &from.elapsed_time, range.clone());
    part(&mut into.run_time, &from.run_time, range.clone());
    part(&mut into.setup_time, &from.setup_time, range.clone());
    part(&mut into.uniform_time, &from.uniform_time, range.clone());
    part(&mut into.jump_time, &from.jump_time, range.clone());
    into.is_untimed = from.is_untimed;
    into.jump_ends = from.jump_ends;
    part(&mut into.rows, &from.rows, range);
}
