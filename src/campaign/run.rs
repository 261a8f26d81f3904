//! One run: its samples with times, inputs and readings, ready for an engine.

use crate::campaign::signal::Track;

/// What a run is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Role {
    /// Slow or static: fixes the transformation.
    Reference,
    /// In motion.
    Kinematic,
}

/// One run of a campaign.
#[derive(Clone, Debug)]
pub struct Run {
    /// Its name, unique in the campaign.
    pub name: String,
    /// Index of its setup in [`crate::campaign::file::Campaign::setups`].
    pub setup: usize,
    /// Reference or kinematic.
    pub role: Role,
    /// What was recorded.
    pub samples: Samples,
}

/// The samples of a run. All in SI; a reading that is not there is NaN.
#[derive(Clone, Debug, Default)]
pub struct Samples {
    /// Reference time (s), one a sample.
    pub time: Vec<f64>,
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
}
