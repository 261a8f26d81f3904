//! Lost samples once more, beside the effects that were found: readings that these explain at their own
//! samples are not lost.
//!
//! Where an instrument goes on by equal steps, a shift by whole samples is an offset, too. An effect of a
//! few steps over a stroke, as of the temperature, looks like lost samples beside the nominal model.

use std::collections::BTreeMap;

use crate::diagnose::fitted::Fitted;
use crate::engine::Problem;
use crate::estimate::residuals::residuals_from;

use super::lost::Elsewhere;
use super::records::Records;
use super::shifted::Shifted;

/// What was found to belong to other moments, and the readings with it.
#[derive(Clone, Debug)]
pub(in crate::diagnose) struct LostSamples {
    found: Elsewhere,
    records: Records,
}

impl LostSamples {
    /// Stretches of the readings of a problem.
    pub(super) fn new(found: Elsewhere, problem: &Problem) -> Self {
        Self { found, records: Records::of(problem) }
    }

    /// The stretches without those that a model of the other readings explains at their own samples;
    /// `None` where it explains none.
    pub(in crate::diagnose) fn unexplained_by(&self, model: &Fitted) -> Option<Elsewhere> {
        let (mut problem, point) = (model.problem.clone(), &model.fit.point);
        if self.found.lost.is_empty() || !self.records.are_of(&problem) {
            return None;
        }
        // The scatter is that of the others.
        let others = residuals_from(&problem, point);
        self.records.put_into(&mut problem);
        let mut runs = BTreeMap::new();
        let mut rest = self.found.clone();
        rest.lost.retain(|one| {
            let of = (one.part, one.run);
            let run = runs.entry(of).or_insert_with(|| Shifted::new(&problem, of, point, &others));
            !run.fits_at_its_own(one.periods, &one.samples)
        });
        (rest.lost.len() < self.found.lost.len()).then_some(rest)
    }
}
