//! Reads an effect file; every fault is reported with its place, and as many as there are.

use std::collections::HashSet;

use indexmap::IndexMap;

use crate::diagnostic::{Diagnostics, Source};
use crate::document::{Item, Reader, Section};
use crate::effect::{Acts, Effect, Family, Members, PatchLine, Target};
use crate::graph::Scope;
use crate::model::name::{checked, fault_of, fault_of_owner};
use crate::model::parameter::declaration_of;
use crate::model::read::fault_of_random;
use crate::model::{ParameterDeclaration, Process};
use crate::units::Unit;

/// The words for [`Acts`], in the order in which effects apply.
pub const ACTS: &[(&str, Acts)] = &[
    ("timing", Acts::Timing),
    ("encoder", Acts::Encoder),
    ("arm", Acts::Arm),
    ("target", Acts::Target),
    ("platform", Acts::Platform),
    ("transformation", Acts::Transformation),
    ("servo", Acts::Servo),
    ("instrument", Acts::Instrument),
    ("distance", Acts::Distance),
    ("atmosphere", Acts::Atmosphere),
    ("noise", Acts::Noise),
];

impl Acts {
    /// The word for it.
    pub fn word(self) -> &'static str {
        ACTS.iter().find(|(_, acts)| *acts == self).map_or("", |(word, _)| word)
    }
}

impl Effect {
    /// Reads an effect file.
    ///
    /// # Errors
    /// Every fault of its form, with its place.
    pub fn parse(source: Source) -> Result<Self, Diagnostics> {
        let reader = Reader::new(&source);
        let table = reader.parse()?;
        let effect = read(&reader, &reader.root(&table, "an effect"));
        reader.into_result(effect)
    }
}

fn read(reader: &Reader<'_>, root: &Section<'_>) -> Option<Effect> {
    let name = root.require("name").and_then(|item| {
        let name = item.string()?;
        let Some((message, help)) = fault_of_owner(name) else { return Some(name.to_owned()) };
        item.error(message, &help);
        None
    });
    let text = |key: &'static str| root.get(key).and_then(|item| item.string()).map(str::to_owned);
    let (title, reference, about) = (text("title"), text("source"), text("about"));
    let acts = root.require("acts").and_then(|item| item.choice(ACTS));
    let flag = |key: &'static str| root.get(key).and_then(|item| item.boolean()).unwrap_or(false);
    let (builtin, runs_in_sequence) = (flag("builtin"), flag("runs_in_sequence"));
    let mut taken = HashSet::new();
    let shape = families(root.section("shape").as_ref(), &mut taken);
    let parameters = parameters(root.section("parameters").as_ref(), &mut taken, &shape);
    let section = root.section("patch");
    let mut patches = Vec::new();
    let mut lines = Vec::new();
    for item in section.iter().flat_map(Section::entries) {
        flatten(item.key().to_owned(), item, &mut lines);
    }
    for (name, item) in lines {
        let Some(target) = target_of(&name, &item) else { continue };
        let Some(formula) = item.formula() else { continue };
        patches.push(PatchLine { name, span: item.key_span(), target, formula });
    }
    if !builtin && section.is_none() && !reader.has_faults() {
        reader.error(
            root.span(),
            "the effect patches nothing",
            "say what it changes: [patch] distance = 'distance + offset'",
        );
    }
    if builtin && let Some(section) = &section {
        reader.error(section.span(), "a built-in detector has no patch", "leave out `builtin`");
    }
    root.finish();
    Some(Effect {
        name: name?,
        title: title.unwrap_or_default(),
        reference,
        source: reader.source().clone(),
        acts: acts?,
        builtin,
        runs_in_sequence,
        parameters,
        patches,
        shape,
        about: about.unwrap_or_default(),
    })
}

/// A name local to the effect: no component, not taken.
fn local_name(item: &Item<'_>, taken: &mut HashSet<String>) -> Option<String> {
    let (name, _) = checked(item, fault_of_owner(item.key()))?;
    if !taken.insert(name.clone()) {
        item.error_at_key(
            format!("the name `{name}` is already taken in [shape]"),
            "choose another name",
        );
        return None;
    }
    Some(name)
}

fn parameters(
    section: Option<&Section<'_>>,
    taken: &mut HashSet<String>,
    shape: &IndexMap<String, Family>,
) -> Vec<ParameterDeclaration> {
    let mut parameters = Vec::new();
    for item in section.into_iter().flat_map(Section::entries) {
        let Some(name) = local_name(&item, taken) else { continue };
        let Some(parameter) = declaration_of(&item, name, Scope::Instrument) else { continue };
        if let Some((message, help)) = fault_of_random(&parameter) {
            item.error_at_key(message, help);
        }
        let setting = &parameter.setting;
        let said =
            |key: &'static str| item.section("").is_some_and(|section| section.get(key).is_some());
        let random = setting.scope == Scope::Sample;
        if !random && (parameter.process != Process::White || parameter.memory.is_some()) {
            item.error_at_key(
                format!("`{}` has a process but is not random", parameter.name),
                "write scope = \"sample\"",
            );
        }
        let remembers = parameter.process == Process::Memory;
        if random && remembers && parameter.memory.is_none() && !shape.contains_key("memory") {
            item.error_at_key(
                format!("`{}` is autocorrelated, but with no stated correlation time", parameter.name),
                "write memory = \"1 s\", or a family: [shape] memory = { unit = \"s\", from = \"0.1 s\", to = \"30 s\" }",
            );
        }
        if !said("typical") && !setting.fixed {
            item.error_at_key(
                format!("`{}` needs `typical`", parameter.name),
                "the magnitude such rigs show, as in typical = \"2 arcsec\"; a constant is `fixed = true`",
            );
        }
        parameters.push(parameter);
    }
    parameters
}

