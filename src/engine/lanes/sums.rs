//! Which nodes one instruction computes as a sum of products: `Σ factor · a` and
//! `Σ factor · a · b`, where factors stand still and a, b move, and such a sum times something that
//! moves.
//!
//! Answers: the terms of every sum, difference, product and negative. A sum takes in what nothing
//! else needs, and a product whose factor stands still wherever it is needed: to multiply once more
//! costs less than to read what was multiplied. Terms are added in the order of the graph, so a
//! small number that is added to a difference of large ones keeps its digits; and a sum times a
//! factor is not multiplied out.

use crate::engine::lanes::instruction::{MOST_TERMS, MOST_WITH_NUMBER};
use crate::graph::table::Table;
use crate::graph::{Binary, Graph, Node, NodeId, Unary};

/// `factor`, `factor · a` or `factor · a · b`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Term {
    /// Stands still.
    pub(super) factor: NodeId,
    /// Move.
    pub(super) lanes: [Option<NodeId>; 2],
}

/// The sum of some terms, or that times something that moves.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Sum {
    /// At least one.
    pub(super) terms: Vec<Term>,
    /// Multiplies their sum.
    pub(super) scale: Option<NodeId>,
}

impl Sum {
    /// The nodes of `Σ factor · a`, two or three, and whether a number is added last; `None` of
    /// other sums. Sums of the same nodes read them once.
    pub(super) fn map_of(&self) -> Option<([Option<NodeId>; 3], bool)> {
        let has_number = self.terms.last().is_some_and(|term| term.lanes == [None, None]);
        let moving = &self.terms[..self.terms.len() - usize::from(has_number)];
        let are_single = moving.iter().all(|term| matches!(term.lanes, [Some(_), None]));
        let mut nodes = [None; 3];
        let fits = self.scale.is_none() && are_single && (2..=nodes.len()).contains(&moving.len());
        for (node, term) in nodes.iter_mut().zip(moving) {
            *node = term.lanes[0];
        }
        fits.then_some((nodes, has_number))
    }

    /// Whether a term may be a number that nothing is multiplied with, see
    /// [`Kind::Number`](super::instruction::Kind::Number).
    pub(super) fn takes_number(&self, term: usize) -> bool {
        term == 0 && self.terms.len() <= MOST_WITH_NUMBER
    }

    /// The nodes that move in it.
    pub(super) fn lanes(&self) -> impl Iterator<Item = NodeId> {
        self.terms.iter().flat_map(|term| term.lanes).flatten().chain(self.scale)
    }
}

/// The sums of a program.
#[derive(Clone, Debug, Default)]
pub(super) struct Sums {
    sums: Table<NodeId, Sum>,
    /// The first node that is this sum: two ways of writing one sum are one sum.
    first: Table<Sum, NodeId>,
}

impl Sums {
    /// What a node is the sum of.
    pub(super) fn get(&self, node: NodeId) -> Option<&Sum> {
        self.sums.get(&node)
    }

    /// The first node that is the same sum as this one.
    pub(super) fn first_alike(&self, node: NodeId) -> NodeId {
        let first = self.sums.get(&node).and_then(|sum| self.first.get(sum));
        first.copied().unwrap_or(node)
    }

    fn insert(&mut self, node: NodeId, sum: Sum) {
        self.first.entry(sum.clone()).or_insert(node);
        self.sums.insert(node, sum);
    }
}

/// The sums among `nodes`, operands before users; `uses` says how often each is needed.
pub(super) fn sums(graph: &mut Graph, nodes: &[NodeId], uses: &[u32]) -> Sums {
    let mut finder = Finder { graph, uses, sums: Sums::default() };
    for &node in nodes {
        if finder.graph.is_moving(node)
            && let Some(sum) = finder.sum(node)
        {
            finder.sums.insert(node, sum);
        }
    }
    finder.sums
}

struct Finder<'a> {
    graph: &'a mut Graph,
    uses: &'a [u32],
    sums: Sums,
}

