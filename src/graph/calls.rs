//! What each function of the language means: nodes, kinds and dimensions. Those of one number are
//! settled by their entry in [`crate::formula::functions`].

use crate::diagnostic::Span;
use crate::formula::functions::Meaning;
use crate::formula::{Expression, Formula, Function};
use crate::graph::context::{Context, Resolver};
use crate::graph::lower::{differ, number};
use crate::graph::node::{Binary, NodeId};
use crate::graph::typed::{Fault, Typed, fault, fault_with, quoted};
use crate::graph::{Graph, Value};
use crate::units::{Dimension, Exponent};

/// The arguments of one call, with what is needed to point at them.
struct Arguments<'a> {
    formula: &'a Formula,
    function: Function,
    expressions: &'a [Expression],
    values: Vec<Typed>,
}

impl Arguments<'_> {
    fn span(&self, index: usize) -> Span {
        self.expressions[index].span
    }

    /// A fault at an argument: what it is and what was due.
    fn wrong(&self, index: usize, due: &str) -> Fault {
        let span = self.span(index);
        let found = quoted(self.formula, span);
        let message = format!(
            "{found} is {}; `{}` takes {due} here",
            self.values[index].words(),
            self.function.entry().signature
        );
        fault(self.formula, span, message)
    }

    /// A number of any dimension.
    fn number(&self, index: usize) -> Result<NodeId, Fault> {
        let due = format!("an argument of `{}`", self.function);
        number(self.formula, self.span(index), &self.values[index], &due)
    }

    /// A plain number.
    fn plain(&self, index: usize) -> Result<NodeId, Fault> {
        match self.values[index].value {
            Value::Scalar(node) if self.values[index].fits(Dimension::NONE) => Ok(node),
            _ => Err(self.wrong(index, "a plain number")),
        }
    }

    /// A vector of any dimension.
    fn vector(&self, index: usize) -> Result<[NodeId; 3], Fault> {
        match self.values[index].value {
            Value::Vector(nodes) => Ok(nodes),
            _ => Err(self.wrong(index, "a vector")),
        }
    }

    /// A rotation.
    fn rotation(&self, index: usize) -> Result<[NodeId; 4], Fault> {
        match self.values[index].value {
            Value::Rotation(nodes) => Ok(nodes),
            _ => Err(self.wrong(index, "a rotation")),
        }
    }

    /// Numbers that all have one dimension.
    fn alike(&self) -> Result<(Vec<NodeId>, Dimension), Fault> {
        let mut first = (self.values[0], self.span(0));
        let mut nodes = vec![self.number(0)?];
        for (index, next) in self.values.iter().enumerate().skip(1) {
            nodes.push(self.number(index)?);
            let Some((dimension, any_dimension)) = first.0.common(next) else {
                return Err(differ(
                    self.formula,
                    [first.1, self.span(index)],
                    [&first.0, next],
                    &format!("`{}` wants one dimension", self.function),
                ));
            };
            let span = if first.0.any_dimension { self.span(index) } else { first.1 };
            first = (Typed { dimension, any_dimension, ..first.0 }, span);
        }
        Ok((nodes, first.0.dimension))
    }
}

impl Resolver<'_> {
    /// The nodes of a call.
    #[inline(never)]
    pub(super) fn call(
        &mut self,
        formula: &Formula,
        span: Span,
        function: Function,
        expressions: &[Expression],
        context: &Context,
    ) -> Result<Typed, Fault> {
        let mut values = Vec::with_capacity(expressions.len());
        for expression in expressions {
            values.push(self.lower(formula, expression, context)?);
        }
        let arguments = Arguments { formula, function, expressions, values };
        if values_are_missing(&arguments) {
            return Err(fault(
                formula,
                span,
                format!("`{}` has too few arguments", function.entry().signature),
            ));
        }
        match function.entry().meaning {
            Meaning::Own if function == Function::Rate => self.rate(&arguments),
            Meaning::Own if function == Function::Delayed => self.delayed(&arguments),
            Meaning::Own => several(&mut self.graph, &arguments),
            meaning => one_number(&mut self.graph, &arguments, meaning),
        }
    }

    fn rate(&mut self, arguments: &Arguments<'_>) -> Result<Typed, Fault> {
        let typed = arguments.values[0];
        let mut rate = |node| self.rates.rate(&mut self.graph, node);
        let value = match typed.value {
            Value::Scalar(node) => Value::Scalar(rate(node)),
            Value::Vector(nodes) => Value::Vector(nodes.map(rate)),
            Value::Rotation(_) => {
                let span = arguments.span(0);
                let found = quoted(arguments.formula, span);
                return Err(fault_with(
                    arguments.formula,
                    span,
                    format!("{found} is a rotation: `rate` takes numbers and vectors"),
                    "take the rate of a vector it turns, `rate(rotate(q, v))`",
                ));
            }
        };
        Ok(Typed { value, dimension: typed.dimension / Dimension::TIME, ..typed })
    }

    fn delayed(&mut self, arguments: &Arguments<'_>) -> Result<Typed, Fault> {
        let [typed, duration] = [arguments.values[0], arguments.values[1]];
        let by = match duration.value {
            Value::Scalar(node) if duration.fits(Dimension::TIME) => node,
            _ => return Err(arguments.wrong(1, "a duration")),
        };
        if self.graph.is_moving(by) {
            let fault = arguments.wrong(1, "a duration that is the same in all samples");
            return Err(Box::new(fault.help("what differs from sample to sample is added to `t`")));
        }
        let mut at = |node| self.delayed.node(&mut self.graph, &self.rates, node, by);
        let value = match typed.value {
            Value::Scalar(node) => Value::Scalar(at(node)),
            Value::Vector(nodes) => Value::Vector(nodes.map(at)),
            Value::Rotation(nodes) => Value::Rotation(nodes.map(at)),
        };
        Ok(Typed { value, ..typed })
    }
}

