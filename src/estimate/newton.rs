//! Each reading's own delay: safeguarded Newton from the reference time.
//!
//! A measurand is a function `m(t)` of its delay alone once the transformation is known (the seed,
//! section 3.2.1); `m(t) = reading` is solved for `t`, starting at the reference time, `t = 0`. The
//! delay is an implicit function of every parameter: `dt/dθ = -(∂m/∂θ) / m'`, so
//! `u² = (u_m² + J Σ Jᵀ) / m'²` with the full covariance Σ of the parameters (the seed, section
//! 3.4, has the reading's part alone). Where `m'` vanishes the reading is *blind*. The lanes
//! compute 192 readings at a time.

use std::convert::Infallible;

use nalgebra::{DMatrix, DVector};

use crate::engine::point::Point;
use crate::engine::problem::Problem;

mod careful;
mod quick;
mod runs;
mod solved;
mod solver;
mod uncertainty;

pub use runs::each_delay;
pub use solved::Solved;

/// A reading whose uncertainty exceeds the smallest of its run and measurand by this factor is
/// blind.
pub const BLIND_RATIO: f64 = 10.0;

/// Whether a reading gave its delay.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum State {
    /// Solved.
    Solved,
    /// The measurand hardly changes with time here.
    Blind,
    /// Newton's iteration found no delay that explains the reading.
    Failed,
}

impl State {
    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Solved => "solved",
            Self::Blind => "blind",
            Self::Failed => "failed",
        }
    }
}

/// The delay of one reading.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadingDelay {
    /// Run of the campaign.
    pub run: usize,
    /// Sample of the run.
    pub sample: usize,
    /// Measurand.
    pub measurand: usize,
    /// Row of the data file (line number, from 1).
    pub row: usize,
    /// Reference time (s).
    pub time: f64,
    /// What came of it.
    pub state: State,
    /// Delay (s); NaN unless solved, as are slope and uncertainties.
    pub delay: f64,
    /// Derivative of the measurand with respect to its delay (unit/s).
    pub slope: f64,
    /// Random part of the standard uncertainty (s): the reading and what is random in its sample.
    pub random: f64,
    /// The same with the slope at the reference time, which the reading's own error does not touch:
    /// what decides on blindness and weights.
    pub random_at_reference: f64,
    /// Common part (s): the parameters' covariance.
    pub common: f64,
    /// Newton steps.
    pub steps: u32,
}

impl ReadingDelay {
    /// Combined standard uncertainty (s).
    pub fn standard_uncertainty(&self) -> f64 {
        self.random.hypot(self.common)
    }

    /// Expanded uncertainty (s), k = 2.
    pub fn expanded_uncertainty(&self) -> f64 {
        2.0 * self.standard_uncertainty()
    }
}

/// The delays of one measurand in one run.
#[derive(Clone, Debug)]
pub struct RunDelays {
    /// One for each reading.
    pub readings: Vec<ReadingDelay>,
    /// `Σ w dt/dθ` of the solved ones over the columns the run touches, with the weights
    /// `w = random_at_reference⁻²`.
    pub weighted_sensitivity: DVector<f64>,
}

/// What the delays of a run are computed from.
#[derive(Clone, Copy, Debug)]
pub struct Given<'a> {
    /// The campaigns.
    pub problem: &'a Problem,
    /// Parameter values.
    pub point: &'a Point,
    /// Covariance of all columns at that point.
    pub covariance: &'a DMatrix<f64>,
    /// Farthest delay looked for (s).
    pub range: f64,
}

/// The delay of every reading of one measurand in one run, all in memory; none of a rotation, which
/// has no single delay.
pub fn delays_of_run(given: &Given<'_>, part: usize, run: usize, measurand: usize) -> RunDelays {
    let problem = given.problem;
    let touched = problem.layout.columns.touched_by(problem.run_index(part, run)).len();
    let mut all = RunDelays { readings: Vec::new(), weighted_sensitivity: DVector::zeros(touched) };
    let Ok(()) = each_delay(
        given,
        part,
        &[run],
        measurand,
        |_, found| found,
        |_, found| {
            all.readings.extend(found.each());
            all.weighted_sensitivity += &found.weighted_sensitivity;
            Ok::<_, Infallible>(())
        },
    );
    all
}
