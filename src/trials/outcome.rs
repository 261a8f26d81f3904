//! What a diagnosis made of one trial, against the truth.
//!
//! The diagnosis is given readings and a library; what is true is looked at only afterwards.
//!
//! An outcome is a line of a file of trials. Fields that older files lack are `None` there.

pub mod findings;
pub mod mixed;

use serde::{Deserialize, Serialize};

use crate::diagnose::budget::answer::Verdict;
use crate::diagnose::fitted::Fitted;
use crate::diagnose::library::wanted::Wanted;
use crate::diagnose::{Diagnosis, diagnose};
use crate::engine::Problem;
use crate::engine::gram::LeastSquares;
use crate::estimate::batch::Options;

use super::design::Design;
use super::draw::{Drawn, draw};
use super::noise::is_foreign;
use super::plan::{Kind, Plan, Trial};
use super::simulated::take_readings;
use findings::{EffectSize, Excluded, Location};
use mixed::Mixed;

/// One trial: what was true, and what was said.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Its number in the plan.
    pub trial: usize,
    /// Seed of its readings.
    pub seed: u64,
    /// [`Kind::word`].
    pub kind: String,
    /// Whether an effect has a form that the library lacks.
    pub own_form: bool,
    /// What was put in.
    pub effects: Vec<String>,
    /// Length of each effect's signature; 0 where there is none, or each has its own.
    pub lambda: f64,
    /// Whether `lambda` was drawn from a range.
    pub spread: bool,
    /// Whether it is of the mix over which probabilities are judged.
    pub mixed: bool,
    /// The verdict.
    pub verdict: String,
    /// The effects it names.
    pub named: Vec<String>,
    /// The effects on the noise it names.
    pub noise: Vec<String>,
    /// The effects that the data would allow, best first, three at most.
    pub best: Vec<String>,
    /// Place of the (first) true effect among the candidates, from 1, effects that are alike
    /// counted once.
    pub rank: Option<usize>,
    /// Whether every effect that is true is named.
    pub declared: bool,
    /// Whether what is true is named, and nothing else.
    pub exact: bool,
    /// Sum of the squared differences between probabilities and truth, over nothing, unknown and
    /// each class of effects.
    pub brier: Option<f64>,
    /// Probability of the most probable answer.
    pub confidence: Option<f64>,
    /// Whether that answer is right.
    pub sure: Option<bool>,
    /// Part of the gap that is said to be closed.
    pub closed: Option<f64>,
    /// Part of the gap that is closed: how much less the fitted model misses readings without
    /// noise.
    pub closed_in_truth: Option<f64>,
    /// Why there is no diagnosis.
    pub failed: Option<String>,
    /// The special situation, where it is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub situation: Option<String>,
    /// What is true of each effect of a mixture, and what was identified.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mixture: Option<Mixed>,
    /// Why what is there has no name; empty where that is no question.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Where it sits, the largest first, three at most.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub location: Option<Vec<Location>>,
    /// The values of the named effects and of the nearest one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sizes: Option<Vec<EffectSize>>,
    /// Readings that are left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub excluded: Option<Vec<Excluded>>,
}

impl Outcome {
    /// Whether there is a diagnosis.
    pub fn is_diagnosed(&self) -> bool {
        let none = [Verdict::Unobservable.word(), Verdict::NotConverged.word()];
        self.failed.is_none() && !none.contains(&self.verdict.as_str())
    }

    /// Whether exactly what is true is said.
    pub fn is_exact(&self) -> bool {
        self.is_diagnosed() && self.exact
    }

    /// What was put in, in a word or two: the situation, else the effects.
    pub fn truth(&self) -> String {
        self.situation.clone().unwrap_or_else(|| self.effects.join(" + "))
    }
}

