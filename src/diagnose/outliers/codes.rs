//! Codes in the place of readings: the 0, -1 or 99999 that some instruments write where they lost
//! their target.
//!
//! A number that comes back to its last digit, in a few places at least, is no measurement where it
//! stands apart from all others by far, or where no other comes back nearly as often and what is
//! read before is far off it. Codes are looked for in the readings themselves, before any model,
//! only where the model's own parameters do not settle or leave far too much, and stay out if they
//! are outliers from where they do nothing. Numbers that are wrong and differ are for [`super::limits`]
//! and `spikes`.

use std::collections::BTreeMap;

use crate::diagnose::found::NoReading;
use crate::engine::Part;
use crate::engine::part::Slot;
use crate::estimate::batch::Options;
use crate::estimate::calibrate::Calibration;
use crate::estimate::residuals::{Far, Residuals, seen_from};
use crate::statistics::{median_size, robust};

use super::Cleaned;
use super::limits::{OUTLIER, has_beyond};
use super::settle::is_spoilt;
use super::suspects::{Suspect, without_suspects};

/// A measurand has so many codes at most: of more numbers those that are there most often count.
const MOST: usize = 8;
/// A code stands in so many places at least, in runs of which it is not the most.
const PLACES: usize = 3;
/// It is apart from all others by so many times the range that half of them have,
const APART: f64 = 3.0;
/// or there so many times as often as others are,
const AS_OFTEN: usize = 10;
/// and so many times as far off the readings before it as these are off each other.
const JUMP: f64 = 5.0;

/// Leaves codes out where the nominal fit does not settle, is spoilt or may hide it, and fits
/// again; `None` where there are none.
pub(super) fn without_codes(whole: &Calibration, options: &Options) -> Cleaned {
    if !is_in_doubt(whole) {
        return Ok(None);
    }
    let parts = whole.problem.parts.iter().enumerate();
    let suspects = parts.flat_map(|(number, part)| codes_of(number, part)).collect();
    without_suspects(whole, suspects, is_far_out, NoReading::Code, options)
}

/// Whether a fit may be spoilt: it does not settle, leaves far too much or some reading far beyond
/// the others, or has levels of its own, which grow with what is left.
fn is_in_doubt(whole: &Calibration) -> bool {
    let has_outlier = |one: &Residuals| has_beyond(one, OUTLIER);
    !whole.fit.outcome.is_result()
        || is_spoilt(whole)
        || !whole.levels.is_empty()
        || seen_from(&whole.problem, &whole.fit.point).iter().any(has_outlier)
}

/// Whether most readings in whose place codes would stand are outliers, as they are of none.
fn is_far_out(codes: &Suspect, all: &Residuals) -> bool {
    let (own, others) = codes.apart(all);
    let Some(size) = median_size(&own) else { return true };
    robust(&others).is_some_and(|deviation| size > OUTLIER * deviation)
}

/// The codes of each measurand of a campaign that has some. A rotation that is a code has a code in
/// some component, and comes back with all of them.
fn codes_of(number: usize, part: &Part) -> Vec<Suspect> {
    let of_slot = |(measurand, slot): (usize, &Slot)| {
        let columns: Vec<Vec<Vec<f64>>> = slot.columns().map(|one| part.readings_of(one)).collect();
        let codes: Vec<Vec<f64>> = columns.iter().map(|runs| codes(runs)).collect();
        let whole = |run: usize, sample: usize| -> Vec<u64> {
            columns.iter().map(|runs| runs[run][sample].to_bits()).collect()
        };
        let mut found: Far = vec![Vec::new(); part.runs.len()];
        let mut places: BTreeMap<Vec<u64>, usize> = BTreeMap::new();
        for (run, found) in found.iter_mut().enumerate() {
            for sample in 0..columns[0][run].len() {
                let held = columns.iter().zip(&codes);
                let mut held = held.map(|(runs, codes)| (runs[run][sample], codes));
                if let Some((code, _)) = held.find(|(value, codes)| codes.contains(value)) {
                    found.push((sample, code));
                    *places.entry(whole(run, sample)).or_default() += 1;
                }
            }
        }
        for (run, found) in found.iter_mut().enumerate() {
            found.retain(|(sample, _)| places[&whole(run, *sample)] >= PLACES);
        }
        let is_any = found.iter().any(|run| !run.is_empty());
        is_any.then_some(Suspect { of: (number, measurand), at: found, side: 0.0 })
    };
    part.slots().iter().enumerate().filter_map(of_slot).collect()
}

