//! The syntax tree of a formula.

use crate::diagnostic::{Source, Span};
use crate::formula::functions::Function;
use crate::units::Unit;

/// A parsed formula and where its text stands.
#[derive(Clone, Debug)]
pub struct Formula {
    /// The file that holds it.
    pub source: Source,
    /// Byte in the file at which the formula's text starts; spans count from there.
    pub offset: usize,
    /// The formula's text.
    pub text: String,
    /// Its meaning.
    pub root: Expression,
}

/// One node of the tree with the bytes it was read from.
#[derive(Clone, Debug, PartialEq)]
pub struct Expression {
    /// What it is.
    pub kind: ExpressionKind,
    /// Where it stands in the formula's text.
    pub span: Span,
}

impl Expression {
    /// The names in it with their places, from left to right. Its depth is limited by the parser.
    pub fn names(&self) -> Vec<(&str, Span)> {
        let mut names = Vec::new();
        self.visit(&mut |one| {
            if let ExpressionKind::Name(name) = &one.kind {
                names.push((name.as_str(), one.span));
            }
        });
        names
    }

    /// Shows it and all its parts, from left to right.
    pub fn visit<'e>(&'e self, see: &mut impl FnMut(&'e Self)) {
        see(self);
        match &self.kind {
            ExpressionKind::Number(..) | ExpressionKind::Name(_) => {}
            ExpressionKind::Member(inner, _) | ExpressionKind::Negate(inner) => inner.visit(see),
            ExpressionKind::Vector(parts) => parts.iter().for_each(|part| part.visit(see)),
            ExpressionKind::Binary(_, left, right) => {
                left.visit(see);
                right.visit(see);
            }
            ExpressionKind::Call(_, arguments) => arguments.iter().for_each(|part| part.visit(see)),
        }
    }
}

/// What a node of the tree is.
#[derive(Clone, Debug, PartialEq)]
pub enum ExpressionKind {
    /// A number, in SI where it has a unit.
    Number(f64, Option<Unit>),
    /// A name, dots included where they are part of it (`horizontal.delay`).
    Name(String),
    /// `.x`, `.y` or `.z` of a vector.
    Member(Box<Expression>, Axis),
    /// `[x, y, z]`.
    Vector(Box<[Expression; 3]>),
    /// `-x`.
    Negate(Box<Expression>),
    /// `a op b`.
    Binary(BinaryOperator, Box<Expression>, Box<Expression>),
    /// `function(arguments)`.
    Call(Function, Vec<Expression>),
}

/// A component of a vector.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Axis {
    /// First.
    X,
    /// Second.
    Y,
    /// Third.
    Z,
}

/// The infix operators.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BinaryOperator {
    /// `+`
    Add,
    /// `-`
    Subtract,
    /// `*`
    Multiply,
    /// `/`
    Divide,
    /// `^`
    Power,
}
