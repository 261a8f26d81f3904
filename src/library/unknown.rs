//! The error for a stated value of a parameter that is not there, with the names that may be meant.

use crate::diagnostic::{Diagnostic, nearest};
use crate::model::Override;

/// Names that a message lists at most.
const MOST: usize = 12;

/// The error for an override that names nothing.
pub(crate) fn unknown_parameter(said: &Override, known: &[String]) -> Diagnostic {
    let error = Diagnostic::error(format!("there is no parameter `{}`", said.name));
    let error = error.at_maybe(said.place.as_ref());
    if let Some(near) = nearest(&said.name, known.iter().map(String::as_str)) {
        return error.help(format!("did you mean `{near}`?"));
    }
    // The effect that is meant says more than what one of its parameters is called.
    let mut by_part = said.name.split('.').map(|part| with_part(part, known));
    let alike = by_part.find(|names| !names.is_empty()).unwrap_or_default();
    if !alike.is_empty() {
        return error.help(format!("similar names: {}", listed(&alike)));
    }
    match known.len() <= MOST {
        true => error.help(format!("known: {}", known.join(", "))),
        false => error.help("`homepoint effects` lists the effects, whose parameters are called `EFFECT.PARAMETER`; those of a model are in its file"),
    }
}

/// The shortest part of a name (characters) that is looked for in others.
const SHORTEST: usize = 3;

/// The names that have a part like this one: `drum` and `drum_runout.size`.
fn with_part<'k>(part: &str, known: &'k [String]) -> Vec<&'k str> {
    let is_long = |part: &str| part.len() >= SHORTEST;
    let is_alike = |own: &str| is_long(own) && (own.contains(part) || part.contains(own));
    let names = known.iter().map(String::as_str).filter(|_| is_long(part));
    names.filter(|name| name.split('.').any(is_alike)).collect()
}

fn listed(names: &[&str]) -> String {
    let more = match names.len().saturating_sub(MOST) {
        0 => String::new(),
        more => format!(", ... and {more} more"),
    };
    names[..names.len().min(MOST)].join(", ") + &more
}
