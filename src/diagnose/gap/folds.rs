//! Folds: which readings models are fitted to, and which they are judged on.
//!
//! Whole runs are left out in turn, or, with fewer than [`LEAST_RUNS`] runs, stretches of time with
//! a gap about them. Where parameters belong to a run, or to a setup with no other run, every other
//! eighth of each run is left out in turn: without the run they would not be known, and a clock's
//! rate learnt from a first half would have to be extrapolated over the second, where its error
//! hides what the effect does.

use crate::diagnose::fitted::Fitted;
use crate::engine::Problem;
use crate::engine::gram::{LeastSquares, Normal, RunGram};

/// Of fewer runs none is judged beside the others.
const LEAST_RUNS: usize = 4;
/// Folds in time.
const FOLDS: usize = 5;
/// Stretches that a run with parameters of its own is cut into.
const STRETCHES: usize = 8;

/// One fold: what is fitted to, and what is judged, as sums of each run.
pub(super) struct Fold {
    pub(super) training: Vec<RunGram>,
    pub(super) judged: Vec<(usize, RunGram)>,
}

/// The folds of a fitted model, of which these are the sums; `memory` from reading to reading
/// widens the gap about stretches of time.
pub(super) fn folds(fitted: &Fitted, normal: &Normal, memory: f64) -> Vec<Fold> {
    let runs = &normal.columns.runs;
    if runs.len() < LEAST_RUNS {
        return in_time(fitted, normal, memory);
    }
    let is_alone = |setup: usize| {
        let others = runs.iter().filter(|(other, _)| *other == setup).count();
        others == 1 && normal.columns.setups[setup] > 0
    };
    if runs.iter().any(|(setup, own)| *own > 0 || is_alone(*setup)) {
        return within_runs(fitted, normal);
    }
    let whole = |out: usize| {
        let mut training = normal.runs.clone();
        let empty = RunGram::empty(training[out].gram.nrows());
        let judged = std::mem::replace(&mut training[out], empty);
        Fold { training, judged: vec![(out, judged)] }
    };
    (0..runs.len()).map(whole).collect()
}

/// Every other eighth of each run, left out in turn.
pub(super) fn within_runs(fitted: &Fitted, normal: &Normal) -> Vec<Fold> {
    let learnt = kept(fitted, |length| move |sample| learns_from(sample, length));
    let rest = kept(fitted, |length| move |sample| !learns_from(sample, length));
    let fold = |(out, (learnt, judged)): (usize, (RunGram, RunGram))| {
        let mut training = normal.runs.clone();
        training[out] = learnt;
        Fold { training, judged: vec![(out, judged)] }
    };
    learnt.into_iter().zip(rest).enumerate().map(fold).collect()
}

/// Stretches of time of all runs, left out in turn with what noise of this memory makes like them.
fn in_time(fitted: &Fitted, normal: &Normal, memory: f64) -> Vec<Fold> {
    let time = if memory > 0.0 { (-1.0 / memory.ln()).ceil() as usize } else { 0 };
    (0..FOLDS)
        .map(|fold| {
            let range = move |length: usize| fold * length / FOLDS..(fold + 1) * length / FOLDS;
            let judged = kept(fitted, |length| move |sample| range(length).contains(&sample));
            let near = kept(fitted, |length| {
                let range = range(length);
                let wide = range.start.saturating_sub(time)..(range.end + time).min(length);
                move |sample| wide.contains(&sample)
            });
            let left = |(all, near): (&RunGram, RunGram)| RunGram {
                gram: &all.gram - near.gram,
                readings: all.readings - near.readings,
            };
            let training = normal.runs.iter().zip(near).map(left).collect();
            Fold { training, judged: judged.into_iter().enumerate().collect() }
        })
        .collect()
}

/// Whether a run's own parameters are fitted to a sample: to every other stretch.
pub(super) fn learns_from(sample: usize, length: usize) -> bool {
    (sample * STRETCHES / length.max(1)).is_multiple_of(2)
}

/// The sums with only some samples of each run, by its length.
fn kept<W: Fn(usize) -> bool>(fitted: &Fitted, wanted: impl Fn(usize) -> W) -> Vec<RunGram> {
    let mut problem = among(&fitted.problem, wanted);
    problem.reweight(&fitted.fit.point);
    problem.normal(&fitted.fit.point).runs
}

/// A problem with only some samples of each run, by its length.
pub(super) fn among<W: Fn(usize) -> bool>(
    problem: &Problem,
    wanted: impl Fn(usize) -> W,
) -> Problem {
    let mut parts = problem.parts.clone();
    for part in &mut parts {
        let columns = part.reading_columns();
        for run in &mut part.runs {
            let wanted = wanted(run.record.len());
            let samples: Vec<bool> = (0..run.record.len()).map(wanted).collect();
            let mut from = 0;
            for alike in samples.chunk_by(|a, b| a == b) {
                let to = from + alike.len();
                run.record.leave_out((!alike[0]).then(|| (from..to, columns.clone())));
                from = to;
            }
        }
    }
    Problem::new(parts)
}
