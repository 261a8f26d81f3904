//! Whether effects imitate what nobody wrote down: two or three of a library can follow much, and
//! one may be near it.

use crate::diagnose::evidence::score::{Score, of_gain};
use crate::diagnose::evidence::thresholds::{FALSE_ALARMS, FURTHER, LEAST_PROBABLE, NAMED, level};
use crate::diagnose::stage::Stage;

use super::Search;
use super::probability::probabilities;

/// Odds of unknown structure over one effect from which on that is no name, where a block explains
/// something beside it.
const LIKELIER: f64 = 3.0;

impl Search {
    /// Whether what was adopted is a cause to be named where it leaves nothing: probable, and no
    /// imitation.
    pub(in crate::diagnose) fn convinces(&self) -> bool {
        self.is_probable() && !self.imitates()
    }

    /// By the last one: what was adopted before was judged without it. And that one must still be
    /// there beside the noise that was found with it.
    pub(in crate::diagnose) fn is_probable(&self) -> bool {
        self.adopted.last().is_some_and(|last| {
            let beside_noise = of_gain(last.gain, last.score.degrees, 1).ln_p;
            last.probability >= LEAST_PROBABLE && beside_noise <= FALSE_ALARMS.ln()
        })
    }

    /// Whether what was adopted accounts for everything, but what nobody wrote down does so, too,
    /// and is simpler or likelier.
    fn imitates(&self) -> bool {
        match self.adopted.len() {
            1 => self.is_doubtful(),
            _ => self.several_imitate(FURTHER),
        }
    }

    /// Whether unknown structure is likelier by far than the one effect that was adopted, and than
    /// each other one, unless that effect explains so much that it may be named whatever else is
    /// there: what it leaves may be too little to be seen by itself.
    pub(super) fn is_doubtful(&self) -> bool {
        let ([one], [first, last]) = (&self.adopted[..], &self.stages[..]) else { return false };
        let probability = probabilities(first);
        let (effects, blocks) = probability.split_at(first.effects);
        let unknown: f64 = blocks.iter().sum();
        let likeliest = effects.iter().copied().fold(LIKELIER * one.probability, f64::max);
        let left = (last.effects..last.candidates.len()).filter(|block| !last.is_scatter(*block));
        let left = left.map(|block| last.scores[block].lambda().powi(2)).fold(0.0, f64::max);
        unknown > likeliest && one.gain < NAMED * (one.gain + left)
    }

    /// Whether blocks of unknown structure account for everything more simply than several effects:
    /// then those effects imitate what nobody wrote down. Of three effects and more fewer blocks
    /// are simpler; of two effects one block, if it is also less surprising by chance. An effect
    /// with a block beside it is simpler, too, where less surprising by these odds: effects with a
    /// value for each run can imitate much. What each effect takes off is in units of the noise
    /// that was found before it, which is not quite the noise of the blocks.
    pub(super) fn several_imitate(&self, odds: f64) -> bool {
        let count = self.adopted.len();
        let Some(first) = self.stages.first().filter(|_| count >= 2) else { return false };
        let gain = self.adopted.iter().map(|one| one.score.gain).sum();
        let degrees = self.adopted.iter().map(|one| one.score.degrees).sum();
        let choices = count as f64 * (first.effects as f64).ln();
        let together = of_gain(gain, degrees, 1).ln_p + choices;
        if with_a_block(first) + odds.ln() < together {
            return true;
        }
        let Some(blocks) = blocks_needed(first, count - 1) else { return false };
        let among = ((first.candidates.len() - first.effects) as f64).ln();
        let together = together + FURTHER.ln();
        (count > 2 && !blocks.is_empty())
            || blocks.iter().any(|block| first.scores[*block].ln_p + among < together)
    }
}

/// Effects that are tried with each block beside them.
const BESIDE: usize = 8;

/// Logarithm of the probability by chance of the effect and block that together are least probable,
/// with the choices among all of them paid for.
fn with_a_block(stage: &Stage) -> f64 {
    let mut effects = stage.declared();
    effects.truncate(BESIDE);
    let blocks = stage.effects..stage.candidates.len();
    let choices = (stage.effects.max(1) as f64 * blocks.len().max(1) as f64).ln();
    let mut best = 0.0_f64;
    for effect in effects {
        let own = &stage.scores[effect];
        let paid = own.ln_p - of_gain(own.gain, own.degrees, 1).ln_p;
        for block in blocks.clone().filter(|block| !stage.is_scatter(*block)) {
            let (gain, degrees) = stage.evidence.beyond(stage.entry(effect), stage.entry(block));
            let both = of_gain(own.gain + gain, own.degrees + degrees, 1).ln_p;
            let member = (stage.members[block] as f64).ln();
            best = best.min(both + paid + member + choices);
        }
    }
    best
}

/// The blocks, taken greedily, beyond which nothing significant is left; `None` where it takes
/// more.
fn blocks_needed(stage: &Stage, most: usize) -> Option<Vec<usize>> {
    let level = level(stage.candidates.len());
    let strong: Vec<usize> = (0..stage.candidates.len())
        .filter(|n| stage.scores[*n].ln_p <= level && !stage.is_scatter(*n))
        .collect();
    let mut taken: Vec<usize> = Vec::new();
    loop {
        let entries: Vec<_> = taken.iter().map(|n| stage.entry(*n)).collect();
        let whole = stage.evidence.together(&entries);
        let left: Vec<(usize, Score)> = strong
            .iter()
            .map(|n| {
                let (gain, degrees) = stage.evidence.beyond(&whole, stage.entry(*n));
                (*n, of_gain(gain, degrees, stage.members[*n]))
            })
            .filter(|(_, score)| score.is_seen(level))
            .collect();
        if left.is_empty() {
            return Some(taken);
        }
        if taken.len() == most {
            return None;
        }
        let blocks = left.iter().filter(|(n, _)| *n >= stage.effects);
        let best = blocks.min_by(|a, b| a.1.ln_p.total_cmp(&b.1.ln_p))?;
        taken.push(best.0);
    }
}
