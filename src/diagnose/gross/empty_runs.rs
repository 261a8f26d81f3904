//! Runs of which no reading is left: they go as wholes where something of their own, or of a setup
//! of which no reading is left, is to be estimated, for nothing would determine it.

use crate::engine::layout::qualified;
use crate::engine::{Part, Problem};
use crate::graph::Scope;

/// Campaigns without such runs; `None` where there are none.
pub(in crate::diagnose) fn without_empty_runs(problem: &Problem) -> Option<Problem> {
    let mut parts = problem.parts.clone();
    for part in &mut parts {
        let goes: Vec<bool> = (0..part.runs.len())
            .map(|run| is_empty(part, run) && has_own_unknowns(problem, part, run))
            .collect();
        if goes.iter().all(|goes| *goes) {
            continue;
        }
        let stays = |run: usize| !goes[run];
        part.runs = kept(&part.runs, stays);
        part.run_levels = kept(&part.run_levels, stays);
    }
    let count = |parts: &[Part]| -> usize { parts.iter().map(|part| part.runs.len()).sum() };
    let is_less = count(&parts) < count(&problem.parts);
    is_less.then(|| Problem { progress: problem.progress.clone(), ..Problem::new(parts) })
}

fn kept<T: Clone>(all: &[T], stays: impl Fn(usize) -> bool) -> Vec<T> {
    all.iter().enumerate().filter(|(run, _)| stays(*run)).map(|(_, one)| one.clone()).collect()
}

fn is_empty(part: &Part, run: usize) -> bool {
    part.present_in(run).iter().all(|count| *count == 0)
}

/// Whether something holds for an empty run alone, or for a setup of which all runs are empty.
fn has_own_unknowns(problem: &Problem, part: &Part, run: usize) -> bool {
    let setup = part.runs[run].setup;
    let mut of_setup = (0..part.runs.len()).filter(|other| part.runs[*other].setup == setup);
    let called = |name: &str| qualified(part.label.as_deref(), name);
    let (run, setup_name) = (called(&part.runs[run].name), called(&part.setups[setup]));
    let is_of_run = |scope, of: &str| scope == Scope::Run && of == run;
    let is_of_setup = |scope, of: &str| scope == Scope::Setup && of == setup_name;
    let unknowns = problem.layout.instances.iter().filter(|one| !one.setting.fixed);
    let mut of = unknowns.filter_map(|one| Some((one.setting.scope, one.of.as_deref()?)));
    let is_setup_empty = of_setup.all(|other| is_empty(part, other));
    of.any(|(scope, of)| is_of_run(scope, of) || is_setup_empty && is_of_setup(scope, of))
}
