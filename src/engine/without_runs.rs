//! A problem without some of its runs, or without readings of some samples.

use std::ops::Range;

use crate::engine::problem::Problem;
use crate::graph::Scope;

impl Problem {
    /// The problem without some runs (campaign and run); a campaign that would lose all of them keeps
    /// all. `None` where none goes.
    pub fn without_runs(&self, goes: impl Fn(usize, usize) -> bool) -> Option<Self> {
        let mut parts = self.parts.clone();
        let mut is_less = false;
        for (number, part) in parts.iter_mut().enumerate() {
            let stays: Vec<bool> = (0..part.runs.len()).map(|run| !goes(number, run)).collect();
            if stays.iter().all(|stays| *stays) || !stays.contains(&true) {
                continue;
            }
            is_less = true;
            part.runs = kept(&part.runs, &stays);
            part.run_levels = kept(&part.run_levels, &stays);
            part.smoothing_sigma = kept(&part.smoothing_sigma, &stays);
        }
        is_less.then(|| self.with_parts(parts))
    }

    /// The problem without runs that have no readings and values of their own: nothing would
    /// determine these.
    #[must_use]
    pub fn without_undetermined_runs(self) -> Self {
        let others = self.without_runs(|part, run| is_undetermined(&self, part, run));
        others.unwrap_or(self)
    }

    /// Leaves samples of each run out: of a run of so many samples these, run after run.
    pub fn leave_out_samples(&mut self, mut out: impl FnMut(usize) -> Vec<Range<usize>>) {
        for part in &mut self.parts {
            let columns = part.reading_columns();
            for run in &mut part.runs {
                let out = out(run.record.len()).into_iter().map(|out| (out, columns.clone()));
                run.record.leave_out(out);
            }
        }
    }
}

/// Those of some elements that stay.
fn kept<T: Clone>(all: &[T], stays: &[bool]) -> Vec<T> {
    all.iter().zip(stays).filter(|(_, stays)| **stays).map(|(one, _)| one.clone()).collect()
}

/// Whether no reading of a run is left and something is to be estimated that holds for it alone, or
/// for a setup of which all runs are empty: nothing would determine it.
fn is_undetermined(problem: &Problem, part: usize, run: usize) -> bool {
    let part = &problem.parts[part];
    if part.has_readings(run) {
        return false;
    }
    let setup = part.runs[run].setup;
    let mut of_setup = (0..part.runs.len()).filter(|other| part.runs[*other].setup == setup);
    let (run, setup_name) = (part.run_name(run), part.qualified(&part.setups[setup]));
    let is_of_run = |scope, of: &str| scope == Scope::Run && of == run;
    let is_of_setup = |scope, of: &str| scope == Scope::Setup && of == setup_name;
    let unknowns = problem.layout.instances.iter().filter(|one| !one.setting.fixed);
    let mut of = unknowns.filter_map(|one| Some((one.setting.scope, one.of.as_deref()?)));
    let is_setup_empty = of_setup.all(|other| !part.has_readings(other));
    of.any(|(scope, of)| is_of_run(scope, of) || is_setup_empty && is_of_setup(scope, of))
}
