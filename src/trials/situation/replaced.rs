//! Readings replaced by others: codes, those of later samples, outliers, another unit, rounded ones.
//!
//! Only measurands of one component are touched. Angles stay within their period.

use rand::RngExt;
use rand_chacha::ChaCha12Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::engine::part::Slot;
use crate::engine::{Part, Problem};
use crate::graph::MeasurandKind;

/// The measurands of one component: their index, their column and where that is.
pub(super) fn scalars(part: &Part) -> Vec<(usize, Slot)> {
    let slots = part.slots().iter().cloned().enumerate();
    slots.filter(|(_, slot)| slot.components == 1).collect()
}

/// An angle back in its period; other readings as they are.
pub(super) fn within(slot: &Slot, value: f64) -> f64 {
    match slot.kind {
        MeasurandKind::Angle { period } if period > 0.0 => value.rem_euclid(period),
        _ => value,
    }
}

/// Changes all readings of one measurand: `change` is given the reading, the noise that is stated
/// for it and random numbers.
fn each_reading(
    problem: &mut Problem,
    chance: &mut ChaCha12Rng,
    mut change: impl FnMut(f64, f64, &mut ChaCha12Rng) -> f64,
) {
    let which: usize = chance.random_range(0..usize::MAX);
    for part in &mut problem.parts {
        let scalars = scalars(part);
        let Some((index, slot)) = scalars.get(which % scalars.len().max(1)) else { continue };
        let sigma = part.sigma[*index];
        for run in &mut part.runs {
            run.record.edit(|samples| {
                for reading in &mut samples.readings[slot.column] {
                    *reading = within(slot, change(*reading, sigma, chance));
                }
            });
        }
    }
}

/// One measurand in one run of one campaign: indices of campaign and run, the noise that is stated,
/// and where the readings are. `None` where there is none with so many samples.
fn one_run(
    problem: &Problem,
    least: usize,
    chance: &mut ChaCha12Rng,
) -> Option<(usize, usize, f64, Slot)> {
    let mut all = Vec::new();
    for (p, part) in problem.parts.iter().enumerate() {
        for (index, slot) in scalars(part) {
            let long = part.runs.iter().enumerate().filter(|(_, run)| run.record.len() >= least);
            all.extend(long.map(|(r, _)| (p, r, part.sigma[index], slot.clone())));
        }
    }
    (!all.is_empty()).then(|| all.swap_remove(chance.random_range(0..all.len())))
}

/// A code in place of a share of the readings of one measurand.
pub(super) fn error_codes(problem: &mut Problem, code: f64, share: f64, chance: &mut ChaCha12Rng) {
    each_reading(
        problem,
        chance,
        |reading, _, chance| {
            if chance.random::<f64>() < share { code } else { reading }
        },
    );
}

/// Readings of one measurand rounded to multiples of a step in units of the noise.
pub(super) fn quantised(problem: &mut Problem, step: f64, chance: &mut ChaCha12Rng) {
    each_reading(problem, chance, |reading, sigma, _| {
        let step = step * sigma;
        (reading / step).round() * step
    });
}

/// The readings of one measurand in one run, multiplied.
pub(super) fn wrong_unit(problem: &mut Problem, factor: f64, chance: &mut ChaCha12Rng) {
    let Some((p, r, _, slot)) = one_run(problem, 1, chance) else { return };
    problem.parts[p].runs[r].record.edit(|samples| {
        for reading in &mut samples.readings[slot.column] {
            *reading = within(&slot, factor * *reading);
        }
    });
}

/// Consecutive readings of one measurand far out on one side: by `size` and more, in units of the
/// noise.
pub(super) fn outlier_burst(
    problem: &mut Problem,
    length: usize,
    size: f64,
    chance: &mut ChaCha12Rng,
) {
    let Some((p, r, sigma, slot)) = one_run(problem, length, chance) else { return };
    let sign = if chance.random::<bool>() { 1.0 } else { -1.0 };
    problem.parts[p].runs[r].record.edit(|samples| {
        let column = &mut samples.readings[slot.column];
        let first = chance.random_range(0..=column.len() - length);
        for reading in &mut column[first..first + length] {
            let more: f64 = StandardNormal.sample(&mut *chance);
            *reading = within(&slot, *reading + sign * sigma * size * (1.0 + 0.3 * more.abs()));
        }
    });
}

/// From a moment in one run on, in its first three quarters, `length` readings at most are those of
/// samples that come `periods` later; readings that no sample has are missing.
pub(super) fn lost_samples(
    problem: &mut Problem,
    periods: usize,
    length: usize,
    chance: &mut ChaCha12Rng,
) {
    let Some((p, r, ..)) = one_run(problem, 4 * (periods + 1), chance) else { return };
    problem.parts[p].runs[r].record.edit(|samples| {
        let count = samples.len();
        let first = chance.random_range(0..3 * count / 4);
        for column in &mut samples.readings {
            for sample in first..count.min(first + length) {
                column[sample] = column.get(sample + periods).copied().unwrap_or(f64::NAN);
            }
        }
    });
}