/// Draws a trial and diagnoses it.
pub fn of(design: &Design, plan: &Plan, number: usize) -> Outcome {
    let trial = plan.trial(number);
    let drawn = draw(design, &trial);
    let withheld = match trial.kind {
        Kind::Withheld => drawn.doses.first(),
        _ => drawn.doses.last().filter(|_| drawn.outside > 0),
    };
    let without = withheld.map_or_else(Vec::new, |dose| design.like(dose));
    let wanted = Wanted { without, ..design.wanted.clone() };
    let mut outcome = truth(number, &trial, &drawn);
    match diagnose(drawn.problem.clone(), drawn.recipes.clone(), &wanted, &Options::default()) {
        Ok(found) => judge(&mut outcome, design, &drawn, &trial, &found),
        Err(error) => outcome.failed = Some(error.to_string()),
    }
    outcome
}

/// The outcome as far as it is known beforehand.
fn truth(number: usize, trial: &Trial, drawn: &Drawn) -> Outcome {
    Outcome {
        trial: number,
        seed: trial.seed,
        kind: trial.kind.word().to_owned(),
        own_form: drawn.doses.iter().any(|dose| !dose.cause.in_library)
            || drawn.noise.as_deref().is_some_and(is_foreign),
        effects: match &drawn.noise {
            Some(noise) => vec![noise.clone()],
            None => drawn.doses.iter().map(|dose| dose.cause.name.clone()).collect(),
        },
        lambda: if drawn.doses.is_empty() { 0.0 } else { trial.lambda },
        spread: trial.spread && !drawn.doses.is_empty(),
        mixed: trial.mixed,
        verdict: String::new(),
        named: Vec::new(),
        noise: Vec::new(),
        best: Vec::new(),
        rank: None,
        declared: false,
        exact: false,
        brier: None,
        confidence: None,
        sure: None,
        closed: None,
        closed_in_truth: None,
        failed: None,
        situation: trial.situation.as_ref().map(|situation| situation.name.clone()),
        mixture: (trial.kind == Kind::Mixture).then(|| Mixed::truth(drawn)),
        reason: None,
        location: None,
        sizes: None,
        excluded: None,
    }
}

fn judge(outcome: &mut Outcome, design: &Design, drawn: &Drawn, trial: &Trial, found: &Diagnosis) {
    outcome.verdict = found.verdict.word().to_owned();
    outcome.named = found.rows.iter().map(|one| one.name.clone()).collect();
    outcome.noise = found.noise.iter().map(|one| one.name.clone()).collect();
    findings::write(outcome, found);
    let names: Vec<&str> = found.candidates.iter().map(|one| one.name.as_str()).collect();
    outcome.best = names.iter().take(3).map(|name| (*name).to_owned()).collect();
    outcome.rank = rank(design, drawn, &names);
    let known = &drawn.doses[..drawn.doses.len() - drawn.outside];
    let is_right = |name: &String| known.iter().any(|dose| design.is_named(dose, name));
    let named = &outcome.named;
    let all_named = known.iter().all(|dose| named.iter().any(|name| design.is_named(dose, name)));
    outcome.declared = !known.is_empty() && trial.kind != Kind::Withheld && all_named;
    let are_right = named.len() == known.len() && named.iter().all(is_right);
    outcome.exact = match (trial.kind, &trial.situation) {
        (Kind::None, _) => found.verdict == Verdict::Adequate,
        (Kind::Noise, _) => named.is_empty() && found.verdict != Verdict::Unknown,
        (Kind::Withheld, _) => found.verdict == Verdict::Unknown,
        (Kind::One | Kind::Two, _) => outcome.declared && are_right,
        (Kind::Mixture, _) => {
            let has_remainder = found.verdict.has_remainder();
            outcome.declared && are_right && has_remainder == (drawn.outside > 0)
        }
        (Kind::Situation, situation) => situation.as_ref().is_some_and(|situation| {
            let is_known = |name: &String| is_right(name) || situation.names.contains(name);
            let is_seen = situation.unmodelled.is_none_or(|it| it == found.verdict.has_remainder());
            all_named && named.iter().all(is_known) && is_seen
        }),
    };
    if let Some(mixture) = &mut outcome.mixture {
        mixture.judge(design, known, &outcome.named, found.verdict.has_remainder());
    }
    if outcome.mixed {
        probability(outcome, design, drawn, trial.kind, found);
    }
    outcome.closed = found.gap.as_ref().map(|gap| gap.closed);
    if outcome.closed.is_some() {
        outcome.closed_in_truth = closed_in_truth(outcome.lambda, drawn, found);
    }
}

