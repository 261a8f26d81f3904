//! Text as a terminal may show it: characters that control it are replaced.
//!
//! Titles, names and messages come from files of strangers; an escape sequence in one of them could
//! clear the screen, set the title or change what a line seems to say. All text goes through here on
//! its way out ([`super::output`], [`super::render`]); JSON says the same characters by their
//! numbers.

use std::borrow::Cow;

/// Whether a character acts on a terminal: C0 but for the line's end and the tab, DEL, C1, line
/// separators, and marks that change the direction of writing.
fn acts(c: char) -> bool {
    (c.is_control() && c != '\n' && c != '\t')
        || matches!(
            c,
            '\u{61c}'
                | '\u{200e}'
                | '\u{200f}'
                | '\u{2028}'..='\u{202e}'
                | '\u{2066}'..='\u{2069}'
        )
}

/// What stands for it: a picture of the control character, or the sign for what cannot be shown. One
/// character for one, so that marks below a line stay where they are.
fn picture(c: char) -> char {
    match u32::from(c) {
        code @ 0..=0x1f => char::from_u32(0x2400 + code).unwrap_or(char::REPLACEMENT_CHARACTER),
        0x7f => '\u{2421}',
        _ => char::REPLACEMENT_CHARACTER,
    }
}

/// Whether a text holds a character that acts on a terminal.
pub(super) fn acts_on_terminal(text: &str) -> bool {
    text.contains(acts)
}

/// Text of one or more lines.
pub(super) fn text(text: &str) -> Cow<'_, str> {
    if text.contains(acts) {
        Cow::Owned(text.chars().map(|c| if acts(c) { picture(c) } else { c }).collect())
    } else {
        Cow::Borrowed(text)
    }
}

/// Text that is to stay on its line.
pub(super) fn line(text: &str) -> String {
    let shown = |c: char| if acts(c) || c == '\n' { picture(c) } else { c };
    text.chars().map(shown).collect()
}

/// JSON that is written already; only strings of it can hold such characters.
pub(super) fn json(text: &str) -> Cow<'_, str> {
    if !text.contains(acts) {
        return Cow::Borrowed(text);
    }
    let escaped = text.chars().map(|c| match u32::from(c) {
        code if acts(c) => format!("\\u{code:04x}"),
        _ => c.to_string(),
    });
    Cow::Owned(escaped.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All that could act on a terminal, by number.
    fn controls() -> impl Iterator<Item = char> {
        let ranges = [0..=0x1f, 0x7f..=0x9f, 0x61c..=0x61c, 0x200e..=0x200f, 0x2028..=0x202e];
        let ranges = ranges.into_iter().chain(std::iter::once(0x2066..=0x2069));
        ranges.flatten().filter_map(char::from_u32)
    }

    #[test]
    fn no_character_that_acts_on_a_terminal_is_left() {
        for c in controls().filter(|c| !matches!(c, '\n' | '\t')) {
            let shown = text(&format!("a{c}b")).into_owned();
            assert!(!shown.contains(c), "{:x}", u32::from(c));
            assert_eq!(shown.chars().count(), 3);
            let shown = line(&format!("a{c}\nb"));
            assert!(!shown.contains(c) && !shown.contains('\n'), "{:x}", u32::from(c));
        }
        assert_eq!(text("\u{1b}[2J\u{9b}1m\u{7}\r"), "␛[2J\u{fffd}1m␇␍");
    }

    #[test]
    fn other_text_stays_as_it_is() {
        let own = "Prüfstand µm ± ∞\n\t中文 \u{301} 🙂";
        assert!(matches!(text(own), Cow::Borrowed(same) if same == own));
        assert!(matches!(json(own), Cow::Borrowed(same) if same == own));
    }

    #[test]
    fn json_says_the_same_by_number() {
        for c in controls() {
            let value = serde_json::json!({ "name": format!("a{c}b") });
            let written = value.to_string();
            let cleaned = json(&written);
            assert!(!cleaned.chars().any(acts), "{cleaned}");
            let read: serde_json::Value = serde_json::from_str(&cleaned).unwrap_or_default();
            assert_eq!(read, value);
        }
    }
}
