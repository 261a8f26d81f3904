//! A copy of some nodes in another graph, with leaves replaced.
//!
//! Answers: what an expression becomes where some leaves are other expressions (a random quantity
//! its mean, an effect's parameter zero). The copy is folded again, so what a replaced leaf made
//! superfluous is gone, and what the other graph holds already is shared.

use crate::graph::Graph;
use crate::graph::node::{Leaf, Node, NodeId};

/// Where the nodes of one graph are in another.
#[derive(Clone, Debug, Default)]
pub struct Import {
    known: Vec<Option<NodeId>>,
    rewrite: Option<Rewrite>,
}

/// Another node for one whose operands are copied already, if there is a better one.
pub type Rewrite = fn(&mut Graph, Node) -> Option<NodeId>;

impl Import {
    /// A copy in which nodes are replaced as `rewrite` says.
    pub fn rewriting(rewrite: Rewrite) -> Self {
        Self { known: Vec::new(), rewrite: Some(rewrite) }
    }

    /// The node of `into` that stands for `node` of `from`. `leaf` makes the nodes of leaves, and
    /// is asked once for each. The same two graphs must be given to every call.
    pub fn node(
        &mut self,
        from: &Graph,
        node: NodeId,
        into: &mut Graph,
        leaf: &mut impl FnMut(&mut Graph, Leaf) -> NodeId,
    ) -> NodeId {
        self.known.resize(from.nodes().len(), None);
        let mut waiting = vec![node];
        while let Some(&next) = waiting.last() {
            if into.is_full() {
                return NodeId(0);
            }
            if self.at(next).is_some() {
                waiting.pop();
                continue;
            }
            let before = waiting.len();
            let missing = from.node(next).operands().filter(|operand| self.at(*operand).is_none());
            waiting.extend(missing);
            if waiting.len() == before {
                let copy = self.copy(from.node(next), into, leaf);
                self.known[next.0 as usize] = Some(copy);
                waiting.pop();
            }
        }
        self.at(node).unwrap_or(NodeId(0))
    }

    fn at(&self, node: NodeId) -> Option<NodeId> {
        self.known[node.0 as usize]
    }

    /// A node whose operands are copied.
    fn copy(
        &self,
        node: Node,
        into: &mut Graph,
        leaf: &mut impl FnMut(&mut Graph, Leaf) -> NodeId,
    ) -> NodeId {
        let at = |operand| self.at(operand).unwrap_or(NodeId(0));
        let node = match node {
            Node::Constant(bits) => return into.constant(f64::from_bits(bits)),
            Node::Leaf(one) => return leaf(into, one),
            Node::Signal { input, order, offset } => {
                Node::Signal { input, order, offset: at(offset) }
            }
            Node::Unary(function, a) => Node::Unary(function, at(a)),
            Node::Binary(function, a, b) => Node::Binary(function, at(a), at(b)),
        };
        match self.rewrite.and_then(|rewrite| rewrite(into, node)) {
            Some(other) => other,
            None => into.folded(node),
        }
    }
}
