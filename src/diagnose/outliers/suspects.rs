//! Readings that may be none: error codes, and limits at which an instrument is saturated.
//!
//! All of them are left out first. The caller confirms them by their residuals from the fit without
//! them; the others are put back, and so on until all that are out are confirmed. Other wrong readings,
//! such as a stretch that is frozen, do not bend that fit: it is trimmed where it leaves a large misfit.

use crate::diagnose::found::{LeftOut, NoReading};
use crate::engine::Point;
use crate::estimate::batch::{FitError, Options};
use crate::estimate::calibrate::Calibration;
use crate::estimate::refit::calibrate_near;
use crate::estimate::residuals::{Far, Residuals, leave_out, seen_from};

use super::Cleaned;
use super::left_out::{if_sound, listed};
use super::lost::{GROSS_FACTOR, robust_fit};

/// Readings of a measurand that may be none.
pub(super) struct Suspect {
    /// The campaign and the measurand in it.
    pub(super) of: (usize, usize),
    /// Samples with the number that stands there, by run.
    pub(super) at: Far,
    /// Where that is a limit, the sign of how far readings would be beyond it; else 0.
    pub(super) side: f64,
}

impl Suspect {
    /// The residuals of the readings, and those of all others of the measurand.
    pub(super) fn apart(&self, all: &Residuals) -> (Vec<f64>, Vec<f64>) {
        let (mut own, mut others) = (Vec::new(), Vec::new());
        for (run, residuals) in all.runs.iter().enumerate() {
            for (sample, residual) in residuals.iter().enumerate() {
                let apart =
                    if self.in_place_of(run, sample).is_some() { &mut own } else { &mut others };
                apart.push(*residual);
            }
        }
        (own, others)
    }

    /// The number in the place of a sample's reading.
    pub(super) fn in_place_of(&self, run: usize, sample: usize) -> Option<f64> {
        let at = self.at[run].binary_search_by_key(&sample, |at| at.0).ok()?;
        Some(self.at[run][at].1)
    }
}

/// Leaves suspects out that are confirmed by the residuals of a component of their measurand, seen
/// from the fit without them; `None` where none is, or where only the fit of all is sound.
pub(super) fn without_suspects(
    nominal: &Calibration,
    mut suspects: Vec<Suspect>,
    is_confirmed: impl Fn(&Suspect, &Residuals) -> bool,
    instead: fn(f64) -> NoReading,
    options: &Options,
) -> Cleaned {
    let problem = &nominal.problem;
    let (fitted, seen) = loop {
        if suspects.is_empty() {
            return Ok(None);
        }
        let mut rest = problem.clone();
        suspects.iter().for_each(|one| leave_out(&mut rest, one.of, &one.at));
        let fitted = calibrate_near(rest, &nominal.fit.point, options)?;
        let seen = seen_from(problem, &robust_point(&fitted, options)?);
        let known = suspects.len();
        suspects.retain(|suspect| {
            let mut own = seen.iter().filter(|one| one.of() == suspect.of);
            own.any(|one| is_confirmed(suspect, one))
        });
        if suspects.len() == known {
            break (fitted, seen);
        }
    };
    let number = |one: &Residuals, run: usize, sample: usize| {
        let mut own = suspects.iter().filter(|suspect| suspect.of == one.of());
        own.find_map(|suspect| suspect.in_place_of(run, sample)).map(instead)
    };
    let out = |one: &Residuals| -> Far {
        let of_run = |run: usize| {
            let readings = one.runs[run].iter().copied().enumerate();
            readings.filter(|(sample, _)| number(one, run, *sample).is_some()).collect()
        };
        (0..one.runs.len()).map(of_run).collect()
    };
    let far: Vec<Far> = seen.iter().map(out).collect();
    let readings = listed(problem, &seen, &far, number);
    Ok(if_sound(nominal, fitted, LeftOut { readings, ..LeftOut::default() }))
}

/// Where a fit ends, by a robust one where it leaves a large misfit.
fn robust_point(fitted: &Calibration, options: &Options) -> Result<Point, FitError> {
    let point = &fitted.fit.point;
    if fitted.variance_factor().is_some_and(|factor| factor > GROSS_FACTOR) {
        let robust = robust_fit(&fitted.problem, point, false, options)?;
        if robust.converged {
            return Ok(robust.point);
        }
    }
    Ok(point.clone())
}
