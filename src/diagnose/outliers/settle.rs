//! The nominal fit, without what keeps it from settling or spoils it: outliers, a run or two
//! that are wrong as wholes (another unit, another setup, another clock), lost samples.

use crate::campaign::record::Change;
use crate::diagnose::found::{LeftOut, Lost};
use crate::engine::{Point, Problem};
use crate::estimate::batch::{FitError, Options};
use crate::estimate::calibrate::{Calibration, calibrate};

use super::limits::{without_outliers_at, without_wrong_at};
use super::lost::{self, Elsewhere, SPOILT};
use super::{Clean, Cleaned};

/// Rounds of leaving outliers out.
const PEELS: usize = 6;

/// Runs that are left out one at a time where the fit does not settle: of so few none stands
/// out as wrong, of so many each one takes too long.
const RUNS: std::ops::RangeInclusive<usize> = 4..=100;

/// Runs that may be wrong together.
const WRONG: usize = 2;
/// They are where the factor without them is so many times less, and not even by so much without
/// another in the place of the last one.
pub(super) const SOUND_WITHOUT: f64 = 50.0;
const SPOILT_WITHOUT: f64 = 4.0;

/// Leaves out what keeps the nominal fit from settling, and fits again: outliers, or what is
/// an outlier where the fit settles once a run or two are left out. `None` where it settles.
pub(super) fn settled(whole: &Calibration, options: &Options) -> Cleaned {
    if whole.fit.outcome.is_result() {
        return Ok(None);
    }
    let (nominal, left_out) = peeled(whole.clone(), LeftOut::default(), options)?;
    if !nominal.fit.outcome.is_result()
        && let Some(found) = without_wrong(&whole.problem, None, options)?
    {
        return Ok(Some(found));
    }
    Ok(Some((nominal, left_out)))
}

/// Leaves out what is far out where the fit is sound without a run or two that spoil it, and fits
/// again; `None` where there are no such runs.
pub(super) fn without_spoiling(nominal: &Calibration, options: &Options) -> Cleaned {
    if !is_spoilt(nominal) || !nominal.is_sound() {
        return Ok(None);
    }
    let found = without_wrong(&nominal.problem, nominal.variance_factor(), options)?;
    // What all readings determine is not to be lost with some of them.
    Ok(found.filter(|(rest, _)| rest.is_sound()))
}

/// Leaves out what is far out where the fit is sound without a run or two, and fits again. `spoilt` is
/// the variance factor of the fit of all, where that settled: then some run is an outlier as a whole.
fn without_wrong(problem: &Problem, spoilt: Option<f64>, options: &Options) -> Cleaned {
    let Some(point) = without_runs(problem, spoilt, options)? else { return Ok(None) };
    let (rest, found) = without_wrong_at(problem, &point);
    if found.runs.is_empty() && (spoilt.is_some() || found.is_empty()) {
        return Ok(None);
    }
    peeled(calibrate(rest, options)?, found, options).map(Some)
}

/// Whether a fit leaves far more than noise, though it may have settled.
pub(super) fn is_spoilt(nominal: &Calibration) -> bool {
    nominal.variance_factor().is_some_and(|factor| factor > SPOILT)
}

/// Leaves outliers out, as they are seen from where the fit stopped, until it settles.
fn peeled(
    mut nominal: Calibration,
    mut left_out: LeftOut,
    options: &Options,
) -> Result<Clean, FitError> {
    for _ in 0..PEELS {
        if nominal.fit.outcome.is_result() {
            break;
        }
        let (rest, found) = without_outliers_at(&nominal.problem, &nominal.fit.point);
        if found.is_empty() {
            break;
        }
        left_out.extend(found);
        nominal = calibrate(rest, options)?;
    }
    Ok((nominal, left_out))
}

/// Where the fit is sound without a run or two, which are to be seen from there; at least where it
/// settles without one, if that of all did not. `spoilt` is the variance factor of the fit of all.
fn without_runs(
    problem: &Problem,
    spoilt: Option<f64>,
    options: &Options,
) -> Result<Option<Point>, FitError> {
    let of = |p: usize| (0..problem.parts[p].runs.len()).map(move |run| (p, run));
    let mut runs: Vec<(usize, usize)> = (0..problem.parts.len()).flat_map(of).collect();
    if !RUNS.contains(&runs.len()) {
        return Ok(None);
    }
    let (mut rest, mut known, mut settled) = (problem.clone(), spoilt, None);
    let limit = spoilt.map_or(SPOILT, |factor| factor / SOUND_WITHOUT);
    for _ in 0..WRONG {
        let mut found = Vec::new();
        for (p, run) in &runs {
            let fit = calibrate(without(&rest, *p, *run), options)?;
            let settles = fit.fit.outcome.is_result();
            let factor = fit.variance_factor().filter(|factor| factor.is_finite());
            found.extend(factor.map(|factor| (factor, settles, (*p, *run), fit.fit.point)));
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let next = found.get(1).map_or(f64::INFINITY, |one| one.0);
        let Some((factor, settles, (p, run), point)) = found.into_iter().next() else { break };
        let is_alone = known.is_none_or(|known| SPOILT_WITHOUT * next > known);
        if settles && factor < limit && is_alone {
            return Ok(Some(point));
        }
        if settles && settled.is_none() {
            settled = Some(point);
        }
        runs.retain(|one| *one != (p, run));
        (rest, known) = (without(&rest, p, run), Some(factor));
    }
    Ok(settled.filter(|_| spoilt.is_none()))
}

/// A problem without the readings of a run.
fn without(problem: &Problem, part: usize, run: usize) -> Problem {
    let mut rest = problem.clone();
    let record = &mut rest.parts[part].runs[run].record;
    *record = record.changed(Change::WithoutReadings);
    rest
}

/// Leaves lost samples out and fits again, until no more are found (`None` where there are none); and
/// they with the jumps of clocks that the last fit shows. Those that are known are not looked for.
pub(super) fn without_lost(
    nominal: &Calibration,
    known: Option<&Elsewhere>,
    options: &Options,
) -> Result<(Option<Calibration>, Elsewhere), FitError> {
    let without = |now: &Calibration, lost: &[Lost]| {
        let mut problem = now.problem.clone();
        lost::leave_out(&mut problem, lost);
        calibrate(problem, options)
    };
    if let Some(known) = known {
        let is_any = !known.lost.is_empty();
        let rest = is_any.then(|| without(nominal, &known.lost)).transpose()?;
        return Ok((rest, known.clone()));
    }
    let (mut rest, mut found) = (None, Elsewhere::default());
    for _ in 0..lost::LOOKS {
        let now = rest.as_ref().unwrap_or(nominal);
        let more = lost::look(&now.problem, &now.fit.point, now.variance_factor(), options)?;
        found.jumps = more.jumps;
        if more.lost.is_empty() {
            break;
        }
        let next = without(now, &more.lost)?;
        found.lost.extend(more.lost);
        rest = Some(next);
    }
    Ok((rest, found))
}