/// The numbers among the readings of some runs that are codes.
fn codes(runs: &[Vec<f64>]) -> Vec<f64> {
    let present = |run: &Vec<f64>| run.iter().copied().filter(|x| !x.is_nan()).collect();
    let runs: Vec<Vec<f64>> = runs.iter().map(present).collect();
    let mut sorted = runs.concat();
    sorted.sort_by(f64::total_cmp);
    let half = sorted.len() / 2;
    let range =
        (0..sorted.len() - half).map(|k| sorted[k + half] - sorted[k]).min_by(f64::total_cmp);
    let Some(range) = range.filter(|range| *range > 0.0) else { return Vec::new() };
    let same: Vec<&[f64]> = sorted.chunk_by(|a, b| a == b).collect();
    // How often the reading in the middle is there, if they are put in the order of that.
    let mut often: Vec<usize> = same.iter().flat_map(|all| all.iter().map(|_| all.len())).collect();
    often.sort_unstable();
    let usual = often[half.min(often.len() - 1)];
    let is_apart = |k: usize| {
        let beside = [k.checked_sub(1), Some(k + 1)].into_iter().flatten();
        let mut beside = beside.filter_map(|k| same.get(k));
        beside.all(|other| (same[k][0] - other[0]).abs() > APART * range)
    };
    let is_often = |k: usize| same[k].len() >= AS_OFTEN * usual;
    let many = (0..same.len()).filter(|k| same[*k].len() >= PLACES);
    let mut found: Vec<usize> = many.filter(|k| is_apart(*k) || is_often(*k)).collect();
    found.sort_by_key(|k| std::cmp::Reverse(same[*k].len()));
    found.truncate(MOST);
    found.retain(|k| is_apart(*k) || is_jump(&runs, same[*k][0]));
    found.retain(|k| is_scattered(&runs, same[*k][0]));
    found.into_iter().map(|k| same[k][0]).collect()
}

/// Whether a number comes back in a few places, in runs of which it is not the most.
fn is_scattered(runs: &[Vec<f64>], code: f64) -> bool {
    let mut places = 0;
    for run in runs {
        if 2 * run.iter().filter(|value| **value == code).count() <= run.len() {
            let groups = run.chunk_by(|a, b| (*a == code) == (*b == code));
            places += groups.filter(|group| group[0] == code).count();
        }
    }
    places >= PLACES
}

/// Whether what is read before a number is far off it.
fn is_jump(runs: &[Vec<f64>], code: f64) -> bool {
    let (mut to_code, mut others) = (Vec::new(), Vec::new());
    for run in runs {
        for pair in run.windows(2).filter(|pair| pair[0] != code) {
            let step = (pair[1] - pair[0]).abs();
            if pair[1] == code {
                to_code.push(step);
            } else if step > 0.0 {
                others.push(step);
            }
        }
    }
    let other = median_size(&others).unwrap_or(f64::INFINITY);
    median_size(&to_code).is_some_and(|to| to > JUMP * other)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A motion and its readings to a digit.
    fn motion(run: usize, digit: f64) -> Vec<f64> {
        let at = |k: usize| 2.0 + 0.3 * (0.05 * k as f64 + run as f64).sin();
        (0..300).map(|k| (at(k) / digit).round() * digit).collect()
    }

    fn with(code: f64, every: usize, digit: f64) -> Vec<f64> {
        let mut runs: Vec<Vec<f64>> = (0..4).map(|run| motion(run, digit)).collect();
        runs.iter_mut().for_each(|run| run.iter_mut().step_by(every).for_each(|x| *x = code));
        codes(&runs)
    }

    #[test]
    fn what_stands_apart_or_among_others() {
        for code in [0.0, -1.0, 99_999.0] {
            assert_eq!(with(code, 100, 1e-7), [code]);
            assert_eq!(with(code, 3, 1e-7), [code]);
        }
        // Among the readings themselves a number must be there far more often than others.
        assert_eq!(with(2.0, 10, 1e-7), [2.0]);
        assert!(with(2.0, 150, 1e-4).is_empty());
    }

    #[test]
    fn rests_turning_points_and_frozen_logs_are_none() {
        // Digits as coarse as a part in a hundred of the motion, which comes back to its ends.
        for digit in [1e-6, 1e-4, 3e-3, 0.1] {
            assert!(codes(&[motion(0, digit), motion(1, digit), motion(2, digit)]).is_empty());
        }
        // A place on a coarse display to which some runs come back, beside motion on a fine one.
        let mut stops = motion(3, 1e-6);
        for k in 0..100 {
            stops[3 * k..3 * k + 3].fill([2.1, 2.1, 2.1, 1.9][k % 4] + 1e-4 * (k % 7) as f64);
        }
        assert!(codes(&[motion(0, 1e-6), motion(1, 1e-6), motion(2, 1e-6), stops]).is_empty());
        // A run at rest, and a rest within others.
        let mut resting = motion(0, 1e-6);
        resting[40..100].fill(2.5);
        assert!(codes(&[resting.clone(), vec![2.5; 300], motion(1, 1e-6)]).is_empty());
        assert!(codes(&[vec![2.0; 300]]).is_empty());
        assert!(codes(&[]).is_empty());
        assert!(codes(&[vec![f64::NAN; 9]]).is_empty());
    }
}
