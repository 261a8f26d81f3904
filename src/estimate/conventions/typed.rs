//! The fit that the line to type makes: of all readings, outliers too, from the start that a campaign
//! states or that is found for it, with inputs as uncertain as they are stated.
//!
//! The search leaves outliers out, begins from several attitudes and stretches uncertainties with
//! the numbers. What it finds may be out of reach for whoever types the line, or fit but for what was
//! left out: lengths of another scale fit a rig that hardly accelerates, but for where it does.

use crate::engine::Problem;
use crate::estimate::batch::Options;
use crate::estimate::minima::improved;
use crate::estimate::start::start;

use super::looked::Looked;
use super::sequence::Sequence;
use super::streams::smooth_as_stated;
use super::trimmed::trimmed_fit;
use super::{ALIKE, BETTER, GOOD};

/// How well a problem fits with a line typed.
#[derive(Clone, Copy)]
pub(super) struct Typed {
    /// Variance factor of all readings.
    pub(super) of_all: f64,
    /// Without outliers.
    pub(super) variance_factor: f64,
    /// Whether the fit of all readings settled.
    pub(super) is_settled: bool,
}

impl Typed {
    /// A fit that does not come to pass.
    const NONE: Self =
        Self { of_all: f64::INFINITY, variance_factor: f64::INFINITY, is_settled: false };

    /// Of numbers as they were read with all of a sequence set right, from the start that is stated.
    pub(super) fn of(first: &Problem, sequence: &Sequence<'_>) -> Self {
        as_typed(first, sequence).and_then(Self::fit).unwrap_or(Self::NONE)
    }

    /// The same from the start that is looked for where the stated one fits badly.
    pub(super) fn improved(first: &Problem, sequence: &Sequence<'_>) -> Self {
        let problem = as_typed(first, sequence).map(|problem| improved(problem).0);
        problem.and_then(Self::fit).unwrap_or(Self::NONE)
    }

    fn fit(mut problem: Problem) -> Option<Self> {
        let iterations = Options::default().max_iterations;
        let mut found = trimmed_fit(&problem, start(&problem).0, iterations)?;
        if found.whole.is_settled && problem.count_smoothing(&found.whole.point) {
            found = trimmed_fit(&problem, found.whole.point, iterations)?;
        }
        Some(Self {
            of_all: found.whole.variance_factor,
            variance_factor: found.fit.variance_factor,
            is_settled: found.whole.is_settled,
        })
    }

    /// Whether it fits about as well as a search did.
    pub(super) fn reaches(&self, looked: &Looked) -> bool {
        self.variance_factor <= GOOD.max(ALIKE * looked.variance_factor)
    }

    /// Whether it fits far better than the numbers as they stand.
    pub(super) fn is_better(&self, stands: &Looked) -> bool {
        is_far_better(stands.variance_factor, self.variance_factor, self.variance_factor)
    }
}

/// Whether a fit is far better than another one; `scored` is its variance factor, relative to how far
/// readings are stretched.
pub(super) fn is_far_better(stands: f64, scored: f64, variance_factor: f64) -> bool {
    let times = stands / scored;
    times > BETTER[0] || (times > BETTER[1] && variance_factor < GOOD)
}

/// The numbers set right, with uncertainties and streams as they are stated.
fn as_typed(first: &Problem, sequence: &Sequence<'_>) -> Option<Problem> {
    let mut problem = sequence.applied(first)?;
    smooth_as_stated(&mut problem, first);
    for (part, own) in problem.parts.iter_mut().zip(&first.parts) {
        part.random_sigma.clone_from(&own.random_sigma);
        part.smoothing_sigma.clear();
    }
    Some(problem)
}
