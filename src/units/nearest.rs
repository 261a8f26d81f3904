//! Which known unit may be meant by another word.

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
    ("day", "d"),
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

/// Words of two meanings, and the symbols of both.
const TWO_MEANINGS: &[(&str, &str)] = &[
    ("grad", "`gon` (400 to a full turn) or `deg` (360, in German *Grad*)"),
    ("grade", "`gon` (400 to a full turn) or `deg` (360, in German *Grad*)"),
];

/// Prefixes of SI units.
const PREFIXES: &str = "TGMkhdcmuµ\u{3bc}np";
/// Words of fewer letters are no misspelt symbols: each may be another unit.
const SHORTEST: usize = 3;

/// The question which unit was meant by a word: by name, by other capitals, by few letters that differ. A
/// symbol of another size is none that was misspelt.
pub(super) fn meant(word: &str) -> Option<String> {
    let small = word.to_lowercase();
    let singular = small.strip_suffix('s').unwrap_or(&small);
    let is = |name: &str| name == small || name == singular;
    if let Some((_, both)) = TWO_MEANINGS.iter().find(|(name, _)| is(name)) {
        return Some(format!("write {both}"));
    }
    let named = NAMES.iter().find(|(name, _)| is(name)).map(|(_, symbol)| *symbol);
    let nearest = named.or_else(|| misspelt(word, &small))?;
    Some(format!("did you mean `{nearest}`?"))
}

/// The symbol that was misspelt; none where the word is a unit with a prefix that the table lacks.
fn misspelt(word: &str, small: &str) -> Option<&'static str> {
    let has_prefix = word.starts_with(|first| PREFIXES.contains(first));
    let unit: String = word.chars().skip(1).collect();
    if has_prefix && super::row(&unit).is_some() {
        return None;
    }
    let known = || TABLE.iter().map(|(known, ..)| *known);
    let mut capitals = known().filter(|known| known.to_lowercase() == small);
    if let Some(first) = capitals.next() {
        return capitals.next().is_none().then_some(first);
    }
    let letters = |text: &str| text.chars().count();
    let far = |known: &str| strsim::damerau_levenshtein(word, known);
    let close = |known: &&str| {
        let shorter = letters(known).min(letters(word));
        let begins_alike = known.chars().next() == word.chars().next();
        begins_alike && shorter >= SHORTEST && far(known) <= 1 + shorter / 5
    };
    known().filter(close).min_by_key(|known| far(known))
}
