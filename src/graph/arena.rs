//! Scalar nodes, interned: equal expressions are one node, and what is known at once is computed
//! at once.
//!
//! Simplifications are those that hold for every finite operand (`x + 0`, `x * 1`, `x * 0`, double
//! negation), so a graph whose effects are off is the nominal graph. It does not reorder sums.

use super::node::{Binary, Leaf, Node, NodeId, Unary};
use crate::graph::table::Table;

/// A graph may hold this many nodes; a formula that wants more is refused.
pub const NODE_LIMIT: usize = 200_000;

/// Interned nodes in topological order.
#[derive(Clone, Debug, Default)]
pub struct Graph {
    nodes: Vec<Node>,
    /// For each node, whether it can differ from sample to sample.
    moving: Vec<bool>,
    index: Table<Node, NodeId>,
    full: bool,
    /// Without a limit: what an engine derives from a graph that was within it.
    boundless: bool,
    /// Matrices that are simpler than what the quaternions they belong to would give.
    pub(super) matrices: Table<[NodeId; 4], [[NodeId; 3]; 3]>,
}

impl Graph {
    /// A graph without a limit, for what is derived from one that has kept to it.
    pub fn boundless() -> Self {
        Self { boundless: true, ..Self::default() }
    }

    /// All nodes; operands come before users.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The node `id`.
    pub fn node(&self, id: NodeId) -> Node {
        self.nodes[id.0 as usize]
    }

    /// Whether a node can differ from sample to sample: it is made of more than parameters.
    pub fn is_moving(&self, id: NodeId) -> bool {
        self.moving[id.0 as usize]
    }

    /// Whether [`NODE_LIMIT`] was passed; the nodes are then of no use.
    pub fn is_full(&self) -> bool {
        self.full
    }

    /// The node, old or new, as it stands; the functions below simplify first.
    ///
    /// Beyond [`NODE_LIMIT`] no node is added, some other node is returned, and
    /// [`is_full`](Self::is_full) says so from then on.
    pub fn intern(&mut self, node: Node) -> NodeId {
        if let Some(id) = self.index.get(&node) {
            return *id;
        }
        if self.nodes.len() >= NODE_LIMIT && !self.boundless {
            self.full = true;
            return NodeId(0);
        }
        let id = NodeId(self.nodes.len() as u32);
        let moving = match node {
            Node::Constant(_) | Node::Leaf(Leaf::Parameter { .. }) => false,
            Node::Leaf(_) | Node::Signal { .. } => true,
            Node::Unary(..) | Node::Binary(..) => node.operands().any(|a| self.is_moving(a)),
        };
        self.nodes.push(node);
        self.moving.push(moving);
        self.index.insert(node, id);
        id
    }

    /// The node, if it is there.
    pub fn find(&self, node: Node) -> Option<NodeId> {
        self.index.get(&node).copied()
    }

    /// A number (`-0` counts as `0`).
    pub fn constant(&mut self, value: f64) -> NodeId {
        let value = if value == 0.0 { 0.0 } else { value };
        self.intern(Node::Constant(value.to_bits()))
    }

