//! The nominal fit, without what keeps it from settling: gross readings, runs that are wrong as wholes (another
//! unit, another setup, another clock), lost samples.

use crate::campaign::record::Change;
use crate::engine::{Point, Problem};
use crate::estimate::batch::{FitError, Options, Outcome};
use crate::estimate::calibrate::{Calibration, calibrate};

use super::lost::{self, Lost};
use super::whiten::PEELS;
use super::wild::{Trimmed, without_gross_at, without_wrong_at};

/// Runs that are left out one at a time where the fit does not settle: of so few none can be told to be
/// wrong, of so many each one takes too long.
const RUNS: std::ops::RangeInclusive<usize> = 4..=100;

/// Leaves out what keeps the nominal fit from settling, and fits again: gross readings, or what is gross where
/// the fit settles once some run is left out.
pub(super) fn without_gross(
    whole: Calibration,
    options: &Options,
) -> Result<(Calibration, Trimmed), FitError> {
    let problem = whole.problem.clone();
    let (nominal, gross) = peeled(whole, Trimmed::default(), options)?;
    if nominal.fit.outcome == Outcome::Converged {
        return Ok((nominal, gross));
    }
    let Some(point) = without_a_run(&problem, options)? else { return Ok((nominal, gross)) };
    let (rest, found) = without_wrong_at(&problem, &point);
    if found.is_empty() {
        return Ok((nominal, gross));
    }
    peeled(calibrate(rest, options)?, found, options)
}

/// Leaves gross readings out, as they are seen from where the fit stopped, until it settles.
fn peeled(
    mut nominal: Calibration,
    mut gross: Trimmed,
    options: &Options,
) -> Result<(Calibration, Trimmed), FitError> {
    for _ in 0..PEELS {
        if nominal.fit.outcome == Outcome::Converged {
            break;
        }
        let (rest, found) = without_gross_at(&nominal.problem, &nominal.fit.point);
        if found.is_empty() {
            break;
        }
        gross.extend(found);
        nominal = calibrate(rest, options)?;
    }
    Ok((nominal, gross))
}

/// Where the fit settles once some run is left out: the best such place, from which that run is to be seen.
fn without_a_run(problem: &Problem, options: &Options) -> Result<Option<Point>, FitError> {
    let of = |p: usize| (0..problem.parts[p].runs.len()).map(move |run| (p, run));
    let runs: Vec<(usize, usize)> = (0..problem.parts.len()).flat_map(of).collect();
    let mut best: Option<(f64, Point)> = None;
    for (p, run) in runs.iter().copied().filter(|_| RUNS.contains(&runs.len())) {
        let mut rest = Problem::new(problem.parts.clone());
        let record = &mut rest.parts[p].runs[run].record;
        *record = record.changed(Change::WithoutReadings);
        let found = calibrate(rest, options)?;
        let Some(factor) =
            found.variance_factor().filter(|_| found.fit.outcome == Outcome::Converged)
        else {
            continue;
        };
        let is_best = best.as_ref().is_none_or(|(least, _)| factor < *least);
        if is_best {
            best = Some((factor, found.fit.point));
        }
    }
    Ok(best.map(|(_, point)| point))
}

/// Leaves lost samples out and fits again, until none are found.
pub(super) fn without_lost(
    whole: Calibration,
    options: &Options,
) -> Result<(Calibration, Vec<Lost>), FitError> {
    let (mut nominal, mut lost) = (whole, Vec::new());
    for _ in 0..lost::LOOKS {
        let factor = nominal.variance_factor();
        let more = lost::look(&nominal.problem, &nominal.fit.point, factor, options)?;
        if more.is_empty() {
            break;
        }
        let mut problem = nominal.problem.clone();
        lost::leave_out(&mut problem, &more);
        lost.extend(more);
        nominal = calibrate(problem, options)?;
    }
    Ok((nominal, lost))
}
