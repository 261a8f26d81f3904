//! Readings that repeat the one before them bit for bit: for a few samples, or for long stretches in
//! which inputs move on.
//!
//! A log that goes on after the instrument has lost its target repeats the last reading; a start that
//! is searched with such readings in it may end anywhere. Whether they are wrong is not judged here:
//! an instrument at rest or at its limit repeats readings, too. Runs that are not in memory are not
//! looked at.

use std::ops::Range;

use crate::campaign::Run;
use crate::campaign::signal::Track;
use crate::engine::{Part, Problem};
use crate::estimate::residuals::OfRun;

/// Least number of readings that a long stretch repeats, and least part of those of its run.
const LONG: usize = 20;
const LONG_PART: f64 = 0.05;
/// Long stretches of a measurand in a run at most: more of them are the steps of a display.
const STRETCHES: usize = 3;
/// Part of the other readings that may repeat the one before: more is a coarse display.
const OTHERS: f64 = 0.2;
/// Part of its span in the run that some input passes through in the stretch.
const MOVES: f64 = 0.2;
/// Readings of a measurand that must remain without long stretches, and the part of all.
const REMAINING: usize = 20;
const REMAINING_PART: f64 = 0.05;

/// A stretch of readings that repeat the one before it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Repeated {
    /// Its samples; what is missing between them counts as repeated.
    pub(crate) samples: Range<usize>,
    /// How many readings they have.
    pub(crate) readings: usize,
}

/// The repeated readings of a measurand, run after run.
pub(crate) fn repeats(part: &Part, measurand: usize) -> Vec<Vec<Repeated>> {
    let slot = &part.slots()[measurand];
    let columns: Vec<Vec<Vec<f64>>> = slot.columns().map(|one| part.readings_of(one)).collect();
    let of_run = |run: usize| {
        let read = |sample: usize| columns.iter().map(move |runs| runs[run][sample].to_bits());
        let mut found: Vec<Repeated> = Vec::new();
        let mut last: Option<usize> = None;
        for sample in (0..columns[0][run].len()).filter(|at| !columns[0][run][*at].is_nan()) {
            if let Some(before) = last.filter(|before| read(*before).eq(read(sample))) {
                match found.last_mut() {
                    Some(one) if one.samples.end == before + 1 => {
                        one.samples.end = sample + 1;
                        one.readings += 1;
                    }
                    _ => found.push(Repeated { samples: sample..sample + 1, readings: 1 }),
                }
            }
            last = Some(sample);
        }
        found
    };
    (0..part.runs.len()).map(of_run).collect()
}

/// The long stretches in which a reading repeats though inputs move.
pub(crate) fn long_repeats(problem: &Problem) -> Vec<(OfRun, Range<usize>)> {
    let mut found = Vec::new();
    for (p, part) in problem.parts.iter().enumerate() {
        if !part.runs.iter().all(|run| run.record.is_in_memory()) {
            continue;
        }
        let present: Vec<Vec<usize>> =
            (0..part.runs.len()).map(|run| part.present_in(run)).collect();
        for measurand in 0..part.slots().len() {
            let mut own = Vec::new();
            for (run, repeats) in repeats(part, measurand).into_iter().enumerate() {
                let long = long_of(&part.runs[run], present[run][measurand], repeats);
                let of = OfRun { part: p, measurand, run };
                own.extend(long.into_iter().map(|one| (of, one)));
            }
            let all: usize = present.iter().map(|run| run[measurand]).sum();
            let out: usize = own.iter().map(|(_, one)| one.readings).sum();
            let remaining = all - out;
            // What never changes is no lost target.
            if remaining >= REMAINING && remaining as f64 >= REMAINING_PART * all as f64 {
                found.extend(own.into_iter().map(|(of, one)| (of, one.samples)));
            }
        }
    }
    found
}

/// Those of a measurand in a run with so many readings that are long; none of a coarse display.
fn long_of(run: &Run, readings: usize, repeats: Vec<Repeated>) -> Vec<Repeated> {
    let is_long =
        |one: &Repeated| one.readings >= LONG && one.readings as f64 >= LONG_PART * readings as f64;
    let (mut long, short): (Vec<_>, Vec<_>) = repeats.into_iter().partition(is_long);
    let count = |all: &[Repeated]| all.iter().map(|one| one.readings).sum::<usize>();
    let others = readings - count(&long);
    if long.len() > STRETCHES || count(&short) as f64 > OTHERS * others as f64 {
        return Vec::new();
    }
    long.retain(|one| moves(run, &one.samples));
    long
}

/// A problem without its long repeats; `None` where there are none.
pub(crate) fn without(problem: &Problem, long: &[(OfRun, Range<usize>)]) -> Option<Problem> {
    let mut rest = (!long.is_empty()).then(|| problem.clone())?;
    for (of, samples) in long {
        let part = &mut rest.parts[of.part];
        let columns = part.slots()[of.measurand].columns();
        part.runs[of.run].record.leave_out([(samples.clone(), columns)]);
    }
    Some(rest)
}

/// Whether some input passes through a good part of its span within some samples of a run.
fn moves(run: &Run, samples: &Range<usize>) -> bool {
    let all = run.record.whole();
    let span = |track: &Track, range: Range<usize>| {
        let values = range.map(|at| track.at(at, all.time[at], 0.0, 0));
        let values = values.filter(|value: &f64| !value.is_nan());
        let ends = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
            [low.min(value), high.max(value)]
        });
        ends[1] - ends[0]
    };
    all.inputs.iter().any(|track| {
        let whole = span(track, 0..all.len());
        whole > 0.0 && span(track, samples.clone()) >= MOVES * whole
    })
}
