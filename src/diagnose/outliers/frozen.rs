//! Frozen readings: a receiver or a log that repeats its last value bit for bit while the instrument
//! moves on.
//!
//! Noise repeats no value, and a display repeats it only while the instrument moves by less than its
//! last digit. Repeats are frozen where the prediction leaves them by many times what residuals
//! change by from one reading to the next, and the reading after them is back at the prediction.
//! What sticks, like a gear with backlash, moves on from where it stood: that is structure. So are
//! repeats all over a run: an instrument that is logged more often than it reads.

use std::ops::Range;

use crate::diagnose::found::{NoReading, Wrong};
use crate::engine::Problem;
use crate::estimate::batch::Options;
use crate::estimate::calibrate::{Calibration, calibrate};
use crate::estimate::repeats::{Repeated, long_repeats, repeats, without};
use crate::estimate::residuals::{Residuals, residuals_from};
use crate::statistics::robust;

use super::Cleaned;
use super::left_out::{OfSamples, rare, without_stretches};
use super::saturated::limits;
use super::suspects::{Suspect, without_suspects};

/// Fewer repeats are none.
const FEWEST: usize = 3;
/// The prediction moves on by so many standard deviations of a residual's changes; by fewer from a long
/// stretch while inputs move, which chance does not repeat.
const MOVED: f64 = 20.0;
const MOVED_FROM_LONG: f64 = 10.0;
/// So many times less must the variance factor of a fit without long repeats be to judge them.
const FAR_SMALLER: f64 = 4.0;
/// The reading after the repeats is back within this part of that.
const BACK: f64 = 0.25;

/// Leaves frozen readings out and fits again; `None` where there are none.
pub(super) fn without_frozen(nominal: &Calibration, options: &Options) -> Cleaned {
    let problem = &nominal.problem;
    let long = long_repeats(problem);
    let view = without_long(nominal, &long, options);
    let point = &view.as_ref().unwrap_or(nominal).fit.point;
    let all = residuals_from(problem, point);
    let frozen = frozen(problem, &all, &long);
    if frozen.is_empty() {
        return Ok(None);
    }
    let mut at_limit = limits(problem);
    at_limit.retain(|limit| stands_often_at(limit, &frozen));
    if !at_limit.is_empty() {
        return without_suspects(nominal, at_limit, |_, _| true, NoReading::Limit, options);
    }
    without_stretches(nominal, (point, &all), frozen, Wrong::Repeated, options)
}

/// The fit without long repeats, which they do not bend, where it is sound and far better.
fn without_long(
    nominal: &Calibration,
    long: &[OfSamples],
    options: &Options,
) -> Option<Calibration> {
    let view = calibrate(without(&nominal.problem, long)?, options).ok()?;
    let factor = |one: &Calibration| one.variance_factor().unwrap_or(f64::INFINITY);
    let is_better = view.is_sound() && FAR_SMALLER * factor(&view) < factor(nominal);
    is_better.then_some(view)
}

/// Whether stretches stand at a limit again and again: an instrument is saturated there, though the
/// model was too wrong to predict readings beyond it.
fn stands_often_at(limit: &Suspect, frozen: &[OfSamples]) -> bool {
    let stands = |(of, samples): &&OfSamples| {
        (of.part, of.measurand) == limit.of && limit.in_place_of(of.run, samples.start).is_some()
    };
    frozen.iter().filter(stands).count() > 1
}

/// The stretches of frozen readings. Where one measurand is frozen, repeats of others beside it
/// are, too, though these may have moved by little.
fn frozen(problem: &Problem, all: &[Residuals], long: &[OfSamples]) -> Vec<OfSamples> {
    let (mut frozen, mut beside) = (Vec::new(), Vec::new());
    for own in all.chunk_by(|a, b| a.of() == b.of()) {
        let (p, measurand) = own[0].of();
        let part = &problem.parts[p];
        let repeats = repeats(part, measurand);
        let deviation = |one: &Residuals| change(one, &repeats).max(part.sigma[measurand]);
        let deviations: Vec<f64> = own.iter().map(deviation).collect();
        for (run, repeats) in repeats.iter().enumerate() {
            for Repeated { samples, .. } in repeats.iter().filter(|one| one.readings >= FEWEST) {
                let of = (own[0].in_run(run), samples.clone());
                let by = if long.contains(&of) { MOVED_FROM_LONG } else { MOVED };
                let is_left = own.iter().zip(&deviations).any(|(one, deviation)| {
                    is_left_behind(&one.runs[run], samples, by * deviation)
                });
                if is_left { frozen.push(of) } else { beside.push(of) }
            }
        }
    }
    beside.retain(|(of, samples)| {
        let of_run = |one: &&OfSamples| (one.0.part, one.0.run) == (of.part, of.run);
        let shared = frozen.iter().filter(of_run).map(|(_, other)| {
            other.end.min(samples.end).saturating_sub(other.start.max(samples.start))
        });
        2 * shared.max().unwrap_or(0) > samples.len()
    });
    frozen.append(&mut beside);
    // A log that goes on to its end without a target may be most of a run.
    let (long, short) = frozen.into_iter().partition(|one| long.contains(one));
    [long, rare(problem, short, |_, _| false)].concat()
}

/// The robust standard deviation of a residual, from its changes between readings that repeat none.
fn change(one: &Residuals, repeats: &[Vec<Repeated>]) -> f64 {
    let mut changes = Vec::new();
    for (run, repeats) in repeats.iter().enumerate() {
        let is_repeat = |sample: usize| {
            let at = repeats.partition_point(|one| one.samples.end <= sample);
            repeats.get(at).is_some_and(|one| one.samples.contains(&sample))
        };
        let readings = one.readings(run);
        let pairs = readings.windows(2).filter(|pair| !is_repeat(pair[1].0));
        changes.extend(pairs.map(|pair| pair[1].1 - pair[0].1));
    }
    robust(&changes).map_or(f64::INFINITY, |deviation| deviation / 2.0_f64.sqrt())
}

/// Whether the prediction moves on by so much from readings that are repeated, and the reading after
/// them is back at it. While a reading stands still, its residual is what the prediction moves by.
fn is_left_behind(residuals: &[f64], repeats: &Range<usize>, least: f64) -> bool {
    let there = |value: &&f64| !value.is_nan();
    let Some(first) = residuals[..repeats.start].iter().rev().find(there) else { return false };
    let moved = residuals[repeats.clone()].iter().filter(there);
    let moved = moved.map(|value| (value - first).abs()).fold(0.0, f64::max);
    let after = residuals[repeats.end..].iter().find(there);
    moved > least && after.is_none_or(|after| (after - first).abs() <= BACK * moved)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_stands_still_and_comes_back_is_left_behind() {
        let freeze = [0.1, -0.2, 5.0, 10.0, 15.0, 0.3];
        assert!(is_left_behind(&freeze, &(2..5), 10.0));
        assert!(!is_left_behind(&freeze, &(2..5), 20.0));
        // To the end of a run; backlash, which moves on from where it stood.
        assert!(is_left_behind(&freeze[..5], &(2..5), 10.0));
        assert!(!is_left_behind(&[0.1, -0.2, 5.0, 10.0, 15.0, 15.1], &(2..5), 10.0));
    }
}
