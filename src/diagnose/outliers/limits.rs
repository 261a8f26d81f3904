//! Outliers: those beyond [`OUTLIER`] robust standard deviations go before anything else is
//! judged, the farthest first, and are listed by row: what they do to the fit would pass for
//! jitter, for noisier runs and for more outliers. Runs of which most readings are that far out go
//! as wholes, and so do runs of which nothing is left. Where many readings are far out the noise has
//! long tails and none is left out.
//!
//! Single outliers of a sound fit are for [`crate::diagnose::budget::noise`].

use std::collections::BTreeSet;

use crate::diagnose::found::{LeftOut, Wrong};
use crate::engine::{Point, Problem};
use crate::estimate::residuals::{Far, OfRun, Residuals, seen_from};
use crate::statistics::robust;

use super::left_out::{readings_out, stretches_out};

/// Outliers are so many robust standard deviations out, of their measurand and of it in their run.
pub(super) const OUTLIER: f64 = 20.0;
/// Of outliers those go at once that are at least this part of the farthest: that one may
/// have put the others there.
const PEELED: f64 = 0.1;
/// Runs of which most readings of a measurand are far out, and so many at least, are left out as
/// wholes: so many runs at most, and one of so many.
const LEAST_WRONG: usize = 10;
pub(super) const RUNS_APART: usize = 3;
pub(super) const ONE_OF: usize = 4;
/// Where more readings than this share are far out, the noise has long tails and none is left out.
pub(super) const MOST_OUTLIERS: f64 = 0.05;

/// The campaigns without outliers, and these, as seen from a point that a fit ran to and did not
/// settle at: one reading of 99999 among thousands keeps it from that.
pub(super) fn without_outliers_at(problem: &Problem, point: &Point) -> (Problem, LeftOut) {
    trimmed(problem, point, PEELED, limit)
}

/// The same from a point that a fit of most runs settled at: a run may be an outlier as a whole there.
pub(super) fn without_wrong_at(problem: &Problem, point: &Point) -> (Problem, LeftOut) {
    trimmed(problem, point, 0.0, |one, _| OUTLIER * one.deviation)
}

/// Whether some reading is so many robust standard deviations out among all.
pub(super) fn has_beyond(one: &Residuals, deviations: f64) -> bool {
    one.present().any(|value| value.abs() > deviations * one.deviation)
}

/// Beyond what a reading of a run is an outlier.
pub(super) fn limit(one: &Residuals, run: usize) -> f64 {
    OUTLIER * robust(one.runs[run].iter()).unwrap_or(0.0).max(one.deviation)
}

/// Leaves readings beyond a limit out and lists them, each once, however many components it has.
fn trimmed(
    problem: &Problem,
    point: &Point,
    peeled: f64,
    limit: impl Fn(&Residuals, usize) -> f64,
) -> (Problem, LeftOut) {
    let mut rest = problem.clone();
    let all = seen_from(problem, point);
    let far: Vec<Far> = all.iter().map(|one| one.beyond(|run| limit(one, run))).collect();
    let wrong = wrong_runs(&all, &far);
    let single = |(one, far)| among_others(one, far, &wrong, peeled);
    let far: Vec<Far> = all.iter().zip(far).map(single).collect();
    let readings = readings_out(&mut rest, &all, &far);
    let whole = |of: &OfRun| (*of, 0..problem.parts[of.part].runs[of.run].record.len());
    let wrong: Vec<_> = wrong.iter().map(whole).collect();
    let runs = stretches_out(&mut rest, &all, &wrong, Wrong::FarOut);
    let found = LeftOut { readings, runs, ..LeftOut::default() };
    (rest.without_undetermined_runs(), found)
}

/// Of readings that are far out those in runs that are not wrong and, if these are not too many, at
/// least some part of the farthest.
fn among_others(one: &Residuals, mut far: Far, wrong: &BTreeSet<OfRun>, peeled: f64) -> Far {
    let others = (0..far.len()).filter(|run| !wrong.contains(&one.in_run(*run)));
    let count: usize = others.map(|run| far[run].len()).sum();
    let too_many = count as f64 > MOST_OUTLIERS * one.present().count() as f64;
    let farthest = one.present().map(f64::abs).fold(0.0, f64::max);
    for (run, far) in far.iter_mut().enumerate() {
        let stays = too_many || wrong.contains(&one.in_run(run));
        far.retain(|(_, value)| !stays && value.abs() >= peeled * farthest);
    }
    far
}

/// The runs of which most readings of a measurand, in some component, are far out; none where they
/// are too many to be exceptions.
fn wrong_runs(all: &[Residuals], far: &[Far]) -> BTreeSet<OfRun> {
    let mut wrong = BTreeSet::new();
    for (one, far) in all.iter().zip(far) {
        let is_wrong = |run: &usize| {
            let count = far[*run].len();
            count >= LEAST_WRONG && 2 * count > one.readings(*run).len()
        };
        wrong.extend((0..far.len()).filter(is_wrong).map(|run| one.in_run(run)));
    }
    for one in all {
        let count = (0..one.runs.len()).filter(|run| wrong.contains(&one.in_run(*run))).count();
        if count > RUNS_APART || ONE_OF * count > one.runs.len() {
            wrong.retain(|run| run.of() != one.of());
        }
    }
    wrong
}
