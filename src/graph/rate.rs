//! The total derivative with respect to the moment, as new nodes.
//!
//! Signals move at their rates, the clocks at 1; parameters, randoms, still inputs and `t` stand
//! still. It is made before any engine sees the graph, and it nests. The partial
//! derivatives are those of [`super::partials`].

use crate::graph::Graph;
use crate::graph::node::{Leaf, Node, NodeId};
use crate::graph::partials::change;
use crate::graph::table::{Set, Table};

/// Derivatives made so far.
#[derive(Clone, Debug, Default)]
pub struct Rates {
    known: Table<NodeId, NodeId>,
    still: Set<NodeId>,
}

impl Rates {
    /// Declares a node to stand still: the offset `t`, whatever it is made of.
    pub fn hold_still(&mut self, node: NodeId) {
        self.still.insert(node);
    }

    /// Whether a node was declared to stand still.
    pub fn is_still(&self, node: NodeId) -> bool {
        self.still.contains(&node)
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
        let zero = graph.constant(0.0);
        if self.still.contains(&node) {
            return zero;
        }
        match graph.node(node) {
            Node::Leaf(Leaf::Clock(clock)) if clock.runs() => graph.constant(1.0),
            Node::Signal { input, order, offset } => {
                graph.signal(input, order.saturating_add(1), offset)
            }
            _ => {
                let of = |operand| self.known.get(&operand).copied().filter(|rate| *rate != zero);
                change(graph, node, of).unwrap_or(zero)
            }
        }
    }
}
