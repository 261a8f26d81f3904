//! Uncertainties that count noise which is not as stated: larger or smaller, or correlated in time.
//!
//! Two ways of the field, neither of which a plain fit takes:
//!
//! - *autocorrelated*: each residual component gets a level and, where its likelihood says so,
//!   one or two first-order Gauss-Markov processes (`correlated_noise` for any measurand). They enter
//!   the weights, so values change, too: the efficient estimate where the noise is of that form.
//! - *sandwich*: values stay those of the plain fit; their covariance is `H⁻¹ B H⁻¹` with scores
//!   summed over clusters (Liang and Zeger 1986), which are runs where there are enough of them,
//!   else stretches of time beyond which residuals are not correlated. Neighbouring stretches count
//!   half (the kernel of Bartlett; Newey and West 1987). It holds whatever the noise is like within
//!   a cluster.

use std::fmt;

use nalgebra::{DMatrix, DVector};

use crate::engine::Problem;
use crate::engine::gauss_markov::{GaussMarkov, Process};
use crate::engine::signatures::Signatures;
use crate::engine::stretches::Left;
use crate::estimate::autocorrelation::longest;
use crate::estimate::batch::{FitError, Options};
use crate::estimate::calibrate::{Calibration, calibrate, calibrate_from};
use crate::estimate::noise::{Clusters, Estimated, Noise};

pub(crate) mod likelihood;

use likelihood::{Sequence, likeliest};

/// Which noise uncertainties are made for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NoiseModel {
    /// As stated, independent from reading to reading.
    #[default]
    Stated,
    /// With a level and a correlation in time that are estimated.
    Autocorrelated,
    /// Whatever it is like within clusters.
    Sandwich,
}

/// Why uncertainties cannot be made for a noise model.
#[derive(Debug, thiserror::Error)]
pub enum NoiseError {
    /// The fit itself fails.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// Too little for a sandwich.
    #[error(
        "a cluster-robust covariance needs {LEAST} clusters (runs or stretches of time) and more than there are unknowns: found {0}"
    )]
    FewClusters(usize),
}

impl fmt::Display for NoiseModel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Stated => "stated",
            Self::Autocorrelated => "autocorrelated",
            Self::Sandwich => "sandwich",
        })
    }
}

/// Rounds of estimating the noise and fitting again.
const ROUNDS: usize = 8;
/// Relative change of level, share and time below which the noise stands.
const SETTLED: f64 = 0.01;
/// Runs that are enough to be the clusters.
const RUNS: usize = 24;
/// Stretches of time at least and at most.
const STRETCHES: [usize; 2] = [24, 400];
/// Clusters without which there is no sandwich.
const LEAST: usize = 8;

/// Estimates everything, with uncertainties for a noise model.
///
/// # Errors
/// As [`calibrate`], and where there are too few clusters.
pub fn calibrate_with(
    problem: Problem,
    options: &Options,
    model: NoiseModel,
) -> Result<Calibration, NoiseError> {
    let plain = calibrate(problem, options)?;
    with_noise(plain, options, model)
}

/// The same of an estimate that was made with the noise as stated.
///
/// # Errors
/// As [`calibrate_with`].
pub fn with_noise(
    plain: Calibration,
    options: &Options,
    model: NoiseModel,
) -> Result<Calibration, NoiseError> {
    if !plain.is_sound() {
        return Ok(plain);
    }
    match model {
        NoiseModel::Stated => Ok(plain),
        NoiseModel::Autocorrelated => autocorrelated(plain, options).map_err(NoiseError::from),
        NoiseModel::Sandwich => sandwich(plain),
    }
}

fn autocorrelated(mut result: Calibration, options: &Options) -> Result<Calibration, FitError> {
    let mut known: Vec<Estimated> = Vec::new();
    for _ in 0..ROUNDS {
        let found = estimated(&mut result);
        let has_settled =
            known.len() == found.len() && known.iter().zip(&found).all(|(a, b)| is_near(a, b));
        known = found;
        let Calibration { problem, fit, aligned, held, .. } = result;
        result = calibrate_from(problem, fit.point, options)?;
        (result.aligned, result.held) = (aligned, held);
        if has_settled || !result.is_sound() {
            break;
        }
    }
    result.noise = Noise::Autocorrelated(known);
    Ok(result)
}

fn is_near(a: &Estimated, b: &Estimated) -> bool {
    let near = |a: f64, b: f64| (a - b).abs() <= SETTLED * a.abs().max(b.abs());
    let alike = |(a, b): (&Option<GaussMarkov>, &Option<GaussMarkov>)| {
        let processes = |noise: &Option<GaussMarkov>| -> Vec<Process> {
            noise.iter().flat_map(GaussMarkov::processes).collect()
        };
        let (a, b) = (processes(a), processes(b));
        let is_near = |(a, b): (&Process, &Process)| near(a.share, b.share) && near(a.time, b.time);
        a.len() == b.len() && a.iter().zip(&b).all(is_near)
    };
    near(a.level, b.level) && a.components.iter().zip(&b.components).all(alike)
}

