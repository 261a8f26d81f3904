//! Formulas turned round: `vertical = '90 deg - elevation'` as `elevation = '90 deg - vertical'`.
//!
//! Answers for the four rules of arithmetic where the name stands once. Everything else, functions
//! included, is not turned round.

use crate::formula::ast::{BinaryOperator, Expression, ExpressionKind};

/// What `name` is if `formula` equals `value`; `None` where it does not stand there exactly once, or
/// stands within more than sums, differences, products and quotients.
///
/// ```
/// use homepoint::formula::isolate::isolated;
/// use homepoint::formula::parser::parse;
///
/// let zenith = parse("90 deg - 2 * elevation").unwrap();
/// let elevation = isolated(&zenith, "elevation", parse("zenith").unwrap()).unwrap();
/// let shown = homepoint::formula::show::text(&elevation);
/// assert_eq!(shown, "(90 deg - zenith) / 2");
/// ```
pub fn isolated(formula: &Expression, name: &str, value: Expression) -> Option<Expression> {
    if formula.names().iter().filter(|(one, _)| *one == name).count() != 1 {
        return None;
    }
    turned(formula, name, value)
}

fn turned(formula: &Expression, name: &str, value: Expression) -> Option<Expression> {
    use BinaryOperator::{Add, Divide, Multiply, Subtract};
    let span = formula.span;
    let has = |part: &Expression| part.names().iter().any(|(one, _)| *one == name);
    let binary = |operator, left: Expression, right: &Expression| Expression {
        kind: ExpressionKind::Binary(operator, Box::new(left), Box::new(right.clone())),
        span,
    };
    match &formula.kind {
        ExpressionKind::Name(one) if one == name => Some(value),
        ExpressionKind::Negate(inner) => {
            let kind = ExpressionKind::Negate(Box::new(value));
            turned(inner, name, Expression { kind, span })
        }
        ExpressionKind::Binary(operator, left, right) if has(left) => {
            let inverse = match operator {
                Add => Subtract,
                Subtract => Add,
                Multiply => Divide,
                Divide => Multiply,
                BinaryOperator::Power => return None,
            };
            turned(left, name, binary(inverse, value, right))
        }
        ExpressionKind::Binary(operator, left, right) => match operator {
            Add => turned(right, name, binary(Subtract, value, left)),
            Multiply => turned(right, name, binary(Divide, value, left)),
            Subtract => turned(right, name, binary(Subtract, (**left).clone(), &value)),
            Divide => turned(right, name, binary(Divide, (**left).clone(), &value)),
            BinaryOperator::Power => None,
        },
        _ => None,
    }
}

/// The formula with other formulas in place of its names, as far as `of` has any.
pub fn replaced(formula: &Expression, of: &dyn Fn(&str) -> Option<Expression>) -> Expression {
    let of_name = |part: &Expression| match &part.kind {
        ExpressionKind::Name(name) => of(name),
        _ => None,
    };
    replaced_parts(formula, &of_name)
}

/// The formula with other formulas in place of its parts, as far as `of` has any; it is asked for
/// the whole before its parts, and not for the parts of a formula that it gave.
pub fn replaced_parts(
    formula: &Expression,
    of: &dyn Fn(&Expression) -> Option<Expression>,
) -> Expression {
    if let Some(other) = of(formula) {
        return Expression { kind: other.kind, span: formula.span };
    }
    let inner = |part: &Expression| Box::new(replaced_parts(part, of));
    let kind = match &formula.kind {
        ExpressionKind::Name(_) | ExpressionKind::Number(..) => formula.kind.clone(),
        ExpressionKind::Member(part, axis) => ExpressionKind::Member(inner(part), *axis),
        ExpressionKind::Negate(part) => ExpressionKind::Negate(inner(part)),
        ExpressionKind::Vector(parts) => {
            ExpressionKind::Vector(Box::new(parts.each_ref().map(|part| replaced_parts(part, of))))
        }
        ExpressionKind::Binary(operator, left, right) => {
            ExpressionKind::Binary(*operator, inner(left), inner(right))
        }
        ExpressionKind::Call(function, arguments) => {
            let arguments = arguments.iter().map(|part| replaced_parts(part, of)).collect();
            ExpressionKind::Call(*function, arguments)
        }
    };
    Expression { kind, span: formula.span }
}

/// Gives a name another one wherever it stands.
pub fn rename(formula: &mut Expression, from: &str, to: &str) {
    let span = formula.span;
    let other = |name: &str| {
        (name == from).then(|| Expression { kind: ExpressionKind::Name(to.to_owned()), span })
    };
    *formula = replaced(formula, &other);
}
