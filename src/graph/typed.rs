//! A value with its dimension, and how both are called in messages.

use std::fmt::Write as _;

use crate::diagnostic::{Diagnostic, Span};
use crate::formula::Formula;
use crate::graph::{Kind, NodeId, Value};
use crate::units::{Dimension, Unit};

/// A fault of a formula; boxed because results are passed through deep recursions.
pub type Fault = Box<Diagnostic>;

/// A value and its dimension.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Typed {
    /// Its nodes.
    pub value: Value,
    /// The dimension of each component.
    pub dimension: Dimension,
    /// Whether it is a literal zero, which fits any dimension.
    pub any_dimension: bool,
}

impl Typed {
    /// A value of this dimension.
    pub fn new(value: Value, dimension: Dimension) -> Self {
        Self { value, dimension, any_dimension: false }
    }

    /// A number of this dimension.
    pub fn scalar(node: NodeId, dimension: Dimension) -> Self {
        Self::new(Value::Scalar(node), dimension)
    }

    /// A plain number.
    pub fn plain(node: NodeId) -> Self {
        Self::scalar(node, Dimension::NONE)
    }

    /// A vector of this dimension.
    pub fn vector(nodes: [NodeId; 3], dimension: Dimension) -> Self {
        Self::new(Value::Vector(nodes), dimension)
    }

    /// A rotation.
    pub fn rotation(nodes: [NodeId; 4]) -> Self {
        Self::new(Value::Rotation(nodes), Dimension::NONE)
    }

    /// Scalar, vector or rotation.
    pub fn kind(&self) -> Kind {
        match self.value {
            Value::Scalar(_) => Kind::Scalar,
            Value::Vector(_) => Kind::Vector,
            Value::Rotation(_) => Kind::Rotation,
        }
    }

    /// Whether it may stand where this dimension is due.
    pub fn fits(&self, dimension: Dimension) -> bool {
        self.any_dimension || self.dimension == dimension
    }

    /// The dimension two values share, if they do, and whether it is still open.
    pub fn common(&self, other: &Self) -> Option<(Dimension, bool)> {
        if self.any_dimension {
            Some((other.dimension, other.any_dimension))
        } else {
            other.fits(self.dimension).then_some((self.dimension, false))
        }
    }

    /// What it is, in words: `a length (m)`, `a plain number`, `a vector in m/s`, `a rotation`.
    pub fn words(&self) -> String {
        words(self.kind(), self.dimension)
    }
}

/// What quantities are called, by their unit.
const NOUNS: &[(&str, &str)] = &[
    ("m", "a length"),
    ("s", "a time"),
    ("kg", "a mass"),
    ("K", "a temperature"),
    ("A", "a current"),
    ("N", "a force"),
    ("N m", "a torque or an energy"),
    ("W", "a power"),
    ("Pa", "a pressure"),
    ("V", "a voltage"),
];

/// A kind and a dimension in words.
pub fn words(kind: Kind, dimension: Dimension) -> String {
    let named = |(symbol, _): &&(&str, &str)| {
        Unit::parse(symbol).is_ok_and(|unit| unit.dimension == dimension)
    };
    match kind {
        Kind::Scalar if dimension == Dimension::NONE => "a plain number".into(),
        Kind::Scalar => match NOUNS.iter().find(named) {
            Some((symbol, noun)) => format!("{noun} ({symbol})"),
            None => format!("a number in {dimension}"),
        },
        Kind::Vector if dimension == Dimension::NONE => "a vector of plain numbers".into(),
        Kind::Vector => format!("a vector in {dimension}"),
        Kind::Rotation => "a rotation".into(),
    }
}

/// A fault at a part of a formula.
pub fn fault(formula: &Formula, span: Span, message: impl Into<String>) -> Fault {
    let place = formula.source.place(span.shifted(formula.offset));
    Box::new(Diagnostic::error(message).at(place))
}

/// A fault at a part of a formula, with a sentence of help.
pub fn fault_with(
    formula: &Formula,
    span: Span,
    message: impl Into<String>,
    help: impl Into<String>,
) -> Fault {
    Box::new(fault(formula, span, message).help(help))
}

/// The text of a part of a formula in backquotes, shortened if it is long.
pub fn quoted(formula: &Formula, span: Span) -> String {
    let text = formula.text.get(span.start..span.end).unwrap_or("").trim();
    let mut quoted = String::from("`");
    for (count, word) in text.split_whitespace().enumerate() {
        if quoted.chars().count() + word.chars().count() > 60 {
            quoted.push_str(" ...");
            break;
        }
        let _ = write!(quoted, "{}{word}", if count > 0 { " " } else { "" });
    }
    quoted.push('`');
    quoted
}
