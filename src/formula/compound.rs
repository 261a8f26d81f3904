//! How far the unit after a number reaches: `9.81 m/s^2`, `3 N m`, `2 m/(rad/s^2)`.
//!
//! Units belong to it that follow after a blank, or after a `*` or `/` without blanks around it:
//! `2 m / h` divides by the quantity `h`, `2 m/h` is a speed. `t` in a product is the delay.

use crate::diagnostic::Span;
use crate::formula::lexer::Token;
use crate::units::Unit;

/// The index of the first token after the unit of which the first symbol ends before token `at`.
pub(super) fn end(text: &str, tokens: &[(Token, Span)], at: usize) -> usize {
    let reader = Reader { text, tokens };
    let mut end = at;
    while let Some(next) = reader.factor(end) {
        end = next;
    }
    end
}

/// The words of a unit that could be names as well: those after its first `*` or `/`.
pub(crate) fn words(unit: &Unit) -> impl Iterator<Item = &str> {
    let rest = unit.symbol.find(['*', '/']).map_or("", |at| &unit.symbol[at..]);
    let words = rest.split(|c: char| !(c.is_alphanumeric() || c == '_'));
    words.filter(|word| word.starts_with(char::is_alphabetic))
}

struct Reader<'t> {
    text: &'t str,
    tokens: &'t [(Token, Span)],
}

impl Reader<'_> {
    fn is(&self, at: usize, symbols: &str) -> bool {
        matches!(self.tokens.get(at), Some((Token::Symbol(found), _)) if symbols.contains(*found))
    }

    /// Whether no blank stands before a token.
    fn is_glued(&self, at: usize) -> bool {
        let (before, own) = (self.tokens.get(at.wrapping_sub(1)), self.tokens.get(at));
        matches!((before, own), (Some((_, before)), Some((_, own))) if before.end == own.start)
    }

    /// Whether a token is a unit, and no function that is called.
    fn is_unit(&self, at: usize) -> bool {
        let Some((Token::Name, span)) = self.tokens.get(at) else { return false };
        Unit::parse(&self.text[span.start..span.end]).is_ok() && !self.is(at + 1, "(")
    }

    /// One more factor of the unit, at a token.
    fn factor(&self, at: usize) -> Option<usize> {
        if self.is_unit(at) {
            return Some(self.power(at + 1));
        }
        if !self.is(at, "*/") || !self.is_glued(at) || !self.is_glued(at + 1) {
            return None;
        }
        let is_time = |(_, span): &(Token, Span)| &self.text[span.start..span.end] == "t";
        if self.is_unit(at + 1) && !self.tokens.get(at + 1).is_some_and(is_time) {
            return Some(self.power(at + 2));
        }
        if !self.is(at + 1, "(") {
            return None;
        }
        let close = (at + 2..self.tokens.len()).find(|at| self.is(*at, "()"))?;
        let within = Span::new(self.tokens[at + 1].1.end, self.tokens[close].1.start);
        let is_unit = self.is(close, ")") && self.is_unit(at + 2);
        let inner = Unit::parse(&self.text[within.start..within.end]);
        (is_unit && inner.is_ok()).then(|| self.power(close + 1))
    }

    /// After the power that may follow a factor.
    fn power(&self, at: usize) -> usize {
        let exponent = at + 1 + usize::from(self.is(at + 1, "-"));
        let is_number = matches!(self.tokens.get(exponent), Some((Token::Number(_), _)));
        if self.is(at, "^") && is_number { exponent + 1 } else { at }
    }
}