fn families(
    section: Option<&Section<'_>>,
    taken: &mut HashSet<String>,
) -> IndexMap<String, Family> {
    section
        .into_iter()
        .flat_map(Section::entries)
        .filter_map(|item| {
            let name = local_name(&item, taken)?;
            let family = family_of(&item)?;
            Some((name, family))
        })
        .collect()
}

/// `[3, 4, 5]`, `["1 s", "2 s"]`, `{ unit = "s", members = [...], means = [...] }` or
/// `{ unit, from, to }`.
fn family_of(item: &Item<'_>) -> Option<Family> {
    if !item.is_table() {
        return members_of(item, None);
    }
    let section = item.section(&format!("the family `{}`", item.key()))?;
    let unit = section.get("unit").map_or(Some(Unit::one()), |item| item.unit());
    let (members, from, to) = (section.get("members"), section.get("from"), section.get("to"));
    let means = section.get("means");
    section.finish();
    let unit = unit?;
    match (members, from, to) {
        (Some(members), None, None) => {
            let family = members_of(&members, Some(unit))?;
            let Some(item) = means else { return Some(family) };
            let means: Vec<String> = item.strings()?.into_iter().map(|(words, _)| words).collect();
            if members.list().is_none_or(|list| list.len() != means.len()) {
                item.error("`means` needs as many sentences as there are members", "");
                return None;
            }
            Some(Family { means, ..family })
        }
        (None, Some(from), Some(to)) => {
            if let Some(means) = means {
                means
                    .error("a range has no `means`: they are those of the `members` of a list", "");
                return None;
            }
            let (from, to) = (from.quantity(&unit), to.quantity(&unit));
            let (from, to) = (from?.0, to?.0);
            if from >= to {
                item.error("`from` must be below `to`", "");
                return None;
            }
            Some(Family { unit, members: Members::Range { from, to }, means: Vec::new() })
        }
        _ => {
            item.error(
                format!(
                    "the family `{}` needs either `members` or both `from` and `to`",
                    item.key()
                ),
                "as in { unit = \"Hz\", from = \"0.5 Hz\", to = \"20 Hz\" }",
            );
            None
        }
    }
}

fn members_of(item: &Item<'_>, unit: Option<Unit>) -> Option<Family> {
    let list = item.list()?;
    let mut unit = unit;
    let mut members = Vec::with_capacity(list.len());
    for member in &list {
        let (value, found) = match &unit {
            Some(unit) => member.quantity(unit)?,
            None => member.any_quantity(None)?,
        };
        members.push(value);
        unit.get_or_insert(found);
    }
    let (Some(unit), false) = (unit, members.is_empty()) else {
        item.error(format!("the family `{}` has no members", item.key()), "");
        return None;
    };
    Some(Family { unit, members: Members::List(members), means: Vec::new() })
}

/// TOML reads `horizontal.sigma = '...'` as a table in a table: puts the name together again.
fn flatten<'r>(name: String, item: Item<'r>, lines: &mut Vec<(String, Item<'r>)>) {
    // Deeper names than `each.angle.sigma` do not exist; the formula is then missing its text.
    if !item.is_table() || name.matches('.').count() > 2 {
        lines.push((name, item));
        return;
    }
    for inner in item.section("the patch").iter().flat_map(Section::entries) {
        flatten(format!("{name}.{}", inner.key()), inner, lines);
    }
}

/// What the left side of a patch names.
fn target_of(left: &str, item: &Item<'_>) -> Option<Target> {
    let parts: Vec<&str> = left.split('.').collect();
    let name = |name: &str| match fault_of(name) {
        None => Some(name.to_owned()),
        Some((message, _)) => {
            item.error_at_key(format!("`{left}` cannot be patched: {message}"), "");
            None
        }
    };
    match parts.as_slice() {
        ["t"] => Some(Target::AllTimes),
        ["each", "angle"] => Some(Target::EachAngle),
        ["each", "angle", "sigma"] => Some(Target::EachAngleSigma),
        [owner, "t"] => name(owner).map(Target::Time),
        [owner, "sigma"] => name(owner).map(Target::Sigma),
        [owner] => name(owner).map(Target::Name),
        _ => {
            item.error_at_key(
                format!("`{left}` cannot be patched"),
                "a patch names t, NAME.t, NAME.sigma, each.angle, each.angle.sigma or a name of the model",
            );
            None
        }
    }
}
