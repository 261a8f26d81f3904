//! A formula to nodes, with its kind and dimension: operators and literals.
//!
//! A kind or dimension that does not fit is a fault at the sub-expression. What a name means is
//! [`super::context`]'s business, what a function means [`super::calls`]'s.

use crate::diagnostic::Span;
use crate::formula::compound::words;
use crate::formula::{Axis, BinaryOperator, Expression, ExpressionKind, Formula};
use crate::graph::context::{Context, Resolver};
use crate::graph::layers::Meaning;
use crate::graph::node::{Binary, NodeId, Unary};
use crate::graph::typed::{Fault, Typed, fault, fault_with, quoted};
use crate::graph::{Graph, Value};
use crate::units::{Dimension, Exponent, Unit};

/// Formulas within formulas nest at most this deep.
const DEPTH_LIMIT: usize = 600;

impl Resolver<'_> {
    /// The nodes of an expression of `formula` in a context.
    pub(super) fn lower(
        &mut self,
        formula: &Formula,
        expression: &Expression,
        context: &Context,
    ) -> Result<Typed, Fault> {
        if self.depth >= DEPTH_LIMIT {
            return Err(fault(
                formula,
                expression.span,
                format!("formulas nest more than {DEPTH_LIMIT} deep here"),
            ));
        }
        self.depth += 1;
        let result = match &expression.kind {
            ExpressionKind::Number(value, unit) => {
                let clear = self.no_name_as_unit(formula, expression.span, unit.as_ref(), context);
                let node = self.graph.constant(*value);
                let dimension = unit.as_ref().map_or(Dimension::NONE, |unit| unit.dimension);
                let any_dimension = *value == 0.0 && unit.is_none();
                clear.map(|()| Typed { any_dimension, ..Typed::scalar(node, dimension) })
            }
            ExpressionKind::Name(name) => self.name(formula, name, expression.span, context),
            ExpressionKind::Member(of, axis) => self.member(formula, of, *axis, context),
            ExpressionKind::Vector(parts) => self.vector(formula, parts, context),
            ExpressionKind::Negate(of) => self.negate(formula, of, context),
            ExpressionKind::Binary(operator, a, b) => {
                self.binary(formula, expression.span, *operator, [a, b], context)
            }
            ExpressionKind::Call(function, arguments) => {
                self.call(formula, expression.span, *function, arguments, context)
            }
        };
        self.depth -= 1;
        if self.graph.is_full() {
            return Err(fault_with(
                formula,
                expression.span,
                format!("the model has more than {} nodes here", crate::graph::arena::NODE_LIMIT),
                "use fewer effects at once, or fewer nested rates",
            ));
        }
        result
    }

    /// Refuses a unit such as `m/s` where `s` is a name, too: nobody could tell which is meant.
    fn no_name_as_unit(
        &self,
        formula: &Formula,
        span: Span,
        unit: Option<&Unit>,
        context: &Context,
    ) -> Result<(), Fault> {
        let Some(word) = unit.into_iter().flat_map(words).find(|word| {
            context.helpers.contains_key(*word)
                || !matches!(self.dictionary.meaning(context.patch, word), Meaning::Unknown)
        }) else {
            return Ok(());
        };
        let message = format!("`{word}` in {} is a unit and a name, too", quoted(formula, span));
        let help = "with blanks around `*` and `/` it is the name; for the unit, rename the other";
        Err(fault_with(formula, span, message, help))
    }

    #[inline(never)]
    fn member(
        &mut self,
        formula: &Formula,
        of: &Expression,
        axis: Axis,
        context: &Context,
    ) -> Result<Typed, Fault> {
        let whole = self.lower(formula, of, context)?;
        match whole.value {
            Value::Vector(nodes) => {
                let value = Value::Scalar(nodes[axis as usize]);
                Ok(Typed { value, ..whole })
            }
            _ => Err(fault(
                formula,
                of.span,
                format!(
                    "{} is {}; only a vector has members x, y, z",
                    quoted(formula, of.span),
                    whole.words()
                ),
            )),
        }
    }

    #[inline(never)]
    fn vector(
        &mut self,
        formula: &Formula,
        parts: &[Expression; 3],
        context: &Context,
    ) -> Result<Typed, Fault> {
        let mut nodes = [NodeId(0); 3];
        let mut first: Option<(Typed, Span)> = None;
        for (node, part) in nodes.iter_mut().zip(parts) {
            let typed = self.lower(formula, part, context)?;
            *node = number(formula, part.span, &typed, "a component of a vector")?;
            first = Some(match first {
                None => (typed, part.span),
                Some((before, span)) => match before.common(&typed) {
                    Some((dimension, any_dimension)) => {
                        let span = if before.any_dimension { part.span } else { span };
                        (Typed { dimension, any_dimension, ..before }, span)
                    }
                    None => {
                        return Err(differ(
                            formula,
                            [span, part.span],
                            [&before, &typed],
                            "cannot be components of one vector",
                        ));
                    }
                },
            });
        }
        let (dimension, any_dimension) =
            first.map_or((Dimension::NONE, true), |(t, _)| (t.dimension, t.any_dimension));
        Ok(Typed { any_dimension, ..Typed::vector(nodes, dimension) })
    }

    #[inline(never)]
    fn negate(
        &mut self,
        formula: &Formula,
        of: &Expression,
        context: &Context,
    ) -> Result<Typed, Fault> {
        let typed = self.lower(formula, of, context)?;
        let value = match typed.value {
            Value::Scalar(node) => Value::Scalar(self.graph.negate(node)),
            Value::Vector(nodes) => Value::Vector(nodes.map(|node| self.graph.negate(node))),
            Value::Rotation(_) => {
                return Err(fault_with(
                    formula,
                    of.span,
                    format!("{} is a rotation: it has no negative", quoted(formula, of.span)),
                    "the rotation back is `inverse(q)`",
                ));
            }
        };
        Ok(Typed { value, ..typed })
    }

    #[inline(never)]
    fn binary(
        &mut self,
        formula: &Formula,
        span: Span,
        operator: BinaryOperator,
        [left, right]: [&Expression; 2],
        context: &Context,
    ) -> Result<Typed, Fault> {
        let a = self.lower(formula, left, context)?;
        let b = self.lower(formula, right, context)?;
        let spans = [left.span, right.span];
        let graph = &mut self.graph;
        match operator {
            BinaryOperator::Add => sum(graph, formula, spans, Binary::Add, a, b),
            BinaryOperator::Subtract => sum(graph, formula, spans, Binary::Subtract, a, b),
            BinaryOperator::Multiply => product(graph, formula, spans, a, b),
            BinaryOperator::Divide => quotient(graph, formula, spans, a, b),
            BinaryOperator::Power => power(graph, formula, span, [left, right], a, b),
        }
    }
}

