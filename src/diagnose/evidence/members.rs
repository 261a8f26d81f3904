//! Which member of a family fits best, of an effect that is in the fit or is put into it.
//!
//! A wave has a period, a lag a time constant. What one member takes off chi squared depends on what
//! else is in the fit: a period that was found beside fewer effects is off where others hid in what the
//! wave explained. So it is looked for again beside all of them. An effect with several families keeps
//! the members that it has.

use std::collections::BTreeSet;

use crate::diagnose::fitted::Fitted;
use crate::diagnose::library::candidate::{Candidate, fitting};
use crate::diagnostic::Diagnostics;
use crate::effect::Members;
use crate::engine::Problem;
use crate::engine::layout::Instance;
use crate::engine::open::Recipe;
use crate::estimate::batch::{FitError, Options};
use crate::estimate::calibrate::calibrate;
use crate::system::Selected;
use crate::units::Unit;

use super::Evidence;
use super::scan::{Scanned, scan};

/// What a better member takes off chi squared at least.
const BETTER: f64 = 0.5;
/// Parts of a gain by which those of members differ that do the same.
const ROUNDING: f64 = 1e-6;
/// Rounds in which several effects find theirs beside each other.
const ROUNDS: usize = 3;

/// A member that was chosen.
#[derive(Clone, Debug)]
pub struct Chosen {
    /// `EFFECT.FAMILY`.
    pub name: String,
    /// The member (SI).
    pub value: f64,
    /// Its unit.
    pub unit: Unit,
    /// How many were tried.
    pub tried: usize,
    /// Whether it is one of a range; else of a list.
    pub is_of_range: bool,
    /// Its meaning in words, where numbers do not say it.
    pub meaning: Option<String>,
    /// Of a list what it takes off chi squared, and the best of those that are not as good.
    pub gains: [Option<f64>; 2],
}

/// Whether a member's gain is the largest of its family: a difference below this is rounding.
pub(in crate::diagnose) fn is_as_good(gain: f64, most: f64) -> bool {
    most - gain <= ROUNDING * most.abs().max(1.0)
}

/// The problem with the best member of each family of which none is stated, of effects (`NAME` or
/// `NAME.HEAD`) that are put in; as it is where no fit without them is sound.
///
/// # Errors
/// What putting the model together again finds.
pub fn choose(
    problem: Problem,
    recipes: &[Recipe],
    effects: &[String],
    options: &Options,
) -> Result<(Problem, Vec<Chosen>), Diagnostics> {
    let is_put_in = |one: &Selected| {
        effects.iter().any(|name| name.split('.').next() == Some(&one.effect.name))
    };
    let mut put_in: Vec<Selected> = Vec::new();
    for one in recipes.iter().flat_map(|recipe| &recipe.effects).filter(|one| is_put_in(one)) {
        if !put_in.iter().any(|known| known.name() == one.name()) {
            put_in.push(one.clone());
        }
    }
    let mut recipes = recipes.to_vec();
    let problem = match state_alike(&mut recipes) {
        true => put_together(&problem, &recipes)?,
        false => problem,
    };
    let (open, closed): (Vec<_>, Vec<_>) =
        put_in.into_iter().partition(|one| is_open(&recipes, one));
    if open.is_empty() {
        return Ok((problem, Vec::new()));
    }
    let Ok(found) = fitted_beside(&problem, &recipes, (&closed, &open), options) else {
        return Ok((problem, Vec::new()));
    };
    for (selected, ..) in &found {
        let of = recipes.iter_mut().flat_map(|recipe| &mut recipe.effects);
        for own in of.filter(|own| own.name() == selected.name()) {
            own.member.clone_from(&selected.member);
        }
    }
    let made = put_together(&problem, &recipes)?;
    // Heads have one member.
    let mut known = BTreeSet::new();
    let first = |one: &Best| known.insert(one.0.effect.name.clone());
    let chosen = found.into_iter().filter(first).filter_map(|(selected, tried, gains)| {
        let (family, value) = selected.member.iter().next()?;
        let declared = selected.effect.shape.get(family)?;
        Some(Chosen {
            name: format!("{}.{family}", selected.effect.name),
            value: *value,
            unit: declared.unit.clone(),
            tried,
            is_of_range: matches!(declared.members, Members::Range { .. }),
            meaning: declared.meaning(*value).map(str::to_owned),
            gains,
        })
    });
    Ok((made, chosen.collect()))
}

