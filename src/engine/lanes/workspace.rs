//! The memory of one thread: a chunk's values, filled from the samples of a run.

use std::ops::Range;

use crate::campaign::Track;
use crate::campaign::record::Stretch;
use crate::campaign::run::Samples;
use crate::engine::lanes::arithmetic::{Aligned, Arithmetic, LANES, Lanes};
use crate::engine::lanes::compile::Code;
use crate::engine::lanes::dispatch::{InstructionSet, Simd, Task};
use crate::engine::lanes::execute::Execution;
use crate::engine::lanes::instruction::{Column, MOST_TOGETHER};
use crate::engine::lanes::math::map;
use crate::engine::pointwise::Leaves;
use crate::graph::Clock;

/// Some samples of a run that follow each other.
#[derive(Clone, Copy, Debug)]
pub struct Chunk<'a> {
    /// Columns that hold them.
    pub samples: &'a Samples,
    /// First reading column of each measurand.
    pub columns: &'a [usize],
    /// Index of the first of them within the columns.
    pub start: usize,
    /// Number of that sample in its run.
    pub first: usize,
    /// How many, at most [`LANES`]; the last one stands in for those that are missing.
    pub len: usize,
}

impl<'a> Chunk<'a> {
    /// The chunks of a stretch.
    pub fn all(stretch: Stretch<'a>, columns: &'a [usize]) -> impl Iterator<Item = Self> {
        (0..stretch.len).step_by(LANES).map(move |offset| Self {
            samples: stretch.samples,
            columns,
            start: stretch.start + offset,
            first: stretch.first + offset,
            len: LANES.min(stretch.len - offset),
        })
    }

    /// The inputs, as [`Workspace::compute`] wants them.
    pub fn inputs(&self) -> &'a [Track] {
        &self.samples.inputs
    }

    /// Its samples as a stretch of their run.
    pub fn stretch(&self) -> Stretch<'a> {
        let Self { samples, start, first, len, .. } = *self;
        Stretch { samples, start, first, len }
    }

    /// Puts 1 where a reading column has a value and 0 elsewhere; how many there are.
    pub fn mark_readings(&self, column: usize, set: InstructionSet, marks: &mut Lanes) -> usize {
        set.run(Marking { readings: self.readings(column), marks })
    }

    /// A reading column's values.
    pub fn readings(&self, column: usize) -> &'a [f64] {
        &self.samples.readings[column][self.start..self.start + self.len]
    }
}

/// Marks where readings are there; how many are.
struct Marking<'a> {
    readings: &'a [f64],
    marks: &'a mut Lanes,
}

impl Task for Marking<'_> {
    type Output = usize;

    #[inline(always)]
    fn run<A: Arithmetic, S: Simd>(self, _: S) -> usize {
        let Self { readings, marks } = self;
        let mut there = 0;
        for (mark, reading) in marks.iter_mut().zip(readings) {
            let is_there = !reading.is_nan();
            *mark = if is_there { 1.0 } else { 0.0 };
            there += u64::from(is_there);
        }
        marks[readings.len()..].fill(0.0);
        there as usize
    }
}

/// Copies some samples of a column; the last stands in for those that are missing.
struct Copying<'a> {
    values: &'a [f64],
    out: &'a mut Lanes,
    /// 0 where there is no number.
    is_reading: bool,
}

impl Task for Copying<'_> {
    type Output = ();

    #[inline(always)]
    fn run<A: Arithmetic, S: Simd>(self, _: S) {
        let Self { values, out, is_reading } = self;
        let number = |value: f64| if value.is_nan() { 0.0 } else { value };
        match <&Lanes>::try_from(values) {
            Ok(values) if is_reading => map(values, out, number),
            _ => {
                let last = values.last().copied().unwrap_or(0.0);
                let all = values.iter().chain(std::iter::repeat(&last));
                for (out, value) in out.iter_mut().zip(all) {
                    *out = if is_reading { number(*value) } else { *value };
                }
            }
        }
    }
}

/// A chunk's values for one program. Keep it between chunks and nothing is allocated.
#[expect(clippy::vec_box, reason = "steps put results in place by exchanging pointers")]
#[derive(Debug)]
pub struct Workspace {
    slots: Vec<Box<Aligned>>,
    spare: [Box<Aligned>; MOST_TOGETHER],
    stills: Vec<f64>,
    scratch: Vec<f64>,
    set: InstructionSet,
    /// The group that was computed last: its outputs are there, those of others may be overwritten.
    group: usize,
}

impl Workspace {
    /// Memory for a program.
    pub fn new(code: &Code, set: InstructionSet) -> Self {
        let lanes = Box::<Aligned>::default;
        Self {
            slots: (0..code.slots).map(|_| lanes()).collect(),
            spare: std::array::from_fn(|_| lanes()),
            stills: Vec::new(),
            scratch: Vec::new(),
            set,
            group: 0,
        }
    }

    /// Computes what stands still: to be done once for a run and a point.
    pub fn hold_still(&mut self, code: &Code, leaves: &impl Leaves<f64>) {
        self.stills.clear();
        self.stills.extend_from_slice(code.stills.evaluate(leaves, &mut self.scratch));
    }

