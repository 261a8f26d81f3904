//! The number that a formula of numbers has, where graphs are more than is needed.
//!
//! Knows scalars in SI: no vectors, no rotations, no rates, no check of units.

use crate::formula::ast::{BinaryOperator, Expression, ExpressionKind};
use crate::formula::functions::Meaning;

impl Expression {
    /// Its value (SI); `None` where a name has none, or for what is no formula of numbers.
    ///
    /// ```
    /// use homepoint::formula::parser::parse;
    ///
    /// let zenith = parse("90 deg - elevation").unwrap();
    /// let value = zenith.value(&|name| (name == "elevation").then_some(0.5)).unwrap();
    /// assert_eq!(value, std::f64::consts::FRAC_PI_2 - 0.5);
    /// ```
    pub fn value(&self, of: &dyn Fn(&str) -> Option<f64>) -> Option<f64> {
        Some(match &self.kind {
            ExpressionKind::Number(value, _) => *value,
            ExpressionKind::Name(name) if name == "pi" => std::f64::consts::PI,
            ExpressionKind::Name(name) => of(name)?,
            ExpressionKind::Negate(inner) => -inner.value(of)?,
            ExpressionKind::Binary(operator, left, right) => {
                let (left, right) = (left.value(of)?, right.value(of)?);
                match operator {
                    BinaryOperator::Add => left + right,
                    BinaryOperator::Subtract => left - right,
                    BinaryOperator::Multiply => left * right,
                    BinaryOperator::Divide => left / right,
                    BinaryOperator::Power => left.powf(right),
                }
            }
            ExpressionKind::Call(function, arguments) => {
                match (function.entry().meaning, arguments.as_slice()) {
                    (
                        Meaning::Plain(unary)
                        | Meaning::Keep(unary)
                        | Meaning::Drop(unary)
                        | Meaning::Root(unary),
                        [argument],
                    ) => unary.apply(argument.value(of)?),
                    _ => return None,
                }
            }
            ExpressionKind::Member(..) | ExpressionKind::Vector(_) => return None,
        })
    }
}
