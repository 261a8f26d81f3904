//! The formula language: text to a syntax tree with spans.
//!
//! Answers: what was written, and where each part of it stands. It does not know what a name
//! means; that is the graph's business.
//!
//! | file | answers |
//! |---|---|
//! | [`functions`] | the table of functions |
//! | [`lexer`] | text to tokens |
//! | [`parser`] | tokens to a tree: [`Formula::parse`] |
//! | `compound` | how far the unit after a number reaches |
//! | [`ast`] | the tree |
//! | `angles` | which parts are angles |
//! | `value` | the number that a formula of numbers has |
//! | [`isolate`] | a formula turned round; a name changed |
//! | [`show`] | a tree as text and as LaTeX |
//! | [`error`] | why a text is not a formula |

pub(crate) mod angles;
pub mod ast;
pub(crate) mod compound;
pub mod error;
pub mod functions;
pub mod isolate;
pub mod lexer;
pub mod parser;
pub mod show;
mod value;

pub use ast::{Axis, BinaryOperator, Expression, ExpressionKind, Formula};
pub use error::FormulaError;
pub use functions::Function;