/// The problem with systems put together anew.
fn put_together(problem: &Problem, recipes: &[Recipe]) -> Result<Problem, Diagnostics> {
    let parts = problem.parts.iter().zip(recipes);
    let parts = parts.map(|(part, recipe)| Ok(part.with_system(recipe.with(&[])?)));
    let mut made = Problem::new(parts.collect::<Result<Vec<_>, Diagnostics>>()?);
    made.progress.clone_from(&problem.progress);
    Ok(made)
}

/// An effect with its best member, how many were tried, and of a list the gains of the best two.
type Best = (Selected, usize, [Option<f64>; 2]);

/// Effects with their best members, beside those without open families and each other.
fn fitted_beside(
    problem: &Problem,
    recipes: &[Recipe],
    (closed, open): (&[Selected], &[Selected]),
    options: &Options,
) -> Result<Vec<Best>, FitError> {
    let names: Vec<String> = closed.iter().chain(open).map(Selected::name).collect();
    let mut recipes = recipes.to_vec();
    for recipe in &mut recipes {
        recipe.effects.retain(|one| !names.contains(&one.name()));
    }
    // What cannot be put together or fitted without them is for the fit with them to report.
    let Ok(nominal) = put_together(problem, &recipes) else { return Ok(Vec::new()) };
    let nominal = calibrate(nominal, options)?;
    let mut fitted = Fitted { recipes, problem: nominal.problem, fit: nominal.fit };
    if !fitted.is_sound() {
        return Ok(Vec::new());
    }
    let take = |fitted: &mut Fitted, selected: &Selected| -> Result<(), FitError> {
        let with = fitted.with(selected, &[], options)?.filter(Fitted::is_sound);
        if let Some(with) = with {
            *fitted = with;
        }
        Ok(())
    };
    for one in closed {
        take(&mut fitted, one)?;
    }
    let mut found: Vec<Best> = Vec::new();
    for heads in open.chunk_by(|a, b| a.effect.name == b.effect.name) {
        // Of the members that are best of each head the one with which all of them fit best.
        let mut best: Option<(Fitted, Vec<Best>)> = None;
        for head in heads {
            let own = match head.effect.shape.values().next().map(|family| &family.members) {
                Some(Members::List(list)) => best_of_list(&fitted, head, list),
                _ => best_of_range(&fitted, head).map(|(best, tried)| (best, tried, [None; 2])),
            };
            let Some((own, tried, gains)) = own else { continue };
            let (mut with, mut all) = (fitted.clone(), Vec::new());
            for other in heads {
                let other = Selected { member: own.member.clone(), ..other.clone() };
                take(&mut with, &other)?;
                all.push((other, tried, gains));
            }
            if best.as_ref().is_none_or(|(known, _)| with.fit.cost < known.fit.cost) {
                best = Some((with, all));
            }
        }
        if let Some((with, all)) = best {
            fitted = with;
            found.extend(all);
        }
    }
    for _ in 0..if closed.len() + open.len() > 1 { ROUNDS } else { 0 } {
        let mut is_other = false;
        for at in 0..found.len() {
            let name = &found[at].0.effect.name;
            if found.iter().filter(|one| one.0.effect.name == *name).count() > 1 {
                continue;
            }
            let (selected, tried, _) = &mut found[at];
            if let Some((with, members)) = with_best_member(&fitted, &selected.name(), options)? {
                fitted = with;
                *tried = members;
                is_other = true;
                let own = fitted.recipes.iter().flat_map(|recipe| &recipe.effects);
                if let Some(own) = own.into_iter().find(|own| own.name() == selected.name()) {
                    selected.member.clone_from(&own.member);
                }
            }
        }
        if !is_other {
            break;
        }
    }
    Ok(found)
}

