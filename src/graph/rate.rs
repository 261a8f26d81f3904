//! The total derivative with respect to the moment, as new nodes.
//!
//! Signals move at their rates, the clocks at 1; parameters, randoms, still inputs and `t` stand
//! still. It is made before any engine sees the graph, and it nests. The conventions at singular
//! points are those of [`crate::number`].

use std::collections::{HashMap, HashSet};

use crate::graph::Graph;
use crate::graph::node::{Binary, Clock, Leaf, Node, NodeId, Unary};

/// Derivatives made so far.
#[derive(Clone, Debug, Default)]
pub struct Rates {
    known: HashMap<NodeId, NodeId>,
    still: HashSet<NodeId>,
}

impl Rates {
    /// Declares a node to stand still: the offset `t`, whatever it is made of.
    pub fn hold_still(&mut self, node: NodeId) {
        self.still.insert(node);
    }

    /// The derivative of a node. Iterative: a deep graph does not exhaust the stack.
    pub fn rate(&mut self, graph: &mut Graph, node: NodeId) -> NodeId {
        let mut waiting = vec![node];
        while let Some(&next) = waiting.last() {
            if graph.is_full() {
                return NodeId(0);
            }
            if self.known.contains_key(&next) {
                waiting.pop();
                continue;
            }
            let before = waiting.len();
            if !self.still.contains(&next) && !matches!(graph.node(next), Node::Signal { .. }) {
                let operands = graph.node(next).operands();
                waiting.extend(operands.filter(|operand| !self.known.contains_key(operand)));
            }
            if waiting.len() == before {
                let rate = self.step(graph, next);
                self.known.insert(next, rate);
                waiting.pop();
            }
        }
        self.of(graph, node)
    }

    /// The derivative of a node whose derivative is known; 0 otherwise.
    fn of(&self, graph: &mut Graph, node: NodeId) -> NodeId {
        match self.known.get(&node) {
            Some(rate) => *rate,
            None => graph.constant(0.0),
        }
    }

    /// The derivative of a node from those of its operands.
    fn step(&self, graph: &mut Graph, node: NodeId) -> NodeId {
        if self.still.contains(&node) {
            return graph.constant(0.0);
        }
        match graph.node(node) {
            Node::Leaf(Leaf::Clock(clock)) => {
                graph.constant(if clock == Clock::Index { 0.0 } else { 1.0 })
            }
            Node::Constant(_) | Node::Leaf(_) => graph.constant(0.0),
            Node::Signal { input, order, offset } => {
                graph.signal(input, order.saturating_add(1), offset)
            }
            Node::Unary(function, u) => {
                let du = self.of(graph, u);
                if graph.constant_value(du) == Some(0.0) {
                    return du;
                }
                let slope = slope(graph, function, u, node);
                graph.multiply(slope, du)
            }
            Node::Binary(function, a, b) => {
                let (da, db) = (self.of(graph, a), self.of(graph, b));
                let zero = |id| graph.constant_value(id) == Some(0.0);
                if zero(da) && zero(db) {
                    return da;
                }
                binary(graph, function, node, (a, da), (b, db))
            }
        }
    }
}

/// The derivative of a function of one number at `u`, where its value is `value`.
fn slope(graph: &mut Graph, function: Unary, u: NodeId, value: NodeId) -> NodeId {
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
            let squared = square(graph, u);
            let rest = graph.subtract(one, squared);
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

/// The derivative of a function of two numbers; each operand comes with its own derivative.
fn binary(
    graph: &mut Graph,
    function: Binary,
    value: NodeId,
    (a, da): (NodeId, NodeId),
    (b, db): (NodeId, NodeId),
) -> NodeId {
    match function {
        Binary::Add => graph.add(da, db),
        Binary::Subtract => graph.subtract(da, db),
        Binary::Multiply => graph.sum_of_products(&[(da, b), (a, db)]),
        Binary::Divide => {
            // (a' - (a/b) b') / b
            let change = graph.multiply(value, db);
            let numerator = graph.subtract(da, change);
            graph.divide(numerator, b)
        }
        Binary::Power => {
            // b a^(b-1) a' + ln(a) a^b b'
            let one = graph.constant(1.0);
            let less = graph.subtract(b, one);
            let lower = graph.binary(Binary::Power, a, less);
            let by_base = graph.multiply(b, lower);
            let base = graph.multiply(by_base, da);
            if graph.constant_value(db) == Some(0.0) {
                return base;
            }
            let logarithm = graph.unary(Unary::Ln, a);
            let by_exponent = graph.multiply(logarithm, value);
            let exponent = graph.multiply(by_exponent, db);
            graph.add(base, exponent)
        }
        Binary::Atan2 => {
            // (b a' - a b') / (a² + b²), nothing at the origin
            let first = graph.multiply(b, da);
            let second = graph.multiply(a, db);
            let numerator = graph.subtract(first, second);
            let squares = graph.sum_of_products(&[(a, a), (b, b)]);
            let reciprocal = graph.unary(Unary::ReciprocalOrZero, squares);
            graph.multiply(numerator, reciprocal)
        }
        Binary::Hypot => {
            let numerator = graph.sum_of_products(&[(a, da), (b, db)]);
            let reciprocal = graph.unary(Unary::ReciprocalOrZero, value);
            graph.multiply(numerator, reciprocal)
        }
        Binary::Min | Binary::Max => {
            // The second operand counts where it is strictly beyond the first: 1 there, 0 elsewhere.
            let beyond =
                if function == Binary::Min { graph.subtract(a, b) } else { graph.subtract(b, a) };
            let sign = graph.unary(Unary::Sign, beyond);
            let zero = graph.constant(0.0);
            let step = graph.binary(Binary::Max, sign, zero);
            let difference = graph.subtract(db, da);
            let change = graph.multiply(step, difference);
            graph.add(da, change)
        }
    }
}
