//! The samples of a run, or of a stretch of it: times, inputs, readings, clocks.

use crate::campaign::signal::Track;

/// The samples of a run, or of a stretch of it. All in SI; a reading that is not there is NaN.
#[derive(Clone, Debug, Default)]
pub struct Samples {
    /// Reference time (s), one a sample.
    pub time: Vec<f64>,
    /// Time since the first sample of all campaigns that are used together (s): what formulas call
    /// `time`.
    pub elapsed_time: Vec<f64>,
    /// Time since the start of the run (s).
    pub run_time: Vec<f64>,
    /// Time since the start of the setup (s).
    pub setup_time: Vec<f64>,
    /// Straight line through `run_time` over the sample number (s).
    pub uniform_time: Vec<f64>,
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
        self.rows.append(&mut more.rows);
    }

    /// Bytes of memory for as many samples, all clocks counted.
    pub(crate) fn bytes(&self) -> u64 {
        8 * (self.columns().count() as u64 + 5) * self.len() as u64
    }

    /// Fills `run_time`, `uniform_time` and, for a setup and campaign that begin with this run,
    /// `setup_time` and `elapsed_time` from `time`.
    pub(crate) fn set_clocks(&mut self) {
        let first = self.time.first().copied().unwrap_or(0.0);
        self.run_time = self.time.iter().map(|time| time - first).collect();
        self.setup_time.clone_from(&self.run_time);
        self.elapsed_time.clone_from(&self.run_time);
        let times = &self.run_time;
        let line = Line::through(times.len(), |visit| times.iter().for_each(|time| visit(*time)));
        self.uniform_time = (0..times.len()).map(|sample| line.at(sample)).collect();
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

/// A straight line over the sample number.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Line {
    middle: f64,
    mean: f64,
    slope: f64,
}

impl Line {
    /// The straight line through `len` values, which `each` shows in their order, twice.
    pub(crate) fn through(len: usize, mut each: impl FnMut(&mut dyn FnMut(f64))) -> Self {
        let middle = (len as f64 - 1.0) / 2.0;
        let mut sum = 0.0;
        each(&mut |value| sum += value);
        let mean = sum / len as f64;
        let (mut x, mut along, mut square) = (-middle, 0.0, 0.0);
        each(&mut |value| {
            along += x * (value - mean);
            square += x * x;
            x += 1.0;
        });
        let slope = if square > 0.0 { along / square } else { 0.0 };
        Self { middle, mean, slope }
    }

    /// Its value at a sample.
    pub(crate) fn at(&self, sample: usize) -> f64 {
        self.mean + self.slope * (sample as f64 - self.middle)
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
