//! Derivatives as new nodes of the same graph: tangents along a direction, gradients of an output.
//!
//! *Forward*: where a direction moves some leaves, every node that hangs on them moves by
//! `Σ partial · change` of its operands; what does not hang on them is left out. This is the
//! definition. *Backward* (the adjoint sweep): the same sums in the opposite order, which costs no
//! more for many directions than for one; it stops where nodes no longer move from sample to sample,
//! and the forward tangents of those few, made once for all samples, finish the chain. Both are
//! expressions like any other: shared, folded, and evaluated by whatever evaluates the graph.

use crate::graph::node::{Leaf, NodeId};
use crate::graph::partials::change;
use crate::graph::table::Table;
use crate::graph::{Graph, Kind};

/// How the nodes move along one direction; those that do not move are absent.
pub type Tangent = Table<NodeId, NodeId>;

/// The nodes that direction `component` of a parameter's tangent space moves, with their
/// derivatives: a number or a vector by its component, a rotation `q turn(δ)` by `δ` at zero, which
/// is `½ q (0, e_k)`. The rotation's matrix is among them, by its own simpler rule.
pub fn seeds(graph: &mut Graph, parameter: u32, kind: Kind, component: usize) -> Tangent {
    let leaf =
        |graph: &mut Graph, component: u8| graph.leaf(Leaf::Parameter { parameter, component });
    match kind {
        Kind::Scalar | Kind::Vector => {
            let node = leaf(graph, component as u8);
            Table::from_iter([(node, graph.constant(1.0))])
        }
        Kind::Rotation => {
            let [w, x, y, z] = [0, 1, 2, 3].map(|c| leaf(graph, c));
            let half = |graph: &mut Graph, sign: f64, node| graph.scale(0.5 * sign, node);
            // (-v_k, w e_k + v × e_k) / 2
            let rows = match component {
                0 => [(-1.0, x), (1.0, w), (1.0, z), (-1.0, y)],
                1 => [(-1.0, y), (-1.0, z), (1.0, w), (1.0, x)],
                _ => [(-1.0, z), (1.0, y), (-1.0, x), (1.0, w)],
            };
            let moved: Tangent = [w, x, y, z]
                .into_iter()
                .zip(rows)
                .map(|(node, (sign, by))| (node, half(graph, sign, by)))
                .collect();
            moved.into_iter().chain(matrix_seeds(graph, [w, x, y, z], component)).collect()
        }
    }
}

/// How the matrix `R` of a rotation of length one moves: `R [e_k ×]`, which is `R` with two of its
/// columns exchanged, one of them negated, and nothing in the third.
fn matrix_seeds(graph: &mut Graph, q: [NodeId; 4], k: usize) -> Vec<(NodeId, NodeId)> {
    let zero = graph.constant(0.0);
    let (next, last) = ((k + 1) % 3, (k + 2) % 3);
    let mut seeds = Vec::with_capacity(9);
    for row in graph.matrix(q) {
        let negated = graph.negate(row[next]);
        seeds.extend([(row[k], zero), (row[next], row[last]), (row[last], negated)]);
    }
    seeds
}

/// How `nodes` (operands before users) move where the seeds do.
pub fn tangent(graph: &mut Graph, nodes: &[NodeId], seeds: &Tangent) -> Tangent {
    let zero = graph.constant(0.0);
    let mut moved = seeds.clone();
    for &node in nodes {
        if moved.contains_key(&node) {
            continue;
        }
        if let Some(rate) = change(graph, node, |operand| moved.get(&operand).copied())
            && rate != zero
        {
            moved.insert(node, rate);
        }
    }
    moved
}

/// Where an adjoint sweep ended, in its order; it may come to a node more than once.
pub type Ends = Vec<(NodeId, Arrival)>;

/// A node where a sweep ends is an operand: what its derivative by it multiplies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Arrival {
    /// The adjoint of the node whose operand it is.
    pub adjoint: NodeId,
    /// The derivative of that node by this one.
    pub slope: NodeId,
}

/// The adjoint sweep from `output`, which counts `weight` times.
///
/// `nodes` are all that the output needs (operands before users), `is_active` says which of them hang
/// on an unknown. The sweep ends at nodes for which `is_end` holds; the derivative of the output by
/// one of them is the sum of `adjoint · slope` over its arrivals.
pub fn adjoint(
    graph: &mut Graph,
    nodes: &[NodeId],
    output: NodeId,
    weight: NodeId,
    is_active: impl Fn(NodeId) -> bool,
    is_end: impl Fn(&Graph, NodeId) -> bool,
) -> Ends {
    let mut adjoints = Table::from_iter([(output, weight)]);
    let mut ends = Ends::new();
    let one = graph.constant(1.0);
    for &node in nodes.iter().rev() {
        let Some(adjoint) = adjoints.remove(&node) else { continue };
        if !is_active(node) {
            continue;
        }
        if is_end(graph, node) {
            ends.push((node, Arrival { adjoint, slope: one }));
            continue;
        }
        let mut operands: Vec<NodeId> = graph.node(node).operands().collect();
        operands.dedup();
        for operand in operands.into_iter().filter(|operand| is_active(*operand)) {
            let slope = change(graph, node, |which| (which == operand).then_some(one));
            let Some(slope) = slope else { continue };
            if is_end(graph, operand) {
                ends.push((operand, Arrival { adjoint, slope }));
                continue;
            }
            let share = graph.multiply(adjoint, slope);
            let sum = match adjoints.get(&operand) {
                Some(before) => graph.add(*before, share),
                None => share,
            };
            adjoints.insert(operand, sum);
        }
    }
    ends
}

/// The derivative along a direction from where a sweep ended: `Σ tangent · adjoint · slope`.
///
/// Where a node moves as another moving one is, but for the sign (the columns of a rotation's matrix
/// turn into each other), terms with the same slope are added first: such a sum is the adjoint of what
/// the other one multiplies, and mostly is there already. For `p = R v` with adjoint `g` this gives
/// `v × (Rᵀ g)` instead of a derivative by each of the nine numbers in `R`.
pub fn along(graph: &mut Graph, ends: &Ends, tangent: &Tangent) -> NodeId {
    let zero = graph.constant(0.0);
    let mut alone: Vec<(NodeId, NodeId)> = Vec::new();
    let mut turning: Vec<((NodeId, bool), NodeId)> = Vec::new();
    for (end, Arrival { adjoint, slope }) in ends {
        let Some(&moved) = tangent.get(end).filter(|moved| **moved != zero) else { continue };
        let opposite = graph.negate(moved);
        let signs = [(moved, false), (opposite, true)];
        match signs.into_iter().find(|(size, _)| tangent.contains_key(size)) {
            Some((size, negative)) => {
                let term = graph.multiply(*adjoint, size);
                add_to(graph, &mut turning, (*slope, negative), term);
            }
            None => {
                let term = graph.multiply(*adjoint, *slope);
                add_to(graph, &mut alone, moved, term);
            }
        }
    }
    let turning = turning
        .into_iter()
        .map(|((slope, negative), sum)| (if negative { graph.negate(slope) } else { slope }, sum));
    let pairs: Vec<_> = turning.chain(alone).collect();
    graph.sum_of_products(&pairs)
}

/// Adds to the sum of a key.
fn add_to<K: PartialEq>(graph: &mut Graph, sums: &mut Vec<(K, NodeId)>, key: K, term: NodeId) {
    match sums.iter_mut().find(|(other, _)| *other == key) {
        Some((_, sum)) => *sum = graph.add(*sum, term),
        None => sums.push((key, term)),
    }
}
