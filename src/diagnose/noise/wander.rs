//! Random walks, tested in the variance.
//!
//! A walk `W` over a time `T` is a sum of sines with independent coefficients (Karhunen and Loève):
//! `W(t) = σ Σ ξ_k √(2 T) / ((k - ½) π) sin((k - ½) π t / T)`. The first sines of every run, and where
//! the walk has come to when the run begins, are columns like those of an effect; of few runs there are more.
//!
//! | file | answers |
//! |---|---|
//! | `sequence` | in which order runs came |
//! | `course` | how a walk goes on from run to run |
//! | `variance` | how large it is, and how unlikely by chance |
//! | `wandering` | what of it is left beyond something known |
//! | [`displaced`] | whether the rig was displaced between runs instead |
//!
//! A walk looks like structure over time and runs, and structure like a walk: significant structure is
//! taken off first as long as it and what it leaves of the walk are clearly likelier than the walk alone. Of the walk
//! and an effect that does for all of it the likelier one is taken; if not clearly so, they are [`Rival`]s.
//! What is accepted joins the model as those columns with a prior each, so that everything that comes
//! later is judged against it.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::ops::RangeInclusive;
use std::sync::Arc;

use course::{Column, Course, Times};
use displaced::Suspect;
use wandering::{Likeliest, Wandering};

use crate::diagnose::evidence::Entry;
use crate::diagnose::evidence::score::{STRETCHES, Score, Support, likelihood_of_gain, of_gain};
use crate::diagnose::evidence::thresholds::{FURTHER, LEAST_LAMBDA, level};
use crate::diagnose::found::{Displaced, NoiseEffect, Rival};
use crate::diagnose::library::candidates::{Candidate, join};
use crate::diagnose::library::structure::Place;
use crate::diagnose::sequences::sequences;
use crate::diagnose::stage::Stage;
use crate::diagnostic::Source;
use crate::effect::Effect;
use crate::engine::open::Recipe;
use crate::system::Selected;
use crate::units::{Dimension, Exponent, Unit};

use super::memory::likelihood_of_memory;

mod course;
pub mod displaced;
pub(in crate::diagnose) mod sequence;
mod variance;
mod wandering;

/// Sines of each run, of all runs together if these are few: 93 % of a walk's variance, and 98 % of one that goes on
/// in few long runs.
const TERMS: RangeInclusive<usize> = 3..=12;
const OF_ALL: usize = 48;
/// What is not so many times likelier than something else cannot be told from it.
const CLEARLY: f64 = 10.0;

/// A walk that was found.
pub(super) struct Found {
    pub(super) effect: NoiseEffect,
    /// The logarithm of its likelihood ratio against white noise of unit variance, a memory of what it
    /// leaves included.
    pub(super) likelihood: f64,
    /// The displacements that do for it, if it is no walk.
    pub(super) displaced: Option<Displaced>,
}

/// The walk of the library that shows, if one does, and effects from which one cannot be told. `level` is the
/// logarithm of its share of the false alarms.
pub(super) fn walk(stage: &Stage, level: f64) -> (Option<Found>, Vec<Rival>) {
    let mut rivals = Vec::new();
    let walks = stage.noise.iter().filter(|one| one.is_walk());
    let found = walks.filter_map(|one| tested(stage, one, level, &mut rivals));
    (found.max_by(|a, b| a.likelihood.total_cmp(&b.likelihood)), rivals)
}

