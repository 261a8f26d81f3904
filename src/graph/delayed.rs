//! An expression at an earlier moment, as new nodes.
//!
//! Signals are taken a duration before, clocks read so much less; parameters, randoms, still inputs
//! and `t` are what they are. Like the rate it is made before any engine sees the graph, and it
//! nests.

use crate::graph::Graph;
use crate::graph::node::{Leaf, Node, NodeId};
use crate::graph::rate::Rates;
use crate::graph::table::Table;

/// Nodes at an earlier moment, made so far: by duration and node.
#[derive(Clone, Debug, Default)]
pub struct Delayed {
    known: Table<(NodeId, NodeId), NodeId>,
}

impl Delayed {
    /// A node as it was `duration` before. What `rates` holds still stays. Iterative: a deep graph
    /// does not exhaust the stack.
    pub fn node(
        &mut self,
        graph: &mut Graph,
        rates: &Rates,
        node: NodeId,
        duration: NodeId,
    ) -> NodeId {
        let mut waiting = vec![node];
        while let Some(&next) = waiting.last() {
            if graph.is_full() {
                return NodeId(0);
            }
            if self.known.contains_key(&(duration, next)) {
                waiting.pop();
                continue;
            }
            let before = waiting.len();
            let is_still = rates.is_still(next);
            if !is_still && !matches!(graph.node(next), Node::Signal { .. }) {
                let missing = |of: &NodeId| !self.known.contains_key(&(duration, *of));
                waiting.extend(graph.node(next).operands().filter(missing));
            }
            if waiting.len() == before {
                let earlier = if is_still { next } else { self.step(graph, next, duration) };
                self.known.insert((duration, next), earlier);
                waiting.pop();
            }
        }
        self.known.get(&(duration, node)).copied().unwrap_or(node)
    }

    /// A node from those of its operands.
    fn step(&self, graph: &mut Graph, node: NodeId, duration: NodeId) -> NodeId {
        let at = |of| self.known.get(&(duration, of)).copied().unwrap_or(of);
        match graph.node(node) {
            Node::Leaf(Leaf::Clock(clock)) if clock.runs() => graph.subtract(node, duration),
            Node::Constant(_) | Node::Leaf(_) => node,
            Node::Signal { input, order, offset } => {
                let offset = graph.subtract(offset, duration);
                graph.signal(input, order, offset)
            }
            Node::Unary(function, a) => graph.unary(function, at(a)),
            Node::Binary(function, a, b) => graph.binary(function, at(a), at(b)),
        }
    }
}
