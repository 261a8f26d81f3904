//! Which columns of two logs, or of one, are called alike: those of a reading, and of what it is read of.

use crate::campaign::begin::candidate::{Candidate, base};
use crate::campaign::begin::log::Log;
use crate::model::name;

/// Words for what was asked for, and for what came of it, in one log.
const ASKED: [&str; 19] = [
    "sent",
    "cmd",
    "command",
    "ref",
    "reference",
    "set",
    "setpoint",
    "desired",
    "target",
    "goal",
    "star",
    "true",
    "truth",
    "nominal",
    "catalogue",
    "catalog",
    "planned",
    "sim",
    "simulated",
];
const CAME: [&str; 15] = [
    "reported",
    "meas",
    "measured",
    "act",
    "actual",
    "read",
    "state",
    "feedback",
    "fb",
    "enc",
    "encoder",
    "obs",
    "observed",
    "tel",
    "instrument",
];

/// Words of uncertainties.
const UNCERTAINTIES: [&str; 6] = ["sigma", "std", "sd", "var", "err", "error"];
/// Characters between the words of a name.
const SEPARATORS: [char; 4] = ['_', '.', ' ', '/'];

/// What a name says beside words for what was asked for and what came of it.
fn stem(name: &str, words: &[&str]) -> Option<String> {
    let base = base(name).0;
    let parts: Vec<&str> = base.split(SEPARATORS).collect();
    let rest: Vec<&str> = parts.iter().copied().filter(|part| !words.contains(part)).collect();
    (rest.len() < parts.len()).then(|| rest.join("_"))
}

/// Columns of both files that are called alike, or of one log those asked for and those that came:
/// the name, the reading, and what it is read of.
pub(super) fn alike(data: &Log, stream: &Log) -> Vec<Pair> {
    let is_one_log = std::ptr::eq(data, stream);
    let own_key = |name: &str| {
        let is_asked = is_one_log && stem(name, &ASKED).is_some();
        (!is_asked).then(|| stem(name, &CAME).unwrap_or_else(|| base(name).0))
    };
    let other_key = |name: &str| match is_one_log {
        true => stem(name, &ASKED),
        false => Some(stem(name, &ASKED).unwrap_or_else(|| base(name).0)),
    };
    let streams = moving(stream);
    let mut found = Vec::new();
    for own in moving(data) {
        // A number is no name: columns of two files without header have nothing in common.
        let Some(own_name) = name_of(data, &own) else { continue };
        let Some(own_key) = own_key(own_name) else { continue };
        let is_like = |other: &&Candidate| other.unit.dimension == own.unit.dimension;
        let is_same = |other: &&Candidate| {
            name_of(stream, other).and_then(other_key).as_ref() == Some(&own_key)
        };
        let within = || {
            let key = |other: &Candidate| name_of(stream, other).and_then(other_key);
            let is_within =
                |other: &&Candidate| key(other).is_some_and(|other| contain(&own_key, &other));
            let mut all = streams.iter().filter(is_like).filter(is_within);
            // Of several, no name says which.
            all.next().filter(|_| all.next().is_none())
        };
        let other = streams.iter().filter(is_like).find(is_same);
        let other = other.or_else(|| within().filter(|_| !is_one_log));
        let name = identifier(&own_key);
        found.extend(other.cloned().map(|other| Pair { name, own: own.clone(), other }));
    }
    found
}

/// Whether all words of one name are among those of the other, as `x` in `rig_x`; the uncertainty of a
/// quantity is another one.
fn contain(one: &str, other: &str) -> bool {
    let words = |name: &'_ str| -> Vec<String> {
        name.split(SEPARATORS).filter(|word| !word.is_empty()).map(str::to_owned).collect()
    };
    let (one, other) = (words(one), words(other));
    let is_uncertainty =
        |words: &[String]| words.iter().any(|word| UNCERTAINTIES.contains(&word.as_str()));
    let all_in =
        |a: &[String], b: &[String]| !a.is_empty() && a.iter().all(|word| b.contains(word));
    is_uncertainty(&one) == is_uncertainty(&other) && (all_in(&one, &other) || all_in(&other, &one))
}

/// A reading and what it is read of.
pub(super) struct Pair {
    pub(super) name: String,
    pub(super) own: Candidate,
    pub(super) other: Candidate,
}

/// The columns of a log that move.
pub(super) fn moving(log: &Log) -> Vec<Candidate> {
    let guess = &log.guess;
    let poses = guess.position.iter().flatten().chain(guess.attitude.iter().flatten());
    poses.chain(&guess.heading).chain(&guess.others).cloned().collect()
}

/// The name of a column, if it has one.
pub(super) fn name_of<'l>(log: &'l Log, one: &Candidate) -> Option<&'l str> {
    let column = &log.survey.columns[one.column];
    column.is_named.then_some(column.name.as_str())
}

/// A name of a model.
pub(super) fn identifier(text: &str) -> String {
    let plain: String =
        text.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    let plain = plain.trim_matches('_');
    match name::fault_of(plain) {
        None if !plain.is_empty() => plain.to_owned(),
        _ => format!("c_{plain}"),
    }
}
