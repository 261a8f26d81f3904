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

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

pub use crate::campaign::spill::BLOCK;

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

/// A run looked at otherwise than it was recorded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// No reading is there.
    WithoutReadings,
    /// The same positions passed at this many times the rate; negative is the other way round.
    Retimed(f64),
}

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

    /// Whether all samples are in memory: from the beginning, or since [`Record::whole`] read them
    /// back.
    pub fn is_in_memory(&self) -> bool {
        !self.is_spilled() || self.whole.get().is_some()
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

    /// Leaves readings out: those of such samples in such reading columns are missing from then on.
    /// What is kept stays where it is.
    pub fn leave_out(&mut self, readings: impl IntoIterator<Item = (Range<usize>, Range<usize>)>) {
        for (samples, columns) in readings.into_iter().filter(|(samples, _)| !samples.is_empty()) {
            let all = Arc::make_mut(&mut self.left_out);
            for block in samples.start / BLOCK..samples.end.div_ceil(BLOCK) {
                let of = samples.start.max(block * BLOCK)..samples.end.min((block + 1) * BLOCK);
                all.entry(block).or_default().push((of, columns.clone()));
            }
            self.whole = OnceLock::new();
        }
    }

    /// The same run, looked at otherwise. Only the last change counts.
    pub fn changed(&self, change: Change) -> Self {
        let inputs = match (change, &self.kept) {
            (Change::WithoutReadings, _) => self.inputs.clone(),
            (Change::Retimed(_), _) => {
                let moving = |track: &Track| match track.moves() {
                    true => captured_with_rates(),
                    false => track.clone(),
                };
                self.inputs.iter().map(moving).collect()
            }
        };
        Self { inputs, change: Some(change), whole: OnceLock::new(), ..self.clone() }
    }

    /// Puts other streams in the place of those of some inputs. What is kept stays where it is.
    pub(crate) fn replace_streams(&mut self, streams: Vec<(usize, Track)>) {
        let put = |inputs: &mut [Track]| {
            streams.iter().for_each(|(input, track)| inputs[*input] = track.clone());
        };
        put(&mut self.inputs);
        match &mut self.kept {
            Kept::Held(samples) => put(&mut Arc::make_mut(samples).inputs),
            Kept::Spilled { inputs, .. } => put(inputs),
        }
        self.whole = OnceLock::new();
    }

    /// Lets the time since the start of the setup count from `start` (s).
    pub(crate) fn set_setup_start(&mut self, start: f64) {
        match &mut self.kept {
            Kept::Held(samples) => {
                let samples = Arc::make_mut(samples);
                samples.setup_time = samples.time.iter().map(|time| time - start).collect();
            }
            Kept::Spilled { starts, .. } => starts.setup = start,
        }
    }

    /// Lets elapsed time count from `start` (s).
    pub(crate) fn set_start(&mut self, start: f64) {
        match &mut self.kept {
            Kept::Held(samples) => {
                let samples = Arc::make_mut(samples);
                samples.elapsed_time = samples.time.iter().map(|time| time - start).collect();
            }
            Kept::Spilled { starts, .. } => starts.all = start,
        }
    }
}

/// An input recorded with its rate and acceleration; columns are empty.
pub(crate) fn captured_with_rates() -> Track {
    Track::Captured { value: Vec::new(), rate: Some(Vec::new()), acceleration: Some(Vec::new()) }
}

impl Change {
    fn apply(self, samples: &mut Samples) {
        match self {
            Self::WithoutReadings => {
                samples.readings.iter_mut().for_each(|column| column.fill(f64::NAN));
            }
            Self::Retimed(factor) => {
                let Samples { time, inputs, .. } = samples;
                for track in inputs.iter_mut().filter(|track| track.moves()) {
                    let at = |order: u8, scale: f64| {
                        let samples = time.iter().enumerate();
                        samples.map(|(i, t)| scale * track.at::<f64>(i, *t, 0.0, order)).collect()
                    };
                    *track = Track::Captured {
                        value: at(0, 1.0),
                        rate: Some(at(1, factor)),
                        acceleration: Some(at(2, factor * factor)),
                    };
                }
            }
        }
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
    into.jump_ends = from.jump_ends;
    part(&mut into.rows, &from.rows, range);
}
