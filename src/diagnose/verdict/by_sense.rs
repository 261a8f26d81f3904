//! What goes otherwise there than back, which a second look finds: hysteresis, lost motion, the
//! drag of a cable.
//!
//! Blocks have the sense of motion and what moves, but not both at once. What is even in neither is
//! an oscillation where it is strong, for runs one way swing against those the other way, and no
//! block says it where it is weak. So it is asked once all else is settled, where nothing was
//! found, or nothing has a name.

use crate::diagnose::evidence::Evidence;
use crate::diagnose::evidence::score::{Score, Support, score};
use crate::diagnose::evidence::thresholds::FALSE_ALARMS;
use crate::diagnose::fitted::Fitted;
use crate::diagnose::library::candidate::Candidate;
use crate::diagnose::library::place::Place;
use crate::diagnose::library::wanted::Wanted;
use crate::diagnose::stage::Stage;

/// Its probability by chance is at most this part of that of any false declaration.
const PART: f64 = 0.1;

/// What goes otherwise there than back.
#[derive(Clone, Debug)]
pub(in crate::diagnose) struct BySense {
    pub(in crate::diagnose) place: Place,
    pub(in crate::diagnose) score: Score,
    /// Whether it is beyond chance by itself, whatever else is said of it.
    pub(in crate::diagnose) is_seen: bool,
}

/// What of it explains a stage best; `None` where nothing can be said of it.
pub(in crate::diagnose) fn by_sense(stage: &Stage, wanted: &Wanted) -> Option<BySense> {
    let Fitted { problem, fit, recipes } = &stage.fitted;
    let made = wanted.catalogue.of(recipes);
    let blocks: Vec<&Candidate> = made.by_sense.iter().collect();
    if blocks.is_empty() {
        return None;
    }
    let signed = made.signatures(problem, &blocks);
    let seen = Evidence::with(problem, &fit.normal, &fit.point, blocks.len(), signed)?;
    let scores = seen.entries.iter().map(|entry| score(entry, 1)).enumerate();
    let testable = scores.filter(|(_, score)| score.degrees > 0);
    let (best, score) = testable.min_by(|a, b| a.1.ln_p.total_cmp(&b.1.ln_p))?;
    let level = (PART * FALSE_ALARMS / blocks.len() as f64).ln();
    let left = seen.left(problem, &fit.point, &seen.together(&[]), stage.noise_found.stretch);
    let stretches = left.iter().map(|run| run.scores.len()).sum();
    let support = Support { stretches, memory: stage.noise_found.memory };
    let inflation = seen.inflation(&seen.entries[best], &left);
    let is_even = || support.ln_p(score.gain, score.degrees, inflation) <= level;
    let place = blocks[best].place.clone()?;
    Some(BySense { place, score, is_seen: score.is_seen(level) && is_even() })
}
