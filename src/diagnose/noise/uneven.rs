//! Single runs that scatter otherwise than most.
//!
//! A run is compared with the median of all by the median of its absolute residuals, which neither
//! wild readings nor long tails move: the logarithm of their ratio has the standard deviation
//! `1.17 / √n`. By how much it scatters otherwise, those of its residuals say that are not wild.
//! What one run has beyond the others would else be taken for an effect that acts there.

use crate::diagnose::evidence::thresholds::{LEAST_RUNS, level};
use crate::diagnose::fitted::Fitted;
use crate::diagnose::found::Noise;
use crate::diagnose::gross::wild::TRIM;
use crate::diagnose::sequences::{NORMAL, OF_A_MEDIAN, Sequence, sequences};
use crate::diagnose::stage::Stage;
use crate::engine::stretches::Left;
use crate::estimate::median::upper_median;
use crate::statistics::ln_normal;

use super::neighbours::LEAST_READINGS;

/// A run that scatters less than so many times as much as most is like them.
const UNEVEN: f64 = 1.25;

/// Lets runs that scatter otherwise than most have a level of their own, once.
pub(super) fn uneven(stage: &Stage, left: &[Left], noise: &Noise) -> Option<Fitted> {
    let problem = &stage.fitted.problem;
    if problem.parts.iter().any(|part| !part.run_levels.is_empty()) {
        return None;
    }
    let beside = left_beside_oscillations(stage, noise);
    let all = sequences(problem, beside.as_deref().unwrap_or(left));
    let runs: usize = problem.parts.iter().map(|part| part.runs.len()).sum();
    let level = level(runs * all.len()) - std::f64::consts::LN_2;
    let mut fitted = stage.fitted.clone();
    let parts = fitted.problem.parts.iter_mut().enumerate();
    for (p, part) in parts {
        for measurand in 0..part.sigma.len() {
            let own = |one: &&Sequence| one.part == p && one.measurand == measurand;
            let own: Vec<&Sequence> = all.iter().filter(own).collect();
            let scatter: Vec<(usize, Scatter)> = (0..part.runs.len())
                .filter_map(|run| Some((run, Scatter::of(&own, run)?)))
                .collect();
            let usual = |of: &dyn Fn(&Scatter) -> f64| {
                upper_median(&mut scatter.iter().map(|(_, one)| of(one)).collect::<Vec<f64>>())
            };
            let (Some(size), Some(rms)) = (usual(&|one| one.median), usual(&|one| one.rms)) else {
                continue;
            };
            if scatter.len() < LEAST_RUNS {
                continue;
            }
            for (run, one) in &scatter {
                let ratio: f64 = one.rms / rms;
                let deviations = (one.median / size).ln().abs()
                    * (noise.alike() * one.count).sqrt()
                    / OF_A_MEDIAN;
                if ratio.ln().abs() < UNEVEN.ln() || ln_normal(deviations) > level {
                    continue;
                }
                if part.run_levels.is_empty() {
                    part.run_levels = vec![vec![1.0; part.sigma.len()]; part.runs.len()];
                }
                part.run_levels[*run][measurand] = ratio;
            }
        }
    }
    fitted.problem.parts.iter().any(|part| !part.run_levels.is_empty()).then_some(fitted)
}

/// What is left of runs that are compared with each other, where an oscillation was taken off: a
/// noisier run makes one, which must stay.
fn left_beside_oscillations(stage: &Stage, noise: &Noise) -> Option<Vec<Left>> {
    let swings = stage.structures().iter().any(|one| stage.is_oscillation(*one));
    let (problem, point) = (&stage.fitted.problem, &stage.fitted.fit.point);
    swings.then(|| {
        let rest = stage.together(&stage.structures_beside_noise());
        stage.evidence.left(problem, point, &rest, noise.stretch)
    })
}

/// How residuals of a measurand scatter in a run.
struct Scatter {
    /// The median of their sizes, by which a run is found to be uneven.
    median: f64,
    /// The root mean square of those that are not wild, which says by how much: of runs that are
    /// chosen for an extreme median that is too far out.
    rms: f64,
    count: f64,
}

impl Scatter {
    fn of(own: &[&Sequence], run: usize) -> Option<Self> {
        let values = own.iter().flat_map(|one| one.runs[run].iter());
        let mut sizes: Vec<f64> =
            values.filter(|value| !value.is_nan()).map(|value| value.abs()).collect();
        let median = upper_median(&mut sizes).filter(|size| *size > 0.0)?;
        let tame = || sizes.iter().filter(|size| **size <= TRIM * NORMAL * median);
        let rms = (tame().map(|size| size * size).sum::<f64>() / tame().count() as f64).sqrt();
        let count = sizes.len() as f64;
        (sizes.len() >= LEAST_READINGS).then_some(Self { median, rms, count })
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::stream::Stream;

    /// Of many runs alike those with the most extreme medians are not what these say.
    #[test]
    fn runs_chosen_for_their_median_scatter_less_unlike_others() {
        let mut stream = Stream(7);
        let runs = (0..400).map(|_| Arc::new((0..60).map(|_| stream.normal()).collect()));
        let all = Sequence::of_runs(runs.collect());
        let mut each: Vec<Scatter> = (0..400).filter_map(|run| Scatter::of(&[&all], run)).collect();
        each.sort_by(|a, b| a.median.total_cmp(&b.median));
        for (extreme, sign) in [(&each[..8], -1.0), (&each[392..], 1.0)] {
            let far = |of: &dyn Fn(&Scatter) -> f64| {
                sign * extreme.iter().map(|one| of(one).ln()).sum::<f64>() / 8.0
            };
            let (by_median, by_rms) = (far(&|one| NORMAL * one.median), far(&|one| one.rms));
            assert!(by_median > 0.25 && by_rms < 0.7 * by_median, "{by_median} {by_rms}");
        }
    }

    #[test]
    fn a_wild_reading_and_a_few_readings_say_nothing_of_a_run() {
        let mut stream = Stream(8);
        let mut run: Vec<f64> = (0..200).map(|_| stream.normal()).collect();
        run[20] = 1e6;
        run[30] = f64::NAN;
        let of = |run: Vec<f64>| Scatter::of(&[&Sequence::of_runs(vec![Arc::new(run)])], 0);
        let found = of(run.clone());
        assert!(found.is_some_and(|one| (one.rms - 1.0).abs() < 0.15 && one.count == 199.0));
        assert!(of(run[..LEAST_READINGS - 1].to_vec()).is_none() && of(vec![0.0; 99]).is_none());
    }
}
