//! Which effect is adopted next, what is said of it, and which effects are like it.

use crate::diagnose::evidence::score::{Score, of_gain};
use crate::diagnose::evidence::thresholds::{ALIKE, TIE, level};
use crate::diagnose::fitted::Fitted;
use crate::diagnose::library::candidate::Candidate;
use crate::diagnose::stage::Stage;
use crate::estimate::batch::{FitError, Options};

use super::probability::{among_effects, probabilities};

/// Effects that are fitted and tested again before one is adopted.
pub(super) const SHORT_LIST: usize = 3;

/// An adopted effect.
#[derive(Clone, Debug)]
pub struct Adopted {
    /// The effect.
    pub candidate: Candidate,
    /// Its test when it was adopted, after the nonlinear fit.
    pub score: Score,
    /// Part of the evidence that lies in prior values.
    pub prior_share: f64,
    /// What it takes off the sum of squares, in units of the noise that is found with it in the
    /// model.
    pub gain: f64,
    /// Effects that these data cannot tell from it.
    pub aliases: Vec<String>,
    /// Probability that it, or one of its aliases, is the cause: against nothing, other effects and
    /// unknown structure; where more than it was found, against other effects.
    pub probability: f64,
    /// The same against other effects.
    pub(in crate::diagnose) among_effects: f64,
}

impl Adopted {
    /// Where most of its evidence lies: `data`, or `prior` where stated values contradict the data.
    pub fn evidence(&self) -> &'static str {
        if self.prior_share > 0.5 { "prior" } else { "data" }
    }
}

/// Effects that explain as much as one of them, but for what chance may do, and the same: neither
/// explains anything beyond the other.
pub(super) fn alike(stage: &Stage, number: usize) -> Vec<usize> {
    let own = stage.scores[number].gain;
    let adds = |known: usize, other: usize| {
        let (gain, degrees) = stage.evidence.beyond(stage.entry(known), stage.entry(other));
        of_gain(gain, degrees, stage.members[other]).ln_p <= level(stage.effects)
    };
    let mut like: Vec<usize> = (0..stage.effects)
        .filter(|n| *n != number && stage.scores[*n].gain >= (own - ALIKE).max(0.5 * own))
        .filter(|n| !adds(number, *n) && !adds(*n, number))
        .collect();
    like.sort_by(|a, b| stage.scores[*a].ln_p.total_cmp(&stage.scores[*b].ln_p));
    like
}

/// The best of the short list after a nonlinear fit.
pub(super) fn best(
    stage: &Stage,
    options: &Options,
) -> Result<Option<(Adopted, Fitted)>, FitError> {
    let mut best: Option<(Adopted, Fitted, f64)> = None;
    let probability = probabilities(stage);
    for number in stage.declared().into_iter().take(SHORT_LIST) {
        let Some((adopted, fitted)) = adopted(stage, number, options)? else { continue };
        // Of effects that are one to rounding, the one whose usual size is nearest.
        let own = probability[number];
        let better = best.as_ref().is_none_or(|(known, _, other)| {
            let apart = known.score.ln_p - adopted.score.ln_p;
            apart > TIE || (apart > -TIE && own > *other)
        });
        if better {
            best = Some((adopted, fitted, own));
        }
    }
    Ok(best.map(|(adopted, fitted, _)| (adopted, fitted)))
}

/// A candidate after a nonlinear fit, if it passes its test there.
pub(super) fn adopted(
    stage: &Stage,
    number: usize,
    options: &Options,
) -> Result<Option<(Adopted, Fitted)>, FitError> {
    let candidate = &stage.candidates[number];
    let start = stage.start(number);
    let fitted = stage.fitted.with(&candidate.selected, &start, options)?;
    let Some(fitted) = fitted.filter(Fitted::is_sound) else { return Ok(None) };
    let gain = stage.fitted.cost() - fitted.cost();
    let linear = &stage.scores[number];
    let mut score = of_gain(gain, linear.degrees, 1);
    // Members of a family are paid for as in the linear test.
    score.ln_p += linear.ln_p - of_gain(linear.gain, linear.degrees, 1).ln_p;
    if !score.is_seen(level(stage.effects)) {
        return Ok(None);
    }
    let like = alike(stage, number);
    let adopted = Adopted {
        candidate: candidate.clone(),
        score,
        prior_share: stage.prior_share(number),
        gain,
        aliases: aliases(stage, number, &like),
        probability: of_all(&probabilities(stage), number, &like),
        among_effects: of_all(&among_effects(stage), number, &like),
    };
    Ok(Some((adopted, fitted)))
}

/// The probability of a candidate and of those like it together.
pub(super) fn of_all(each: &[f64], number: usize, like: &[usize]) -> f64 {
    like.iter().chain([&number]).map(|n| each[*n]).sum()
}

/// What cannot be told from a candidate: those like it, and walks.
pub(super) fn aliases(stage: &Stage, number: usize, like: &[usize]) -> Vec<String> {
    let name = |number: usize| stage.candidates[number].name.as_str();
    let walks = stage.noise_found.walks_like(name(number));
    like.iter().map(|n| name(*n)).chain(walks).map(str::to_owned).collect()
}
