//! What a campaign says of parameters, over what the model and its effects say.
//!
//! The parameter may belong to an effect that only the caller knows, so an override is read here
//! and applied later, by name.

use std::collections::HashSet;

use crate::campaign::statement;
use crate::diagnostic::Diagnostic;
use crate::document::entries::{Entry, Item, Reader, Value};
use crate::graph::Scope;
use crate::model::Override;
use crate::model::parameter::SCOPES;
use crate::units::Unit;

const KEYS: [&str; 14] = [
    "value",
    "sigma",
    "U",
    "k",
    "degrees_of_freedom",
    "lower",
    "upper",
    "start",
    "plausible",
    "linear_range",
    "simulated_at",
    "fixed",
    "scope",
    "sum",
];

/// Reads `[parameters]`. A name with a dot may be quoted or not: `horizontal.delay = { ... }`.
pub(crate) fn read(reader: &mut Reader, entries: &[Entry]) -> Vec<Override> {
    let mut found = Found::default();
    for entry in entries {
        read_one(reader, entry, &entry.key, &mut found);
    }
    found.overrides
}

/// Reads `[setups.NAME]`: what holds in a setup alone, of parameters that have a value in each. A
/// setup without a run is a fault.
pub(crate) fn of_setups(reader: &mut Reader, entries: &[Entry], setups: &[&str]) -> Vec<Override> {
    let mut found = Vec::new();
    for setup in entries {
        if !setups.contains(&setup.key.as_str()) {
            reader.unknown(setup.span, "setup", &setup.key, setups);
        }
        let said = reader.table(&setup.item, "[setups.A]").to_vec();
        let own = read(reader, &said);
        for one in own.iter().filter(|one| one.scope.is_some() || one.sum_zero.is_some()) {
            let message = format!("`scope` and `sum` of `{}` hold for all setups", one.name);
            let fault = Diagnostic::error(message).help("state them in [parameters]");
            reader.report(fault.at_maybe(one.place.as_ref()));
        }
        found.extend(own.into_iter().map(|one| Override { setup: Some(setup.key.clone()), ..one }));
    }
    found
}

/// What `[parameters]` say of how values are known that every setup states for itself is said of
/// those: nobody states another.
pub(crate) fn hand_on(parameters: &mut [Override], setups: &[&str]) {
    let stated_own = |one: &Override| {
        one.value.as_ref()?;
        Some((one.name.clone(), one.setup.clone()?))
    };
    let own: HashSet<(String, String)> = parameters.iter().filter_map(stated_own).collect();
    for index in 0..parameters.len() {
        let general = &parameters[index];
        let (fixed, sigma) = (general.fixed, general.sigma.clone());
        let (degrees, name) = (general.degrees_of_freedom, general.name.clone());
        let stated = |setup: &&str| own.contains(&(name.clone(), (*setup).to_owned()));
        let is_handed_on = general.setup.is_none()
            && general.value.is_none()
            && (fixed.is_some() || sigma.is_some())
            && setups.iter().all(stated);
        if !is_handed_on {
            continue;
        }
        for own in parameters.iter_mut().filter(|one| one.name == name && one.setup.is_some()) {
            if own.fixed.is_none() && own.sigma.is_none() {
                (own.fixed, own.sigma) = (fixed, sigma.clone());
                own.degrees_of_freedom = own.degrees_of_freedom.or(degrees);
            }
        }
        let general = &mut parameters[index];
        (general.fixed, general.sigma, general.degrees_of_freedom) = (None, None, None);
    }
}

/// What was read so far, and the names in it.
#[derive(Default)]
struct Found {
    overrides: Vec<Override>,
    names: HashSet<String>,
}

fn read_one(reader: &mut Reader, entry: &Entry, name: &str, found: &mut Found) {
    let entries = reader.table(&entry.item, "radius = { value = \"1.146 m\", sigma = \"20 um\" }");
    let mut this = Override {
        name: name.to_owned(),
        place: Some(reader.place(entry.span)),
        ..Override::default()
    };
    // An effect's parameter may be called `k`: a table is always a name, no key takes one.
    let is_name = |entry: &&Entry| matches!(entry.item.value, Value::Table(_));
    let (names, said): (Vec<&Entry>, Vec<&Entry>) = entries.iter().partition(is_name);
    for entry in names {
        read_one(reader, entry, &format!("{name}.{}", entry.key), found);
    }
    let said: Vec<Entry> = said.into_iter().cloned().collect();
    let coverage = statement::coverage(reader, &said, &format!("`{name}`"));
    this.degrees_of_freedom = coverage.degrees_of_freedom;
    for entry in &said {
        let item = &entry.item;
        match entry.key.as_str() {
            "value" => this.value = several(reader, item),
            key @ ("sigma" | "U") => {
                let stated = several(reader, item);
                let by = if key == "U" { coverage.factor.unwrap_or(1.0) } else { 1.0 };
                let divided = |(value, unit)| (value / by, unit);
                this.sigma = stated.map(|stated| stated.into_iter().map(divided).collect());
                if this.sigma.iter().flatten().any(|(value, _)| *value <= 0.0) {
                    let message = format!("{key} of `{name}` must be greater than zero");
                    reader.fault(
                        item.span,
                        message,
                        "for a value known exactly write `fixed = true`",
                    );
                }
            }
            "lower" => this.lower = several(reader, item),
            "upper" => this.upper = several(reader, item),
            "start" => this.start = several(reader, item),
            "plausible" => this.plausible = reader.quantity(item).map(|q| (q.value, q.unit)),
            "linear_range" => this.linear_range = reader.quantity(item).map(|q| (q.value, q.unit)),
            "simulated_at" => this.simulated_at = reader.quantity(item).map(|q| (q.value, q.unit)),
            "fixed" => this.fixed = reader.boolean(item),
            "scope" => this.scope = scope(reader, item),
            "sum" => match reader.text(item, "sum = \"zero\"") {
                Some(text) if text == "zero" => this.sum_zero = Some(true),
                Some(text) => reader.unknown(item.span, "sum", &text, &["zero"]),
                None => {}
            },
            "k" | "degrees_of_freedom" => {}
            key => reader.unknown(entry.span, "key", key, &KEYS),
        }
    }
    if !said.is_empty() {
        if this.fixed == Some(true) && this.sigma.is_some() {
            let message = format!("`{name}` is either fixed or known with a standard uncertainty");
            reader.fault(
                entry.span,
                message,
                "leave out `fixed` to use `sigma` as prior knowledge",
            );
        }
        if !found.names.insert(this.name.clone()) {
            reader.fault(entry.span, format!("the parameter `{name}` is here twice"), "");
        }
        found.overrides.push(this);
    }
}

fn scope(reader: &mut Reader, item: &Item) -> Option<Scope> {
    let text = reader.text(item, "scope = \"run\"")?;
    let found = SCOPES.iter().find(|(word, _)| *word == text).map(|(_, scope)| *scope);
    if found.is_none() {
        let known: Vec<&str> = SCOPES.iter().map(|(word, _)| *word).collect();
        reader.unknown(item.span, "scope", &text, &known);
    }
    found
}

/// A quantity or a list of them, in SI with the unit written.
fn several(reader: &mut Reader, item: &Item) -> Option<Vec<(f64, Unit)>> {
    let found = reader.quantities(item)?;
    Some(found.into_iter().map(|quantity| (quantity.value, quantity.unit)).collect())
}
