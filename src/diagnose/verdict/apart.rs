//! What is off in a few runs alone, and whether that is what there is.

use crate::diagnose::evidence::Entry;
use crate::diagnose::found::{Apart, Displaced, Noise};
use crate::diagnose::library::place::Place;
use crate::diagnose::search::Search;
use crate::diagnose::stage::Stage;

use super::leftover;

/// What is off in a few runs is what there is where it explains this part of what the best block
/// does.
const RUNS_LEAD: f64 = 0.8;

/// What displaced the rig: it is in the model as a walk, which soaks it up, but it is none.
pub fn displaced(search: &Search) -> Option<&Displaced> {
    search.stages.last()?.noise_found.displaced.as_ref()
}

/// What is off in a few runs, as the last stage sees it: first what is left out.
pub fn apart(search: &Search) -> Vec<&Place> {
    search.stages.last().map_or_else(Vec::new, |last| {
        let Noise { left_out, apart, .. } = &last.noise_found;
        let out = left_out.runs.iter().map(|one| &one.place);
        out.chain(apart.iter().map(|one| &one.place)).collect()
    })
}

/// Whether a few runs are off, but far from all of what there is.
pub(super) fn has_more_than_runs(stage: &Stage) -> bool {
    let Noise { left_out, apart, .. } = &stage.noise_found;
    let most = leftover(stage);
    let is_less = |one: &Apart| share_of_runs(stage, one, most) < RUNS_LEAD;
    left_out.runs.is_empty() && !apart.is_empty() && apart.iter().all(is_less)
}

/// What changes in a few runs explain by themselves, over the `most` that a block does; all where
/// there is none.
pub(super) fn share_of_runs(stage: &Stage, apart: &Apart, most: f64) -> f64 {
    let block = stage.candidates.iter().position(|one| one.name == apart.block);
    let Some(block) = block.filter(|_| most > 0.0) else { return 1.0 };
    let own = stage.entry(block);
    let change = |runs: &Vec<usize>| stage.evidence.tied_over(own, |run| runs.contains(&run));
    let changes: Vec<Entry> = apart.runs.iter().map(change).collect();
    let all = stage.evidence.together(&changes.iter().collect::<Vec<_>>());
    ((all.gain() - all.degrees() as f64).max(0.0) / most).min(1.0)
}