/// The noise of every measurand from the residuals of a fit; it is written into the problem.
fn estimated(result: &mut Calibration) -> Vec<Estimated> {
    let mut white = result.problem.clone();
    white.parts.iter_mut().for_each(|part| part.gauss_markov.fill(None));
    // As many residuals were fitted away as there are unknowns.
    let freedom = result.degrees_of_freedom().max(1) as f64 / result.readings.max(1) as f64;
    let mut all = Vec::new();
    for p in 0..white.parts.len() {
        let left = whitened(&white, &result.fit.point, p, usize::MAX);
        let part = &mut result.problem.parts[p];
        if part.run_levels.is_empty() {
            part.run_levels = vec![vec![1.0; part.sigma.len()]; part.runs.len()];
        }
        let names: Vec<String> =
            part.system.assembly.names.measurands.iter().map(|one| one.name.clone()).collect();
        for (m, slot) in part.slots().to_vec().iter().enumerate() {
            let (mut squares, mut count) = (0.0, 0.0);
            let mut components = Vec::new();
            for row in slot.residual..slot.residual + slot.components {
                let sequence = Sequence::of(part, &left, row);
                let found = likeliest(&sequence);
                squares += found.variance * sequence.count as f64;
                count += sequence.count as f64;
                part.gauss_markov[row] = found.noise;
                components.push(found.noise);
            }
            if count == 0.0 || squares <= 0.0 {
                continue;
            }
            // What was whitened had the level of before.
            let by = (squares / count / freedom).sqrt();
            part.run_levels.iter_mut().for_each(|levels| levels[m] *= by);
            let level = part.run_levels.first().map_or(by, |levels| levels[m]);
            all.push(Estimated {
                measurand: names[m].clone(),
                of: part.label.clone(),
                level,
                components,
                is_over_rows: part.is_untimed(),
            });
        }
    }
    all
}

/// The whitened residuals of a campaign, and its scores over stretches of so many samples.
fn whitened(
    problem: &Problem,
    point: &crate::engine::Point,
    part: usize,
    length: usize,
) -> Vec<Left> {
    let signatures = Signatures::new(problem, part, &[]);
    let size = |run| problem.layout.columns.touched_by(problem.run_index(part, run)).len();
    let steps: Vec<Vec<f64>> =
        (0..problem.parts[part].runs.len()).map(|run| vec![0.0; size(run)]).collect();
    problem.left(&signatures, point, &steps, length)
}

fn sandwich(mut result: Calibration) -> Result<Calibration, NoiseError> {
    let problem = &result.problem;
    let runs: usize = problem.parts.iter().map(|part| part.runs.len()).sum();
    let samples = problem.sample_count();
    let length = if runs >= RUNS {
        None
    } else {
        let [least, most] = STRETCHES;
        let wanted = 2 * usize::try_from(longest(&result)).unwrap_or(usize::MAX);
        Some(wanted.max(samples.div_ceil(most)).min(samples / least).max(1))
    };
    let n = problem.layout.columns.len();
    let mut meat = DMatrix::<f64>::zeros(n, n);
    let mut count = 0;
    for p in 0..problem.parts.len() {
        let left = whitened(problem, &result.fit.point, p, length.unwrap_or(usize::MAX));
        for (run, one) in left.iter().enumerate() {
            let touched = problem.layout.columns.touched_by(problem.run_index(p, run));
            let mut before: Option<DVector<f64>> = None;
            for scores in one.scores.iter().filter(|one| one.iter().any(|score| *score != 0.0)) {
                let mut own = DVector::zeros(n);
                touched.iter().zip(scores.iter()).for_each(|(at, score)| own[*at] = *score);
                meat += &own * own.transpose();
                if let Some(before) = &before {
                    let across = 0.5 * before * own.transpose();
                    meat += &across + across.transpose();
                }
                count += 1;
                before = length.is_some().then_some(own);
            }
        }
    }
    if count < LEAST || count <= n {
        return Err(NoiseError::FewClusters(count));
    }
    meat *= count as f64 / (count as f64 - 1.0);
    // What is stated is known to what is stated.
    for row in &result.fit.normal.priors {
        for (i, a) in &row.coefficients {
            for (j, b) in &row.coefficients {
                meat[(*i, *j)] += a * b;
            }
        }
    }
    let bread = &result.covariance;
    result.covariance = bread * meat * bread;
    result.noise = Noise::Sandwich(Clusters { count, samples: length });
    Ok(result)
}
