//! Which words may name something in a model or an effect.

use crate::diagnostic::Span;
use crate::document::Item;
use crate::formula::functions::Function;

/// Longest name.
const MAXIMUM_LENGTH: usize = 64;

/// Words with a meaning of their own in formulas, and that meaning.
const RESERVED: &[(&str, &str)] = &[
    ("t", "the measurand's delay with all effects"),
    ("time", "the reference time of the sample"),
    ("moment", "the moment of the reading, time + t"),
    ("index", "the number of the sample in its run"),
    ("run_time", "the time since the start of the run"),
    ("setup_time", "the time since the start of the setup"),
    ("uniform_time", "the straight line through run_time over index, with its jumps"),
    ("jump_time", "how far the stamps of the run have jumped"),
    ("first_jump_time", "jump_time at the first sample of the run"),
    ("last_jump_time", "jump_time at the last sample of the run"),
    ("delay", "as in `horizontal.delay`"),
    ("sigma", "as in `horizontal.sigma`"),
    ("self", "the unpatched quantity"),
    ("each", "as in `each.angle`"),
    ("pi", "the number"),
];

/// Whether a formula may use this name for a time of the sample or a number.
pub fn is_built_in(name: &str) -> bool {
    is_time(name) || matches!(name, "index" | "pi")
}

/// Whether a formula may use this name for a time of the sample.
pub fn is_time(name: &str) -> bool {
    let of_run = matches!(name, "run_time" | "setup_time" | "uniform_time");
    let of_jumps = matches!(name, "jump_time" | "first_jump_time" | "last_jump_time");
    of_run || of_jumps || matches!(name, "t" | "time" | "moment")
}

/// The name of the random error of an input.
pub fn error_of_input(input: &str) -> String {
    format!("{input}.error")
}

/// What is wrong with a name for something formulas may use: message and help.
pub fn fault_of(name: &str) -> Option<(String, String)> {
    let letter = |c: char| c.is_ascii_alphabetic() || c == '_';
    if !name.starts_with(letter) || !name.chars().all(|c| letter(c) || c.is_ascii_digit()) {
        let message = format!("`{name}` cannot be a name");
        let help = "names are letters, digits and underscores, and start with a letter";
        return Some((message, help.to_owned()));
    }
    if name.len() > MAXIMUM_LENGTH {
        let help = format!("at most {MAXIMUM_LENGTH} letters");
        return Some((format!("the name `{name}` is too long"), help));
    }
    if let Some((_, meaning)) = RESERVED.iter().find(|(word, _)| *word == name) {
        let message = format!("the name `{name}` is reserved: {meaning}");
        return Some((message, "choose another name".to_owned()));
    }
    if Function::find(name).is_some() {
        let message = format!("the name `{name}` is reserved: it is a function of formulas");
        return Some((message, "choose another name".to_owned()));
    }
    None
}

/// What is wrong with a name that stands before or behind a dot (`NAME.delay`, `EFFECT.NAME`),
/// where `x`, `y` and `z` are components.
pub fn fault_of_owner(name: &str) -> Option<(String, String)> {
    if matches!(name, "x" | "y" | "z") {
        let message = format!("the name `{name}` is reserved: a component of a vector");
        return Some((message, "choose another name".to_owned()));
    }
    fault_of(name)
}

/// The key of an item, if it may be a name; else records why not.
pub fn checked(item: &Item<'_>, fault: Option<(String, String)>) -> Option<(String, Span)> {
    match fault {
        None => Some((item.key().to_owned(), item.key_span())),
        Some((message, help)) => {
            item.error_at_key(message, &help);
            None
        }
    }
}
