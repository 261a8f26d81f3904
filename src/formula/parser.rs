//! Tokens to a syntax tree: precedence climbing after Pratt.
//!
//! From loose to tight: `+ -`, `* /`, unary `-`, `^` (right-associative, so `-x^2` is `-(x^2)` and
//! `x^-2` is allowed), members and calls. The height of the tree is limited, so that no later walk
//! over it can exhaust the stack.

use crate::diagnostic::{Diagnostic, Source, Span};
use crate::formula::ast::{Axis, BinaryOperator, Expression, ExpressionKind, Formula};
use crate::formula::compound;
use crate::formula::error::{DEPTH_LIMIT, FormulaError, LENGTH_LIMIT};
use crate::formula::functions::Function;
use crate::formula::lexer::{Token, tokens};
use crate::units::{Unit, parse_quantity};

impl Formula {
    /// Reads the formula `text` that starts at byte `offset` of a file.
    ///
    /// # Errors
    /// A message that points at the file's line and column.
    pub fn parse(source: Source, offset: usize, text: &str) -> Result<Self, Diagnostic> {
        match parse(text) {
            Ok(root) => Ok(Self { source, offset, text: text.to_owned(), root }),
            Err(error) => Err(error.diagnostic(&source, offset)),
        }
    }

    /// Whether a text that may be a quantity or a formula, is a formula: it names something.
    pub fn is_meant(text: &str) -> bool {
        parse_quantity(text).is_err() && parse(text).is_ok_and(|root| !root.names().is_empty())
    }

    /// Reads a formula that stands in no file; `title` takes the file's place in messages.
    ///
    /// # Errors
    /// A message that points into the text.
    pub fn parse_text(title: &str, text: &str) -> Result<Self, Diagnostic> {
        Self::parse(Source::new(title, text), 0, text)
    }
}

/// The syntax tree of a text.
///
/// # Errors
/// What was found where something else was due.
pub fn parse(text: &str) -> Result<Expression, FormulaError> {
    if text.len() > LENGTH_LIMIT {
        return Err(FormulaError::Long { found: text.len() });
    }
    if text.trim().is_empty() {
        return Err(FormulaError::Empty);
    }
    let tokens = tokens(text)?;
    let mut parser = Parser { text, tokens: &tokens, at: 0 };
    let root = parser.expression(0, 0)?.0;
    match parser.peek() {
        (Token::End, _) => Ok(root),
        _ => Err(parser.unexpected("an operator or the end")),
    }
}

/// A tree and its height.
type Tree = (Expression, usize);

struct Parser<'t> {
    text: &'t str,
    tokens: &'t [(Token, Span)],
    at: usize,
}

/// Binding powers: what holds its left operand, what holds its right one.
fn binding(symbol: char) -> Option<(BinaryOperator, u8, u8)> {
    match symbol {
        '+' => Some((BinaryOperator::Add, 1, 2)),
        '-' => Some((BinaryOperator::Subtract, 1, 2)),
        '*' => Some((BinaryOperator::Multiply, 3, 4)),
        '/' => Some((BinaryOperator::Divide, 3, 4)),
        '^' => Some((BinaryOperator::Power, 8, 7)),
        _ => None,
    }
}

/// Binding power of unary minus, between `*` and `^`.
const NEGATE: u8 = 5;

impl<'t> Parser<'t> {
    fn peek(&self) -> (&'t Token, Span) {
        // The last token is the end, and nothing goes past it.
        let (token, span) = &self.tokens[self.at.min(self.tokens.len() - 1)];
        (token, *span)
    }

