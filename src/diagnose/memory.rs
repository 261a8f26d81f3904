//! Noise with a memory: readings next to each other in time are alike.
//!
//! The correlation of neighbours is tested one-sidedly, `r √n` being normal without a memory; its time is
//! from the correlations at the first `LAGS` lags. Stretches over which scores are summed follow the
//! memory, and so does what noise may pretend. Whether a random walk of the whole station is the better
//! reason, likelihoods decide.

use crate::engine::stretches::Left;
use crate::model::Process;

use super::candidates::Candidate;
use super::gap::LEAST_RUNS;
use super::search::level;
use super::stage::Stage;
use super::tail::ln_normal;
use super::wander::walk;
use super::whiten::{Noise, NoiseEffect, Sequence, sequences};

/// A random walk that shows, unless one is in the model already, the runs are too few to tell one from
/// structure, or a memory of each measurand by itself
/// is the likelier reason.
pub(super) fn wanders(stage: &Stage, noise: &Noise) -> Option<NoiseEffect> {
    let walks = |one: &NoiseEffect| {
        stage.noise.iter().any(|other| other.name == one.name && is_walk(other))
    };
    let runs: usize = stage.fitted.problem.parts.iter().map(|part| part.runs.len()).sum();
    if noise.effects.iter().any(walks) || runs < LEAST_RUNS {
        return None;
    }
    let rows: usize = stage.fitted.problem.parts.iter().map(|part| part.residual_count()).sum();
    let (found, likelihood) = walk(stage, level(rows + stage.noise.len()))?;
    let nothing = stage.evidence.together(&[]);
    let (problem, point) = (&stage.fitted.problem, &stage.fitted.fit.point);
    let left = stage.evidence.left(problem, point, &nothing, 1_000);
    let alone: f64 = sequences(problem, &left).iter().map(likelihood_of_memory).sum();
    (likelihood > alone).then_some(found)
}

/// Logarithm of the likelihood ratio of noise with a memory against white noise of the same scatter, the
/// largest over sizes and times: a filter goes through each run and predicts every reading.
fn likelihood_of_memory(one: &Sequence) -> f64 {
    let (squares, count) =
        one.present().fold((0.0, 0.0), |(sum, count), value| (sum + value * value, count + 1.0));
    if count == 0.0 || squares == 0.0 {
        return 0.0;
    }
    let variance = squares / count;
    let at = |share: f64, samples: f64| {
        let rho = f64::exp(-1.0 / samples);
        let mut sum = 0.0;
        for run in &one.runs {
            let (mut state, mut spread) = (0.0, share);
            for value in run {
                if !value.is_nan() {
                    let left = value / variance.sqrt() - state;
                    let total = spread + 1.0 - share;
                    sum += 0.5 * (value * value / variance - total.ln() - left * left / total);
                    let gain = spread / total;
                    state += gain * left;
                    spread *= 1.0 - gain;
                }
                state *= rho;
                spread = rho * rho * spread + share * (1.0 - rho * rho);
            }
        }
        sum
    };
    let shares = [0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 0.9];
    let times = (0..14).map(|k| 0.5 * 1.7_f64.powi(k));
    let all = times.flat_map(|time| shares.map(|share| at(share, time)));
    all.fold(0.0, f64::max)
}

fn is_walk(candidate: &Candidate) -> bool {
    candidate.selected.effect.parameters.iter().any(|one| one.process == Process::Walk)
}

/// Noise with a memory: neighbours in time are alike.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Memory {
    /// Part of the variance that has it.
    share: f64,
    /// After so many samples it is down to a factor of e.
    samples: f64,
    /// Number of pairs of neighbours.
    pairs: f64,
    /// Logarithm of the probability of the neighbours' correlation by chance.
    ln_p: f64,
}

/// Lags at which a memory is fitted.
const LAGS: usize = 24;

