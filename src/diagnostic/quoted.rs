//! Texts and numbers as messages quote them: never longer than a reader needs.

use std::borrow::Cow;

/// The most characters of a text that a message quotes.
const LONGEST_QUOTE: usize = 40;
/// A message with a longer part in backticks quotes it in part: paths are shorter.
const LONGEST_WORD: usize = 500;
/// The same of a part that is not in backticks: lists of names are shorter.
const LONGEST_PART: usize = 4000;

/// A text for a message: its beginning where it is long.
pub fn shortened(text: &str) -> Cow<'_, str> {
    shortened_to(text, LONGEST_QUOTE)
}

fn shortened_to(text: &str, most: usize) -> Cow<'_, str> {
    match text.char_indices().nth(most) {
        None => Cow::Borrowed(text),
        Some((end, _)) => Cow::Owned(format!("{}...", &text[..end])),
    }
}

/// A message whose parts in backticks are not longer than [`LONGEST_WORD`], whoever wrote it.
pub(super) fn short_quotes(message: String) -> String {
    if message.len() <= LONGEST_WORD {
        return message;
    }
    let parts: Vec<Cow<'_, str>> = message
        .split('`')
        .enumerate()
        .map(|(number, part)| match number % 2 {
            0 => shortened_to(part, LONGEST_PART),
            _ => shortened_to(part, LONGEST_WORD),
        })
        .collect();
    parts.join("`")
}

/// A number for a message: a power of ten in place of many zeros.
pub fn number(value: f64) -> String {
    let is_short = value == 0.0 || (1e-9..1e18).contains(&value.abs());
    if is_short { value.to_string() } else { format!("{value:e}") }
}

/// So many of a noun: `1 row`, `2 rows`.
pub fn counted(count: usize, noun: &str) -> String {
    if count == 1 { format!("1 {noun}") } else { format!("{count} {noun}s") }
}

/// A number with so many decimals.
pub fn decimals(value: f64, places: usize) -> String {
    if value.abs() < 1e15 { format!("{value:.places$}") } else { format!("{value:.places$e}") }
}