fn tested(
    stage: &Stage,
    candidate: &Candidate,
    level: f64,
    rivals: &mut Vec<Rival>,
) -> Option<Found> {
    let fitted = &stage.fitted;
    let runs = fitted.problem.run_names().len();
    let terms = (OF_ALL / runs.max(1)).clamp(*TERMS.start(), *TERMS.end());
    let times = Times::of(&fitted.problem, u8::try_from(terms).unwrap_or(u8::MAX));
    let anywhere = select(candidate, &times, Course::Anywhere, None)?;
    let structures = stage.structures_beside_noise();
    let others = stage.readings_over_runs().into_iter().filter(|one| !structures.contains(one));
    let beside = structures.iter().copied().chain(others).map(|n| &stage.candidates[n]);
    let beside: Vec<&Candidate> = beside.collect();
    let columns = joined(&fitted.recipes, anywhere)?;
    let wandering = Wandering::of(fitted, &beside, &columns, &times, level)?;
    let entries = &wandering.evidence.entries[..];
    let of_runs: Vec<(&Place, &Entry)> = beside
        .iter()
        .zip(entries)
        .filter_map(|(one, entry)| Some((one.place.as_ref()?, entry)))
        .filter(|(place, _)| place.is_of_runs())
        .collect();
    let displaced = |known: &[Entry], likelihood| {
        let (name, of_runs) = (&candidate.name[..], &of_runs[..]);
        let suspect = Suspect { name, wandering: &wandering, known, of_runs, likelihood };
        suspect.displaced(&fitted.problem)
    };
    // Structure over time follows displacements, too, but not as well.
    let mut found = wandering.beyond(&wandering.evidence.together(&[]))?;
    let (mut jumps, mut known) = (displaced(&[], found.likelihood), 0);
    if jumps.is_none() {
        let all: Vec<Structure> =
            structures.iter().map(|number| Structure::of(stage, *number)).collect();
        let (left, close) = beside_structure(&wandering, found, &all);
        rivals.extend(close.map(|Close { structure, score, likelier }| Rival {
            walk: candidate.name.clone(),
            effect: stage.candidates[structures[structure]].name.clone(),
            score,
            likelier,
        }));
        (found, known) = left?;
    }
    if found.walk.ln_p() > level {
        rivals.retain(|one| one.walk != candidate.name);
        return None;
    }
    if known > 0 {
        jumps = displaced(&entries[..known], found.likelihood);
    }
    let Likeliest { course, walk, likelihood } = found;
    let (variance, spread) = walk.variance();
    let sigma = variance.sqrt();
    let (parameter, others) = candidate.selected.effect.parameters.split_first()?;
    let full = |name: &str| format!("{}.{name}", candidate.name);
    let own = Entry::of(wandering.own.clone());
    let taken: Vec<&Entry> = entries[..known].iter().chain([&own]).collect();
    let rest = wandering.evidence.together(&taken);
    let instead = rivals.iter().filter(|one| one.walk == candidate.name);
    let aliases = instead.map(|one| one.effect.clone()).collect();
    let (problem, point) = (&fitted.problem, &fitted.fit.point);
    let rest = sequences(problem, &wandering.evidence.left(problem, point, &rest, usize::MAX));
    let effect = NoiseEffect {
        name: candidate.name.clone(),
        selected: select(candidate, &times, course, Some(sigma)),
        parameter: full(&parameter.name),
        also: others.iter().map(|one| full(&one.name)).collect(),
        of: None,
        unit: parameter.unit.clone(),
        value: sigma,
        sigma: if sigma > 0.0 { spread / (2.0 * sigma) } else { 0.0 },
        aliases,
        memory: None,
        ln_p: walk.ln_p(),
    };
    let likelihood = likelihood + likelihood_of_memory(&rest);
    Some(Found { effect, likelihood, displaced: jumps })
}

/// What may be there instead of a walk.
#[derive(Clone, Copy)]
struct Structure {
    /// Logarithm of how much likelier it must be for the choice that there was.
    price: f64,
    /// Members of its family that were tried.
    members: usize,
    /// Of an effect the level at which it is declared.
    declared: Option<f64>,
}

impl Structure {
    /// One of a stage. What nobody wrote down must be far likelier, the choice among all of it paid for.
    fn of(stage: &Stage, number: usize) -> Self {
        let members = stage.members[number];
        let is_effect = number < stage.effects;
        let blocks = stage.candidates.len() - stage.effects;
        let unknown = if is_effect { 0.0 } else { FURTHER.ln() + (blocks as f64).ln() };
        let declared = is_effect.then(|| level(stage.effects));
        Self { price: unknown + (members as f64).ln(), members, declared }
    }