/// Where the first of the true effects stands, effects that are alike counted once.
fn rank(design: &Design, drawn: &Drawn, names: &[&str]) -> Option<usize> {
    let mut before: Vec<&str> = Vec::new();
    for name in names {
        if drawn.doses.iter().any(|dose| design.is_named(dose, name)) {
            return Some(before.len() + 1);
        }
        if !before.iter().any(|known| design.are_alike(known, name)) {
            before.push(name);
        }
    }
    None
}

/// How good the probabilities are.
fn probability(
    outcome: &mut Outcome,
    design: &Design,
    drawn: &Drawn,
    kind: Kind,
    found: &Diagnosis,
) {
    let Some([nothing, _, unknown]) = found.causes else { return };
    // Classes of effects, each with a name to know it by; the true one first.
    let mut classes: Vec<(Option<&str>, f64)> = vec![(None, 0.0)];
    let truth = if kind == Kind::Withheld { None } else { drawn.doses.first() };
    for candidate in &found.candidates {
        let (name, own) = (candidate.name.as_str(), &candidate.probability);
        if truth.is_some_and(|dose| design.is_named(dose, name)) {
            classes[0].1 += own;
            continue;
        }
        let known = classes[1..].iter_mut().find(|(known, _)| {
            known.is_some_and(|known| *own > 1e-6 && design.are_alike(known, name))
        });
        match known {
            Some((_, sum)) => *sum += own,
            None => classes.push((Some(name), *own)),
        }
    }
    let right = [
        (nothing, kind == Kind::None),
        (unknown, kind == Kind::Withheld),
        (classes[0].1, kind == Kind::One),
    ];
    let answers = right.into_iter().chain(classes[1..].iter().map(|(_, own)| (*own, false)));
    let (mut brier, mut confidence, mut sure) = (0.0, 0.0, false);
    for (own, is_true) in answers {
        brier += (own - f64::from(u8::from(is_true))).powi(2);
        if own > confidence {
            (confidence, sure) = (own, is_true);
        }
    }
    outcome.brier = Some(brier);
    outcome.confidence = Some(confidence);
    outcome.sure = Some(sure);
}

/// How much less the model with the named effects misses readings without noise than the nominal
/// one, in units of what the effects that were put in make up. `None` where noise is part of the
/// model, for then the units are others.
fn closed_in_truth(lambda: f64, drawn: &Drawn, found: &Diagnosis) -> Option<f64> {
    let truth = drawn.noiseless()?;
    let steps = found.steps.as_ref()?;
    if !found.noise.is_empty() {
        return None;
    }
    let missed = |fitted: &Fitted, weighed: &Problem| {
        let mut problem = fitted.problem.clone();
        take_readings(&mut problem, &truth);
        for (part, weighed) in problem.parts.iter_mut().zip(&weighed.parts) {
            part.sigma.clone_from(&weighed.sigma);
        }
        problem.reweight(&fitted.fit.point);
        problem.cost(&fitted.fit.point)
    };
    // Levels of noise that were found to be others than stated are units, too.
    let (first, last) = (&steps.nominal, steps.last());
    let (found_units, stated_units) = (&last.problem, &drawn.problem);
    let before = missed(first, found_units);
    let whole = drawn.doses.len() as f64 * lambda * lambda * before / missed(first, stated_units);
    (whole > 0.0).then(|| (before - missed(last, found_units)) / whole)
}