    /// Fills the columns from a chunk's samples. `given` are the values that the caller supplies;
    /// `complete` says that it is known to have every reading in every lane.
    pub fn load(&mut self, code: &Code, chunk: &Chunk<'_>, given: &[Lanes], complete: bool) {
        let samples = chunk.samples;
        let stretch = chunk.start..chunk.start + chunk.len;
        for (column, slot) in code.columns.iter().zip(&mut self.slots) {
            let values: &[f64] = match *column {
                Column::Clock(Clock::Time) => &samples.elapsed_time[stretch.clone()],
                Column::Clock(Clock::RunTime) => &samples.run_time[stretch.clone()],
                Column::Clock(Clock::SetupTime) => &samples.setup_time[stretch.clone()],
                Column::Clock(Clock::UniformTime) => &samples.uniform_time[stretch.clone()],
                Column::Clock(Clock::JumpTime) if samples.jump_time.is_empty() => {
                    slot.fill(0.0);
                    continue;
                }
                Column::Clock(Clock::JumpTime) => &samples.jump_time[stretch.clone()],
                Column::Clock(Clock::FirstJumpTime) => {
                    slot.fill(samples.jump_ends[0]);
                    continue;
                }
                Column::Clock(Clock::LastJumpTime) => {
                    slot.fill(samples.jump_ends[1]);
                    continue;
                }
                Column::Clock(Clock::Index) => {
                    for (lane, value) in slot.iter_mut().enumerate() {
                        *value = (chunk.first + lane.min(chunk.len - 1)) as f64;
                    }
                    continue;
                }
                Column::Input(input, order) => {
                    match recorded(&samples.inputs[input as usize], order) {
                        Ok(column) => &column[stretch.clone()],
                        Err(value) => {
                            // No acceleration is read of a track that has none.
                            if order < 2 {
                                slot.fill(value);
                            }
                            continue;
                        }
                    }
                }
                Column::Reading(measurand, component) => {
                    let first = chunk.columns[measurand as usize];
                    &samples.readings[first + component as usize][stretch.clone()]
                }
                Column::SignalTime => {
                    if !samples.inputs.iter().any(|track| matches!(track, Track::Logged(_))) {
                        continue;
                    }
                    &samples.time[stretch.clone()]
                }
                Column::Given(index) => {
                    ***slot = given[index as usize];
                    continue;
                }
                Column::One => {
                    slot.fill(1.0);
                    continue;
                }
            };
            let is_reading = matches!(column, Column::Reading(..)) && !complete;
            match <&Lanes>::try_from(values) {
                Ok(values) if !is_reading => ***slot = *values,
                _ => self.set.run(Copying { values, out: slot, is_reading }),
            }
        }
    }

    /// The columns that were filled, to be computed with later in another order.
    pub fn loaded(&self, code: &Code) -> impl Iterator<Item = &Lanes> {
        self.slots[..code.columns.len()].iter().map(|slot| &***slot)
    }

    /// Fills the columns with such as [`Workspace::loaded`] showed.
    pub fn reload(&mut self, columns: &[Lanes]) {
        for (slot, column) in self.slots.iter_mut().zip(columns) {
            ***slot = *column;
        }
    }

    /// Changes a value that the caller supplies.
    pub fn give(&mut self, code: &Code, index: u32, values: &Lanes) {
        if let Some(slot) = code.columns.iter().position(|column| *column == Column::Given(index)) {
            **self.slots[slot] = *values;
        }
    }

    /// Computes one group of outputs for the columns that were filled; those before it in order
    /// must have been computed. `inputs` are those of the run.
    pub fn compute(&mut self, code: &Code, group: usize, inputs: &[Track]) {
        self.group = group;
        let start = if group == 0 { 0 } else { code.groups[group - 1].end };
        let mut execution = Execution {
            set: self.set,
            products: &code.products,
            slots: &mut self.slots,
            spare: &mut self.spare,
            stills: &self.stills,
            tracks: inputs,
        };
        execution.compute(&code.instructions[start..code.groups[group].end]);
    }

    /// Some outputs of a group that was just computed.
    pub fn lanes(&self, code: &Code, group: usize, outputs: Range<usize>) -> Vec<&Lanes> {
        debug_assert_eq!(group, self.group, "another group was computed since");
        let slots = &code.groups[group].outputs[outputs];
        slots.iter().map(|slot| &**self.slots[*slot as usize]).collect()
    }

    /// All outputs of a group that was just computed.
    pub fn outputs(&self, code: &Code, group: usize) -> Vec<&Lanes> {
        self.lanes(code, group, 0..code.groups[group].outputs.len())
    }

    /// Puts zero into the lanes of some outputs where `weight` is zero, whatever was there.
    pub fn silence(&mut self, code: &Code, group: usize, outputs: Range<usize>, weight: &Lanes) {
        let outputs = &code.groups[group].outputs[outputs];
        self.set.run(Silencing { slots: &mut self.slots, outputs, weight });
    }
}

/// Puts zero where the weight is zero.
#[expect(clippy::vec_box, reason = "the slots are those of a workspace")]
struct Silencing<'a> {
    slots: &'a mut Vec<Box<Aligned>>,
    outputs: &'a [u32],
    weight: &'a Lanes,
}

impl Task for Silencing<'_> {
    type Output = ();

    #[inline(always)]
    fn run<A: Arithmetic, S: Simd>(self, _: S) {
        for slot in self.outputs {
            for (value, weight) in self.slots[*slot as usize].iter_mut().zip(self.weight) {
                *value = if *weight == 0.0 { 0.0 } else { *value };
            }
        }
    }
}

/// A recorded column of an input, or the number that stands for it all through the run.
fn recorded(track: &Track, order: u8) -> Result<&[f64], f64> {
    match track {
        Track::Captured { value, rate, acceleration } => {
            let column = match order {
                0 => Some(value),
                1 => rate.as_ref(),
                _ => acceleration.as_ref(),
            };
            column.map(Vec::as_slice).ok_or(0.0)
        }
        Track::Constant(value) => Err(if order == 0 { *value } else { 0.0 }),
        Track::Absent => Err(f64::NAN),
        // Its curve is evaluated where it is needed.
        Track::Logged(_) => Err(0.0),
    }
}
