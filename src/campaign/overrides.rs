//! What a campaign says of parameters, over what the model and its effects say.
//!
//! The parameter may belong to an effect that only the caller knows, so an override is read here
//! and applied later, by name.

use crate::campaign::entries::{Entry, Item, Reader, Value};
use crate::graph::Scope;
use crate::model::Override;
use crate::model::parameter::SCOPES;
use crate::units::Unit;

const KEYS: [&str; 9] =
    ["value", "sigma", "lower", "upper", "start", "plausible", "fixed", "scope", "sum"];

/// Reads `[parameters]`. A name with a dot may be quoted or not: `horizontal.delay = { ... }`.
pub(crate) fn read(reader: &mut Reader, entries: &[Entry]) -> Vec<Override> {
    let mut found = Vec::new();
    for entry in entries {
        read_one(reader, entry, &entry.key, &mut found);
    }
    found
}

fn read_one(reader: &mut Reader, entry: &Entry, name: &str, found: &mut Vec<Override>) {
    let entries = reader.table(&entry.item, "radius = { value = \"1.146 m\", sigma = \"20 um\" }");
    let mut this =
        Override { name: name.to_owned(), place: Some(reader.place(entry.span)), ..nothing() };
    let mut said = false;
    for entry in entries {
        let item = &entry.item;
        if matches!(item.value, Value::Table(_)) && !KEYS.contains(&entry.key.as_str()) {
            read_one(reader, entry, &format!("{name}.{}", entry.key), found);
            continue;
        }
        said = true;
        match entry.key.as_str() {
            "value" => this.value = several(reader, item),
            "sigma" => {
                this.sigma = several(reader, item);
                if this.sigma.iter().flatten().any(|(value, _)| *value <= 0.0) {
                    let message = format!("sigma of `{name}` must be greater than zero");
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
            "fixed" => this.fixed = reader.boolean(item),
            "scope" => this.scope = scope(reader, item),
            "sum" => match reader.text(item, "sum = \"zero\"") {
                Some(text) if text == "zero" => this.sum_zero = Some(true),
                Some(text) => reader.unknown(item.span, "sum", &text, &["zero"]),
                None => {}
            },
            key => reader.unknown(entry.span, "key", key, &KEYS),
        }
    }
    if said {
        if this.fixed == Some(true) && this.sigma.is_some() {
            let message = format!("`{name}` is either fixed or known with a standard uncertainty");
            reader.fault(
                entry.span,
                message,
                "leave out `fixed` to use `sigma` as prior knowledge",
            );
        }
        if found.iter().any(|other| other.name == this.name) {
            reader.fault(entry.span, format!("the parameter `{name}` is here twice"), "");
        }
        found.push(this);
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

fn nothing() -> Override {
    Override {
        name: String::new(),
        place: None,
        value: None,
        sigma: None,
        lower: None,
        upper: None,
        start: None,
        plausible: None,
        fixed: None,
        scope: None,
        sum_zero: None,
    }
}
