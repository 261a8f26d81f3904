//! How readings differ from their neighbours in a run: what moves slowly adds nothing to that.

use std::collections::BTreeMap;
use std::f64::consts::SQRT_2;

use crate::diagnose::sequences::{NORMAL, seen_from};
use crate::engine::{Point, Problem};
use crate::estimate::median::upper_median;

/// Readings of a run from which on its scatter is looked at.
pub(super) const LEAST_READINGS: usize = 20;

/// Neighbours that differ so many times as much as is stated say that this is wrong.
const FAR: f64 = 10.0;

/// Lets stated uncertainties that are far too small follow how neighbours differ, before anything
/// is judged; whether some are. What is weighed far too much bends the fit of all else, and
/// everything is structure beside it. No effect does that: in a quarter of the runs, those in which
/// they differ least, it moves slowly.
pub(super) fn follow_neighbours(problem: &mut Problem, point: &Point) -> bool {
    let mut found: BTreeMap<(usize, usize), f64> = BTreeMap::new();
    for one in seen_from(problem, point) {
        let mut sizes: Vec<f64> = one.runs.iter().filter_map(|run| of_neighbours(run)).collect();
        sizes.sort_by(f64::total_cmp);
        let Some(quiet) = sizes.get(sizes.len() / 4) else { continue };
        let factor = quiet / problem.parts[one.part].sigma[one.measurand];
        if factor > FAR && factor.is_finite() {
            let known = found.entry((one.part, one.measurand)).or_insert(factor);
            *known = known.min(factor);
        }
    }
    for ((part, measurand), factor) in &found {
        problem.parts[*part].sigma[*measurand] *= factor;
    }
    !found.is_empty()
}

/// The standard deviation of a run's noise, from how neighbours differ: what moves slowly adds
/// nothing. `None` of few.
pub(in crate::diagnose) fn of_neighbours(run: &[f64]) -> Option<f64> {
    let pairs = run.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let mut sizes: Vec<f64> = pairs.filter(|size| !size.is_nan()).collect();
    let are_enough = sizes.len() >= LEAST_READINGS;
    upper_median(&mut sizes).filter(|_| are_enough).map(|size| NORMAL * size / SQRT_2)
}
