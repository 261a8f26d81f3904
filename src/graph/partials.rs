//! Partial derivatives of every function of the graph, as nodes: the one table that the rate, the
//! tangents and the gradients are made from.
//!
//! The conventions at singular points are those of [`crate::number`].

use crate::graph::Graph;
use crate::graph::node::{Binary, NodeId, Unary};

/// The derivative of a function of one number at `u`, where its value is `value`.
pub fn slope(graph: &mut Graph, function: Unary, u: NodeId, value: NodeId) -> NodeId {
    let one = graph.constant(1.0);
    let square = |graph: &mut Graph, x| graph.multiply(x, x);
    match function {
        Unary::Negate => graph.constant(-1.0),
        Unary::Sin => graph.unary(Unary::Cos, u),
        Unary::Cos => {
            let sine = graph.unary(Unary::Sin, u);
            graph.negate(sine)
        }
        Unary::Tan => {
            let squared = square(graph, value);
            graph.add(one, squared)
        }
        Unary::Asin | Unary::Acos => {
            // (1 - u)(1 + u) keeps its digits next to the ends.
            let (below, above) = (graph.subtract(one, u), graph.add(one, u));
            let rest = graph.multiply(below, above);
            let root = graph.unary(Unary::Sqrt, rest);
            let slope = graph.unary(Unary::ReciprocalOrZero, root);
            if function == Unary::Asin { slope } else { graph.negate(slope) }
        }
        Unary::Atan => {
            let squared = square(graph, u);
            let sum = graph.add(one, squared);
            graph.divide(one, sum)
        }
        Unary::Sqrt => {
            let reciprocal = graph.unary(Unary::ReciprocalOrZero, value);
            graph.scale(0.5, reciprocal)
        }
        Unary::Exp => value,
        Unary::Ln => graph.divide(one, u),
        Unary::Abs => graph.unary(Unary::Sign, u),
        Unary::Sign | Unary::Floor => graph.constant(0.0),
        Unary::Tanh => {
            let squared = square(graph, value);
            graph.subtract(one, squared)
        }
        Unary::Fract => one,
        Unary::PowerInteger(exponent) => {
            let lower = graph.unary(Unary::PowerInteger(exponent.saturating_sub(1)), u);
            graph.scale(f64::from(exponent), lower)
        }
        Unary::Stumpff(order) => {
            let second = graph.unary(Unary::Stumpff(order.saturating_add(2)), u);
            let first = graph.unary(Unary::Stumpff(order.saturating_add(1)), u);
            let scaled = graph.scale(f64::from(order), second);
            let difference = graph.subtract(scaled, first);
            graph.scale(0.5, difference)
        }
        Unary::ReciprocalOrZero => {
            let squared = square(graph, value);
            graph.negate(squared)
        }
    }
}

/// The derivative of a function of `a` and `b`, whose value is `value`, with respect to its first
/// (`side` 0) or second operand.
pub fn partial(
    graph: &mut Graph,
    function: Binary,
    (a, b): (NodeId, NodeId),
    value: NodeId,
    side: usize,
) -> NodeId {
    let first = side == 0;
    match function {
        Binary::Add => graph.constant(1.0),
        Binary::Subtract => graph.constant(if first { 1.0 } else { -1.0 }),
        Binary::Multiply => {
            if first {
                b
            } else {
                a
            }
        }
        Binary::Divide => {
            // 1 / b and -(a / b) / b
            let one = graph.constant(1.0);
            let reciprocal = graph.divide(one, b);
            if first {
                return reciprocal;
            }
            let product = graph.multiply(value, reciprocal);
            graph.negate(product)
        }
        Binary::Power if first => {
            // b a^(b - 1)
            let one = graph.constant(1.0);
            let less = graph.subtract(b, one);
            let lower = graph.binary(Binary::Power, a, less);
            graph.multiply(b, lower)
        }
        Binary::Power => {
            // ln(a) a^b
            let logarithm = graph.unary(Unary::Ln, a);
            graph.multiply(logarithm, value)
        }
        Binary::Atan2 => {
            // b / (a² + b²) and -a / (a² + b²), nothing at the origin
            let squares = graph.sum_of_products(&[(a, a), (b, b)]);
            let reciprocal = graph.unary(Unary::ReciprocalOrZero, squares);
            let product = graph.multiply(if first { b } else { a }, reciprocal);
            if first { product } else { graph.negate(product) }
        }
        Binary::Hypot => {
            let reciprocal = graph.unary(Unary::ReciprocalOrZero, value);
            graph.multiply(if first { a } else { b }, reciprocal)
        }
        Binary::Min | Binary::Max => {
            // The second operand counts where it is strictly beyond the first: 1 there, 0
            // elsewhere.
            let beyond =
                if function == Binary::Min { graph.subtract(a, b) } else { graph.subtract(b, a) };
            let sign = graph.unary(Unary::Sign, beyond);
            let (zero, one) = (graph.constant(0.0), graph.constant(1.0));
            let second = graph.binary(Binary::Max, sign, zero);
            if first { graph.subtract(one, second) } else { second }
        }
    }
}

/// `Σ partial · change` over the operands of a node whose changes are given; `None` where nothing
/// changes.
pub fn change(
    graph: &mut Graph,
    node: NodeId,
    of: impl Fn(NodeId) -> Option<NodeId>,
) -> Option<NodeId> {
    use crate::graph::node::Node;
    match graph.node(node) {
        Node::Constant(_) | Node::Leaf(_) => None,
        Node::Signal { input, order, offset } => {
            let moved = of(offset)?;
            let rate = graph.signal(input, order.saturating_add(1), offset);
            Some(graph.multiply(rate, moved))
        }
        Node::Unary(function, u) => {
            let moved = of(u)?;
            let slope = slope(graph, function, u, node);
            Some(graph.multiply(slope, moved))
        }
        Node::Binary(function, a, b) => {
            let mut sum = None;
            for (side, operand) in [a, b].into_iter().enumerate() {
                let Some(moved) = of(operand) else { continue };
                let by = partial(graph, function, (a, b), node, side);
                let term = graph.multiply(by, moved);
                sum = Some(match sum {
                    Some(before) => graph.add(before, term),
                    None => term,
                });
            }
            sum
        }
    }
}
