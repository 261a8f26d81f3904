//! Levels of noise that the model itself has: what the nominal fit took for noise may have been what rows
//! explain, so they are estimated anew beside the rows that are in the fit.

use crate::diagnose::fitted::Fitted;
use crate::estimate::batch::FitError;
use crate::estimate::levels::settle_levels;
use crate::estimate::variance::{Unknown, current, unknown_levels};

use super::{Competed, Search};

/// Relative change of a level that is worth another round.
const CHANGED: f64 = 0.02;

impl Search<'_> {
    /// Takes the levels beside the rows that are in the fit; whether one of them changed.
    pub(super) fn take_levels(&mut self, competed: &Competed) -> Result<bool, FitError> {
        let found = self.with_levels(&competed.linear.fitted)?;
        let Some((with, _)) = found.filter(|(_, change)| *change > CHANGED) else {
            return Ok(false);
        };
        self.log.push("levels of noise beside the rows".to_owned());
        self.fitted = with;
        Ok(true)
    }

    /// A fit with the levels that its residuals have, and the largest relative change of one; `None` of a
    /// model without levels of its own, and where they do not settle.
    pub(super) fn with_levels(&self, fitted: &Fitted) -> Result<Option<(Fitted, f64)>, FitError> {
        let mut unknown = unknown_levels(&fitted.problem);
        // The level of an effect on the noise is estimated where that was found.
        let is_found = |name: &String| self.noise.iter().any(|own| own.parameter == *name);
        unknown.retain(|one| !matches!(one, Unknown::Random(name) if is_found(name)));
        if unknown.is_empty() {
            return Ok(None);
        }
        let Fitted { recipes, mut problem, fit } = fitted.clone();
        let before = unknown.iter().map(|one| current(&problem, &fit.point, one));
        let before: Vec<f64> = before.collect();
        let (fit, levels) = settle_levels(&mut problem, fit, &unknown, self.options)?;
        let changes = levels.iter().zip(&before).map(|(level, before)| {
            let larger = before.abs().max(level.value.abs()).max(f64::MIN_POSITIVE);
            (level.value - before).abs() / larger
        });
        let change = changes.fold(0.0, f64::max);
        let with = Fitted { recipes, problem, fit };
        Ok(with.is_sound().then_some((with, change)))
    }
}
