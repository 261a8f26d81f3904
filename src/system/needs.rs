//! Whether an effect can be applied to a model, and at which of its heads.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::diagnostic::{Diagnostic, Diagnostics, Place, nearest};
use crate::effect::{Effect, PatchLine, Target};
use crate::graph::{Kind, MeasurandKind, Scope};
use crate::model::component::AXES;
use crate::model::name::{error_of_input, is_built_in};
use crate::model::{Model, Override, ParameterDeclaration, Roles};
use crate::system::{Selected, System};

/// The ways in which an effect can be applied to a model: one for each head that it fits, or one.
///
/// # Errors
/// Why there is none: names that the model lacks, constants that nobody stated, what the assembly
/// of the graph finds; at their places in the effect's file.
pub fn candidates(
    model: &Model,
    effect: &Arc<Effect>,
    overrides: &[Override],
) -> Result<Vec<Selected>, Diagnostics> {
    if effect.builtin {
        let message = "it is a built-in detector and has no form to fit";
        return Err(Diagnostic::error(message).into());
    }
    let mut found = Vec::new();
    let mut reasons: Vec<Diagnostic> = Vec::new();
    for head in heads_for(model, effect) {
        let mut lacks = lacks_of(model, effect, head.as_deref());
        if lacks.is_empty() {
            lacks = missing_constants(effect, overrides);
        }
        if !lacks.is_empty() {
            reasons.extend(lacks);
            continue;
        }
        let selected = Selected { effect: effect.clone(), head, member: BTreeMap::new() };
        match System::build(model, std::slice::from_ref(&selected), overrides, &[]) {
            Ok(_) => found.push(selected),
            Err(faults) => reasons.extend(faults.0),
        }
    }
    let mut seen = std::collections::HashSet::new();
    reasons.retain(|reason| seen.insert(reason.message.clone()));
    if found.is_empty() { Err(Diagnostics(reasons)) } else { Ok(found) }
}

/// The constants (`fixed = true` without a value) that only a campaign can state, by their full
/// names.
fn constants(effect: &Effect) -> impl Iterator<Item = (String, &ParameterDeclaration)> {
    let open = effect.parameters.iter().filter(|p| p.setting.fixed && p.setting.value.is_none());
    open.map(|constant| (format!("{}.{}", effect.name, constant.name), constant))
}

/// Those that no override states.
fn open_constants<'e>(
    effect: &'e Effect,
    overrides: &[Override],
) -> impl Iterator<Item = (String, &'e ParameterDeclaration)> {
    let is_stated =
        |name: &String| overrides.iter().any(|said| said.name == *name && said.value.is_some());
    constants(effect).filter(move |(name, _)| !is_stated(name))
}

/// Their names, if they are all that an effect wants to be applied to a model; empty where it wants
/// none, or more.
pub fn wanted_constants(model: &Model, effect: &Effect, overrides: &[Override]) -> Vec<String> {
    if lacks(model, effect) {
        return Vec::new();
    }
    open_constants(effect, overrides).map(|(name, _)| name).collect()
}

fn missing_constants(effect: &Effect, overrides: &[Override]) -> Vec<Diagnostic> {
    open_constants(effect, overrides)
        .map(|(name, constant)| {
            Diagnostic::error(format!("needs the constant `{name}`"))
                .at(effect.source.place(constant.span))
                .help(format!("state `\"{name}\" = {{ value = ... }}` under [parameters]"))
        })
        .collect()
}

/// One unit of each constant that only a campaign can state, to stand in for it.
pub fn stand_ins(effect: &Effect) -> Vec<Override> {
    constants(effect)
        .map(|(name, constant)| Override {
            name,
            value: Some(vec![(constant.unit.factor, constant.unit.clone())]),
            ..Override::default()
        })
        .collect()
}

/// The heads at which an effect is to be tried: all of them if it names something that heads have
/// in their own way, or patches each angle, which at a head is each of its own, else none.
pub(crate) fn heads_for(model: &Model, effect: &Effect) -> Vec<Option<String>> {
    let uses_heads = names_in(effect)
        .iter()
        .any(|name| model.heads.values().any(|roles| roles.contains_key(owner_of(name))));
    let is_each = |target: &Target| matches!(target, Target::EachAngle | Target::EachAngleSigma);
    let patches_each = effect.patches.iter().any(|line| is_each(&line.target));
    if uses_heads || (patches_each && !model.heads.is_empty()) {
        model.heads.keys().map(|head| Some(head.clone())).collect()
    } else {
        vec![None]
    }
}

/// The least number of names that a model lacks of those that an effect names, over its heads.
pub fn missing_names(model: &Model, effect: &Effect) -> usize {
    let at =
        |head: Option<String>| missing_at(model, effect, &roles_at(model, head.as_deref())).len();
    heads_for(model, effect).into_iter().map(at).min().unwrap_or(0)
}

/// Whether a model lacks what an effect acts on, at each of its heads.
pub fn lacks(model: &Model, effect: &Effect) -> bool {
    let lacks = |head: &Option<String>| !lacks_of(model, effect, head.as_deref()).is_empty();
    heads_for(model, effect).iter().all(lacks)
}

/// What stands for names of the library at a head: its own roles before those of the model.
pub(super) fn roles_at(model: &Model, head: Option<&str>) -> Roles {
    let own = head.and_then(|head| model.heads.get(head));
    let mut roles = model.roles.clone();
    roles.extend(own.into_iter().flatten().map(|(role, means)| (role.clone(), means.clone())));
    roles
}

pub(super) fn missing_at(model: &Model, effect: &Effect, roles: &Roles) -> Vec<String> {
    names_in(effect).into_iter().filter(|name| !has(model, roles, name)).collect()
}