    /// The number a node is, if it is one.
    pub fn constant_value(&self, id: NodeId) -> Option<f64> {
        match self.node(id) {
            Node::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    /// A value from outside.
    pub fn leaf(&mut self, leaf: Leaf) -> NodeId {
        self.intern(Node::Leaf(leaf))
    }

    /// The `order`-th derivative of a moving input at `offset` from the reference time.
    pub fn signal(&mut self, input: u32, order: u8, offset: NodeId) -> NodeId {
        self.intern(Node::Signal { input, order, offset })
    }

    /// The node, simplified.
    pub fn folded(&mut self, node: Node) -> NodeId {
        match node {
            Node::Constant(bits) => self.constant(f64::from_bits(bits)),
            Node::Leaf(_) | Node::Signal { .. } => self.intern(node),
            Node::Unary(function, a) => self.unary(function, a),
            Node::Binary(function, a, b) => self.binary(function, a, b),
        }
    }

    /// A function of one node.
    pub fn unary(&mut self, function: Unary, a: NodeId) -> NodeId {
        if let Some(value) = self.constant_value(a) {
            let result: f64 = function.apply(value);
            if result.is_finite() {
                return self.constant(result);
            }
        }
        match (function, self.node(a)) {
            (Unary::Negate, Node::Unary(Unary::Negate, inner)) => inner,
            (Unary::Negate, Node::Binary(Binary::Subtract, x, y)) => self.subtract(y, x),
            (Unary::PowerInteger(0), _) => self.constant(1.0),
            (Unary::PowerInteger(1), _) => a,
            (Unary::PowerInteger(2), _) => self.multiply(a, a),
            (Unary::Abs, Node::Unary(Unary::Negate, inner)) => self.unary(Unary::Abs, inner),
            _ => self.intern(Node::Unary(function, a)),
        }
    }

    /// A function of two nodes.
    pub fn binary(&mut self, function: Binary, a: NodeId, b: NodeId) -> NodeId {
        let (x, y) = (self.constant_value(a), self.constant_value(b));
        if let (Some(x), Some(y)) = (x, y) {
            let result: f64 = function.apply(x, y);
            if result.is_finite() {
                return self.constant(result);
            }
        }
        let negated = |graph: &Self, id| match graph.node(id) {
            Node::Unary(Unary::Negate, inner) => Some(inner),
            _ => None,
        };
        match function {
            Binary::Add => {
                if x == Some(0.0) {
                    return b;
                }
                if y == Some(0.0) {
                    return a;
                }
                if a == b {
                    return self.scale(2.0, a);
                }
                if let Some(inner) = negated(self, b) {
                    return self.subtract(a, inner);
                }
                if let Some(inner) = negated(self, a) {
                    return self.subtract(b, inner);
                }
                self.intern(Node::Binary(function, a.min(b), a.max(b)))
            }
            Binary::Subtract => {
                if y == Some(0.0) {
                    return a;
                }
                if x == Some(0.0) {
                    return self.negate(b);
                }
                match negated(self, b) {
                    Some(inner) => self.add(a, inner),
                    None => self.intern(Node::Binary(function, a, b)),
                }
            }
            Binary::Multiply => {
                if x == Some(0.0) || y == Some(0.0) {
                    return self.constant(0.0);
                }
                if x == Some(1.0) {
                    return b;
                }
                if y == Some(1.0) {
                    return a;
                }
                if x == Some(-1.0) {
                    return self.negate(b);
                }
                if y == Some(-1.0) {
                    return self.negate(a);
                }
                match (negated(self, a), negated(self, b)) {
                    (Some(p), Some(q)) => self.multiply(p, q),
                    (Some(p), None) => {
                        let product = self.multiply(p, b);
                        self.negate(product)
                    }
                    (None, Some(q)) => {
                        let product = self.multiply(a, q);
                        self.negate(product)
                    }
                    (None, None) => self.intern(Node::Binary(function, a.min(b), a.max(b))),
                }
            }
            Binary::Divide if y == Some(1.0) => a,
            Binary::Divide if x == Some(0.0) && y != Some(0.0) => self.constant(0.0),
            Binary::Power if y == Some(1.0) => a,
            Binary::Power if y == Some(0.0) => self.constant(1.0),
            Binary::Min | Binary::Max if a == b => a,
            _ => self.intern(Node::Binary(function, a, b)),
        }
    }

    /// `-a`
    pub fn negate(&mut self, a: NodeId) -> NodeId {
        self.unary(Unary::Negate, a)
    }

    /// `a + b`
    pub fn add(&mut self, a: NodeId, b: NodeId) -> NodeId {
        self.binary(Binary::Add, a, b)
    }

    /// `a - b`
    pub fn subtract(&mut self, a: NodeId, b: NodeId) -> NodeId {
        self.binary(Binary::Subtract, a, b)
    }

    /// `a * b`
    pub fn multiply(&mut self, a: NodeId, b: NodeId) -> NodeId {
        self.binary(Binary::Multiply, a, b)
    }

    /// `factor * a`
    pub fn scale(&mut self, factor: f64, a: NodeId) -> NodeId {
        let factor = self.constant(factor);
        self.multiply(factor, a)
    }

    /// `a / b`
    pub fn divide(&mut self, a: NodeId, b: NodeId) -> NodeId {
        self.binary(Binary::Divide, a, b)
    }

    /// The sum of products `a0 b0 + a1 b1 + ...`, 0 of none.
    pub fn sum_of_products(&mut self, pairs: &[(NodeId, NodeId)]) -> NodeId {
        let mut sum = self.constant(0.0);
        for (a, b) in pairs {
            let product = self.multiply(*a, *b);
            sum = self.add(sum, product);
        }
        sum
    }

    /// The nodes these outputs need, themselves included, operands before users.
    pub fn needed_by(&self, outputs: &[NodeId]) -> Vec<NodeId> {
        let mut needed = vec![false; self.nodes.len()];
        let mut waiting: Vec<NodeId> = outputs.to_vec();
        while let Some(id) = waiting.pop() {
            if let Some(mark) = needed.get_mut(id.0 as usize)
                && !*mark
            {
                *mark = true;
                waiting.extend(self.node(id).operands());
            }
        }
        (0..self.nodes.len()).filter(|i| needed[*i]).map(|i| NodeId(i as u32)).collect()
    }
}
