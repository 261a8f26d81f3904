//! Readings that are left out, and how they are listed: single ones by row, once for all components,
//! with how far out they were; a run or a stretch of it that is wrong as a whole by their number.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::Arc;

use crate::diagnose::found::{LeftOut, NoReading, Reading, Stretch, Wrong};
use crate::engine::{Part, Point, Problem};
use crate::estimate::batch::Options;
use crate::estimate::calibrate::Calibration;
use crate::estimate::refit::calibrate_near;
use crate::estimate::residuals::{Far, OfRun, Residuals, leave_out};
use crate::statistics::median_size;

use super::{Clean, Cleaned};

/// Part of a measurand's readings that may be wrong in stretches.
const MOST: f64 = 0.4;

/// Some samples of a measurand in a run.
pub(super) type OfSamples = (OfRun, Range<usize>);

/// The fit of the rest with what was left out; `None` where it is not sound, but that of all is.
pub(super) fn if_sound(
    nominal: &Calibration,
    rest: Calibration,
    left_out: LeftOut,
) -> Option<Clean> {
    (rest.is_sound() || !nominal.is_sound()).then_some((rest, left_out))
}

/// Leaves stretches out, in order, and fits again from a point or near it; `None` where there are none.
pub(super) fn without_stretches(
    nominal: &Calibration,
    (point, all): (&Point, &[Residuals]),
    found: Vec<OfSamples>,
    how: Wrong,
    options: &Options,
) -> Cleaned {
    if found.is_empty() {
        return Ok(None);
    }
    let mut rest = nominal.problem.clone();
    let stretches = stretches_out(&mut rest, all, &in_order(found), how);
    let left_out = LeftOut { stretches, ..LeftOut::default() };
    Ok(if_sound(nominal, calibrate_near(rest, point, options)?, left_out))
}

/// Stretches in order, without those of measurands that are structure or have too many of them.
pub(super) fn rare(
    problem: &Problem,
    mut found: Vec<OfSamples>,
    is_structure: impl Fn((usize, usize), &[OfSamples]) -> bool,
) -> Vec<OfSamples> {
    let mut counts: BTreeMap<(usize, usize), usize> = BTreeMap::new();
    for (of, samples) in &found {
        *counts.entry(of.of()).or_default() += samples.len();
    }
    let present: Vec<Vec<usize>> = problem.parts.iter().map(Part::present).collect();
    counts.retain(|of, count| {
        *count as f64 <= MOST * present[of.0][of.1] as f64 && !is_structure(*of, &found)
    });
    found.retain(|(of, _)| counts.contains_key(&of.of()));
    in_order(found)
}

/// Stretches in the order of campaigns, runs and time.
pub(super) fn in_order(mut found: Vec<OfSamples>) -> Vec<OfSamples> {
    found.sort_by_key(|(of, samples)| (of.part, of.run, samples.start, of.measurand));
    found
}

/// Leaves readings out that are far out, and lists them.
pub(super) fn readings_out(problem: &mut Problem, all: &[Residuals], far: &[Far]) -> Vec<Reading> {
    let readings = listed(problem, all, far, |_, _, _| None);
    all.iter().zip(far).for_each(|(one, far)| leave_out(problem, one.of(), far));
    readings
}

/// Leaves stretches of readings out and lists them, with what is wrong with them.
pub(super) fn stretches_out(
    problem: &mut Problem,
    all: &[Residuals],
    off: &[OfSamples],
    how: Wrong,
) -> Vec<Stretch> {
    let stretches = off.iter().filter_map(|one| stretch(problem, all, one, how)).collect();
    for (one, samples) in off {
        let part = &mut problem.parts[one.part];
        let columns = part.slots()[one.measurand].columns();
        part.runs[one.run].record.leave_out([(samples.clone(), columns)]);
    }
    stretches
}

/// Readings that are far out as they are listed, each once, with what stands `instead` of them.
pub(super) fn listed(
    problem: &Problem,
    all: &[Residuals],
    far: &[Far],
    instead: impl Fn(&Residuals, usize, usize) -> Option<NoReading>,
) -> Vec<Reading> {
    let (mut readings, mut listed) = (Vec::new(), BTreeSet::new());
    for (one, far) in all.iter().zip(far) {
        let part = &problem.parts[one.part];
        let names = &part.system.assembly.names.measurands;
        let measurand: Arc<str> = names[one.measurand].name.as_str().into();
        for (number, (run, far)) in part.runs.iter().zip(far).enumerate() {
            let mut new = far.clone();
            new.retain(|(at, _)| listed.insert((one.part, number, one.measurand, *at)));
            let samples: Vec<usize> = new.iter().map(|(sample, _)| *sample).collect();
            let called: Arc<str> = part.run_name(number).into();
            let rows = run.record.rows(&samples);
            readings.extend(new.iter().zip(rows).map(|((sample, value), row)| Reading {
                run: Arc::clone(&called),
                row,
                measurand: Arc::clone(&measurand),
                deviations: *value / one.deviation,
                instead: instead(one, number, *sample),
            }));
        }
    }
    readings
}

/// A stretch of which all readings are left out, as it is listed; `None` where it has none.
fn stretch(
    problem: &Problem,
    all: &[Residuals],
    (off, samples): &OfSamples,
    how: Wrong,
) -> Option<Stretch> {
    let (run, measurand) = off.names(problem);
    let own = || all.iter().filter(|one| one.of() == off.of());
    let mut there = own().next()?.readings(off.run);
    there.retain(|(sample, _)| samples.contains(sample));
    let ends = [there.first()?.0, there.last()?.0];
    let rows = problem.parts[off.part].runs[off.run].record.rows(&ends);
    let size =
        |one: &Residuals| Some(median_size(&one.runs[off.run][samples.clone()])? / one.deviation);
    let sizes = own().filter(|one| one.deviation > 0.0).filter_map(size);
    Some(Stretch {
        run,
        measurand,
        readings: there.len(),
        rows: (*rows.first()?, *rows.last()?),
        how,
        deviations: sizes.fold(0.0, f64::max),
    })
}
