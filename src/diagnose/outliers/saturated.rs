//! Saturated readings: a converter or an amplifier shows the limit of its range, whatever is beyond.
//!
//! The largest or the smallest reading of a measurand stands there far more often than others come
//! back, bit for bit. That alone may be an end stop, or an instrument at rest: readings are saturated
//! where a model that is fitted to the others predicts them beyond the limit.

use crate::diagnose::found::{LeftOut, NoReading};
use crate::diagnose::sequences::{Sequence, median_size, seen_from};
use crate::engine::Problem;
use crate::estimate::batch::Options;
use crate::estimate::calibrate::{Calibration, calibrate};

use super::Cleaned;
use super::codes::readings;
use super::left_out::{Far, leave_out, listed};

/// A limit stands there so many times at least, in so many places, and so many times as often as the
/// usual reading; it is so large a part of all readings at most. In one place a log may be frozen.
const FEWEST: usize = 4;
const PLACES: usize = 2;
const AS_OFTEN: usize = 4;
const MOST: f64 = 0.5;
/// Part of what stands at a limit that is predicted beyond it, half of it by so many times the median
/// size of the other residuals.
const BEYOND: f64 = 0.9;
const FAR: f64 = 3.0;

/// A limit of a measurand, and where its readings stand at it, by run.
struct Limit {
    of: (usize, usize),
    value: f64,
    /// Readings beyond it would be larger (1), or smaller (-1).
    sign: f64,
    samples: Vec<Vec<usize>>,
}

/// Leaves saturated readings out and fits again; `None` where there are none.
pub(super) fn without_saturated(nominal: &Calibration, options: &Options) -> Cleaned {
    let problem = &nominal.problem;
    let mut limits = limits(problem);
    if limits.is_empty() {
        return Ok(None);
    }
    let mut seen = seen_from(problem, &nominal.fit.point);
    loop {
        let mut rest = problem.clone();
        let far: Vec<Far> = seen.iter().map(|one| far(one, &limits)).collect();
        seen.iter().zip(&far).for_each(|(one, far)| leave_out(&mut rest, one, far));
        let fitted = calibrate(rest, options)?;
        if nominal.is_sound() && !fitted.is_sound() {
            return Ok(None);
        }
        seen = seen_from(problem, &fitted.fit.point);
        let known = limits.len();
        limits.retain(|limit| seen.iter().any(|one| limit.is_passed(one)));
        if limits.is_empty() {
            return Ok(None);
        }
        if limits.len() == known {
            let far: Vec<Far> = seen.iter().map(|one| self::far(one, &limits)).collect();
            let limit = |one: &Sequence, run: usize, sample: usize| {
                let of = limits.iter().filter(|limit| limit.of == one.of());
                let mut at = of.filter(|limit| limit.samples[run].binary_search(&sample).is_ok());
                at.next().map(|limit| NoReading::Limit(limit.value))
            };
            let readings = listed(problem, &seen, &far, limit);
            return Ok(Some((fitted, LeftOut { readings, ..LeftOut::default() })));
        }
    }
}

impl Limit {
    /// Whether a fit without the readings at a limit predicts them beyond it.
    fn is_passed(&self, one: &Sequence) -> bool {
        if one.of() != self.of {
            return false;
        }
        let at = self.samples.iter().zip(&one.runs);
        let beyond: Vec<f64> =
            at.flat_map(|(at, run)| at.iter().map(|sample| -self.sign * run[*sample])).collect();
        let count = beyond.iter().filter(|by| **by > 0.0).count();
        let mut others = one.runs.iter().zip(&self.samples).flat_map(|(run, at)| {
            let is_other = move |sample: &usize| at.binary_search(sample).is_err();
            (0..run.len()).filter(is_other).map(|sample| &run[sample])
        });
        let others = median_size(&mut others).unwrap_or(0.0);
        count as f64 >= BEYOND * beyond.len() as f64
            && median_size(&beyond).is_some_and(|size| size > FAR * others)
    }
}

/// The residuals of a sequence where its readings stand at a limit.
fn far(one: &Sequence, limits: &[Limit]) -> Far {
    let of_run = |(number, run): (usize, &std::sync::Arc<Vec<f64>>)| {
        let own = limits.iter().filter(|limit| limit.of == one.of());
        let mut samples: Vec<usize> = own.flat_map(|limit| limit.samples[number].clone()).collect();
        samples.sort_unstable();
        samples.into_iter().map(|sample| (sample, run[sample])).collect()
    };
    one.runs.iter().enumerate().map(of_run).collect()
}

/// The numbers at the ends of what measurands of one component read that may be limits.
fn limits(problem: &Problem) -> Vec<Limit> {
    let mut limits = Vec::new();
    for (p, part) in problem.parts.iter().enumerate() {
        for (measurand, slot) in part.slots().iter().enumerate() {
            let mut columns = slot.columns();
            let (Some(column), None) = (columns.next(), columns.next()) else { continue };
            let runs = readings(part, column);
            for (value, sign) in ends(&runs) {
                let at = |run: &Vec<f64>| (0..run.len()).filter(|k| run[*k] == value).collect();
                let samples: Vec<Vec<usize>> = runs.iter().map(at).collect();
                let places = |run: &Vec<usize>| run.chunk_by(|a, b| b - a == 1).count();
                if samples.iter().map(places).sum::<usize>() >= PLACES {
                    limits.push(Limit { of: (p, measurand), value, sign, samples });
                }
            }
        }
    }
    limits
}

/// The smallest (-1) and the largest (1) of the readings of some runs, where it is there often.
fn ends(runs: &[Vec<f64>]) -> Vec<(f64, f64)> {
    let mut sorted: Vec<f64> = runs.concat();
    sorted.retain(|one| !one.is_nan());
    sorted.sort_by(f64::total_cmp);
    let same: Vec<&[f64]> = sorted.chunk_by(|a, b| a == b).collect();
    let mut often: Vec<usize> = same.iter().map(|all| all.len()).collect();
    often.sort_unstable();
    let usual = often.get(often.len() / 2).copied().unwrap_or(0);
    let is_often = |end: &&[f64]| {
        let count = end.len();
        count >= FEWEST.max(AS_OFTEN * usual) && count as f64 <= MOST * sorted.len() as f64
    };
    let ends = [(same.first(), -1.0), (same.last(), 1.0)].into_iter();
    let ends = ends.filter_map(|(end, sign)| Some((*end.filter(|end| is_often(end))?, sign)));
    ends.map(|(end, sign)| (end[0], sign)).collect()
}
