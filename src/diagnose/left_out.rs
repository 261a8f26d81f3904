//! Readings that are left out, and how they are told: by row, once for all components, with how far out they were.
//!
//! Which ones those are is judged elsewhere ([`super::wild`], `codes`, `spikes`, `alone`).

use std::collections::BTreeSet;

use crate::engine::Problem;
use crate::engine::layout::qualified;

use super::apart::Apart;
use super::sequences::Sequence;
use super::structure::Place;

/// A reading that is left out because it is wild or a code, or because its run is wrong.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOut {
    /// Name of the run.
    pub run: String,
    /// Row of its data file.
    pub row: usize,
    /// The measurand.
    pub measurand: String,
    /// How far out it was, in robust standard deviations of its measurand.
    pub deviations: f64,
    /// Whether all readings of the measurand in the run are, for it is wrong there.
    pub of_run: bool,
}

/// What is left out.
#[derive(Clone, Debug, Default)]
pub struct Trimmed {
    /// Single readings.
    pub wild: Vec<LeftOut>,
    /// All those of a measurand in runs that are wrong as wholes.
    pub of_runs: Vec<LeftOut>,
    /// Those runs.
    pub apart: Vec<Apart>,
}

impl Trimmed {
    /// Whether it is nothing.
    pub fn is_empty(&self) -> bool {
        self.wild.is_empty() && self.of_runs.is_empty()
    }

    /// Adds what is left out later.
    pub fn extend(&mut self, later: Self) {
        self.wild.extend(later.wild);
        self.of_runs.extend(later.of_runs);
        self.apart.extend(later.apart);
    }
}

/// Samples and residuals of readings of a sequence, by run.
pub(super) type Far = Vec<Vec<(usize, f64)>>;

/// A measurand of a run of a campaign.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct OfRun {
    pub(super) part: usize,
    pub(super) measurand: usize,
    pub(super) run: usize,
}

/// What was listed already: campaign, run, measurand and sample.
pub(super) type Listed = BTreeSet<(usize, usize, usize, usize)>;

/// Leaves readings of sequences out and lists them.
pub(super) fn readings_out(problem: &mut Problem, all: &[Sequence], far: &[Far]) -> Trimmed {
    let (mut trimmed, mut listed) = (Trimmed::default(), Listed::new());
    for (one, far) in all.iter().zip(far) {
        trimmed.extend(told(problem, one, far, &[], &mut listed));
        leave_out(problem, one, far);
    }
    trimmed
}

/// Leaves all readings of measurands in some runs out and lists them.
pub(super) fn runs_out(problem: &mut Problem, all: &[Sequence], off: &BTreeSet<OfRun>) -> Trimmed {
    let (mut trimmed, mut listed) = (Trimmed::default(), Listed::new());
    for one in all {
        let wrong: Vec<usize> = (0..one.runs.len()).filter(|run| one.is_among(off, *run)).collect();
        let readings = |run| if wrong.contains(&run) { one.readings(run) } else { Vec::new() };
        let far: Far = (0..one.runs.len()).map(readings).collect();
        trimmed.extend(told(problem, one, &far, &wrong, &mut listed));
    }
    leave_runs_out(problem, all, off);
    trimmed
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
pub(super) fn leave_runs_out(problem: &mut Problem, all: &[Sequence], off: &BTreeSet<OfRun>) {
    for one in all {
        let part = &mut problem.parts[one.part];
        let columns = part.slots()[one.measurand].columns();
        for (number, run) in part.runs.iter_mut().enumerate() {
            if one.is_among(off, number) {
                run.record.leave_out([(0..run.record.len(), columns.clone())]);
            }
        }
    }
}

/// Readings of a sequence that are left out, as they are told: those that are not listed yet, and those of `wrong`
/// runs as of such.
pub(super) fn told(
    problem: &Problem,
    one: &Sequence,
    far: &Far,
    wrong: &[usize],
    listed: &mut Listed,
) -> Trimmed {
    let mut trimmed = Trimmed::default();
    let deviation = one.deviation().unwrap_or(1.0);
    let part = &problem.parts[one.part];
    let name = &part.system.assembly.names.measurands[one.measurand].name;
    for (number, (run, far)) in part.runs.iter().zip(far).enumerate() {
        let called = qualified(part.label.as_deref(), &run.name);
        let of_run = wrong.contains(&number);
        let new =
            |(sample, _): &&(usize, f64)| listed.insert((one.part, number, one.measurand, *sample));
        let each = far.iter().filter(new).map(|(sample, value)| LeftOut {
            run: called.clone(),
            row: run.record.row(*sample),
            measurand: name.clone(),
            deviations: *value / deviation,
            of_run,
        });
        if !of_run {
            trimmed.wild.extend(each);
        } else if !far.is_empty() {
            trimmed.of_runs.extend(each);
            trimmed.apart.push(Apart { block: None, place: Place::of_run(name, &called) });
        }
    }
    trimmed
}