    /// Whether it is an effect that would be declared: one that would not is none to put in a walk's place.
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
struct Close {
    /// Its number among the structures.
    structure: usize,
    score: Score,
    /// Logarithm of its likelihood, with what it leaves of the walk, over that of the walk alone.
    likelier: f64,
}

/// Takes structure off as long as it, its price paid, and what is left of the walk are clearly likelier than the walk
/// alone; an effect that does for the walk ends it, and is taken where it is likelier at all: what is left then and how many
/// structures are known, `None` where nothing of the walk is left, and the effect that cannot be told from the walk.
fn beside_structure(
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

/// What is offered to the campaigns' models.
fn joined(recipes: &[Recipe], selected: Selected) -> Option<Candidate> {
    let mut made = Vec::new();
    for (campaign, recipe) in recipes.iter().enumerate() {
        if let Ok(system) = recipe.with(std::slice::from_ref(&selected)) {
            join(&mut made, (campaign, recipes.len()), selected.clone(), None, system);
        }
    }
    made.pop()
}

/// A walk that takes a course, as columns in its own place.
fn select(
    candidate: &Candidate,
    times: &Times,
    course: Course,
    sigma: Option<f64>,
) -> Option<Selected> {
    let Selected { effect, head, .. } = &candidate.selected;
    let effect = Arc::new(columns(effect, times, course, sigma)?);
    Some(Selected { effect, head: head.clone(), member: BTreeMap::new() })
}

/// An effect of random walks that take a course as columns, with a prior if a size is given.
fn columns(effect: &Effect, times: &Times, course: Course, sigma: Option<f64>) -> Option<Effect> {
    let name = format!("{}_columns", effect.name);
    let mut text = format!(
        "name = \"{name}\"\ntitle = \"{}\"\nacts = \"noise\"\n[parameters]\n",
        effect.title
    );
    let mut sums: Vec<(&str, String)> = Vec::new();
    for parameter in &effect.parameters {
        let dimension = parameter.unit.dimension * Dimension::TIME.pow(Exponent::new(1, 2)?);
        let unit = Unit::coherent(dimension).si_symbol();
        let mut sum = Vec::new();
        for Column { name, scope, wave, deviation } in times.columns(course) {
            let own = format!("{}_{name}", parameter.name);
            let prior = sigma.map_or_else(String::new, |sigma| {
                let sigma = (sigma * deviation).max(f64::MIN_POSITIVE);
                format!(", value = \"0 {unit}\", sigma = \"{sigma:e} {unit}\"")
            });
            let line = writeln!(
                text,
                "{own} = {{ unit = \"{unit}\", typical = \"1 {unit}\", scope = \"{scope}\"{prior} }}"
            );
            line.ok()?;
            sum.push(format!("{own}{wave}"));
        }
        sums.push((&parameter.name, format!("({})", sum.join(" + "))));
    }
    text.push_str("[patch]\n");
    for line in &effect.patches {
        let formula = replaced(&line.formula.text, &sums);
        writeln!(text, "\"{}\" = '{formula}'", line.name).ok()?;
    }
    Effect::parse(Source::new(name, text)).ok()
}

/// A formula with some of its names replaced.
fn replaced(formula: &str, by: &[(&str, String)]) -> String {
    let mut made = String::new();
    let mut rest = formula;
    while !rest.is_empty() {
        let of_name = |c: char| c.is_alphanumeric() || c == '_' || c == '.';
        let end = rest.find(|c| !of_name(c)).unwrap_or(rest.len());
        let (name, after) = rest.split_at(end);
        let found = by.iter().find(|(known, _)| *known == name);
        made.push_str(found.map_or(name, |(_, sum)| sum));
        let other = after.chars().next().map_or(0, char::len_utf8);
        made.push_str(&after[..other]);
        rest = &after[other..];
    }
    made
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_replaced_as_wholes() {
        let by = [("walk", "(a + b)".to_owned())];
        let made = replaced("position + [walk, 2 * walk_y, -walk]", &by);
        assert_eq!(made, "position + [(a + b), 2 * walk_y, -(a + b)]");
    }
}
