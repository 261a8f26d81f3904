//! Whether an effect can be applied to a model, and at which of its heads.

use std::collections::BTreeMap;
use std::sync::Arc;

use indexmap::IndexMap;

use crate::effect::{Effect, Target};
use crate::formula::{Expression, ExpressionKind};
use crate::graph::{MeasurandKind, Scope};
use crate::model::name::is_built_in;
use crate::model::{Model, Override};
use crate::system::{Selected, System};

/// A head's names by role; empty without heads.
pub(crate) type Aliases = IndexMap<String, String>;

/// Why an effect cannot be applied to a model, if it cannot.
///
/// # Errors
/// A sentence each: names that the model lacks, constants that nobody stated, what the assembly
/// of the graph finds.
pub fn testable(
    model: &Model,
    effect: &Arc<Effect>,
    overrides: &[Override],
) -> Result<(), Vec<String>> {
    candidates(model, effect, overrides).map(|_| ())
}

/// The ways in which an effect can be applied to a model: one for each head that it fits, or one.
///
/// # Errors
/// Why there is none, as [`testable`].
pub fn candidates(
    model: &Model,
    effect: &Arc<Effect>,
    overrides: &[Override],
) -> Result<Vec<Selected>, Vec<String>> {
    if effect.builtin {
        return Err(vec!["it is a built-in detector and has no form to fit".to_owned()]);
    }
    let mut found = Vec::new();
    let mut reasons = Vec::new();
    for head in heads_for(model, effect) {
        let mut lacks = lacks_of(model, effect, head.as_deref());
        if lacks.is_empty() {
            lacks = missing_constants(effect, overrides);
        }
        if !lacks.is_empty() {
            lacks.retain(|lack| !reasons.contains(lack));
            reasons.extend(lacks);
            continue;
        }
        let selected = Selected { effect: effect.clone(), head, member: BTreeMap::new() };
        match System::build(model, std::slice::from_ref(&selected), overrides, &[]) {
            Ok(_) => found.push(selected),
            Err(faults) => reasons.extend(faults.0.into_iter().map(|fault| fault.message)),
        }
    }
    if found.is_empty() { Err(reasons) } else { Ok(found) }
}

/// Constants (`fixed = true` without a value) that no override states, a sentence each.
fn missing_constants(effect: &Effect, overrides: &[Override]) -> Vec<String> {
    let constants =
        effect.parameters.iter().filter(|p| p.setting.fixed && p.setting.value.is_none());
    constants
        .filter(|constant| {
            let name = format!("{}.{}", effect.name, constant.name);
            !overrides.iter().any(|said| said.name == name && said.value.is_some())
        })
        .map(|constant| format!("needs the constant `{}.{}`", effect.name, constant.name))
        .collect()
}

/// The heads at which an effect is to be tried: all of them if it names something that heads have
/// in their own way, else none.
pub(crate) fn heads_for(model: &Model, effect: &Effect) -> Vec<Option<String>> {
    let uses_heads = names_in(effect)
        .iter()
        .any(|name| model.heads.values().any(|aliases| aliases.contains_key(owner_of(name))));
    if uses_heads {
        model.heads.keys().map(|head| Some(head.clone())).collect()
    } else {
        vec![None]
    }
}

/// What a model (at a head) lacks that an effect names, a sentence each.
pub(crate) fn lacks_of(model: &Model, effect: &Effect, head: Option<&str>) -> Vec<String> {
    let none = Aliases::new();
    let aliases = head.and_then(|head| model.heads.get(head)).unwrap_or(&none);
    let mut lacks = Vec::new();
    let missing = names_in(effect).into_iter().filter(|name| !has(model, aliases, name));
    let missing: Vec<String> = missing.map(|name| format!("`{name}`")).collect();
    if !missing.is_empty() {
        let at = head.map(|head| format!(" at its head `{head}`")).unwrap_or_default();
        lacks.push(format!("the model has no {}{at}", missing.join(", ")));
    }
    let each = effect
        .patches
        .iter()
        .any(|p| matches!(p.target, Target::EachAngle | Target::EachAngleSigma));
    let angles = model.measurands.iter().any(|m| matches!(m.kind, MeasurandKind::Angle { .. }));
    if each && !angles {
        lacks.push("the model reads no angle".to_owned());
    }
    for patch in &effect.patches {
        if let Target::Time(name) | Target::Sigma(name) = &patch.target {
            let name = aliases.get(name).unwrap_or(name);
            let known = has(model, aliases, name);
            if known && !model.measurands.iter().any(|measurand| measurand.name == *name) {
                lacks.push(format!("`{name}` is not a measurand of the model"));
            }
        }
    }
    lacks
}

