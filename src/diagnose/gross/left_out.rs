//! Readings that are left out, and how they are told: single ones by row, once for all components,
//! with how far out they were; those of a measurand in a run, or a stretch of it, that is wrong as
//! a whole by their number.
//!
//! Which ones those are is judged elsewhere ([`super::wild`], `codes`, `frozen`, `bursts`,
//! `spikes`).

use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;

use crate::diagnose::found::{LeftOut, Reading, Stretch};
use crate::diagnose::library::place::Place;
use crate::diagnose::sequences::{OfRun, Sequence};
use crate::engine::Problem;
use crate::engine::layout::qualified;
use crate::estimate::median::upper_median;

/// Samples and residuals of readings of a sequence, by run.
pub(super) type Far = Vec<Vec<(usize, f64)>>;

/// Some samples of a measurand in a run.
pub(super) type OfSamples = (OfRun, Range<usize>);

/// Leaves readings of sequences out and lists them.
pub(super) fn readings_out(problem: &mut Problem, all: &[Sequence], far: &[Far]) -> LeftOut {
    let readings = told(problem, all, far, |_, _, _| None);
    all.iter().zip(far).for_each(|(one, far)| leave_out(problem, one, far));
    LeftOut { readings, ..LeftOut::default() }
}

/// Leaves all readings of measurands in some runs out and lists them; `place` says where each is
/// off.
pub(super) fn runs_out(
    problem: &mut Problem,
    all: &[Sequence],
    off: &BTreeSet<OfRun>,
    place: impl Fn(&Problem, OfRun) -> Place,
) -> LeftOut {
    let told = |one: &OfRun| stretch(problem, all, &whole(problem, *one), place(problem, *one));
    let runs = off.iter().filter_map(told).collect();
    leave_runs_out(problem, off);
    LeftOut { runs, ..LeftOut::default() }
}

/// Leaves readings of a sequence out.
pub(super) fn leave_out(problem: &mut Problem, one: &Sequence, far: &Far) {
    let part = &mut problem.parts[one.part];
    let columns = part.slots()[one.measurand].columns();
    for (run, far) in part.runs.iter_mut().zip(far) {
        let groups = far.chunk_by(|before, after| after.0 == before.0 + 1);
        let range = |group: &[(usize, f64)]| group[0].0..group[0].0 + group.len();
        run.record.leave_out(groups.map(|group| (range(group), columns.clone())));
    }
}

/// Leaves all readings of measurands in some runs out.
fn leave_runs_out(problem: &mut Problem, off: &BTreeSet<OfRun>) {
    let off: Vec<OfSamples> = off.iter().map(|one| whole(problem, *one)).collect();
    leave_samples_out(problem, &off);
}

/// Leaves stretches of readings out and lists them; `repeats` where they repeat the reading before.
pub(super) fn stretches_out(
    problem: &mut Problem,
    all: &[Sequence],
    off: &[OfSamples],
    repeats: bool,
) -> LeftOut {
    let told = |one: &OfSamples| {
        let (run, measurand) = one.0.names(problem);
        let place = Place::of_run(&measurand, &run);
        Some(Stretch { repeats, ..stretch(problem, all, one, place)? })
    };
    let stretches = off.iter().filter_map(told).collect();
    leave_samples_out(problem, off);
    LeftOut { stretches, ..LeftOut::default() }
}

/// Leaves readings of measurands in some samples of runs out.
fn leave_samples_out(problem: &mut Problem, off: &[OfSamples]) {
    for (one, samples) in off {
        let part = &mut problem.parts[one.part];
        let columns = part.slots()[one.measurand].columns();
        part.runs[one.run].record.leave_out([(samples.clone(), columns)]);
    }
}

fn whole(problem: &Problem, one: OfRun) -> OfSamples {
    (one, 0..problem.parts[one.part].runs[one.run].record.len())
}

/// Readings of sequences as they are told, each once; `code` says which code stands in a sample of
/// a run.
pub(super) fn told(
    problem: &Problem,
    all: &[Sequence],
    far: &[Far],
    code: impl Fn(&Sequence, usize, usize) -> Option<f64>,
) -> Vec<Reading> {
    let (mut readings, mut listed) = (Vec::new(), BTreeSet::new());
    for (one, far) in all.iter().zip(far) {
        let deviation = one.deviation().unwrap_or(1.0);
        let part = &problem.parts[one.part];
        let names = &part.system.assembly.names.measurands;
        let measurand: Arc<str> = names[one.measurand].name.as_str().into();
        for (number, (run, far)) in part.runs.iter().zip(far).enumerate() {
            let mut new = far.clone();
            new.retain(|(at, _)| listed.insert((one.part, number, one.measurand, *at)));
            let samples: Vec<usize> = new.iter().map(|(sample, _)| *sample).collect();
            let called: Arc<str> = qualified(part.label.as_deref(), &run.name).into();
            let rows = run.record.rows(&samples);
            readings.extend(new.iter().zip(rows).map(|((sample, value), row)| Reading {
                run: Arc::clone(&called),
                row,
                measurand: Arc::clone(&measurand),
                deviations: *value / deviation,
                code: code(one, number, *sample),
            }));
        }
    }
    readings
}

/// Samples of a measurand in a run of which all readings are left out, as they are told; `None`
/// where no readings are there.
fn stretch(
    problem: &Problem,
    all: &[Sequence],
    (off, samples): &OfSamples,
    place: Place,
) -> Option<Stretch> {
    let is_own = |one: &&Sequence| (one.part, one.measurand) == (off.part, off.measurand);
    let part = &problem.parts[off.part];
    let run = &part.runs[off.run];
    let (run_name, measurand) = off.names(problem);
    let readings = |one: &Sequence| {
        let mut own = one.readings(off.run);
        own.retain(|(sample, _)| samples.contains(sample));
        own
    };
    let size = |one: &Sequence| {
        let mut sizes: Vec<f64> = readings(one).iter().map(|one| one.1.abs()).collect();
        Some(upper_median(&mut sizes)? / one.deviation().filter(|deviation| *deviation > 0.0)?)
    };
    let own: Vec<&Sequence> = all.iter().filter(is_own).collect();
    let there: Vec<(usize, f64)> = readings(own.first()?);
    let ends = [there.first()?.0, there.last()?.0];
    let rows = run.record.rows(&ends);
    Some(Stretch {
        place,
        run: run_name,
        measurand,
        readings: there.len(),
        rows: (*rows.first()?, *rows.last()?),
        repeats: false,
        deviations: own.iter().filter_map(|one| size(one)).fold(0.0, f64::max),
    })
}
