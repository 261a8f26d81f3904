//! Delays with all readings and without those that are left out, with the same noise.

use crate::diagnose::fitted::Fitted;
use crate::estimate::batch::{Fit, FitError, Options};
use crate::estimate::calibrate::{Calibration, finish};

/// A delay with all readings and without those that are left out.
#[derive(Clone, Debug, PartialEq)]
pub struct ComparedDelay {
    /// Its name.
    pub name: String,
    /// The setup or run.
    pub of: Option<String>,
    /// With all readings (s).
    pub with: f64,
    /// Without those left out (s).
    pub without: f64,
    /// Standard uncertainty without them (s).
    pub sigma: Option<f64>,
}

/// The delays of campaigns as they are given and as a fit without some readings has them.
pub(in crate::diagnose) fn compared_delays(
    whole: &Calibration,
    stage: &Fitted,
    options: &Options,
) -> Result<Vec<ComparedDelay>, FitError> {
    let Fitted { problem, fit, recipes } = stage.clone();
    let mut parts = problem.parts.clone();
    for (part, given) in parts.iter_mut().zip(&whole.problem.parts) {
        if part.runs.len() != given.runs.len() {
            part.run_levels.clear();
            part.smoothing_sigma.clone_from(&given.smoothing_sigma);
            part.has_stream_noise = given.has_stream_noise;
        }
        part.runs.clone_from(&given.runs);
    }
    let given = problem.with_parts(parts);
    let point = fit.point.carried(&problem.layout, &given.layout);
    let with = Fitted { recipes, problem: given, fit: Fit { point, ..fit.clone() } };
    let with = with.again(options)?;
    // Outliers may keep the fit of all from settling: then it has no delays.
    if !with.is_sound() {
        return Ok(Vec::new());
    }
    let without = finish(problem, fit, Vec::new(), Vec::new())?.estimates();
    let with = finish(with.problem, with.fit, Vec::new(), Vec::new())?.estimates();
    let delays = without.into_iter().filter(|one| one.name.ends_with(".delay") && !one.fixed);
    let pairs = delays.filter_map(|one| {
        let same = with.iter().find(|other| other.name == one.name && other.of == one.of)?;
        let (with, without) = (same.value?, one.value?);
        Some(ComparedDelay { name: one.name, of: one.of, with, without, sigma: one.sigma })
    });
    Ok(pairs.collect())
}