impl Finder<'_> {
    fn sum(&mut self, node: NodeId) -> Option<Sum> {
        let mut terms = match self.graph.node(node) {
            Node::Binary(Binary::Add, a, b) => self.added([a, b], false),
            Node::Binary(Binary::Subtract, a, b) => self.added([a, b], true),
            Node::Binary(Binary::Multiply, a, b) => {
                if let Some(sum) = self.times(a, b).or_else(|| self.times(b, a)) {
                    return Some(sum);
                }
                let one = self.graph.constant(1.0);
                vec![self.product(one, a, b)]
            }
            Node::Unary(Unary::Negate, a) => {
                if let Some(Sum { terms, scale }) = self.alone(a).cloned() {
                    return Some(Sum { terms: self.negated(terms), scale });
                }
                let term = self.term(a);
                self.negated(vec![term])
            }
            _ => return None,
        };
        // Two terms are the same sum in either order.
        if terms.len() == 2 {
            terms.sort_unstable_by_key(|term| (term.lanes, term.factor));
        }
        Some(Sum { terms, scale: None })
    }

    /// A moving node times a sum that nothing else needs.
    fn times(&self, scale: NodeId, node: NodeId) -> Option<Sum> {
        let Sum { terms, scale: None } = self.alone(node)? else { return None };
        let scale = self.graph.is_moving(scale).then(|| self.sums.first_alike(scale))?;
        Some(Sum { terms: terms.clone(), scale: Some(scale) })
    }

    /// A sum that nothing else needs, and that is more than one number times another.
    fn alone(&self, node: NodeId) -> Option<&Sum> {
        let sum = self.sums.get(node)?;
        let is_sum = sum.terms.len() > 1 || sum.terms.iter().any(|term| term.lanes[1].is_some());
        (is_sum && self.is_needed_once(node) && self.sums.first_alike(node) == node).then_some(sum)
    }

    /// The terms of `a + b` or `a - b`: those of the longer part that fits, then the other as one.
    fn added(&mut self, [a, b]: [NodeId; 2], subtract: bool) -> Vec<Term> {
        let [left, right] = [a, b].map(|node| self.part(node, MOST_TERMS - 1));
        let length = |part: &Option<Vec<Term>>| part.as_ref().map_or(0, Vec::len);
        let (mut terms, last) = if length(&right) > length(&left) {
            let right = right.unwrap_or_default();
            (if subtract { self.negated(right) } else { right }, self.term(a))
        } else {
            let left = match left {
                Some(part) => part,
                None => vec![self.term(a)],
            };
            let term = self.term(b);
            (left, if subtract { self.negated(vec![term])[0] } else { term })
        };
        terms.push(last);
        terms
    }

    /// The terms of a sum that nothing else needs, where there are more than one and at most
    /// `most`.
    fn part(&self, node: NodeId, most: usize) -> Option<Vec<Term>> {
        let Sum { terms, scale: None } = self.sums.get(node)? else { return None };
        (self.is_needed_once(node) && (2..=most).contains(&terms.len())).then(|| terms.to_vec())
    }

    /// A node as one term.
    fn term(&mut self, node: NodeId) -> Term {
        if !self.graph.is_moving(node) {
            return Term { factor: node, lanes: [None, None] };
        }
        let (factor, rest) = self.scaled(node);
        match self.graph.node(rest) {
            Node::Binary(Binary::Multiply, a, b)
                if self.is_needed_once(rest) && (rest == node || self.is_needed_once(node)) =>
            {
                self.product(factor, a, b)
            }
            _ => Term { factor, lanes: [Some(rest), None] },
        }
    }

    fn product(&mut self, factor: NodeId, a: NodeId, b: NodeId) -> Term {
        let mut factor = factor;
        let mut lanes = [None, None];
        let mut count = 0;
        for operand in [a, b] {
            let (by, rest) = self.scaled(operand);
            factor = self.multiplied(factor, by);
            if self.graph.is_moving(rest) {
                lanes[count] = Some(rest);
                count += 1;
            } else {
                factor = self.multiplied(factor, rest);
            }
        }
        if count == 2 {
            lanes.sort_unstable();
        }
        Term { factor, lanes }
    }

    /// A node as a factor that stands still and the rest.
    fn scaled(&mut self, node: NodeId) -> (NodeId, NodeId) {
        let (mut factor, mut rest) = (self.graph.constant(1.0), node);
        loop {
            rest = self.sums.first_alike(rest);
            (factor, rest) = match self.graph.node(rest) {
                Node::Binary(Binary::Multiply, a, b) if !self.graph.is_moving(a) => {
                    (self.multiplied(factor, a), b)
                }
                Node::Binary(Binary::Multiply, a, b) if !self.graph.is_moving(b) => {
                    (self.multiplied(factor, b), a)
                }
                Node::Unary(Unary::Negate, a) => (self.graph.negate(factor), a),
                _ => return (factor, rest),
            };
        }
    }

    /// The product of two factors that stand still, in one way of those that differ by the place of
    /// a sign: `-(r (a - b))` for `r (b - a)`.
    fn multiplied(&mut self, factor: NodeId, by: NodeId) -> NodeId {
        if let Node::Binary(Binary::Multiply, a, b) = self.graph.node(by) {
            let product = self.multiplied(factor, a);
            return self.multiplied(product, b);
        }
        let ((minus, factor), (other_minus, by)) = (self.signed(factor), self.signed(by));
        let product = self.graph.multiply(factor, by);
        if minus == other_minus { product } else { self.graph.negate(product) }
    }

    /// Whether a factor counts negative, and the rest: of a difference and its opposite always the
    /// same.
    fn signed(&mut self, factor: NodeId) -> (bool, NodeId) {
        match self.graph.node(factor) {
            Node::Unary(Unary::Negate, opposite) => (true, opposite),
            Node::Binary(Binary::Subtract, a, b) if a > b => (true, self.graph.subtract(b, a)),
            _ => (false, factor),
        }
    }

    fn negated(&mut self, terms: Vec<Term>) -> Vec<Term> {
        let negate = |term: Term| Term { factor: self.graph.negate(term.factor), ..term };
        terms.into_iter().map(negate).collect()
    }

    fn is_needed_once(&self, node: NodeId) -> bool {
        self.uses[node.0 as usize] == 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::pointwise::{Leaves, Program};
    use crate::graph::Leaf;

    /// Some number for each leaf.
    struct Numbers;

    impl Leaves<f64> for Numbers {
        fn leaf(&self, leaf: Leaf) -> f64 {
            match leaf {
                Leaf::Given(index) => 0.3 + 1.7 * f64::from(index),
                Leaf::Parameter { parameter, .. } => -0.9 + 0.8 * f64::from(parameter),
                _ => f64::NAN,
            }
        }

        fn signal(&self, _: u32, _: u8, _: f64) -> f64 {
            f64::NAN
        }
    }

    fn found(graph: &mut Graph, outputs: &[NodeId]) -> Sums {
        let nodes = graph.needed_by(outputs);
        let mut uses = vec![0; graph.nodes().len()];
        outputs.iter().for_each(|output| uses[output.0 as usize] += 1);
        for node in &nodes {
            graph.node(*node).operands().for_each(|operand| uses[operand.0 as usize] += 1);
        }
        sums(graph, &nodes, &uses)
    }

    fn value(graph: &Graph, node: NodeId) -> f64 {
        Program::new(graph, &[node]).evaluate(&Numbers, &mut Vec::new())[0]
    }

    /// `p - (k x + y z) + x`, its negative, `(k x) (y z)` with `y z` needed elsewhere, too, and
    /// `y (k z + x z)`.
    fn expressions(graph: &mut Graph) -> Vec<NodeId> {
        let [x, y, z] = [0, 1, 2].map(|index| graph.leaf(Leaf::Given(index)));
        let [p, k] =
            [0, 1].map(|parameter| graph.leaf(Leaf::Parameter { parameter, component: 0 }));
        let (kx, yz) = (graph.multiply(k, x), graph.multiply(y, z));
        let zz = graph.multiply(z, z);
        let inner = graph.add(kx, zz);
        let rest = graph.subtract(p, inner);
        let sum = graph.add(rest, x);
        let last = graph.subtract(y, sum);
        let product = graph.multiply(kx, yz);
        let sum = graph.sum_of_products(&[(k, z), (x, z)]);
        vec![graph.negate(last), product, yz, graph.multiply(y, sum)]
    }

    #[test]
    fn the_terms_of_a_node_add_up_to_it() {
        let mut graph = Graph::default();
        let outputs = expressions(&mut graph);
        let sums = found(&mut graph, &outputs);
        assert!(sums.sums.len() > 5);
        for (node, Sum { terms, scale }) in &sums.sums {
            assert!(terms.len() <= MOST_TERMS);
            let added: f64 = terms
                .iter()
                .map(|term| {
                    let lanes: f64 =
                        term.lanes.iter().flatten().map(|n| value(&graph, *n)).product();
                    value(&graph, term.factor) * lanes
                })
                .sum();
            let added = added * scale.map_or(1.0, |scale| value(&graph, scale));
            let expected = value(&graph, *node);
            assert!((added - expected).abs() < 1e-14, "{terms:?}: {added}, not {expected}");
        }
        // Five terms: the innermost pair stays a sum of its own.
        let length = |node| sums.get(node).map_or(0, |sum| sum.terms.len());
        let lengths: Vec<usize> = outputs.iter().map(|node| length(*node)).collect();
        assert_eq!(lengths, [2, 1, 1, 2]);
        let moving = |node| sums.get(node).map_or(0, |sum| sum.lanes().count());
        assert_eq!([moving(outputs[1]), moving(outputs[3])], [2, 4]);
    }

    #[test]
    fn one_sum_written_twice_is_one() {
        let mut graph = Graph::default();
        let [x, y] = [0, 1].map(|index| graph.leaf(Leaf::Given(index)));
        let k = graph.leaf(Leaf::Parameter { parameter: 0, component: 0 });
        let (kx, ky) = (graph.multiply(k, x), graph.multiply(k, y));
        let (left, right) = (graph.multiply(kx, y), graph.multiply(x, ky));
        assert_ne!(left, right);
        let sums = found(&mut graph, &[left, right]);
        assert_eq!(sums.first_alike(left), sums.first_alike(right));
    }

    #[test]
    fn a_sum_is_one_whatever_the_order_and_the_place_of_a_sign() {
        let mut graph = Graph::default();
        let [x, y] = [0, 1].map(|index| graph.leaf(Leaf::Given(index)));
        let [r, p, q] =
            [0, 1, 2].map(|parameter| graph.leaf(Leaf::Parameter { parameter, component: 0 }));
        let [less, more] = [(p, q), (q, p)].map(|(a, b)| graph.subtract(a, b));
        // r (p - q) x + q y, and q y - r ((q - p) x)
        let (by, inner) = (graph.multiply(r, less), graph.multiply(more, x));
        let (first, other) = (graph.multiply(by, x), graph.multiply(r, inner));
        let last = graph.multiply(q, y);
        let (sum, difference) = (graph.add(first, last), graph.subtract(last, other));
        assert_ne!(sum, difference);
        let sums = found(&mut graph, &[sum, difference]);
        assert_eq!(sums.first_alike(sum), sums.first_alike(difference));
    }
}
