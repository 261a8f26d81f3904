//! A walk beside structure: what is known of the readings is taken off first, as long as that is
//! clearly likelier than the walk alone; which effects cannot be told from it.

use crate::diagnose::evidence::score::{STRETCHES, Score, Support, likelihood_of_gain, of_gain};
use crate::diagnose::evidence::thresholds::{FURTHER, LEAST_LAMBDA, level};
use crate::diagnose::stage::Stage;

use super::wandering::{Likeliest, Wandering};

/// What is not so many times likelier than something else cannot be told from it.
const CLEARLY: f64 = 10.0;

/// What may be there instead of a walk.
#[derive(Clone, Copy)]
pub(super) struct Structure {
    /// Logarithm of how much likelier it must be for the choice that there was.
    price: f64,
    /// Members of its family that were tried.
    members: usize,
    /// Of an effect the level at which it is declared.
    declared: Option<f64>,
}

impl Structure {
    /// One of a stage. What nobody wrote down must be far likelier, the choice among all of it paid
    /// for.
    pub(super) fn of(stage: &Stage, number: usize) -> Self {
        let members = stage.members[number];
        let is_effect = number < stage.effects;
        let blocks = stage.candidates.len() - stage.effects;
        let unknown = if is_effect { 0.0 } else { FURTHER.ln() + (blocks as f64).ln() };
        let declared = is_effect.then(|| level(stage.effects));
        Self { price: unknown + (members as f64).ln(), members, declared }
    }

    /// Whether it is an effect that would be declared: one that would not is none to put in a
    /// walk's place.
    fn is_declared(&self, score: &Score) -> bool {
        let support = Support { stretches: STRETCHES, memory: 0.0 };
        self.declared.is_some_and(|level| {
            score.ln_p <= level
                && score.lambda() >= LEAST_LAMBDA
                && support.ln_p(score.gain, score.degrees, 1.0) <= level
        })
    }
}

/// An effect that is as likely as a walk.
pub(super) struct Close {
    /// Its number among the structures.
    pub(super) structure: usize,
    pub(super) score: Score,
    /// Logarithm of its likelihood, with what it leaves of the walk, over that of the walk alone.
    pub(super) likelier: f64,
}

/// Logarithm of the likelihood of the first of some structures, where that is an effect that would
/// be declared and leaves nothing of the walk.
pub(super) fn of_an_effect(wandering: &Wandering, structures: &[Structure]) -> Option<f64> {
    let (entry, structure) = wandering.evidence.entries.iter().zip(structures).next()?;
    let score = of_gain(entry.gain(), entry.degrees(), structure.members);
    (structure.is_declared(&score) && wandering.is_gone(entry))
        .then(|| likelihood_of_gain(entry.gain(), entry.degrees()) - structure.price)
}

/// Takes structure off as long as it, its price paid, and what is left of the walk are clearly
/// likelier than the walk alone; an effect that does for the walk ends it, and is taken where it is
/// likelier at all: what is left then and how many structures are known, `None` where nothing of
/// the walk is left, and the effect that cannot be told from the walk.
pub(super) fn beside_structure(
    wandering: &Wandering,
    mut found: Likeliest,
    structures: &[Structure],
) -> (Option<(Likeliest, usize)>, Option<Close>) {
    let evidence = &wandering.evidence;
    let together =
        |count: usize| evidence.together(&evidence.entries[..count].iter().collect::<Vec<_>>());
    for (number, (next, structure)) in evidence.entries.iter().zip(structures).enumerate() {
        let (gain, degrees) = evidence.beyond(&together(number), next);
        let score = of_gain(gain, degrees, structure.members);
        let beside = together(number + 1);
        let rest = wandering.beyond(&beside);
        let left = rest.as_ref().map_or(0.0, |rest| rest.likelihood.max(0.0));
        let own = likelihood_of_gain(gain, degrees) - structure.price;
        let likelier = own + left - found.likelihood;
        // Where a walk is there beside it, an effect does not do for that.
        if structure.declared.is_some()
            && likelier.abs() < CLEARLY.ln()
            && wandering.is_gone(&beside)
        {
            let is_taken = likelier > 0.0 && structure.is_declared(&score);
            let walk = (!is_taken).then_some((found, number));
            return (walk, Some(Close { structure: number, score, likelier }));
        }
        if likelier < CLEARLY.ln() {
            return (Some((found, number)), None);
        }
        let Some(rest) = rest else { return (None, None) };
        found = rest;
    }
    (Some((found, structures.len())), None)
}
