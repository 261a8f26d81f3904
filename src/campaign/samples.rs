//! The samples of a run, or of a stretch of it: times, inputs, readings, clocks.

use crate::campaign::signal::Track;
use crate::campaign::uniform::Uniform;

/// The samples of a run, or of a stretch of it. All in SI; a reading that is not there is NaN.
#[derive(Clone, Debug, Default)]
pub struct Samples {
    /// Reference time (s), one a sample; all 0 where the data have no times.
    pub time: Vec<f64>,
    /// Whether the data have no times.
    pub is_untimed: bool,
    /// Time since the first sample of all campaigns that are used together (s): what formulas call
    /// `time`.
    pub elapsed_time: Vec<f64>,
    /// Time since the start of the run (s).
    pub run_time: Vec<f64>,
    /// Time since the start of the setup (s).
    pub setup_time: Vec<f64>,
    /// Straight line through `run_time` over the sample number, with the jumps of the stamps (s).
    pub uniform_time: Vec<f64>,
    /// How far the stamps have jumped (s), see `uniform`; empty where they do not jump.
    pub jump_time: Vec<f64>,
    /// `jump_time` at the first sample of the run and at the last (s).
    pub jump_ends: [f64; 2],
    /// One for each input of the model, in its order.
    pub inputs: Vec<Track>,
    /// One column for each component of each measurand of the model, in their order (a rotation has
    /// four: w, x, y, z); NaN where missing.
    pub readings: Vec<Vec<f64>>,
    /// Row of the data file (line number, from 1) of each sample.
    pub rows: Vec<usize>,
}

impl Samples {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }

    /// What the noise of a sample is correlated over: its time (s), or its row of the data file where
    /// there are no times.
    pub fn order_of(&self, at: usize) -> f64 {
        if self.is_untimed { self.rows[at] as f64 } else { self.time[at] }
    }

    /// Columns of times, captured inputs and readings, in this order.
    pub(crate) fn columns(&self) -> impl Iterator<Item = &[f64]> {
        let captured = self.inputs.iter().flat_map(Track::columns);
        std::iter::once(&self.time).chain(captured).chain(&self.readings).map(Vec::as_slice)
    }

    /// The same, to be changed.
    pub(crate) fn columns_mut(&mut self) -> impl Iterator<Item = &mut Vec<f64>> {
        let captured = self.inputs.iter_mut().flat_map(Track::columns_mut);
        std::iter::once(&mut self.time).chain(captured).chain(&mut self.readings)
    }

    /// Puts more samples of the same run behind these.
    pub(crate) fn append(&mut self, mut more: Self) {
        if self.is_empty() {
            *self = more;
            return;
        }
        for (own, more) in self.columns_mut().zip(more.columns_mut()) {
            own.append(more);
        }
        self.elapsed_time.append(&mut more.elapsed_time);
        self.run_time.append(&mut more.run_time);
        self.setup_time.append(&mut more.setup_time);
        self.uniform_time.append(&mut more.uniform_time);
        self.jump_time.append(&mut more.jump_time);
        self.rows.append(&mut more.rows);
    }

    /// Bytes of memory for as many samples, all clocks counted.
    pub(crate) fn bytes(&self) -> u64 {
        8 * (self.columns().count() as u64 + 5) * self.len() as u64
    }

    /// Fills `run_time`, `uniform_time`, `jump_time` with its ends and, for a setup and campaign that
    /// begin with this run, `setup_time` and `elapsed_time` from `time`.
    pub(crate) fn set_clocks(&mut self) {
        let first = self.time.first().copied().unwrap_or(0.0);
        self.run_time = self.time.iter().map(|time| time - first).collect();
        self.setup_time.clone_from(&self.run_time);
        self.elapsed_time.clone_from(&self.run_time);
        let times = &self.run_time;
        let each = |visit: &mut dyn FnMut(f64)| times.iter().for_each(|time| visit(*time));
        let uniform = Uniform::through(times.len(), each);
        self.uniform_time = (0..times.len()).map(|sample| uniform.at(sample)).collect();
        self.jump_time = uniform.jumps_at(0..times.len());
        self.jump_ends = uniform.jump_ends();
    }
}

/// From when a run's clocks count (s).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Starts {
    /// The first sample of its setup.
    pub(crate) setup: f64,
    /// The first sample of all.
    pub(crate) all: f64,
}

impl Starts {
    pub(crate) fn at(time: f64) -> Self {
        Self { setup: time, all: time }
    }
}

/// Gives samples the columns of others; what is in those of the same shape may stay.
pub(crate) fn shape(samples: &mut Samples, inputs: &[Track], readings: usize) {
    samples.inputs.resize_with(inputs.len(), || Track::Absent);
    for (to, from) in samples.inputs.iter_mut().zip(inputs) {
        if !to.has_columns_of(from) {
            *to = from.without_values();
        }
    }
    samples.readings.resize_with(readings, Vec::new);
}