/// What one campaign states of a member holds for those that state nothing; whether there are such.
fn state_alike(recipes: &mut [Recipe]) -> bool {
    let said: Vec<(String, f64)> = recipes
        .iter()
        .flat_map(|recipe| &recipe.overrides)
        .filter_map(|said| Some((said.name.clone(), said.value.as_ref()?.first()?.0)))
        .collect();
    let mut is_any = false;
    for recipe in recipes {
        let own: BTreeSet<&str> = recipe.overrides.iter().map(|said| said.name.as_str()).collect();
        for selected in &mut recipe.effects {
            for family in selected.effect.shape.keys() {
                let name = format!("{}.{family}", selected.effect.name);
                let stated = said.iter().find(|one| one.0 == name && !own.contains(name.as_str()));
                if let Some((_, value)) = stated.filter(|_| !selected.member.contains_key(family)) {
                    selected.member.insert(family.clone(), *value);
                    is_any = true;
                }
            }
        }
    }
    is_any
}

/// Whether an effect has one family, of which no member is stated. A memory is a matter of the
/// noise: no reading follows it.
fn is_open(recipes: &[Recipe], selected: &Selected) -> bool {
    let effect = &selected.effect;
    let mut families = effect.shape.keys();
    let (Some(family), None) = (families.next(), families.next()) else { return false };
    let name = format!("{}.{family}", effect.name);
    let is_stated = recipes.iter().flat_map(|one| &one.overrides).any(|said| said.name == name);
    let is_chosen = selected.member.contains_key(family) || is_stated;
    !is_chosen && !effect.parameters.is_empty() && family != "memory"
}

/// The effect with the best member of a range beside a fit without it.
fn best_of_range(fitted: &Fitted, selected: &Selected) -> Option<(Selected, usize)> {
    let family = fitting(&fitted.recipes, selected, None)?;
    let (best, tried) = scan(fitted, &family, &mut Scanned::new())?;
    Some((best.selected, tried))
}

/// The same of a list.
fn best_of_list(fitted: &Fitted, selected: &Selected, list: &[f64]) -> Option<Best> {
    let (family, _) = selected.effect.shape.first()?;
    let candidate = |value: &f64| {
        let member = [(family.clone(), *value)].into();
        fitting(&fitted.recipes, &Selected { member, ..selected.clone() }, None)
    };
    let all: Vec<Candidate> = list.iter().filter_map(candidate).collect();
    let Fitted { problem, fit, .. } = fitted;
    let evidence =
        Evidence::new(problem, &fit.normal, &fit.point, &all.iter().collect::<Vec<_>>())?;
    let gain = |at: &usize| evidence.entries[*at].gain().gain;
    let most = (0..all.len()).map(|at| gain(&at)).reduce(f64::max)?;
    let (as_good, others): (Vec<usize>, Vec<usize>) =
        (0..all.len()).partition(|at| is_as_good(gain(at), most));
    let first = *as_good.first()?;
    let gains = [Some(gain(&first)), others.iter().map(gain).reduce(f64::max)];
    Some((all[first].selected.clone(), list.len(), gains))
}

/// A fit with the best member of a range of an effect in it, beside the others, if it is a better one;
/// and how many members were tried. What is stated stays.
///
/// # Errors
/// [`FitError`] where the problem cannot be fitted at all.
pub fn with_best_member(
    fitted: &Fitted,
    name: &str,
    options: &Options,
) -> Result<Option<(Fitted, usize)>, FitError> {
    let mut effects = fitted.recipes.iter().flat_map(|recipe| &recipe.effects);
    let Some(selected) = effects.find(|one| one.name() == name) else { return Ok(None) };
    let plain = Selected { member: Default::default(), ..selected.clone() };
    let is_range =
        selected.effect.shape.values().all(|one| matches!(one.members, Members::Range { .. }));
    if !is_range || !is_open(&fitted.recipes, &plain) {
        return Ok(None);
    }
    let without = fitted.without(&[selected], options)?;
    if !without.is_sound() {
        return Ok(None);
    }
    let Some((best, members)) = best_of_range(&without, selected) else { return Ok(None) };
    let start = |one: &Instance, component: usize| fitted.value(one, component);
    let with = without.with_starts(&best, start, options)?;
    let is_better = |with: &Fitted| with.is_sound() && with.fit.cost + BETTER < fitted.fit.cost;
    Ok(with.filter(is_better).map(|with| (with, members)))
}
