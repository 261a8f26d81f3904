//! A parameter that is not what is stated.

use rand::RngExt;
use rand_chacha::ChaCha12Rng;

use crate::engine::Problem;
use crate::engine::open::Recipe;
use crate::model::Override;

/// States one of the parameters that have a standard uncertainty `by` of these off, above or below;
/// with `fixed` as exact. Readings stay as they are. Nothing happens where no parameter is stated
/// so.
pub(super) fn misstate(
    problem: &mut Problem,
    recipes: &mut [Recipe],
    (by, fixed): (f64, bool),
    chance: &mut ChaCha12Rng,
) {
    let mut names: Vec<String> = Vec::new();
    for stated in recipes.iter().flat_map(|recipe| &recipe.overrides).filter(|one| is_known(one)) {
        if !names.contains(&stated.name) {
            names.push(stated.name.clone());
        }
    }
    if names.is_empty() {
        return;
    }
    let name = &names[chance.random_range(0..names.len())];
    let by = if chance.random::<bool>() { by } else { -by };
    for recipe in &mut *recipes {
        let mut own = recipe.overrides.iter_mut().filter(|one| is_known(one) && one.name == *name);
        own.by_ref().for_each(|one| move_value(one, by, fixed));
    }
    let parts = problem.parts.iter().zip(recipes.iter());
    let rebuilt = parts.map(|(part, recipe)| match recipe.with(&[]) {
        Ok(system) => part.with_system(system),
        Err(_) => part.clone(),
    });
    *problem = Problem::new(rebuilt.collect());
}

/// Whether a value is stated with its standard uncertainty.
fn is_known(one: &Override) -> bool {
    one.value.is_some() && one.sigma.is_some() && one.fixed != Some(true)
}

fn move_value(one: &mut Override, by: f64, fixed: bool) {
    if let (Some(value), Some(sigma)) = (&mut one.value, &one.sigma) {
        for (value, sigma) in value.iter_mut().zip(sigma) {
            value.0 += by * sigma.0;
        }
    }
    if fixed {
        (one.fixed, one.sigma) = (Some(true), None);
    }
}
