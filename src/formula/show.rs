//! A formula as people read it: tidy text and LaTeX.
//!
//! Both keep the meaning (the text parses to the same tree); neither simplifies.

use crate::formula::ast::{Axis, BinaryOperator, Expression, ExpressionKind, Formula};
use crate::formula::functions::{Function, Setting};
use crate::units::Unit;

impl Formula {
    /// The formula as text with even spacing and no needless parentheses.
    pub fn to_text(&self) -> String {
        text(&self.root)
    }

    /// The formula as LaTeX for mathematics mode.
    pub fn to_latex(&self) -> String {
        latex(&self.root)
    }
}

/// How tightly an expression holds together: sums 1, products 3, negatives 5, powers 7, the rest 9.
fn tightness(expression: &Expression) -> u8 {
    match &expression.kind {
        ExpressionKind::Binary(BinaryOperator::Add | BinaryOperator::Subtract, ..) => 1,
        ExpressionKind::Binary(BinaryOperator::Multiply | BinaryOperator::Divide, ..) => 3,
        ExpressionKind::Negate(_) => 5,
        ExpressionKind::Number(value, unit) if quantity(*value, unit.as_ref()) < 0.0 => 5,
        ExpressionKind::Binary(BinaryOperator::Power, ..) => 7,
        _ => 9,
    }
}

fn quantity(si: f64, unit: Option<&Unit>) -> f64 {
    unit.map_or(si, |unit| unit.from_si(si))
}

/// A number without the dust of unit conversions: 15 digits, trailing zeros cut.
fn digits(value: f64) -> String {
    let rounded: f64 = format!("{value:.14e}").parse().unwrap_or(value);
    if rounded != 0.0 && !(1e-4..1e9).contains(&rounded.abs()) {
        format!("{rounded:e}")
    } else {
        format!("{rounded}")
    }
}

fn axis_name(axis: Axis) -> &'static str {
    match axis {
        Axis::X => "x",
        Axis::Y => "y",
        Axis::Z => "z",
    }
}

/// An expression as text.
pub fn text(expression: &Expression) -> String {
    match &expression.kind {
        ExpressionKind::Number(value, unit) => {
            let number = digits(quantity(*value, unit.as_ref()));
            match unit {
                Some(unit) => format!("{number} {}", unit.symbol),
                None => number,
            }
        }
        ExpressionKind::Name(name) => name.clone(),
        ExpressionKind::Member(of, axis) => {
            // A number or a name with a dot after it would be read as something else.
            let inner = match &of.kind {
                ExpressionKind::Number(..) => format!("({})", text(of)),
                _ => text_within(of, 9),
            };
            format!("{inner}.{}", axis_name(*axis))
        }
        ExpressionKind::Vector(parts) => {
            let [x, y, z] = &**parts;
            format!("[{}, {}, {}]", text(x), text(y), text(z))
        }
        ExpressionKind::Negate(of) => format!("-{}", text_within(of, 7)),
        ExpressionKind::Binary(operator, a, b) => {
            let (symbol, left, right) = match operator {
                BinaryOperator::Add => (" + ", 1, 2),
                BinaryOperator::Subtract => (" - ", 1, 2),
                BinaryOperator::Multiply => (" * ", 3, 4),
                BinaryOperator::Divide => (" / ", 3, 4),
                BinaryOperator::Power => ("^", 8, 5),
            };
            // A power right after a unit would be ambiguous.
            let quantity = matches!(a.kind, ExpressionKind::Number(_, Some(_)));
            let a = match operator {
                BinaryOperator::Power if quantity => format!("({})", text(a)),
                _ => text_within(a, left),
            };
            format!("{a}{symbol}{}", text_within(b, right))
        }
        ExpressionKind::Call(function, arguments) => {
            let arguments: Vec<String> = arguments.iter().map(text).collect();
            format!("{function}({})", arguments.join(", "))
        }
    }
}

fn text_within(expression: &Expression, least: u8) -> String {
    let inner = text(expression);
    if tightness(expression) < least { format!("({inner})") } else { inner }
}

/// A name in LaTeX: upright, what follows an underscore or a dot as subscripts; `pi` is π, a single
/// letter stays italic.
pub fn latex_name(name: &str) -> String {
    name_with(name, None)
}

fn name_with(name: &str, last: Option<&str>) -> String {
    if name == "pi" && last.is_none() {
        return "\\pi".into();
    }
    let word = |word: &str| {
        if word.chars().count() == 1 { word.to_owned() } else { format!("\\mathrm{{{word}}}") }
    };
    let mut parts = name.split(['_', '.']).filter(|part| !part.is_empty()).chain(last);
    let base = word(parts.next().unwrap_or("?"));
    let below: Vec<String> = parts.map(word).collect();
    if below.is_empty() { base } else { format!("{base}_{{{}}}", below.join(", ")) }
}

