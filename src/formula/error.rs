//! Why a text is not a formula.

use crate::diagnostic::{Diagnostic, Source, Span, nearest};
use crate::formula::functions::{Function, TABLE};

/// A formula is at most this many bytes long.
pub const LENGTH_LIMIT: usize = 20_000;

/// Expressions nest at most this deep; a sum of n terms counts n.
pub const DEPTH_LIMIT: usize = 128;

/// Why a text is not a formula. Spans count from the start of the formula.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FormulaError {
    /// A character that no formula has.
    #[error("unexpected character {found:?}")]
    Character {
        /// The character.
        found: char,
        /// Where.
        span: Span,
    },
    /// A number that cannot be read or is out of range.
    #[error("`{found}` is not a number that can be held")]
    Number {
        /// What was written.
        found: String,
        /// Where.
        span: Span,
    },
    /// Something else was due here.
    #[error("expected {expected}, found {found}")]
    Unexpected {
        /// What could stand here.
        expected: &'static str,
        /// What stands here.
        found: String,
        /// Where.
        span: Span,
    },
    /// A number followed by something that is not a unit.
    #[error("expected an operator or a unit after the number, found `{found}`")]
    Unit {
        /// What was written.
        found: String,
        /// The unit that may be meant.
        help: Option<String>,
        /// Where.
        span: Span,
    },
    /// A power right after a unit: of the unit or of the quantity?
    #[error("`{found}` could mean the power of the unit or of the quantity")]
    UnitPower {
        /// The quantity, up to the sign of the power.
        found: String,
        /// The number and the power of its unit, where this is a simple one.
        number: Option<String>,
        /// Where.
        span: Span,
    },
    /// A member other than x, y, z.
    #[error("expected a member `x`, `y` or `z`, found `{found}`")]
    Member {
        /// What was written.
        found: String,
        /// Where.
        span: Span,
    },
    /// A call of something that is no function.
    #[error("there is no function `{name}`")]
    Function {
        /// What was called.
        name: String,
        /// Where.
        span: Span,
    },
    /// A function named without its arguments.
    #[error("the function `{function}` is named without arguments")]
    NotCalled {
        /// Which.
        function: Function,
        /// Where.
        span: Span,
    },
    /// Too many or too few arguments.
    #[error("`{}` takes {}, found {found}", function.entry().signature, count(*function))]
    Arity {
        /// Which function.
        function: Function,
        /// How many were given.
        found: usize,
        /// Where.
        span: Span,
    },
    /// Nothing at all.
    #[error("expected a formula, found nothing")]
    Empty,
    /// Longer than [`LENGTH_LIMIT`].
    #[error("the formula is {found} bytes long; at most {LENGTH_LIMIT} are read")]
    Long {
        /// Its length.
        found: usize,
    },
    /// Deeper than [`DEPTH_LIMIT`].
    #[error("the formula nests more than {DEPTH_LIMIT} deep here")]
    Deep {
        /// Where.
        span: Span,
    },
}

fn count(function: Function) -> String {
    let arity = function.entry().arity.clone();
    match (*arity.start(), *arity.end()) {
        (1, 1) => "1 argument".into(),
        (a, b) if a == b => format!("{a} arguments"),
        (a, b) => format!("{a} to {b} arguments"),
    }
}

impl FormulaError {
    /// Where it is, from the start of the formula.
    pub fn span(&self) -> Span {
        match self {
            Self::Character { span, .. }
            | Self::Number { span, .. }
            | Self::Unexpected { span, .. }
            | Self::Unit { span, .. }
            | Self::UnitPower { span, .. }
            | Self::Member { span, .. }
            | Self::Function { span, .. }
            | Self::NotCalled { span, .. }
            | Self::Arity { span, .. }
            | Self::Deep { span } => *span,
            Self::Empty | Self::Long { .. } => Span::new(0, 1),
        }
    }

    /// What to do about it, if that is known.
    pub fn help(&self) -> Option<String> {
        match self {
            Self::Function { name, .. } => {
                match nearest(name, TABLE.iter().map(|entry| entry.name)) {
                    Some(near) => Some(format!("did you mean `{near}`?")),
                    None => Some(format!(
                        "the functions are {}",
                        TABLE.iter().map(|entry| entry.name).collect::<Vec<_>>().join(" ")
                    )),
                }
            }
            Self::NotCalled { function, .. } => {
                Some(format!("write `{}`", function.entry().signature))
            }
            Self::Arity { function, .. } => Some(function.entry().about.to_owned()),
            Self::Unit { help, .. } => Some(help.clone().unwrap_or_else(|| {
                "a number may carry a unit, as in `20 arcsec`, `9.81 m/s^2` or `3 N m`".into()
            })),
            Self::Character { found: '\'' | '"', .. } => {
                Some("a formula holds no quotation marks".into())
            }
            Self::UnitPower { found, number, .. } => {
                let quantity = found.trim_end_matches('^').trim_end();
                let number = number.as_ref().map_or_else(String::new, |number| {
                    format!(", `{number}` for the power of the unit")
                });
                Some(format!("write `({quantity})^2` for the power of the quantity{number}"))
            }
            Self::Deep { .. } | Self::Long { .. } => {
                Some("give parts of it names of their own in [quantities]".into())
            }
            _ => None,
        }
    }

    /// The message with its place, for a formula that starts at byte `offset` of a file.
    pub fn diagnostic(&self, source: &Source, offset: usize) -> Diagnostic {
        let mut diagnostic =
            Diagnostic::error(self.to_string()).at(source.place(self.span().shifted(offset)));
        diagnostic.help.extend(self.help());
        diagnostic
    }
}