/// Every name of the model that an effect names, once, in order.
fn names_in(effect: &Effect) -> Vec<String> {
    let mut names = Vec::new();
    for patch in &effect.patches {
        match &patch.target {
            Target::Time(name) | Target::Sigma(name) | Target::Name(name) => {
                names.push(name.clone())
            }
            Target::AllTimes | Target::EachAngle | Target::EachAngleSigma => {}
        }
        names_of(&patch.formula.root, &mut names);
    }
    let mut seen = std::collections::HashSet::new();
    names.retain(|name| {
        let local =
            effect.shape.contains_key(name) || effect.parameters.iter().any(|p| p.name == *name);
        !local && name != "self" && !is_built_in(name) && seen.insert(name.clone())
    });
    names
}

/// The names in an expression. Its depth is limited by the parser.
pub(crate) fn names_of(expression: &Expression, names: &mut Vec<String>) {
    match &expression.kind {
        ExpressionKind::Number(..) => {}
        ExpressionKind::Name(name) => names.push(name.clone()),
        ExpressionKind::Member(inner, _) | ExpressionKind::Negate(inner) => names_of(inner, names),
        ExpressionKind::Vector(parts) => parts.iter().for_each(|part| names_of(part, names)),
        ExpressionKind::Binary(_, left, right) => {
            names_of(left, names);
            names_of(right, names);
        }
        ExpressionKind::Call(_, arguments) => {
            arguments.iter().for_each(|part| names_of(part, names))
        }
    }
}

/// `horizontal` of `horizontal.delay`.
fn owner_of(name: &str) -> &str {
    name.split('.').next().unwrap_or(name)
}

fn has(model: &Model, aliases: &Aliases, name: &str) -> bool {
    let name = aliases.get(name).map_or(name, String::as_str);
    if let Some((owner, part)) = name.split_once('.') {
        let owner = aliases.get(owner).map_or(owner, String::as_str);
        let read = model.measurands.iter().any(|measurand| measurand.name == owner);
        let shared = model.delays.iter().any(|group| group.name == owner);
        return (read && matches!(part, "t" | "delay" | "sigma")) || (shared && part == "delay");
    }
    model.inputs.iter().any(|input| input.name == name)
        || model.parameters.iter().any(|parameter| parameter.name == name)
        || model.quantities.contains_key(name)
        || model.measurands.iter().any(|measurand| measurand.name == name)
}

/// Every name that an override of this model or of these effects may have.
pub fn known_names<'e>(
    model: &Model,
    effects: impl Iterator<Item = &'e Arc<Effect>>,
) -> Vec<String> {
    let mut known: Vec<String> = model.parameters.iter().map(|p| p.name.clone()).collect();
    known.extend(delay_names(model));
    known.extend(model.inputs.iter().map(|input| format!("{}.error", input.name)));
    for effect in effects {
        let mut owners = vec![effect.name.clone()];
        owners.extend(
            heads_for(model, effect)
                .into_iter()
                .flatten()
                .map(|head| format!("{}.{head}", effect.name)),
        );
        for owner in owners {
            known.extend(effect.shape.keys().map(|family| format!("{owner}.{family}")));
            for parameter in &effect.parameters {
                let name = format!("{owner}.{}", parameter.name);
                if parameter.per_measurand {
                    known.extend(model.measurands.iter().map(|m| format!("{name}.{}", m.name)));
                }
                known.push(name);
            }
        }
    }
    known
}

/// The names of the model's delays: shared ones first, then those of single measurands.
pub(crate) fn delay_names(model: &Model) -> impl Iterator<Item = String> + '_ {
    let own = model.measurands.iter().map(|measurand| &measurand.name);
    let own = own.filter(|name| !model.delays.iter().any(|group| group.of.contains(name)));
    model.delays.iter().map(|group| &group.name).chain(own).map(|name| format!("{name}.delay"))
}

/// Whether a scope is that of random quantities.
pub(crate) fn is_random(scope: Scope) -> bool {
    scope == Scope::Sample
}
