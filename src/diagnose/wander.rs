//! Random walks, tested in the variance.
//!
//! A walk `W` over a time `T` is a sum of sines with independent coefficients (Karhunen and Loève):
//! `W(t) = σ Σ ξ_k √(2 T) / ((k - ½) π) sin((k - ½) π t / T)`. The first `TERMS` of every run, and where
//! the walk has come to when the run begins, are columns like those of an effect.
//!
//! | file | answers |
//! |---|---|
//! | `course` | how a walk goes on from run to run |
//! | `variance` | how large it is, and how unlikely by chance |
//!
//! A walk looks like structure over time and runs, and structure like a walk: significant structure is
//! taken off first as long as it and what it leaves of the walk are far likelier than the walk alone.
//! What is accepted joins the model as those columns with a prior each, so that everything that comes
//! later is judged against it.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::Arc;

use crate::diagnostic::Source;
use crate::effect::Effect;
use crate::model::Process;
use crate::system::Selected;
use crate::units::{Dimension, Exponent, Unit};

use super::candidates::{Candidate, join};
use super::displaced::{Displaced, Suspect};
use super::evidence::{Entry, Evidence, Owner};
use super::memory::likelihood_of_memory;
use super::score::likelihood_of_gain;
use super::stage::Stage;
use super::verdict::FURTHER;
use super::whiten::{NoiseEffect, sequences};
use course::{Column, Times, number_of};
use variance::ln_plain;

mod course;
mod variance;

pub(super) use course::{Course, Steps};
pub(super) use variance::Walk;

/// Sines of each run: 93 % of a walk's variance.
const TERMS: u8 = 3;
/// A walk that was found.
pub(super) struct Found {
    pub(super) effect: NoiseEffect,
    /// The logarithm of its likelihood ratio against white noise of unit variance, a memory of what it
    /// leaves included.
    pub(super) likelihood: f64,
    /// The displacements that do for it, if it is no walk.
    pub(super) displaced: Option<Displaced>,
}

/// The walk of the library that shows, if one does. `level` is the logarithm of its share of the false
/// alarms.
pub(super) fn walk(stage: &Stage, level: f64) -> Option<Found> {
    let mut best: Option<Found> = None;
    for candidate in &stage.noise {
        let effect = &candidate.selected.effect;
        let walks = !effect.parameters.is_empty()
            && effect.parameters.iter().all(|one| one.process == Process::Walk);
        if !walks {
            continue;
        }
        let Some(found) = tested(stage, candidate, level) else { continue };
        if best.as_ref().is_none_or(|known| found.likelihood > known.likelihood) {
            best = Some(found);
        }
    }
    best
}

fn tested(stage: &Stage, candidate: &Candidate, level: f64) -> Option<Found> {
    let walking = &candidate.selected.effect;
    let times = Times::of(&stage.fitted.problem, TERMS);
    let of = |course, sigma| Some(select(candidate, columns(walking, &times, course, sigma)?));
    let selected: Selected = of(Course::Anywhere, None)?;
    let recipes = &stage.fitted.recipes;
    let mut made = Vec::new();
    for (campaign, recipe) in recipes.iter().enumerate() {
        if let Ok(system) = recipe.with(std::slice::from_ref(&selected)) {
            join(&mut made, (campaign, recipes.len()), selected.clone(), None, system);
        }
    }
    let columns = made.pop()?;
    let structures = stage.structures_beside_noise();
    let mut all: Vec<&Candidate> = structures.iter().map(|n| &stage.candidates[*n]).collect();
    all.push(&columns);
    let fit = &stage.fitted.fit;
    let (evidence, own) = Evidence::beside(&stage.fitted.problem, &fit.normal, &fit.point, &all)?;
    let acts = own.left.trace() > 0.0;
    let anywhere = Steps::of(&own, &times, Course::Anywhere);
    if !acts || ln_plain(&own, &anywhere) > level {
        return None;
    }
    let courses = times.courses(own.owners().len());
    let steps: Vec<(Course, Steps)> =
        courses.into_iter().map(|course| (course, Steps::of(&own, &times, course))).collect();
    // Of the course that is likeliest.
    let beyond = |known: &Entry| {
        let walks = steps.iter().filter_map(|(course, steps)| {
            let walk = Walk::beyond(&evidence, known, &own, steps)?;
            Some((walk.likelihood(), walk, *course))
        });
        walks.filter(|walk| walk.0.is_finite()).max_by(|a, b| a.0.total_cmp(&b.0))
    };
    let entries: Vec<&Entry> = evidence.entries.iter().collect();
    // Structure is taken off as long as it and what is left of the walk are likelier than the walk alone; what
    // nobody wrote down must be far likelier, the choice among all of it paid for.
    let blocks = stage.candidates.len() - stage.effects;
    let choice = |number: usize| {
        let unknown = stage.candidates[number].place.is_some();
        if unknown { FURTHER.ln() + (blocks as f64).ln() } else { 0.0 }
    };
    let (mut walk, mut known) = (beyond(&evidence.together(&[]))?, 0);
    let begins = |owner: &Owner| number_of(&owner.parameter) == 0;
    let displaced = |known: &[&Entry], likelihood: f64, ln_p: f64| {
        let (evidence, own, steps) = (&evidence, &own, &steps[..]);
        let name = &candidate.name;
        Suspect { name, ln_p, evidence, known, own, steps, begins, likelihood, level }
            .displaced(&stage.fitted.problem)
    };
    // Structure over time follows displacements, too, but not as well.
    let mut jumps = displaced(&[], walk.0, walk.1.ln_p());
    while let (None, Some(next)) = (&jumps, entries.get(known)) {
        let (gain, degrees) = evidence.beyond(&evidence.together(&entries[..known]), next);
        let structure = likelihood_of_gain(gain, degrees) - choice(structures[known]);
        let rest = beyond(&evidence.together(&entries[..=known]));
        if walk.0 > structure + rest.as_ref().map_or(0.0, |rest| rest.0.max(0.0)) {
            break;
        }
        walk = rest?;
        known += 1;
    }
    let (likelihood, walk, course) = walk;
    if walk.ln_p() > level {
        return None;
    }
    if known > 0 {
        jumps = displaced(&entries[..known], likelihood, walk.ln_p());
    }
    let (variance, spread) = walk.variance();
    let sigma = variance.sqrt();
    let parameter = walking.parameters.first()?;
    let mut taken: Vec<&Entry> = entries[..known].to_vec();
    let own = Entry::of(own);
    taken.push(&own);
    let rest = evidence.together(&taken);
    let (problem, point) = (&stage.fitted.problem, &fit.point);
    let rest = sequences(problem, &evidence.left(problem, point, &rest, usize::MAX));
    let likelihood = likelihood + likelihood_of_memory(&rest);
    let effect = NoiseEffect {
        name: candidate.name.clone(),
        selected: of(course, Some(sigma)),
        parameter: format!("{}.{}", candidate.name, parameter.name),
        unit: parameter.unit.clone(),
        value: sigma,
        sigma: if sigma > 0.0 { spread / (2.0 * sigma) } else { 0.0 },
        aliases: Vec::new(),
        memory: None,
        ln_p: walk.ln_p(),
    };
    Some(Found { effect, likelihood, displaced: jumps })
}

fn select(candidate: &Candidate, effect: Effect) -> Selected {
    let head = candidate.selected.head.clone();
    Selected { effect: Arc::new(effect), head, member: BTreeMap::new() }
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
