//! Readings that repeat the one before them bit for bit: for a few samples, or for long stretches in
//! which the inputs move on.
//!
//! A log that goes on after the instrument has lost its target repeats the last reading; a start that
//! is searched with such readings in it may end anywhere. Whether they are wrong is not judged here:
//! an instrument at rest or at its limit repeats readings, too.

use std::ops::Range;

use crate::campaign::signal::Track;
use crate::diagnostic::Diagnostic;
use crate::engine::{Part, Problem};
use crate::estimate::residuals::OfRun;

/// A long stretch has so many samples at least.
pub(crate) const LONG: usize = 20;
/// It is so large a part of the readings of its run at least.
const PART: f64 = 0.05;
/// Part of the other readings that may repeat the one before: more is a coarse display.
const OTHERS: f64 = 0.2;
/// Part of its span in the run that some input passes through in the stretch.
const MOVES: f64 = 0.2;
/// Samples of a stretch at which inputs are asked for.
const MOMENTS: usize = 64;

/// The samples of each run whose readings of a measurand repeat the one before them; what is missing
/// between them counts as repeated.
pub(crate) fn repeats(part: &Part, measurand: usize) -> Vec<Vec<Range<usize>>> {
    let slot = &part.slots()[measurand];
    let columns: Vec<Vec<Vec<f64>>> = slot.columns().map(|one| part.readings_of(one)).collect();
    let of_run = |run: usize| {
        let read = |sample: usize| columns.iter().map(move |runs| runs[run][sample].to_bits());
        let mut found: Vec<Range<usize>> = Vec::new();
        let mut last: Option<usize> = None;
        for sample in (0..columns[0][run].len()).filter(|at| !columns[0][run][*at].is_nan()) {
            if let Some(before) = last.filter(|before| read(*before).eq(read(sample))) {
                match found.last_mut() {
                    Some(range) if range.end == before + 1 => range.end = sample + 1,
                    _ => found.push(sample..sample + 1),
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
        let in_memory = part.runs.iter().all(|run| run.record.is_in_memory());
        for measurand in (0..part.slots().len()).filter(|_| in_memory) {
            let readings: Vec<usize> =
                (0..part.runs.len()).map(|run| part.present_in(run)[measurand]).collect();
            for (run, repeats) in repeats(part, measurand).into_iter().enumerate() {
                let is_long = |one: &Range<usize>| {
                    one.len() >= LONG && one.len() as f64 >= PART * readings[run] as f64
                };
                let (long, short): (Vec<_>, Vec<_>) = repeats.into_iter().partition(is_long);
                let count = |all: &[Range<usize>]| all.iter().map(Range::len).sum::<usize>();
                let others = readings[run].saturating_sub(count(&long));
                if count(&short) as f64 > OTHERS * others as f64 {
                    continue;
                }
                let of = OfRun { part: p, measurand, run };
                let moves = long.into_iter().filter(|samples| moves(part, run, samples));
                found.extend(moves.map(|samples| (of, samples)));
            }
        }
    }
    found
}

/// A problem without long repeats; `None` where there are none.
pub(crate) fn without_long_repeats(problem: &Problem) -> Option<Problem> {
    let long = long_repeats(problem);
    let mut rest = (!long.is_empty()).then(|| problem.clone())?;
    for (of, samples) in long {
        let part = &mut rest.parts[of.part];
        let columns = part.slots()[of.measurand].columns();
        part.runs[of.run].record.leave_out([(samples, columns)]);
    }
    Some(rest)
}

/// Whether some input passes through a good part of its span within some samples of a run.
fn moves(part: &Part, run: usize, samples: &Range<usize>) -> bool {
    let record = &part.runs[run].record;
    let all = record.whole();
    let span = |track: &Track, range: Range<usize>| {
        let step = (range.len() / MOMENTS).max(1);
        let values = range.step_by(step).map(|at| track.at(at, all.time[at], 0.0, 0));
        let values = values.filter(|value: &f64| !value.is_nan());
        let ends = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
            [low.min(value), high.max(value)]
        });
        ends[1] - ends[0]
    };
    record.inputs().iter().any(|track| {
        let whole = span(track, 0..all.len());
        whole > 0.0 && span(track, samples.clone()) >= MOVES * whole
    })
}

/// A warning for each campaign in which readings repeat for long while inputs move.
pub fn warnings(problem: &Problem) -> Vec<Diagnostic> {
    let long = long_repeats(problem);
    let of_part = long.chunk_by(|a, b| a.0.part == b.0.part);
    let words = of_part.filter_map(|all| {
        let (of, samples) = all.iter().max_by_key(|one| one.1.len())?;
        let (together, others): (Vec<_>, Vec<_>) =
            all.iter().partition(|one| (one.0.run, &one.1) == (of.run, samples));
        let measurands = together.iter().map(|one| format!("`{}`", one.0.names(problem).1));
        let record = &problem.parts[of.part].runs[of.run].record;
        let rows = record.rows(&[samples.start, samples.end - 1]);
        let message = format!(
            "{} {} bit for bit in rows {} to {} of run `{}`{}, while inputs move",
            measurands.collect::<Vec<_>>().join(", "),
            if together.len() == 1 { "repeats its reading" } else { "repeat their readings" },
            rows.first()?,
            rows.last()?,
            of.names(problem).0,
            match others.len() {
                0 => String::new(),
                1 => ", and in 1 more stretch".to_owned(),
                more => format!(", and in {more} more stretches"),
            }
        );
        let help = "has the instrument lost its target, or is it at its limit? the search for a start passes over these rows, a fit uses them: `homepoint diagnose` judges them";
        Some(Diagnostic::warning(message).help(help))
    });
    words.collect()
}
