//! Which effects are applied, where and with which members, in order of application.

use std::cmp::Ordering;
use std::collections::{BTreeMap, HashMap};

use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::model::{Model, Override};
use crate::system::Selected;
use crate::system::layer::Placed;
use crate::system::needs::{heads_for, lacks_of};

/// Effects at their heads with their members, in order of application.
pub(super) fn place(
    model: &Model,
    effects: &[Selected],
    overrides: &[Override],
) -> Result<Vec<Placed>, Diagnostics> {
    let mut placed: Vec<Placed> = Vec::new();
    let mut faults = Vec::new();
    for selected in effects {
        match place_one(model, selected, overrides) {
            Ok(more) => placed.extend(more),
            Err(fault) => faults.extend(fault.0),
        }
    }
    Diagnostics(faults).into_result(())?;
    let head = |one: &Placed| one.head.as_ref().and_then(|head| model.heads.get_index_of(head));
    placed.sort_by(|a, b| {
        let names =
            (a.effect.acts, &a.effect.name, head(a)).cmp(&(b.effect.acts, &b.effect.name, head(b)));
        names.then_with(|| compare(&a.member, &b.member))
    });
    placed.dedup_by(|a, b| a.name == b.name && compare(&a.member, &b.member) == Ordering::Equal);
    // A family that is there more than once says which member each one is.
    let mut count: HashMap<String, usize> = HashMap::new();
    for one in &placed {
        *count.entry(one.name.clone()).or_default() += 1;
    }
    for one in placed.iter_mut().filter(|one| count.get(&one.name).is_some_and(|count| *count > 1))
    {
        let members = one.effect.shape.iter().map(|(family, declared)| {
            let value = declared.unit.from_si(one.member.get(family).copied().unwrap_or(0.0));
            let symbol =
                if declared.unit.symbol == "1" { "" } else { declared.unit.symbol.as_str() };
            format!("{family}={value} {symbol}").trim_end().to_owned()
        });
        let members = members.collect::<Vec<_>>().join(", ");
        one.name = format!("{}[{members}]", one.name);
    }
    Ok(placed)
}

fn compare(a: &BTreeMap<String, f64>, b: &BTreeMap<String, f64>) -> Ordering {
    let pairs = a.values().zip(b.values());
    pairs.map(|(a, b)| a.total_cmp(b)).find(|order| order.is_ne()).unwrap_or(Ordering::Equal)
}

fn place_one(
    model: &Model,
    selected: &Selected,
    overrides: &[Override],
) -> Result<Vec<Placed>, Diagnostics> {
    let effect = &selected.effect;
    let refuse = |reasons: &str| {
        Diagnostic::error(format!(
            "the effect `{}` cannot be applied to the model `{}`: {reasons}",
            effect.name, model.name
        ))
    };
    if effect.builtin {
        return Err(refuse("it is a built-in detector and has no form to fit").into());
    }
    let mut heads = heads_for(model, effect);
    if let Some(head) = &selected.head {
        if !heads.iter().flatten().any(|known| known == head) {
            let known: Vec<String> = heads.into_iter().flatten().collect();
            let words = if known.is_empty() {
                "it has no heads here".to_owned()
            } else {
                format!("heads: {}", known.join(", "))
            };
            return Err(refuse(&format!("there is no head `{head}`")).help(words).into());
        }
        heads = vec![Some(head.clone())];
    }
    let mut member = BTreeMap::new();
    for (family, declared) in &effect.shape {
        let name = format!("{}.{family}", effect.name);
        let mut value = declared.members.default_member();
        for said in overrides.iter().filter(|said| said.name == name) {
            if said.setup.is_some() {
                let message = format!("`{name}` is a member of a family, the same in all setups");
                let error = Diagnostic::error(message).help("state it in [parameters]");
                return Err(error.at_maybe(said.place.as_ref()).into());
            }
            if let Some((message, help)) = said.check(1, &declared.unit) {
                let error = Diagnostic::error(message).help(help);
                return Err(error.at_maybe(said.place.as_ref()).into());
            }
            value =
                said.value.as_ref().and_then(|said| said.first()).map_or(value, |(said, _)| *said);
        }
        member.insert(family.clone(), selected.member.get(family).copied().unwrap_or(value));
    }
    if let Some(unknown) = selected.member.keys().find(|key| !effect.shape.contains_key(*key)) {
        return Err(refuse(&format!("it has no family `{unknown}`")).into());
    }
    let mut placed = Vec::new();
    let mut reasons = Diagnostics::default();
    for head in heads {
        let lacks = lacks_of(model, effect, head.as_deref());
        if !lacks.is_empty() {
            reasons.0.extend(lacks);
            continue;
        }
        let name = match &head {
            Some(head) => format!("{}.{head}", effect.name),
            None => effect.name.clone(),
        };
        placed.push(Placed { effect: effect.clone(), head, member: member.clone(), name });
    }
    if !placed.is_empty() {
        return Ok(placed);
    }
    let mut refused = refuse(&reasons.messages());
    // Heads lack the same names, at the same place.
    if let Some(first) = reasons.0.into_iter().next() {
        refused = refused.at_maybe(first.place.as_ref());
        refused.help.extend(first.help);
    }
    Err(refused.into())
}