/// What a model (at a head) lacks that an effect names, at its place in the effect's file.
pub(crate) fn lacks_of(model: &Model, effect: &Effect, head: Option<&str>) -> Vec<Diagnostic> {
    let roles = &roles_at(model, head);
    let mut lacks = Vec::new();
    let missing = missing_at(model, effect, roles);
    if let Some(first) = missing.first() {
        let at = head.map(|head| format!(" at its head `{head}`")).unwrap_or_default();
        let quoted: Vec<String> = missing.iter().map(|name| format!("`{name}`")).collect();
        let mut lack = Diagnostic::error(format!("the model has no {}{at}", quoted.join(", ")))
            .at_maybe(place_of(effect, first).as_ref());
        for name in &missing {
            if let Some(near) = nearest(name, names_to_use(model, effect, roles)) {
                lack = lack.help(format!("for `{name}`: did you mean `{near}`?"));
            }
        }
        lacks.push(lack);
    }
    let named =
        |patch: &&PatchLine| matches!(patch.target, Target::EachAngle | Target::EachAngleSigma);
    let angles = model.measurands.iter().any(|m| matches!(m.kind, MeasurandKind::Angle { .. }));
    if let (Some(each), false) = (effect.patches.iter().find(named), angles) {
        let place = effect.source.place(each.span);
        lacks.push(Diagnostic::error("the model reads no angle").at(place));
    }
    for patch in &effect.patches {
        if let Target::Time(name) | Target::Sigma(name) = &patch.target {
            let name = roles.get(name).map_or(name, |role| &role.owner);
            let known = has(model, roles, name);
            if known && !model.measurands.iter().any(|measurand| measurand.name == *name) {
                let message = format!("`{name}` is not a measurand of the model");
                lacks.push(Diagnostic::error(message).at(effect.source.place(patch.span)));
            }
        }
    }
    lacks
}

/// Where an effect names something first.
fn place_of(effect: &Effect, name: &str) -> Option<Place> {
    let of = |patch: &PatchLine| match &patch.target {
        Target::Time(own) | Target::Sigma(own) | Target::Name(own) if own == name => {
            Some(patch.span)
        }
        _ => {
            let names = patch.formula.root.names();
            let found = names.into_iter().find(|(own, _)| *own == name);
            found.map(|(_, span)| span.shifted(patch.formula.offset))
        }
    };
    effect.patches.iter().find_map(of).map(|span| effect.source.place(span))
}

/// The names that an effect may use in a model: the roles of a head instead of what they stand for.
fn names_to_use<'a>(
    model: &'a Model,
    effect: &'a Effect,
    roles: &'a Roles,
) -> impl Iterator<Item = &'a str> {
    let inputs = model.inputs.iter().map(|input| &input.name);
    let parameters = model.parameters.iter().map(|parameter| &parameter.name);
    let measurands = model.measurands.iter().map(|measurand| &measurand.name);
    let of_model = inputs.chain(parameters).chain(measurands).chain(model.quantities.keys());
    let in_a_head = |name: &String| {
        model.heads.values().any(|roles| roles.values().any(|role| role.owner == *name))
    };
    let has_heads = !roles.is_empty() && !model.heads.is_empty();
    let of_model = of_model.filter(move |name| !(has_heads && in_a_head(name)));
    let own = effect.parameters.iter().map(|parameter| &parameter.name).chain(effect.shape.keys());
    of_model.chain(roles.keys()).chain(own).map(String::as_str)
}

/// Every name of the model that an effect names, once, in order.
pub(super) fn names_in(effect: &Effect) -> Vec<String> {
    let mut names = Vec::new();
    for patch in &effect.patches {
        match &patch.target {
            Target::Time(name) | Target::Sigma(name) | Target::Name(name) => {
                names.push(name.clone())
            }
            Target::AllTimes | Target::EachAngle | Target::EachAngleSigma => {}
        }
        names.extend(patch.formula.root.names().into_iter().map(|(name, _)| name.to_owned()));
    }
    let mut seen = std::collections::HashSet::new();
    names.retain(|name| {
        let local =
            effect.shape.contains_key(name) || effect.parameters.iter().any(|p| p.name == *name);
        !local && name != "self" && !is_built_in(name) && seen.insert(name.clone())
    });
    names
}

/// `horizontal` of `horizontal.delay`.
fn owner_of(name: &str) -> &str {
    name.split('.').next().unwrap_or(name)
}

fn has(model: &Model, roles: &Roles, name: &str) -> bool {
    if let Some((owner, part)) = name.split_once('.') {
        let owner = roles.get(owner).map_or(owner, |role| role.owner.as_str());
        let read = model.measurands.iter().any(|measurand| measurand.name == owner);
        let shared = model.delays.iter().any(|group| group.name == owner);
        return (read && matches!(part, "t" | "delay" | "sigma")) || (shared && part == "delay");
    }
    let name = roles.get(name).map_or(name, |role| role.value.as_str());
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
    let several = model.parameters.iter().filter(|one| one.kind != Kind::Scalar);
    let of_one = |one: &ParameterDeclaration| AXES.map(|axis| format!("{}.{axis}", one.name));
    let mut members: Vec<String> = several.flat_map(of_one).collect();
    known.extend(delay_names(model));
    known.extend(model.inputs.iter().map(|input| error_of_input(&input.name)));
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
                if parameter.kind != Kind::Scalar {
                    members.extend(AXES.map(|axis| format!("{name}.{axis}")));
                }
                known.push(name);
            }
        }
    }
    known.append(&mut members);
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