    fn word(&self, span: Span) -> &'t str {
        &self.text[span.start..span.end]
    }

    fn unexpected(&self, expected: &'static str) -> FormulaError {
        let (token, span) = self.peek();
        let found = match token {
            Token::End => "the end of the formula".to_owned(),
            _ => format!("`{}`", self.word(span)),
        };
        FormulaError::Unexpected { expected, found, span }
    }

    fn expect(&mut self, symbol: char, expected: &'static str) -> Result<Span, FormulaError> {
        match self.peek() {
            (Token::Symbol(found), span) if *found == symbol => {
                self.at += 1;
                Ok(span)
            }
            _ => Err(self.unexpected(expected)),
        }
    }

    /// An expression whose operators bind more tightly than `minimum`, `depth` levels down.
    fn expression(&mut self, minimum: u8, depth: usize) -> Result<Tree, FormulaError> {
        if depth >= DEPTH_LIMIT {
            return Err(FormulaError::Deep { span: self.peek().1 });
        }
        let (mut left, mut height) = self.operand(depth)?;
        while let (Token::Symbol(symbol), _) = self.peek()
            && let Some((operator, power, right_power)) = binding(*symbol)
            && power > minimum
        {
            self.at += 1;
            let (right, right_height) = self.expression(right_power, depth + 1)?;
            let span = left.span.to(right.span);
            height = taller(height.max(right_height), span)?;
            let kind = ExpressionKind::Binary(operator, Box::new(left), Box::new(right));
            left = Expression { kind, span };
        }
        Ok((left, height))
    }

    /// One operand with its members: a number, a name, a call, `( )`, `[ ]`, or `-` and an operand.
    fn operand(&mut self, depth: usize) -> Result<Tree, FormulaError> {
        let (token, span) = self.peek();
        let (mut tree, mut height) = match token {
            Token::Number(value) => {
                self.at += 1;
                (self.quantity(*value, span)?, 1)
            }
            Token::Name => {
                self.at += 1;
                self.name_or_call(span, depth)?
            }
            Token::Symbol('-') => {
                self.at += 1;
                let (inner, height) = self.expression(NEGATE, depth + 1)?;
                let span = span.to(inner.span);
                if let ExpressionKind::Number(si, Some(unit)) = &inner.kind
                    && unit.offset != 0.0
                {
                    // -2 degC is a temperature of its own, not the negative of 275.15 K.
                    let si = unit.to_si(-unit.from_si(*si));
                    let kind = ExpressionKind::Number(si, Some(unit.clone()));
                    return Ok((Expression { kind, span }, height));
                }
                let kind = ExpressionKind::Negate(Box::new(inner));
                return Ok((Expression { kind, span }, taller(height, span)?));
            }
            Token::Symbol('(') => {
                self.at += 1;
                let (mut inner, height) = self.expression(0, depth + 1)?;
                let close = self.expect(')', "an operator or `)`")?;
                inner.span = span.to(close);
                (inner, height)
            }
            Token::Symbol('[') => {
                self.at += 1;
                self.vector(span, depth)?
            }
            _ => {
                return Err(self.unexpected("a number, a name, a function, `(`, `[` or `-`"));
            }
        };
        while let (Token::Symbol('.'), _) = self.peek() {
            self.at += 1;
            let (Token::Name, span) = self.peek() else {
                return Err(self.unexpected("a member `x`, `y` or `z`"));
            };
            self.at += 1;
            for axis in self.word(span).split('.') {
                let Some(axis) = axis_of(axis) else {
                    return Err(FormulaError::Member { found: self.word(span).to_owned(), span });
                };
                let span = tree.span.to(span);
                height = taller(height, span)?;
                tree = Expression { kind: ExpressionKind::Member(Box::new(tree), axis), span };
            }
        }
        Ok((tree, height))
    }

    /// A number with the unit that may follow it, in SI.
    fn quantity(&mut self, value: f64, span: Span) -> Result<Expression, FormulaError> {
        let (Token::Name, first) = self.peek() else {
            return Ok(Expression { kind: ExpressionKind::Number(value, None), span });
        };
        let end = compound::end(self.text, self.tokens, self.at + 1);
        let (_, last) = &self.tokens[end - 1];
        let unit_span = first.to(*last);
        let symbol = self.word(unit_span);
        let unit = Unit::parse(symbol).map_err(|error| FormulaError::Unit {
            found: symbol.to_owned(),
            help: error.help.filter(|help| !help.starts_with("known units")),
            span: unit_span,
        })?;
        let is_compound = end > self.at + 1;
        self.at = end;
        // `1 s^2` is the same either way; `3 s^2` is not.
        if let (Token::Symbol('^'), power) = self.peek()
            && (value != 1.0 || unit.offset != 0.0 || is_compound)
        {
            let is_simple = !is_compound && unit.offset == 0.0;
            let number = is_simple.then(|| format!("{} * 1 {symbol}^2", self.word(span)));
            let span = span.to(power);
            let found = self.word(span).to_owned();
            return Err(FormulaError::UnitPower { found, number, span });
        }
        let si = unit.to_si(value);
        let span = span.to(unit_span);
        if !si.is_finite() {
            return Err(FormulaError::Number { found: self.word(span).to_owned(), span });
        }
        Ok(Expression { kind: ExpressionKind::Number(si, Some(unit)), span })
    }

    fn name_or_call(&mut self, span: Span, depth: usize) -> Result<Tree, FormulaError> {
        let word = self.word(span);
        if let (Token::Symbol('('), _) = self.peek() {
            let Some(function) = Function::find(word) else {
                return Err(FormulaError::Function { name: word.to_owned(), span });
            };
            self.at += 1;
            return self.arguments(function, span, depth);
        }
        if let Some(function) = Function::find(word) {
            return Err(FormulaError::NotCalled { function, span });
        }
        // Trailing x, y, z are members; a name alone may be `x`.
        let mut name = word;
        let mut members = Vec::new();
        while let Some((head, last)) = name.rsplit_once('.')
            && let Some(axis) = axis_of(last)
        {
            members.push((axis, span.start + name.len()));
            name = head;
        }
        let mut tree = Expression {
            kind: ExpressionKind::Name(name.to_owned()),
            span: Span::new(span.start, span.start + name.len()),
        };
        let mut height = 1;
        for (axis, end) in members.into_iter().rev() {
            let span = Span::new(span.start, end);
            height = taller(height, span)?;
            tree = Expression { kind: ExpressionKind::Member(Box::new(tree), axis), span };
        }
        Ok((tree, height))
    }

    fn arguments(
        &mut self,
        function: Function,
        name: Span,
        depth: usize,
    ) -> Result<Tree, FormulaError> {
        let mut arguments = Vec::new();
        let mut height = 0;
        if !matches!(self.peek(), (Token::Symbol(')'), _)) {
            loop {
                let (argument, argument_height) = self.expression(0, depth + 1)?;
                arguments.push(argument);
                height = height.max(argument_height);
                if !matches!(self.peek(), (Token::Symbol(','), _)) {
                    break;
                }
                self.at += 1;
            }
        }
        let close = self.expect(')', "an operator, `,` or `)`")?;
        let span = name.to(close);
        if !function.entry().arity.contains(&arguments.len()) {
            return Err(FormulaError::Arity { function, found: arguments.len(), span });
        }
        let kind = ExpressionKind::Call(function, arguments);
        Ok((Expression { kind, span }, taller(height, span)?))
    }

    fn vector(&mut self, open: Span, depth: usize) -> Result<Tree, FormulaError> {
        let (x, a) = self.expression(0, depth + 1)?;
        self.expect(',', "an operator or `,` (a vector has three components)")?;
        let (y, b) = self.expression(0, depth + 1)?;
        self.expect(',', "an operator or `,` (a vector has three components)")?;
        let (z, c) = self.expression(0, depth + 1)?;
        let close = self.expect(']', "an operator or `]` (a vector has three components)")?;
        let span = open.to(close);
        let kind = ExpressionKind::Vector(Box::new([x, y, z]));
        Ok((Expression { kind, span }, taller(a.max(b).max(c), span)?))
    }
}

/// One more than `height`, within the limit.
fn taller(height: usize, span: Span) -> Result<usize, FormulaError> {
    if height >= DEPTH_LIMIT {
        return Err(FormulaError::Deep { span });
    }
    Ok(height + 1)
}

fn axis_of(name: &str) -> Option<Axis> {
    match name {
        "x" => Some(Axis::X),
        "y" => Some(Axis::Y),
        "z" => Some(Axis::Z),
        _ => None,
    }
}
