//! Text to tokens with spans.

use crate::diagnostic::Span;
use crate::formula::error::FormulaError;

/// A word of a formula.
#[derive(Clone, Debug, PartialEq)]
pub enum Token {
    /// A number.
    Number(f64),
    /// A name with its dots: `horizontal.delay`, `point.x`; `%` after a number.
    Name,
    /// One of `+ - * / ^ ( ) [ ] , .`
    Symbol(char),
    /// The end of the text.
    End,
}

/// All tokens of a text, [`Token::End`] last.
///
/// # Errors
/// A character that no formula has, or a number that cannot be held.
pub fn tokens(text: &str) -> Result<Vec<(Token, Span)>, FormulaError> {
    let mut tokens = Vec::new();
    let mut at = 0;
    while let Some(first) = text[at..].chars().next() {
        let start = at;
        if first.is_whitespace() {
            at += first.len_utf8();
            continue;
        }
        let token = if first.is_ascii_digit() || (first == '.' && digits(&text[at + 1..]) > 0) {
            at += number(&text[at..]);
            let written = &text[start..at];
            match written.parse::<f64>() {
                Ok(value) if value.is_finite() => Token::Number(value),
                _ => {
                    return Err(FormulaError::Number {
                        found: written.to_owned(),
                        span: Span::new(start, at),
                    });
                }
            }
        } else if first == '%' && matches!(tokens.last(), Some((Token::Number(_), _))) {
            at += 1;
            Token::Name
        } else if starts_name(first) {
            at += name(&text[at..]);
            Token::Name
        } else if "+-*/^()[],.".contains(first) {
            at += 1;
            Token::Symbol(first)
        } else {
            let span = Span::new(start, start + first.len_utf8());
            return Err(FormulaError::Character { found: first, span });
        };
        tokens.push((token, Span::new(start, at)));
    }
    tokens.push((Token::End, Span::new(text.len(), text.len())));
    Ok(tokens)
}

fn starts_name(character: char) -> bool {
    character.is_alphabetic() || character == '_'
}

fn digits(text: &str) -> usize {
    text.bytes().take_while(u8::is_ascii_digit).count()
}

/// Bytes of the number at the start of a text: `12`, `1.5`, `.5`, `1e-3`.
fn number(text: &str) -> usize {
    let mut length = digits(text);
    if text[length..].starts_with('.') {
        let fraction = digits(&text[length + 1..]);
        if fraction > 0 {
            length += 1 + fraction;
        }
    }
    if text[length..].starts_with(['e', 'E']) {
        let signed = usize::from(text[length + 1..].starts_with(['+', '-']));
        let exponent = digits(&text[length + 1 + signed..]);
        if exponent > 0 {
            length += 1 + signed + exponent;
        }
    }
    length
}

/// Bytes of the dotted name at the start of a text.
fn name(text: &str) -> usize {
    let word =
        |text: &str| text.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(text.len());
    let mut length = word(text);
    while let Some(rest) = text[length..].strip_prefix('.')
        && rest.starts_with(starts_name)
    {
        length += 1 + word(rest);
    }
    length
}
