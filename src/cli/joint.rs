//! The joint fit that stands behind the delays of `delays`, `compare` and `deviations`: with the
//! members of families that fit best, members of effects held that the model absorbs, and other minima.

use serde_json::Value;

use super::calibrate::estimate_with;
use super::load::Loaded;
use super::{Failure, load};
use crate::diagnose::evidence::members::{Chosen, choose};
use crate::estimate::batch::Options;
use crate::estimate::calibrate::Calibration;
use crate::estimate::minima::{Other, others};
use crate::report;

/// A joint fit with what was decided in it.
pub(super) struct Joint {
    pub(super) fit: Calibration,
    chosen: Vec<Chosen>,
    others: Vec<Other>,
}

impl Joint {
    /// Fits; the campaigns then have the members that were chosen and those that were held.
    pub(super) fn of(loaded: &mut Loaded, effects: &[String]) -> Result<Self, Failure> {
        let (problem, chosen) =
            choose(loaded.problem.clone(), &loaded.recipes, effects, &Options::default())?;
        let fit = estimate_with(problem.clone(), effects)?;
        loaded.problem = problem;
        if !fit.held.is_empty() {
            loaded.problem = fit.problem.clone();
        }
        let others = others(&fit);
        Ok(Self { fit, chosen, others })
    }

    /// What is to be said of it beside delays; empty if nothing is.
    pub(super) fn text(&self) -> String {
        let held = report::text::held(&self.fit);
        let correlated = report::autocorrelation::correlated(&self.fit);
        held + &report::members::text(&self.chosen)
            + &report::autocorrelation::text(&correlated)
            + &report::minima::text(&self.fit, &self.others)
    }

    /// The same for programs.
    pub(super) fn json(&self) -> Value {
        let mut value = report::members::json(&self.chosen);
        load::merge(&mut value, report::json::held(&self.fit));
        let correlated = report::autocorrelation::correlated(&self.fit);
        load::merge(&mut value, report::autocorrelation::json(&correlated));
        load::merge(&mut value, report::minima::json(&self.fit, &self.others));
        value
    }
}
