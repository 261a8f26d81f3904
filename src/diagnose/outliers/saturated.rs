//! Saturated readings: a converter or an amplifier shows the limit of its range, whatever is beyond.
//!
//! The largest or the smallest reading of a measurand stands there far more often than others come
//! back, bit for bit. That alone may be an end stop, or an instrument at rest: readings are saturated
//! where a model that is fitted to the others predicts them beyond the limit.

use crate::diagnose::found::NoReading;
use crate::engine::Problem;
use crate::estimate::batch::Options;
use crate::estimate::calibrate::Calibration;
use crate::estimate::residuals::{Far, Residuals};
use crate::statistics::median_size;

use super::Cleaned;
use super::suspects::{Suspect, without_suspects};

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

/// Leaves saturated readings out and fits again; `None` where there are none.
pub(super) fn without_saturated(nominal: &Calibration, options: &Options) -> Cleaned {
    without_suspects(nominal, limits(&nominal.problem), is_passed, NoReading::Limit, options)
}

/// Whether a fit without the readings at a limit predicts them beyond it.
fn is_passed(limit: &Suspect, all: &Residuals) -> bool {
    let (own, others) = limit.apart(all);
    let count = own.iter().filter(|residual| -limit.side * **residual > 0.0).count();
    let others = median_size(&others).unwrap_or(0.0);
    count as f64 >= BEYOND * own.len() as f64
        && median_size(&own).is_some_and(|size| size > FAR * others)
}

/// The numbers at the ends of what measurands of one component read that may be limits.
pub(super) fn limits(problem: &Problem) -> Vec<Suspect> {
    let mut limits = Vec::new();
    for (p, part) in problem.parts.iter().enumerate() {
        for (measurand, slot) in part.slots().iter().enumerate().filter(|(_, one)| one.width == 1) {
            let runs = part.readings_of(slot.column);
            for (value, side) in ends(&runs) {
                let at = |run: &Vec<f64>| {
                    run.iter().copied().enumerate().filter(|one| one.1 == value).collect()
                };
                let at: Far = runs.iter().map(at).collect();
                let places = |run: &Vec<(usize, f64)>| run.chunk_by(|a, b| b.0 - a.0 == 1).count();
                if at.iter().map(places).sum::<usize>() >= PLACES {
                    limits.push(Suspect { of: (p, measurand), at, side });
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
    let ends = [(same.first(), -1.0), (same.last(), 1.0)];
    ends.into_iter()
        .filter_map(|(end, sign)| Some((end.filter(|end| is_often(end))?[0], sign)))
        .collect()
}
