//! Which known unit somebody may have meant who wrote another word.

use super::TABLE;

/// Units by their names, as people write them out, and spellings of their symbols.
const NAMES: &[(&str, &str)] = &[
    ("metre", "m"),
    ("meter", "m"),
    ("inch", "in"),
    ("sec", "s"),
    ("second", "s"),
    ("minute", "min"),
    ("hour", "h"),
    ("hr", "h"),
    ("radian", "rad"),
    ("degree", "deg"),
    ("revolution", "rev"),
    ("hertz", "Hz"),
    ("percent", "%"),
    ("kelvin", "K"),
    ("celsius", "degC"),
    ("gram", "g"),
    ("kilogram", "kg"),
    ("tonne", "t"),
    ("newton", "N"),
    ("joule", "J"),
    ("watt", "W"),
    ("pascal", "Pa"),
    ("ampere", "A"),
    ("amp", "A"),
    ("volt", "V"),
    ("micron", "um"),
    ("tick", "count"),
];

/// The known symbol nearest to a word: by name, by other capitals, by few letters that differ.
pub(super) fn nearest(word: &str) -> Option<&'static str> {
    let small = word.to_lowercase();
    let singular = small.strip_suffix('s').unwrap_or(&small);
    let named = NAMES.iter().find(|(name, _)| *name == small || *name == singular);
    let capitals = || TABLE.iter().find(|(known, ..)| known.to_lowercase() == small);
    let letters = |text: &str| text.chars().count();
    let by_letters = || {
        let far = |known: &str| strsim::damerau_levenshtein(word, known);
        let close = |known: &str| {
            let shorter = letters(known).min(letters(word));
            far(known) <= 1 + shorter / 5 && far(known) < letters(word)
        };
        let all = TABLE.iter().map(|(known, ..)| *known).filter(|known| close(known));
        all.min_by_key(|known| far(known))
    };
    named
        .map(|(_, symbol)| *symbol)
        .or_else(|| capitals().map(|(symbol, ..)| *symbol))
        .or_else(by_letters)
}
