//! Noise that is larger or smaller in some runs than in the others: which runs, and whether that
//! explains more than basis blocks do.
//!
//! Under one noise scale factor for all, the noise of a noisier run looks like an oscillation with a
//! phase for each run. The log likelihoods of the two decide, each with its price.

use std::collections::BTreeMap;

use super::linear::Linear;
use super::noise::{Component, components};
use super::selection::Selection;
use crate::diagnose::thresholds::{NOISE, NOISE_OF_A_RUN};
use crate::statistics::{robust, upper_median};

/// Standard deviation of the logarithm of that from `n` readings, times `√n`.
const SCATTER: f64 = 1.17;
/// Readings of a run of which the noise is judged at least.
const LEAST: usize = 20;

/// Noise of a run: campaign, run in it, measurand in it, factor on the noise of the others.
pub type OfRun = (usize, usize, usize, f64);

/// Runs whose noise differs from the others' in what some terms leave, and by how much their own
/// factors raise the log likelihood, less their price.
pub fn noise_of_runs(
    linear: &Linear,
    selection: &Selection<'_>,
    model: &[usize],
) -> (f64, Vec<OfRun>) {
    let mut by_measurand: BTreeMap<(usize, usize), Vec<Component>> = BTreeMap::new();
    for ((part, measurand, _), runs) in components(linear, selection, model, &mut |_, _| {}) {
        by_measurand.entry((part, measurand)).or_default().push(runs);
    }
    let (mut gained, mut found) = (0.0, Vec::new());
    for ((part, measurand), components) in by_measurand {
        let mut of_run: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
        for (run, values) in components.into_iter().flatten() {
            of_run.entry(run).or_default().extend(values.iter().map(|(.., value)| value.abs()));
        }
        of_run.retain(|_, sizes| sizes.len() >= LEAST);
        let robust: BTreeMap<usize, f64> =
            of_run.iter().map(|(run, sizes)| (*run, robust(sizes).unwrap_or(0.0))).collect();
        let usual = upper_median(&mut robust.values().copied().collect::<Vec<f64>>());
        let usual = usual.unwrap_or(0.0);
        // Where half of the residuals are zero, such as those of counts, their scatter is not known.
        if of_run.len() < 3 || robust.values().any(|one| *one <= 0.0) {
            continue;
        }
        let is_own = |run: &usize| {
            let ratio = (robust[run] / usual).ln();
            let score = ratio.abs() * (of_run[run].len() as f64).sqrt() / SCATTER;
            score > NOISE && ratio.abs() > NOISE_OF_A_RUN.ln()
        };
        let own: Vec<usize> = of_run.keys().copied().filter(is_own).collect();
        if own.is_empty() || 2 * own.len() > of_run.len() {
            continue;
        }
        // Outliers are no noise.
        let sums = |run: &usize| {
            let kept = of_run[run].iter().filter(|size| **size <= NOISE * robust[run]);
            kept.fold((0.0, 0.0), |(n, sum), size| (n + 1.0, sum + size * size))
        };
        let ln_likelihood = |runs: &[usize]| {
            let (n, sum) = runs.iter().map(sums).fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
            if n > 0.0 { -0.5 * n * (sum / n).ln() } else { 0.0 }
        };
        let all: Vec<usize> = of_run.keys().copied().collect();
        let others: Vec<usize> = all.iter().copied().filter(|run| !own.contains(run)).collect();
        let (n, sum) = others.iter().map(sums).fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
        let readings = all.iter().map(sums).map(|(n, _)| n).sum::<f64>();
        gained += ln_likelihood(&others) - ln_likelihood(&all);
        for run in own {
            gained += ln_likelihood(&[run]) - 0.5 * readings.ln() - (all.len() as f64).ln();
            let own = sums(&run);
            let factor = (own.1 / own.0 / (sum / n)).sqrt();
            let (_, of_part) = linear.part_of(run);
            let first = linear.sums.first_measurand[part];
            found.push((part, of_part, measurand - first, factor));
        }
    }
    (gained, found)
}
