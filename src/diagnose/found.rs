//! What is found beside effects, as data: in the noise, in a few runs, in readings that are left
//! out, and places.
//!
//! How it is found is for [`super::outliers`] and [`super::budget`] to say.

use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;

use crate::engine::gauss_markov::GaussMarkov;
use crate::system::Selected;
use crate::units::Unit;

/// Something found in the noise.
#[derive(Clone, Debug)]
pub struct NoiseEffect {
    /// The effect of the library.
    pub name: String,
    /// As what it is part of the model.
    pub selected: Selected,
    /// The name of its parameter.
    pub parameter: String,
    /// Unit in which the parameter is declared.
    pub unit: Unit,
    /// Its size (SI).
    pub value: f64,
    /// Standard uncertainty.
    pub sigma: f64,
    /// Logarithm of the probability of such a finding by chance.
    pub ln_p: f64,
}

/// By how much a measurand scatters otherwise than stated.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// The measurand.
    pub measurand: String,
    /// Its campaign, where there are several.
    pub of: Option<String>,
    /// The run, where the noise of that one differs from the others'.
    pub run: Option<String>,
    /// The factor on the standard uncertainty that is stated.
    pub factor: f64,
}

/// Autocorrelated noise of a measurand.
#[derive(Clone, Debug, PartialEq)]
pub struct AutocorrelatedNoise {
    /// The measurand.
    pub measurand: String,
    /// Its campaign, where there are several.
    pub of: Option<String>,
    /// The processes.
    pub noise: GaussMarkov,
    /// Whether it is correlated over rows, for the data have no times.
    pub is_over_rows: bool,
}

/// A reading that is left out because it is an outlier or a code.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// Name of the run.
    pub run: Arc<str>,
    /// Row of its data file.
    pub row: usize,
    /// The measurand.
    pub measurand: Arc<str>,
    /// How far out it was, in robust standard deviations of its measurand.
    pub deviations: f64,
    /// What stands in its place, if it is no reading.
    pub instead: Option<NoReading>,
}

/// A number that stands in the place of a reading (SI).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoReading {
    /// A code for what was not measured.
    Code(f64),
    /// The limit at which an instrument is saturated.
    Limit(f64),
}

impl NoReading {
    /// The number, if it is a code.
    pub fn code(self) -> Option<f64> {
        if let Self::Code(code) = self { Some(code) } else { None }
    }

    /// The number, if it is a limit.
    pub fn limit(self) -> Option<f64> {
        if let Self::Limit(limit) = self { Some(limit) } else { None }
    }
}

/// A run, or a stretch of it, of which all readings of a measurand are left out.
#[derive(Clone, Debug, PartialEq)]
pub struct Stretch {
    /// Name of the run.
    pub run: String,
    /// The measurand.
    pub measurand: String,
    /// How many readings that are.
    pub readings: usize,
    /// Rows of the data file: first and last.
    pub rows: (usize, usize),
    /// How far out half of them were at least, in robust standard deviations of the measurand.
    pub deviations: f64,
    /// What is wrong with them.
    pub how: Wrong,
}

/// What is wrong with a stretch of readings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrong {
    /// They are far out.
    FarOut,
    /// They repeat the reading before them.
    Repeated,
    /// They stand still but for their noise, while the prediction moves.
    Unresponsive,
}

/// What is left out.
#[derive(Clone, Debug, Default)]
pub struct LeftOut {
    /// Single readings.
    pub readings: Vec<Reading>,
    /// Runs that are wrong as wholes.
    pub runs: Vec<Stretch>,
    /// Stretches of runs that are wrong.
    pub stretches: Vec<Stretch>,
    /// Stretches of lost samples.
    pub lost: Vec<Lost>,
}

impl LeftOut {
    /// Whether it is nothing.
    pub fn is_empty(&self) -> bool {
        let Self { readings, runs, stretches, lost } = self;
        readings.is_empty() && runs.is_empty() && stretches.is_empty() && lost.is_empty()
    }

    /// Adds what is left out later, each reading once.
    pub fn extend(&mut self, later: Self) {
        let at = |one: &Reading| (one.run.clone(), one.measurand.clone(), one.row);
        let known: BTreeSet<_> = self.readings.iter().map(at).collect();
        self.readings.extend(later.readings.into_iter().filter(|one| !known.contains(&at(one))));
        self.runs.extend(later.runs);
        self.stretches.extend(later.stretches);
        self.lost.extend(later.lost);
    }
}

/// A stretch of readings that belong to other moments.
#[derive(Clone, Debug, PartialEq)]
pub struct Lost {
    /// Index of the campaign.
    pub part: usize,
    /// Index of the run.
    pub run: usize,
    /// Name of the run.
    pub name: String,
    /// Its samples.
    pub samples: Range<usize>,
    /// Rows of the data file: first and last.
    pub rows: (usize, usize),
    /// The readings of sample `i` belong to sample `i + periods`.
    pub periods: isize,
    /// The same as a time (s), by the mean interval of the samples.
    pub seconds: f64,
    /// Whether the whole run is so: its clock is off.
    pub is_whole_run: bool,
    /// Logarithm of the probability of such a finding by chance.
    pub ln_p: f64,
}