/// An expression as LaTeX.
pub fn latex(expression: &Expression) -> String {
    match &expression.kind {
        ExpressionKind::Number(value, unit) => latex_number(*value, unit.as_ref()),
        ExpressionKind::Name(name) => latex_name(name),
        ExpressionKind::Member(of, axis) => match &of.kind {
            ExpressionKind::Name(name) => name_with(name, Some(axis_name(*axis))),
            _ => format!("{}_{{{}}}", parenthesised(&latex(of)), axis_name(*axis)),
        },
        ExpressionKind::Vector(parts) => {
            let rows: Vec<String> = parts.iter().map(latex).collect();
            format!("\\begin{{pmatrix}} {} \\end{{pmatrix}}", rows.join(" \\\\ "))
        }
        ExpressionKind::Negate(of) => format!("-{}", latex_within(of, 3)),
        ExpressionKind::Binary(operator, a, b) => match operator {
            BinaryOperator::Add => format!("{} + {}", latex(a), latex_within(b, 2)),
            BinaryOperator::Subtract => format!("{} - {}", latex(a), latex_within(b, 2)),
            BinaryOperator::Multiply => {
                format!("{} \\, {}", latex_within(a, 3), latex_within(b, 4))
            }
            BinaryOperator::Divide => format!("\\frac{{{}}}{{{}}}", latex(a), latex(b)),
            BinaryOperator::Power => {
                let base = match &a.kind {
                    ExpressionKind::Name(_) | ExpressionKind::Member(..) => latex(a),
                    ExpressionKind::Number(_, None) => latex_within(a, 9),
                    _ => parenthesised(&latex(a)),
                };
                format!("{{{base}}}^{{{}}}", latex(b))
            }
        },
        ExpressionKind::Call(function, arguments) => latex_call(*function, arguments),
    }
}

fn latex_within(expression: &Expression, least: u8) -> String {
    // A fraction holds itself together.
    let fraction = matches!(&expression.kind, ExpressionKind::Binary(BinaryOperator::Divide, ..));
    // Between the factors of a product a binary infix call needs parentheses.
    let infix = matches!(&expression.kind, ExpressionKind::Call(function, _)
        if matches!(function.entry().setting, Setting::Infix(_)));
    let inner = latex(expression);
    if (tightness(expression) < least && !fraction) || (infix && least > 2) {
        parenthesised(&inner)
    } else {
        inner
    }
}

fn parenthesised(inner: &str) -> String {
    format!("\\left({inner}\\right)")
}

fn latex_number(si: f64, unit: Option<&Unit>) -> String {
    let written = digits(quantity(si, unit));
    let number = match written.split_once('e') {
        Some((mantissa, exponent)) => format!("{mantissa} \\cdot 10^{{{exponent}}}"),
        None => written,
    };
    match unit {
        Some(unit) => format!("{number}\\,\\mathrm{{{}}}", unit.symbol),
        None => number,
    }
}

fn latex_call(function: Function, arguments: &[Expression]) -> String {
    let first = || arguments.first().map(latex).unwrap_or_default();
    match (function.entry().setting, arguments) {
        (Setting::Between(open, close), _) => format!("{open} {} {close}", first()),
        (Setting::Infix(sign), [a, b]) => {
            format!("{} {sign} {}", latex_within(a, 3), latex_within(b, 3))
        }
        (Setting::Postfix(mark), [of]) => match &of.kind {
            ExpressionKind::Name(_) => format!("{{{}}}{mark}", latex(of)),
            _ => format!("{}{mark}", parenthesised(&latex(of))),
        },
        (Setting::Rate, [of]) => match &of.kind {
            ExpressionKind::Name(_) => format!("\\dot{{{}}}", latex(of)),
            ExpressionKind::Call(Function::Rate, inner) if is_one_name(inner) => {
                format!("\\ddot{{{}}}", inner.first().map(latex).unwrap_or_default())
            }
            _ => {
                format!("\\frac{{\\mathrm{{d}}}}{{\\mathrm{{d}} t}} {}", parenthesised(&latex(of)))
            }
        },
        (setting, _) => {
            let name = match setting {
                Setting::Operator(name) => name.to_owned(),
                _ => format!("\\operatorname{{{function}}}"),
            };
            let list: Vec<String> = arguments.iter().map(latex).collect();
            format!("{name}{}", parenthesised(&list.join(", ")))
        }
    }
}

/// Whether these arguments are one name.
fn is_one_name(arguments: &[Expression]) -> bool {
    matches!(arguments, [Expression { kind: ExpressionKind::Name(_), .. }])
}
