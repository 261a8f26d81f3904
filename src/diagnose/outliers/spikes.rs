//! Outliers that bend the nominal fit, seen from one that they do not bend.
//!
//! Some readings that a display repeats, or a log that stands still for a moment, are thousands of
//! uncertainties off, and so is what is read while a beam is broken. The fit bends towards them,
//! and others look worse than they do. It is trimmed, therefore (`estimate::trimmed`), beyond a part
//! of all readings at least; where much is wrong the trimmed fit is the one of least scatter of
//! several starts. What is far out from there and stands in `bursts`, alone or with a few
//! neighbours is left out, and judged once more beside the effects that were found; what rises and
//! falls is structure. All others are judged with the noise (`limits`).

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::diagnose::found::{LeftOut, Wrong};
use crate::engine::gram::LeastSquares;
use crate::engine::{Point, Problem};
use crate::estimate::batch::{FitError, Options};
use crate::estimate::calibrate::Calibration;
use crate::estimate::observability::examine;
use crate::estimate::refit::calibrate_near;
use crate::estimate::residuals::{Far, Residuals, seen_from};
use crate::estimate::trimmed::{TrimmedFit, drawn_starts, starts, trimmed_fit};
use crate::estimate::withheld::limits;

use super::Cleaned;
use super::bursts::{FAR, TRIM, bursts};
use super::left_out::{OfSamples, if_sound, readings_out, stretches_out};
use super::limits::{ONE_OF, RUNS_APART, has_beyond, limit};
use super::lost::GROSS_FACTOR;
use super::records::Records;
use super::settle::is_spoilt;

/// Fits until the same readings are out; from other starts.
const STEPS: usize = 12;
const STEPS_OF_OTHERS: usize = 5;
/// Part of the readings of a measurand that is out of such a fit at most, and of spikes for good;
/// where the others scatter so many times as stated at most, they are right, and more may go.
const TRIMMED: f64 = 0.4;
const MOST: f64 = 0.15;
const MOST_BESIDE_RIGHT: f64 = 0.35;
const RIGHT: f64 = 2.0;
/// More next to each other, beyond this part of what is far out, are no spikes.
const NEIGHBOURS: usize = 5;
const FOOT: f64 = 0.25;

/// Leaves outliers out that bend a fit, and fits again; `None` where there are none.
pub(super) fn without_spikes(nominal: &Calibration, options: &Options) -> Cleaned {
    let whole = &nominal.problem;
    let is_far_out = nominal.variance_factor().is_some_and(|factor| factor > GROSS_FACTOR);
    let has_far = || seen_from(whole, &nominal.fit.point).iter().any(|one| has_beyond(one, FAR));
    if !nominal.is_sound() || !(is_far_out || has_far()) {
        return Ok(None);
    }
    let Some(TrimmedFit { seen, point, .. }) = sturdiest(nominal, options)? else {
        return Ok(None);
    };
    let mut rest = whole.clone();
    let found = spikes_out(&mut rest, &seen);
    if found.is_empty() {
        return Ok(None);
    }
    Ok(if_sound(nominal, calibrate_near(rest, &point, options)?, found))
}

/// Leaves bursts and spikes out that are seen from a fit that they do not bend, and lists them.
fn spikes_out(problem: &mut Problem, seen: &[Residuals]) -> LeftOut {
    let bursts = bursts(problem, seen);
    let stretches = stretches_out(problem, seen, &bursts, Wrong::FarOut);
    let others: Vec<Residuals> = seen.iter().map(|one| without(one, &bursts)).collect();
    let most = |one: &Residuals| {
        let stated = problem.parts[one.part].sigma[one.measurand];
        if one.deviation <= RIGHT * stated { MOST_BESIDE_RIGHT } else { MOST }
    };
    let far: Vec<Far> = others.iter().map(|one| spikes(one, most(one))).collect();
    let readings = readings_out(problem, &others, &far);
    LeftOut { readings, stretches, ..LeftOut::default() }
}

/// Bursts and spikes that were left out.
#[derive(Clone, Debug)]
pub struct Spikes {
    /// They.
    pub left_out: LeftOut,
    /// The readings with them.
    records: Records,
}

impl Spikes {
    /// None of the readings of a problem.
    pub(in crate::diagnose) fn none(problem: &Problem) -> Self {
        Self { left_out: LeftOut::default(), records: Records::of(problem) }
    }

    /// Judges them again from where another model of the same readings was fitted: what this model
    /// explains comes back, and what effects hid is left out. Whether that is something else.
    pub(in crate::diagnose) fn judge(&mut self, problem: &mut Problem, point: &Point) -> bool {
        let before = Records::of(problem);
        self.records.put_into(problem);
        let seen = seen_from(problem, point);
        let found = spikes_out(problem, &seen);
        let is_same = places(&found) == places(&self.left_out);
        if is_same {
            before.put_into(problem);
        } else {
            self.left_out = found;
        }
        !is_same
    }
}

/// Run, measurand, first and last row of what is left out, in order.
fn places(left_out: &LeftOut) -> BTreeSet<(&str, &str, usize, usize)> {
    let readings = left_out.readings.iter();
    let readings = readings.map(|one| (&*one.run, &*one.measurand, one.row, one.row));
    let stretches = left_out.stretches.iter();
    let stretches = stretches.map(|one| (&*one.run, &*one.measurand, one.rows.0, one.rows.1));
    readings.chain(stretches).collect()
}

