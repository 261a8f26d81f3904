//! Single runs in which a reading, the target or a clock is off by a value of its own, and runs
//! from which on it is: told from noise with a long memory.
//!
//! A forgotten prism constant, a fixture that slipped or an encoder that lost its datum puts one
//! run beside the others. Noise with a memory as long as a run explains that, too, but then every
//! run would be off. Where a few changes leave nothing of what each run has for itself, and are far
//! likelier than a memory, they are what happened. Displacements beside a walk are those of
//! [`super::wander::displaced`].

use crate::diagnose::evidence::Entry;
use crate::diagnose::evidence::score::of_gain;
use crate::diagnose::evidence::thresholds::level;
use crate::diagnose::found::Apart;
use crate::diagnose::stage::Stage;

use super::wander::sequence::{Change, in_order, places, spans};

/// Changes that are looked for: more are noise.
const MOST: usize = 3;
/// Blocks that are looked at, the least probable by chance first.
const BLOCKS: usize = 4;
/// Runs for each change at least.
const RUNS: usize = 4;

/// What does for a block with a value for each run.
pub(super) struct Few {
    pub(super) apart: Apart,
    pub(super) entry: Entry,
    /// Logarithm of the number of choices.
    pub(super) choices: f64,
}

/// The structure that is there beside what each run has for itself, and what is off in a few runs
/// if that is all that runs have for themselves beside it.
pub(super) fn few(stage: &Stage) -> Option<(Vec<usize>, Few)> {
    let all = stage.structures();
    let is_known = |n: &usize| !stage.is_of_runs(*n) && !stage.is_oscillation(*n);
    let known: Vec<usize> = all.iter().copied().filter(is_known).collect();
    let of_runs: Vec<usize> = all.iter().copied().filter(|n| stage.is_of_runs(*n)).collect();
    let mut blocks = stage.blocks_over_runs();
    blocks.sort_by(|a, b| stage.scores[*a].ln_p.total_cmp(&stage.scores[*b].ln_p));
    blocks.truncate(if of_runs.is_empty() { 0 } else { BLOCKS });
    let is_all = |few: &Few| {
        let entries = known.iter().map(|n| stage.entry(*n)).chain([&few.entry]);
        let whole = stage.evidence.together(&entries.collect::<Vec<_>>());
        !of_runs.iter().any(|block| shows(stage, *block, &whole))
    };
    // Beside other structure a displacement in some run is soon a part of what that leaves.
    let of_readings = stage.readings_over_runs();
    blocks.retain(|block| known.is_empty() || of_readings.contains(block));
    let few = blocks.into_iter().find_map(|block| few_of(stage, block, &known).filter(is_all))?;
    Some((known, few))
}

/// Whether a block is significant beyond something.
fn shows(stage: &Stage, block: usize, beyond: &Entry) -> bool {
    let (gain, degrees) = stage.evidence.beyond(beyond, stage.entry(block));
    of_gain(gain, degrees, 1).ln_p <= level(stage.candidates.len())
}

/// A change, the runs that have its value, and what it explains.
struct Possible {
    change: Change,
    runs: Vec<usize>,
    entry: Entry,
}

fn few_of(stage: &Stage, block: usize, known: &[usize]) -> Option<Few> {
    let evidence = &stage.evidence;
    let own = stage.entry(block);
    let spans = spans(&stage.fitted.problem);
    let order = places(&in_order(&spans));
    let is_later =
        |run: usize, from: usize| spans[run].0 == spans[from].0 && order[run] >= order[from];
    let possible: Vec<Possible> = (0..spans.len())
        .flat_map(|from| {
            let later: Vec<usize> = (0..spans.len()).filter(|run| is_later(*run, from)).collect();
            let rest = (later.len() > 1).then_some((Change::From(from), later));
            std::iter::once((Change::In(from), vec![from])).chain(rest)
        })
        .map(|(change, runs)| {
            let entry = evidence.tied_over(own, |run| runs.contains(&run));
            Possible { change, runs, entry }
        })
        .filter(|one| one.entry.degrees() > 0)
        .collect();
    let mut entries: Vec<&Entry> = known.iter().map(|n| stage.entry(*n)).collect();
    let mut taken: Vec<&Possible> = Vec::new();
    loop {
        let whole = evidence.together(&entries);
        if !shows(stage, block, &whole) {
            break;
        }
        if taken.len() == MOST || RUNS * (taken.len() + 1) > spans.len() {
            return None;
        }
        let gain = |one: &&Possible| evidence.beyond(&whole, &one.entry).0;
        let best = possible.iter().max_by(|a, b| gain(a).total_cmp(&gain(b)))?;
        taken.push(best);
        entries.push(&best.entry);
    }
    let names = stage.fitted.problem.run_names();
    let words: Vec<String> = taken.iter().map(|one| one.change.words(&names)).collect();
    let candidate = &stage.candidates[block];
    let only = match taken[..] {
        [one] => one.change.only_run(&names),
        _ => None,
    };
    let place = candidate.place.as_ref()?.in_runs(&words.join(" and "), only);
    let entry = evidence.together(&entries[known.len()..]);
    let choices = taken.len() as f64 * (possible.len() as f64).ln();
    let runs = taken.iter().map(|one| one.runs.clone()).collect();
    let apart = Apart { block: candidate.name.clone(), runs, place };
    (!taken.is_empty()).then_some(Few { apart, entry, choices })
}
