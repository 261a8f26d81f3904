//! Candidates in relaxed forms, beside those of the library or in their place.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::engine::open::Recipe;
use crate::graph::Scope;
use crate::system::System;

use super::candidate::{Candidate, fitting};
use super::variant::Variant;

/// Effects, with their heads, that are wanted in a relaxed form.
pub type Variants = BTreeMap<String, Variant>;

/// Candidates, those that are wanted in a relaxed form in that, and the others with a value for each
/// angle as well: that is one column more, and errors of opposite sign are nothing to one value.
pub fn with_variants(
    offered: Vec<Candidate>,
    variants: &Variants,
    recipes: &[Recipe],
) -> Vec<Candidate> {
    let mut all = Vec::with_capacity(offered.len());
    for one in offered {
        if let Some(form) = variants.get(&one.name) {
            all.push(relaxed(&one, *form, recipes).unwrap_or(one));
            continue;
        }
        let is_whole = one.selected.effect.shape.is_empty();
        let each = is_whole.then(|| relaxed(&one, Variant::EachAngle, recipes)).flatten();
        all.push(one);
        all.extend(each);
    }
    all
}

/// A candidate in a relaxed form.
fn relaxed(one: &Candidate, form: Variant, recipes: &[Recipe]) -> Option<Candidate> {
    let selected = form.selected(&one.selected)?;
    let relaxed = Candidate { variant: Some(form), ..fitting(recipes, &selected, None)? };
    // What a campaign states of scopes may undo the form.
    (scopes(&relaxed) != scopes(one)).then_some(relaxed)
}

/// The scopes of a candidate's parameters.
fn scopes(one: &Candidate) -> Vec<Scope> {
    let prefix = format!("{}.", one.name);
    let systems = one.systems.iter().flatten();
    let of = |system: &Arc<System>| -> Vec<Scope> {
        let names = system.assembly.names.parameters.iter().zip(&system.settings);
        let own = names.filter(|(parameter, _)| parameter.name.starts_with(&prefix));
        own.map(|(_, setting)| setting.scope).collect()
    };
    systems.flat_map(of).collect()
}
