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
    /// The same where uncertainties shrink with the readings: by what was set right last, ...
    scored: f64,
    /// ... and by all of it.
    scored_as_read: f64,
    /// Whether a unit that a file states is doubted by what was set right last, or by all of it.
    doubts: [bool; 2],
    /// Whether the fit of all readings settled.
    pub(super) is_settled: bool,
}

impl Typed {
    /// A fit that does not come to pass.
    const NONE: Self = Self {
        of_all: f64::INFINITY,
        variance_factor: f64::INFINITY,
        scored: f64::INFINITY,
        scored_as_read: f64::INFINITY,
        doubts: [false; 2],
        is_settled: false,
    };

    /// Of numbers as they were read with all of a sequence set right, from the start that is stated.
    pub(super) fn of(first: &Problem, sequence: &Sequence<'_>) -> Self {
        as_typed(first, sequence).and_then(|one| Self::fit(one, sequence)).unwrap_or(Self::NONE)
    }

    /// The same from the start that is looked for where the stated one fits badly.
    pub(super) fn improved(first: &Problem, sequence: &Sequence<'_>) -> Self {
        let problem = as_typed(first, sequence).map(|problem| improved(problem).0);
        problem.and_then(|one| Self::fit(one, sequence)).unwrap_or(Self::NONE)
    }

    fn fit(mut problem: Problem, sequence: &Sequence<'_>) -> Option<Self> {
        let iterations = Options::default().max_iterations;
        let mut found = trimmed_fit(&problem, start(&problem).0, iterations)?;
        if found.whole.is_settled && problem.count_smoothing(&found.whole.point) {
            found = trimmed_fit(&problem, found.whole.point, iterations)?;
        }
        Some(Self {
            of_all: found.whole.variance_factor,
            variance_factor: found.fit.variance_factor,
            scored: sequence.score(&found.kept, &found.fit).as_stated.exp(),
            scored_as_read: sequence.score_of_all(&found.kept, &found.fit).as_stated.exp(),
            doubts: [sequence.doubts_a_head(), sequence.doubts_any_head()],
            is_settled: found.whole.is_settled,
        })
    }

    /// Whether it fits about as well as a search did.
    pub(super) fn reaches(&self, looked: &Looked) -> bool {
        self.variance_factor <= GOOD.max(ALIKE * looked.variance_factor)
    }

    /// Whether it fits far better than the numbers as they stand, beside which the last was set right.
    pub(super) fn is_better(&self, stands: &Looked) -> bool {
        is_far_better(stands.variance_factor, self.scored, self.doubts[0])
    }

    /// Whether it fits far better than the numbers as they were read.
    pub(super) fn is_better_than_read(&self, as_read: &Looked) -> bool {
        is_far_better(as_read.variance_factor, self.scored_as_read, self.doubts[1])
    }
}

/// Whether a fit is far better than another one; `scored` is its variance factor, relative to how far
/// readings are stretched: readings that are made 40 times smaller leave residuals 40 times smaller,
/// whatever the model. A unit that a file states is doubted for the larger improvement alone.
pub(super) fn is_far_better(stands: f64, scored: f64, doubts_a_head: bool) -> bool {
    let times = stands / scored;
    times > BETTER[0] || (!doubts_a_head && times > BETTER[1] && scored < GOOD)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_fits_by_its_size_alone_is_not_far_better() {
        assert!(is_far_better(193.0, 0.9, true));
        // A variance factor of 0.03 of readings that are 40 times smaller is one of 48.
        assert!(!is_far_better(193.0, 0.03 * 1600.0, false));
        assert!(is_far_better(12.0, 1.0, false));
        assert!(!is_far_better(12.0, 1.0, true), "a file states the unit");
    }
}
