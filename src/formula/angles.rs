//! Which parts of a formula are angles, as far as its units say: numbers beside angles need one.

use crate::formula::ast::{BinaryOperator, Expression, ExpressionKind};
use crate::formula::functions::{Function, Meaning};
use crate::units::Unit;

/// A number without unit that is added to an angle.
pub(crate) fn bare_angle<'e>(
    root: &'e Expression,
    is_angle: &dyn Fn(&str) -> bool,
) -> Option<(&'e Expression, f64)> {
    let mut found = None;
    root.visit(&mut |one| {
        let ExpressionKind::Binary(BinaryOperator::Add | BinaryOperator::Subtract, a, b) =
            &one.kind
        else {
            return;
        };
        for (number, other) in [(a, b), (b, a)] {
            if let (ExpressionKind::Number(value, None), true) =
                (&number.kind, holds_angle(other, is_angle))
                && *value != 0.0
            {
                found = Some((&**number, *value));
            }
        }
    });
    found
}

/// Whether the value of an expression is an angle.
fn holds_angle(one: &Expression, is_angle: &dyn Fn(&str) -> bool) -> bool {
    let holds = |one: &Expression| holds_angle(one, is_angle);
    match &one.kind {
        ExpressionKind::Name(name) => is_angle(name),
        ExpressionKind::Number(_, unit) => unit.as_ref().is_some_and(Unit::is_angle),
        ExpressionKind::Negate(inner) => holds(inner),
        ExpressionKind::Binary(operator, a, b) => match operator {
            BinaryOperator::Add | BinaryOperator::Subtract => holds(a) || holds(b),
            BinaryOperator::Multiply => holds(a) != holds(b),
            BinaryOperator::Divide => holds(a) && !holds(b),
            BinaryOperator::Power => false,
        },
        ExpressionKind::Call(Function::Abs | Function::Min | Function::Max, arguments) => {
            arguments.iter().any(holds)
        }
        _ => false,
    }
}

/// Whether anything in a formula is an angle.
pub(crate) fn makes_angle(root: &Expression, is_angle: &dyn Fn(&str) -> bool) -> bool {
    let mut found = false;
    root.visit(&mut |one| {
        found |= match &one.kind {
            ExpressionKind::Number(_, Some(unit)) => unit.is_angle(),
            ExpressionKind::Name(name) => name == "pi" || is_angle(name),
            ExpressionKind::Call(function, _) => matches!(
                function,
                Function::Asin | Function::Acos | Function::Atan | Function::Atan2
            ),
            _ => false,
        };
    });
    found
}

/// Whether an angle stands outside the arguments of functions such as cosines: only then the value
/// can be one.
pub(crate) fn brings_angle(one: &Expression, is_angle: &dyn Fn(&str) -> bool) -> bool {
    let brings = |one: &Expression| brings_angle(one, is_angle);
    match &one.kind {
        ExpressionKind::Number(_, unit) => unit.as_ref().is_some_and(Unit::is_angle),
        ExpressionKind::Name(name) => name == "pi" || is_angle(name),
        ExpressionKind::Negate(inner) | ExpressionKind::Member(inner, _) => brings(inner),
        ExpressionKind::Binary(_, a, b) => brings(a) || brings(b),
        ExpressionKind::Vector(parts) => parts.iter().any(brings),
        ExpressionKind::Call(function, arguments) => match function {
            Function::Asin | Function::Acos | Function::Atan | Function::Atan2 => true,
            other => {
                !matches!(other.entry().meaning, Meaning::Plain(_)) && arguments.iter().any(brings)
            }
        },
    }
}