/// The node of a number, or a fault that says what was due.
pub(super) fn number(
    formula: &Formula,
    span: Span,
    typed: &Typed,
    due: &str,
) -> Result<NodeId, Fault> {
    match typed.value {
        Value::Scalar(node) => Ok(node),
        _ => {
            let found = quoted(formula, span);
            let message = format!("{found} is {}; {due} is a number", typed.words());
            Err(fault(formula, span, message))
        }
    }
}

/// The fault of two parts that do not go together.
pub(super) fn differ(
    formula: &Formula,
    spans: [Span; 2],
    [a, b]: [&Typed; 2],
    what: &str,
) -> Fault {
    let [left, right] = spans.map(|span| quoted(formula, span));
    let message = format!("{left} is {}, {right} is {}: {what}", a.words(), b.words());
    fault(formula, spans[0].to(spans[1]), message)
}

fn sum(
    graph: &mut Graph,
    formula: &Formula,
    spans: [Span; 2],
    operator: Binary,
    a: Typed,
    b: Typed,
) -> Result<Typed, Fault> {
    let verb = if operator == Binary::Add { "cannot add" } else { "cannot subtract" };
    let Some((dimension, any_dimension)) = a.common(&b) else {
        return Err(differ(formula, spans, [&a, &b], verb));
    };
    let value = match (a.value, b.value) {
        (Value::Scalar(x), Value::Scalar(y)) => Value::Scalar(graph.binary(operator, x, y)),
        (Value::Vector(x), Value::Vector(y)) => {
            Value::Vector([0, 1, 2].map(|i| graph.binary(operator, x[i], y[i])))
        }
        (Value::Rotation(_), _) | (_, Value::Rotation(_)) => {
            let fault = differ(formula, spans, [&a, &b], verb);
            return Err(Box::new(
                fault.help("rotations are put together with `*`; a small one is `turn(v)`"),
            ));
        }
        _ => return Err(differ(formula, spans, [&a, &b], verb)),
    };
    Ok(Typed { value, dimension, any_dimension })
}