/// Whether a tree was made by hand with fewer arguments than its function takes.
fn values_are_missing(arguments: &Arguments<'_>) -> bool {
    arguments.values.len() < *arguments.function.entry().arity.start()
}

/// The functions of one number, as their entries say.
fn one_number(
    graph: &mut Graph,
    arguments: &Arguments<'_>,
    meaning: Meaning,
) -> Result<Typed, Fault> {
    let dimension = arguments.values[0].dimension;
    let (unary, node, dimension) = match meaning {
        Meaning::Plain(unary) => (unary, arguments.plain(0)?, Dimension::NONE),
        Meaning::Keep(unary) => (unary, arguments.number(0)?, dimension),
        Meaning::Drop(unary) => (unary, arguments.number(0)?, Dimension::NONE),
        Meaning::Root(unary) => {
            let half = Exponent::new(1, 2).unwrap_or(Exponent::ZERO);
            (unary, arguments.number(0)?, dimension.pow(half))
        }
        Meaning::Own => return Err(arguments.wrong(0, "something else")),
    };
    Ok(Typed::scalar(graph.unary(unary, node), dimension))
}

/// The functions that are not of one number.
fn several(graph: &mut Graph, arguments: &Arguments<'_>) -> Result<Typed, Fault> {
    let dimension = |index: usize| arguments.values[index].dimension;
    let fold = |graph: &mut Graph, nodes: Vec<NodeId>, binary| {
        let mut nodes = nodes.into_iter();
        let first = nodes.next().unwrap_or(NodeId(0));
        nodes.fold(first, |result, node| graph.binary(binary, result, node))
    };
    match arguments.function {
        Function::Atan2 => {
            let (nodes, _) = arguments.alike()?;
            Ok(Typed::plain(fold(graph, nodes, Binary::Atan2)))
        }
        Function::Hypot | Function::Min | Function::Max => {
            let (nodes, dimension) = arguments.alike()?;
            let binary = match arguments.function {
                Function::Hypot => Binary::Hypot,
                Function::Min => Binary::Min,
                _ => Binary::Max,
            };
            Ok(Typed::scalar(fold(graph, nodes, binary), dimension))
        }
        Function::Norm => {
            let v = arguments.vector(0)?;
            Ok(Typed::scalar(graph.norm(v), dimension(0)))
        }
        Function::Dot => {
            let (a, b) = (arguments.vector(0)?, arguments.vector(1)?);
            Ok(Typed::scalar(graph.dot(a, b), dimension(0) * dimension(1)))
        }
        Function::Cross => {
            let (a, b) = (arguments.vector(0)?, arguments.vector(1)?);
            Ok(Typed::vector(graph.cross(a, b), dimension(0) * dimension(1)))
        }
        Function::Normalize => {
            let v = arguments.vector(0)?;
            Ok(Typed::vector(graph.normalized(v), Dimension::NONE))
        }
        Function::RotationX | Function::RotationY | Function::RotationZ => {
            let angle = arguments.plain(0)?;
            let about = match arguments.function {
                Function::RotationX => 0,
                Function::RotationY => 1,
                _ => 2,
            };
            Ok(Typed::rotation(graph.rotation_about_coordinate(about, angle)))
        }
        Function::Rotation => {
            let (axis, angle) = (arguments.vector(0)?, arguments.plain(1)?);
            let axis = graph.normalized(axis);
            Ok(Typed::rotation(graph.rotation_about(axis, angle)))
        }
        Function::Turn => {
            let v = arguments.vector(0)?;
            if !arguments.values[0].fits(Dimension::NONE) {
                return Err(arguments.wrong(0, "a rotation vector (plain numbers)"));
            }
            Ok(Typed::rotation(graph.turn(v)))
        }
        Function::Quaternion => {
            let (nodes, _) = arguments.alike()?;
            let quaternion = [nodes[0], nodes[1], nodes[2], nodes[3]];
            Ok(Typed::rotation(graph.normalized(quaternion)))
        }
        Function::Rotate => {
            let (q, v) = (arguments.rotation(0)?, arguments.vector(1)?);
            let value = Value::Vector(graph.rotate(q, v));
            Ok(Typed { value, ..arguments.values[1] })
        }
        Function::Inverse => {
            let Value::Rotation(q) = arguments.values[0].value else {
                let fault = arguments.wrong(0, "a rotation");
                return Err(Box::new(fault.help("the reciprocal of a number is `1 / x`")));
            };
            Ok(Typed::rotation(graph.inverse(q)))
        }
        _ => Err(arguments.wrong(0, "something that is not worked out yet")),
    }
}
