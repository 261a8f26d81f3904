//! Two effects at once: what the search one by one may miss.
//!
//! The effect that explains most alone need not be one of two that explain everything together: one
//! with a value for each run takes up a part of both. Each of the `BEST` candidates is tried on the
//! sums of the nominal stage with the `SECOND` that explain most beyond it: both must explain
//! something beyond the other, and no block of unknown structure may be left.

use crate::diagnose::evidence::Entry;
use crate::diagnose::evidence::score::of_gain;
use crate::diagnose::evidence::thresholds::level;
use crate::diagnose::stage::Stage;

/// Candidates that may be the first of a pair.
const BEST: usize = 8;
/// Candidates that are tried as the second of each.
const SECOND: usize = 3;

/// Pairs that leave nothing, the least probable by chance first.
pub fn pairs(stage: &Stage) -> Vec<(usize, usize)> {
    let mut best: Vec<usize> =
        (0..stage.effects).filter(|n| stage.entry(*n).degrees() > 0).collect();
    best.sort_by(|a, b| stage.scores[*a].ln_p.total_cmp(&stage.scores[*b].ln_p));
    let all = best.clone();
    best.truncate(BEST);
    let mut found: Vec<(f64, (usize, usize))> = Vec::new();
    for first in best {
        let known = stage.entry(first);
        let others = all.iter().copied().filter(|second| *second != first);
        let mut seconds: Vec<(f64, usize)> =
            others.filter_map(|second| Some((adds(stage, known, second)?, second))).collect();
        seconds.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (_, second) in seconds.into_iter().take(SECOND) {
            let is_known = |(_, pair): &(f64, (usize, usize))| *pair == (second, first);
            let other = stage.entry(second);
            if found.iter().any(is_known) || adds(stage, other, first).is_none() {
                continue;
            }
            let both = stage.evidence.together(&[known, other]);
            if leaves_nothing(stage, &both) {
                let members = stage.members[first] * stage.members[second];
                let ln_p = of_gain(both.gain(), both.degrees(), members).ln_p;
                found.push((ln_p, (first, second)));
            }
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.into_iter().map(|(_, pair)| pair).collect()
}

/// Logarithm of the probability by chance of what a candidate explains beyond an entry, if it
/// explains something.
fn adds(stage: &Stage, known: &Entry, candidate: usize) -> Option<f64> {
    let (gain, degrees) = stage.evidence.beyond(known, stage.entry(candidate));
    let score = of_gain(gain, degrees, stage.members[candidate]);
    score.is_seen(level(stage.effects)).then_some(score.ln_p)
}

/// Whether no block of unknown structure explains anything beyond an entry.
fn leaves_nothing(stage: &Stage, known: &Entry) -> bool {
    let blocks = stage.effects..stage.candidates.len();
    let level = level(blocks.len());
    blocks.into_iter().filter(|block| !stage.is_scatter(*block)).all(|block| {
        let (gain, degrees) = stage.evidence.beyond(known, stage.entry(block));
        !of_gain(gain, degrees, stage.members[block]).is_seen(level)
    })
}
