//! Timestamp jitter enters the covariance; beside the model that is found with it its size is estimated
//! once more, since structure that imitated it had a part of it.

use crate::diagnose::budget::noise::{Jitter, noise};
use crate::diagnose::fitted::Fitted;
use crate::diagnose::found::NoiseEffect;
use crate::engine::gram::LeastSquares;
use crate::estimate::batch::FitError;

use super::{Competed, Search};

/// The effect that is timestamp jitter.
const JITTER: &str = "timestamp_jitter";
/// Change of its size that is worth another round: relative, and in standard uncertainties.
const CHANGED: f64 = 0.02;
const HALF: f64 = 0.5;

impl Search<'_> {
    /// Takes timestamp jitter that was found into the problem, where the library offers it, or the size
    /// that it has beside the present model; whether the problem changed.
    pub(super) fn take_jitter(
        &mut self,
        competed: &Competed,
        found: Option<Jitter>,
    ) -> Result<bool, FitError> {
        let with = match self.noise.first() {
            None => match found {
                Some(found) => self.with_jitter(competed, found)?,
                None => None,
            },
            Some(_) => self.with_its_size(competed)?,
        };
        let Some(with) = with else { return Ok(false) };
        self.seen_outliers.clear();
        self.log.extend(self.noise.first().map(|one| format!("{} {:.3e} s", one.name, one.value)));
        self.fitted = with;
        Ok(true)
    }

    fn with_jitter(
        &mut self,
        Competed { linear, .. }: &Competed,
        Jitter { variance, sigma, score }: Jitter,
    ) -> Result<Option<Fitted>, FitError> {
        let candidate = linear.noise.iter().find(|one| one.name.starts_with(JITTER));
        let Some(candidate) = candidate else { return Ok(None) };
        let Some(mut with) = linear.fitted.with(&candidate.selected, &[], self.options)? else {
            return Ok(None);
        };
        let prefix = format!("{}.", candidate.name);
        let system = candidate.systems.iter().flatten().next();
        let random = system.and_then(|system| {
            system.randoms.iter().find(|random| random.name.starts_with(&prefix))
        });
        let Some(random) = random else { return Ok(None) };
        let value = variance.sqrt();
        with.problem.set_random(&random.name, value);
        // Jitter makes fast runs noisy: whether the noise of a run is its own is judged beside it.
        for (part, stated) in with.problem.parts.iter_mut().zip(&self.nominal.problem.parts) {
            part.run_levels.clone_from(&stated.run_levels);
        }
        let with = with.again(self.options)?;
        self.noise.push(NoiseEffect {
            name: candidate.name.clone(),
            selected: candidate.selected.clone(),
            parameter: random.name.clone(),
            unit: random.unit.clone(),
            value,
            sigma: 0.5 * sigma / value,
            ln_p: -0.5 * score * score,
        });
        Ok(Some(with))
    }

    /// The model with the size of jitter that its residuals have without it in the covariance; `None`
    /// where that is as it was.
    fn with_its_size(&mut self, competed: &Competed) -> Result<Option<Fitted>, FitError> {
        let selection = self.selection_of(competed);
        let Competed { linear, judged, .. } = competed;
        let Some(known) = self.noise.first() else { return Ok(None) };
        let mut plain = linear.clone();
        plain.fitted.problem.set_random(&known.parameter, 0.0);
        plain.fitted.problem.reweight(&linear.fitted.fit.point);
        let found = noise(&plain, &selection, &judged.model, &self.outliers, false).jitter;
        drop(selection);
        let Some(Jitter { variance, sigma, score }) = found else { return Ok(None) };
        let value = variance.sqrt();
        let sigma = 0.5 * sigma / value;
        if (value - known.value).abs() < (CHANGED * known.value).max(HALF * sigma) {
            return Ok(None);
        }
        let mut with = linear.fitted.clone();
        with.problem.set_random(&known.parameter, value);
        let with = with.again(self.options)?;
        for own in self.noise.iter_mut().take(1) {
            (own.value, own.sigma, own.ln_p) = (value, sigma, -0.5 * score * score);
        }
        Ok(Some(with))
    }
}