/// The memory of a measurand, if it has one: `share · exp(-lag / samples)` through its correlations, by
/// least squares over a grid of times.
fn remembered(one: &Sequence, level: f64) -> Option<Memory> {
    let correlation = |lag: usize| {
        let (mut products, mut count) = (0.0, 0.0);
        for run in &one.runs {
            for (a, b) in run.iter().zip(run.iter().skip(lag)) {
                if !a.is_nan() && !b.is_nan() {
                    products += a * b;
                    count += 1.0;
                }
            }
        }
        (products, count)
    };
    let (squares, all) = correlation(0);
    let (neighbours, pairs) = correlation(1);
    if all == 0.0 || pairs == 0.0 || squares <= 0.0 {
        return None;
    }
    let variance = squares / all;
    let ln_p = ln_normal(neighbours / pairs / variance * f64::sqrt(pairs));
    if ln_p > level {
        return None;
    }
    let lags: Vec<(f64, f64)> = (1..=LAGS)
        .map(|lag| (lag as f64, correlation(lag)))
        .filter(|(_, (_, count))| *count > 0.0)
        .map(|(lag, (products, count))| (lag, products / count / variance))
        .collect();
    let fitted = |samples: f64| {
        let decay = |lag: f64| (-lag / samples).exp();
        let own: f64 = lags.iter().map(|(lag, _)| decay(*lag).powi(2)).sum();
        let both: f64 = lags.iter().map(|(lag, value)| decay(*lag) * value).sum();
        let share = (both / own).clamp(0.0, 1.0);
        let misfit = |(lag, value): &(f64, f64)| (value - share * decay(*lag)).powi(2);
        (lags.iter().map(misfit).sum::<f64>(), share, samples)
    };
    let times = (0..80).map(|k| 0.3 * 1.12_f64.powi(k));
    let best = times.map(fitted).min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(Memory { share: best.1, samples: best.2, pairs, ln_p })
}

/// The part of each measurand's variance that has no memory, by campaign and measurand.
pub(super) fn white_parts(stage: &Stage, left: &[Left]) -> Vec<(usize, usize, f64)> {
    let all = sequences(&stage.fitted.problem, left);
    let level = level(all.len() + stage.noise.len());
    let share = |one: &Sequence| remembered(one, level).map_or(0.0, |memory| memory.share);
    all.iter().map(|one| (one.part, one.measurand, 1.0 - share(one))).collect()
}

/// Names noise with a memory; the strongest where there is more.
pub(super) fn name_memory(stage: &Stage, left: &[Left], noise: &mut Noise) {
    let has_process = |candidate: &&Candidate| {
        candidate.selected.effect.parameters.iter().any(|one| one.process == Process::Memory)
    };
    let Some(candidate) = stage.noise.iter().find(has_process) else { return };
    let all = sequences(&stage.fitted.problem, left);
    let level = level(all.len() + stage.noise.len());
    let found = all.iter().filter_map(|one| Some((one, remembered(one, level)?)));
    let Some((one, memory)) = found.min_by(|a, b| a.1.ln_p.total_cmp(&b.1.ln_p)) else { return };
    let part = &stage.fitted.problem.parts[one.part];
    let measurand = &part.system.assembly.names.measurands[one.measurand];
    let size = part.sigma[one.measurand] * memory.share.sqrt();
    noise.effects.push(NoiseEffect {
        name: candidate.name.clone(),
        selected: None,
        parameter: format!("{}.{}", candidate.name, measurand.name),
        unit: measurand.unit.clone(),
        value: size,
        // The share is known as the correlation of neighbours is.
        sigma: 0.5 * size / (memory.share.max(1e-12) * memory.pairs.sqrt()),
        ln_p: memory.ln_p,
    });
}

/// The largest correlation of neighbours that is more than chance; 0 where there is none.
pub(super) fn memory(all: &[Sequence], level: f64) -> f64 {
    all.iter()
        .map(|one| {
            let (mut products, mut squares, mut count) = (0.0, 0.0, 0);
            for run in &one.runs {
                for pair in run.windows(2).filter(|pair| pair.iter().all(|value| !value.is_nan())) {
                    products += pair[0] * pair[1];
                    squares += 0.5 * (pair[0] * pair[0] + pair[1] * pair[1]);
                    count += 1;
                }
            }
            let correlation = if squares > 0.0 { products / squares } else { 0.0 };
            let ln_p = ln_normal(correlation * f64::from(count).sqrt());
            if ln_p <= level { correlation.min(0.99) } else { 0.0 }
        })
        .fold(0.0, f64::max)
}