fn product(
    graph: &mut Graph,
    formula: &Formula,
    spans: [Span; 2],
    a: Typed,
    b: Typed,
) -> Result<Typed, Fault> {
    let value = match (a.value, b.value) {
        (Value::Scalar(x), Value::Scalar(y)) => Value::Scalar(graph.multiply(x, y)),
        (Value::Scalar(x), Value::Vector(v)) | (Value::Vector(v), Value::Scalar(x)) => {
            Value::Vector(graph.scaled(x, v))
        }
        (Value::Rotation(p), Value::Rotation(q)) => Value::Rotation(graph.compose(p, q)),
        _ => {
            let help = match (a.value, b.value) {
                (Value::Vector(_), Value::Vector(_)) => "write `dot(a, b)` or `cross(a, b)`",
                (Value::Scalar(_), _) | (_, Value::Scalar(_)) => {
                    "a rotation by a rotation vector is `turn(v)`; scale that vector"
                }
                _ => "a vector is turned by `rotate(q, v)`",
            };
            let fault = differ(formula, spans, [&a, &b], "cannot multiply");
            return Err(Box::new(fault.help(help)));
        }
    };
    Ok(Typed::new(value, a.dimension * b.dimension))
}

fn quotient(
    graph: &mut Graph,
    formula: &Formula,
    spans: [Span; 2],
    a: Typed,
    b: Typed,
) -> Result<Typed, Fault> {
    let value = match (a.value, b.value) {
        (Value::Scalar(x), Value::Scalar(y)) => Value::Scalar(graph.divide(x, y)),
        (Value::Vector(v), Value::Scalar(y)) => Value::Vector(v.map(|x| graph.divide(x, y))),
        _ => {
            let mut fault = differ(formula, spans, [&a, &b], "cannot divide");
            if matches!(b.value, Value::Rotation(_)) {
                *fault = fault.help("the rotation back is `inverse(q)`");
            }
            return Err(fault);
        }
    };
    Ok(Typed::new(value, a.dimension / b.dimension))
}

fn power(
    graph: &mut Graph,
    formula: &Formula,
    span: Span,
    [left, right]: [&Expression; 2],
    a: Typed,
    b: Typed,
) -> Result<Typed, Fault> {
    let base = number(formula, left.span, &a, "the base of `^`")?;
    let exponent = number(formula, right.span, &b, "the exponent of `^`")?;
    if !b.fits(Dimension::NONE) {
        let found = quoted(formula, right.span);
        let message = format!("{found} is {}; an exponent is a plain number", b.words());
        return Err(fault(formula, right.span, message));
    }
    let dimension = if a.fits(Dimension::NONE) {
        Dimension::NONE
    } else {
        let Some(rational) = literal(right).and_then(Exponent::from_decimal) else {
            return Err(fault_with(
                formula,
                span,
                format!(
                    "{} is {}, so its exponent must be written out as a simple fraction",
                    quoted(formula, left.span),
                    a.words()
                ),
                "as in `x^2`, `x^0.5` or `x^(2/3)`",
            ));
        };
        a.dimension.pow(rational)
    };
    let node = match graph.constant_value(exponent) {
        Some(value) => constant_power(graph, base, value),
        None => graph.binary(Binary::Power, base, exponent),
    };
    Ok(Typed::scalar(node, dimension))
}

/// `base ^ exponent`: whole and half powers are exact and hold for every base they can.
fn constant_power(graph: &mut Graph, base: NodeId, exponent: f64) -> NodeId {
    let whole = |x: f64| x.fract() == 0.0 && x.abs() <= 1000.0;
    if whole(exponent) {
        return graph.unary(Unary::PowerInteger(exponent as i32), base);
    }
    if whole(2.0 * exponent) {
        let root = graph.unary(Unary::Sqrt, base);
        return graph.unary(Unary::PowerInteger((2.0 * exponent) as i32), root);
    }
    let exponent = graph.constant(exponent);
    graph.binary(Binary::Power, base, exponent)
}

/// The value of a number written out: `2`, `-1`, `2/3`.
fn literal(expression: &Expression) -> Option<f64> {
    match &expression.kind {
        ExpressionKind::Number(value, None) => Some(*value),
        ExpressionKind::Negate(of) => literal(of).map(|value| -value),
        ExpressionKind::Binary(BinaryOperator::Divide, a, b) => Some(literal(a)? / literal(b)?),
        _ => None,
    }
}