/// The trimmed fit of least robust scatter, of those that determine all parameters if there are any: from
/// where the fit of all stopped and, where that is spoilt, from fits to parts of the runs.
fn sturdiest(nominal: &Calibration, options: &Options) -> Result<Option<TrimmedFit>, FitError> {
    let whole = &nominal.problem;
    let mut fits = vec![trimmed_fit(whole, &nominal.fit.point, STEPS, farthest, options)?];
    if is_spoilt(nominal) {
        let of_parts = starts(whole, &nominal.fit.point, options).map(|(point, _)| point);
        for point in of_parts.chain(drawn_starts(whole, &nominal.fit.point, options)) {
            fits.extend(trimmed_fit(whole, &point, STEPS_OF_OTHERS, farthest, options).ok());
        }
    }
    let scatter = |one: &TrimmedFit| -> f64 {
        let of = |one: &Residuals| one.present().count() as f64 * one.deviation.ln();
        one.seen.iter().filter(|one| !one.deviation.is_nan()).map(of).sum()
    };
    fits.retain(|one| one.converged);
    fits.sort_by(|a, b| scatter(a).total_cmp(&scatter(b)));
    // Without all readings that determine a parameter the others may scatter less.
    let limits = limits(whole, &nominal.fit);
    let determines = |one: &TrimmedFit| {
        let examined = examine(&one.rest.normal(&one.point), &limits);
        examined.is_ok_and(|found| found.directions.is_empty())
    };
    let best = fits.iter().position(determines).unwrap_or(0);
    Ok(fits.into_iter().nth(best))
}

/// A sequence without its readings in some stretches.
fn without(one: &Residuals, stretches: &[OfSamples]) -> Residuals {
    let mut runs = one.runs.clone();
    for (of, samples) in stretches.iter().filter(|(of, _)| of.of() == one.of()) {
        Arc::make_mut(&mut runs[of.run])[samples.clone()].fill(f64::NAN);
    }
    Residuals::new(one.of(), runs)
}

/// The readings of a sequence that are far out, the farthest if they are too many, by run.
fn farthest(one: &Residuals) -> Far {
    let mut sizes: Vec<f64> = one.present().map(f64::abs).collect();
    sizes.sort_by(f64::total_cmp);
    let kept = (sizes.len() as f64 * (1.0 - TRIMMED)) as usize;
    let most = sizes.get(kept).copied().unwrap_or(f64::INFINITY);
    one.beyond(|_| most.max(TRIM * one.deviation))
}

/// The outliers of a sequence with the few next to them that are far out, too, by run: those in small
/// groups; none where they are more than a part of all readings, or where larger groups, which are
/// structure, are in more than a few runs.
fn spikes(one: &Residuals, most: f64) -> Far {
    let none = || vec![Vec::new(); one.runs.len()];
    let (mut all, mut long) = (none(), 0);
    for (run, out) in all.iter_mut().enumerate() {
        let limit = limit(one, run);
        let readings = one.readings(run);
        let is_far = |value: f64| value.abs() > FOOT * limit;
        let groups = readings.chunk_by(|before, after| is_far(before.1) && is_far(after.1));
        let is_far_out = |group: &&[(usize, f64)]| group.iter().any(|one| one.1.abs() > limit);
        let groups: Vec<&[(usize, f64)]> = groups.filter(is_far_out).collect();
        // A larger group is what the run has for itself.
        if groups.iter().all(|group| group.len() <= NEIGHBOURS) {
            *out = groups.concat();
        } else {
            long += 1;
        }
    }
    let count: usize = all.iter().map(Vec::len).sum();
    let are_few = long <= RUNS_APART && (long < 2 || ONE_OF * long <= all.len());
    let are_too_many = count as f64 > most * one.present().count() as f64;
    if are_too_many || !are_few { none() } else { all }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::diagnose::outliers::limits::OUTLIER;
    use crate::estimate::residuals::samples;

    #[test]
    fn what_stands_alone_is_a_spike() {
        let mut run: Vec<f64> = (0..400).map(|k| [0.7, -1.0, 1.2, -0.4][k % 4]).collect();
        (run[40], run[41], run[90]) = (60.0, -70.0, 50.0);
        let one = Residuals::new((0, 0), vec![Arc::new(run.clone())]);
        let found = |one: &Residuals| samples(&spikes(one, MOST)).concat();
        assert_eq!(found(&one), [40, 41, 90]);
        assert!(has_beyond(&one, OUTLIER));
        assert_eq!(farthest(&one)[0].len(), 3);
        // Where a run has a longer group, it has something for itself.
        run[200..220].fill(90.0);
        let one = Residuals::new((0, 0), vec![Arc::new(run)]);
        assert!(found(&one).is_empty());
    }

    #[test]
    fn a_step_and_a_crest_are_none() {
        let noise = |k: usize| [1.0, 1.0, -1.0, -1.0][k % 4];
        // A step about the limit: half of its readings are beyond.
        let limit = OUTLIER * crate::statistics::NORMAL;
        let step: Vec<f64> = (0..400)
            .map(|k| noise(k) + if (200..230).contains(&k) { limit } else { 0.0 })
            .collect();
        let crest = |k: usize| 1.1 * limit * (-0.5 * ((k as f64 - 300.0) / 4.0).powi(2)).exp();
        let crest: Vec<f64> = (0..400).map(|k| noise(k) + crest(k)).collect();
        // The same where every second reading is missing.
        let every_second = |run: &[f64]| {
            run.iter()
                .enumerate()
                .map(|(k, value)| if k % 2 == 0 { *value } else { f64::NAN })
                .collect()
        };
        for run in [step.clone(), crest.clone(), every_second(&step), every_second(&crest)] {
            let one = Residuals::new((0, 0), vec![Arc::new(run)]);
            assert!(has_beyond(&one, OUTLIER));
            assert_eq!(spikes(&one, MOST)[0], []);
        }
    }
}
