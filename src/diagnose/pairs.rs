//! Two effects at once: what the search one by one may miss.
//!
//! The effect that explains most alone need not be one of two that explain everything together. Of the
//! `BEST` candidates every pair is tried on the sums of the nominal stage: both must explain something
//! beyond the other, and no block of unknown structure may be left.

use super::evidence::Entry;
use super::score::of_gain;
use super::search::{LEAST_LAMBDA, level};
use super::stage::Stage;

/// Candidates of which pairs are made.
const BEST: usize = 8;
/// Candidates that explain less than this part of the best one's gain are no part of a pair.
const LEAST_SHARE: f64 = 0.02;

/// Pairs that leave nothing, the least probable by chance first.
pub fn pairs(stage: &Stage) -> Vec<(usize, usize)> {
    let mut best: Vec<usize> =
        (0..stage.effects).filter(|n| stage.entry(*n).degrees() > 0).collect();
    best.sort_by(|a, b| stage.scores[*a].ln_p.total_cmp(&stage.scores[*b].ln_p));
    let most = best.first().map_or(0.0, |n| stage.scores[*n].gain);
    best.retain(|n| stage.scores[*n].gain >= LEAST_SHARE * most);
    best.truncate(BEST);
    let mut found: Vec<(f64, (usize, usize))> = Vec::new();
    for (k, first) in best.iter().enumerate() {
        for second in &best[..k] {
            let (a, b) = (stage.entry(*first), stage.entry(*second));
            if !(adds(stage, a, *second) && adds(stage, b, *first)) {
                continue;
            }
            let both = stage.evidence.together(&[a, b]);
            if leaves_nothing(stage, &both) {
                let members = stage.members[*first] * stage.members[*second];
                let ln_p = of_gain(both.gain(), both.degrees(), members).ln_p;
                found.push((ln_p, (*second, *first)));
            }
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.into_iter().map(|(_, pair)| pair).collect()
}

/// Whether a candidate explains something beyond an entry.
fn adds(stage: &Stage, known: &Entry, candidate: usize) -> bool {
    let (gain, degrees) = stage.evidence.beyond(known, stage.entry(candidate));
    let score = of_gain(gain, degrees, stage.members[candidate]);
    score.ln_p <= level(stage.effects) && score.lambda() >= LEAST_LAMBDA
}

/// Whether no block of unknown structure explains anything beyond an entry.
fn leaves_nothing(stage: &Stage, known: &Entry) -> bool {
    let blocks = stage.effects..stage.candidates.len();
    let level = level(blocks.len());
    blocks.into_iter().filter(|block| !stage.is_scatter(*block)).all(|block| {
        let (gain, degrees) = stage.evidence.beyond(known, stage.entry(block));
        let score = of_gain(gain, degrees, stage.members[block]);
        score.ln_p > level || score.lambda() < LEAST_LAMBDA
    })
}
