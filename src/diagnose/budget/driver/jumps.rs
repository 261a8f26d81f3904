//! Jumps of a clock that are long beside the motion, such as a third of its period: no change that is
//! linear in them sees these, and what they leave looks like other structure. The search begins with
//! them in the fit, as changes (`fitted_changes`) from a start that was found by shifting readings.

use crate::diagnose::budget::families::Families;
use crate::diagnose::budget::linear::Linear;
use crate::diagnose::budget::terms::{Base, Change};
use crate::diagnose::library::place::{ALL_READINGS, Place};
use crate::diagnose::outliers::lost::Jump;
use crate::diagnose::price::Gain;
use crate::estimate::batch::FitError;

use super::Search;

/// Jumps in the fit at most.
const MOST: usize = 12;
/// A fit with jumps leaves so many times less.
const FAR_LESS: f64 = 2.0;

impl Search<'_> {
    /// Lets jumps enter the fit, but for those that do not better it; whether it is far better with them.
    pub(super) fn take_jumps(&mut self, jumps: &[Jump]) -> Result<bool, FitError> {
        let before = self.fitted.fit.cost;
        // Members of families that are found beside jumps are worth nothing later.
        let mut scanned = Families::default();
        let fitted = self.fitted.clone();
        let linear = Linear::new(fitted, &self.rows, &self.wanted, true, &mut scanned);
        let Some(linear) = linear else { return Ok(false) };
        for jump in jumps.iter().take(MOST) {
            for (change, place) in linear.jump(jump) {
                self.fit_change(&linear, &change, &place, &[jump.seconds])?;
            }
        }
        Ok(self.fitted.fit.cost * FAR_LESS < before)
    }
}

impl Linear {
    /// The changes that a jump is: of the delay of all readings, or of each measurand.
    fn jump(&self, jump: &Jump) -> Vec<(Change, Place)> {
        let problem = &self.fitted.problem;
        let run = problem.run_index(jump.part, jump.run);
        let samples: usize = (0..self.order.len()).map(|run| problem.samples_in(run)).sum();
        let blocks = self.candidates.iter().enumerate();
        let timing = blocks.filter_map(|(candidate, one)| {
            let place = one.place.as_ref()?;
            Some((candidate, place, place.delayed_by_run()?))
        });
        let timing: Vec<(usize, &Place, &str)> = timing.collect();
        let is_of_all = |one: &&(usize, &Place, &str)| one.2 == ALL_READINGS;
        let wanted: Vec<_> = match timing.iter().find(is_of_all) {
            Some(all) => vec![*all],
            None => timing,
        };
        let change = |(candidate, place, _): (usize, &Place, &str)| {
            let change = Change {
                base: Base { candidate, signature: 0 },
                width: 1,
                at: (run, jump.samples.start),
                end: Some(jump.samples.end),
                gain: Gain::default(),
                members: samples,
            };
            let place = place.within(&problem.run_names()[run], self.extent(&change));
            (change, place)
        };
        wanted.into_iter().map(change).collect()
    }
}
