//! Derivatives as new nodes of the same graph: tangents along a direction, gradients of an output.
//!
//! *Forward*: where a direction moves some leaves, every node that hangs on them moves by
//! `Σ partial · change` of its operands; what does not hang on them is left out. This is the
//! definition. *Backward* (the adjoint sweep): the same sums in the opposite order, which costs no
//! more for many directions than for one; it stops where nodes no longer move from sample to sample,
//! and the forward tangents of those few, made once for all samples, finish the chain. Both are
//! expressions like any other: shared, folded, and evaluated by whatever evaluates the graph.

use std::collections::{BTreeMap, HashMap};

use crate::graph::node::{Leaf, NodeId};
use crate::graph::partials::change;
use crate::graph::{Graph, Kind};

/// How the nodes move along one direction; those that do not move are absent.
pub type Tangent = HashMap<NodeId, NodeId>;

/// The nodes that direction `component` of a parameter's tangent space moves, with their
/// derivatives: a number or a vector by its component, a rotation `q turn(δ)` by `δ` at zero, which
/// is `½ q (0, e_k)`.
pub fn seeds(graph: &mut Graph, parameter: u32, kind: Kind, component: usize) -> Tangent {
    let leaf =
        |graph: &mut Graph, component: u8| graph.leaf(Leaf::Parameter { parameter, component });
    match kind {
        Kind::Scalar | Kind::Vector => {
            let node = leaf(graph, component as u8);
            HashMap::from([(node, graph.constant(1.0))])
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
            [w, x, y, z]
                .into_iter()
                .zip(rows)
                .map(|(node, (sign, by))| (node, half(graph, sign, by)))
                .collect()
        }
    }
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

/// The gradient of `Σ weight · output` over some outputs.
///
/// `nodes` are all that the outputs need (operands before users), `is_active` says which of them hang
/// on an unknown. The sweep ends at nodes for which `is_end` holds and returns their adjoints, in
/// order.
pub fn adjoint(
    graph: &mut Graph,
    nodes: &[NodeId],
    outputs: &[(NodeId, NodeId)],
    is_active: impl Fn(NodeId) -> bool,
    is_end: impl Fn(&Graph, NodeId) -> bool,
) -> BTreeMap<NodeId, NodeId> {
    let mut adjoints: HashMap<NodeId, NodeId> = HashMap::new();
    let mut ends = BTreeMap::new();
    for (output, weight) in outputs {
        accumulate(graph, &mut adjoints, *output, *weight);
    }
    for &node in nodes.iter().rev() {
        let Some(adjoint) = adjoints.remove(&node) else { continue };
        if !is_active(node) {
            continue;
        }
        if is_end(graph, node) {
            ends.insert(node, adjoint);
            continue;
        }
        let mut operands: Vec<NodeId> = graph.node(node).operands().collect();
        operands.dedup();
        for operand in operands.into_iter().filter(|operand| is_active(*operand)) {
            let one = graph.constant(1.0);
            let slope = change(graph, node, |which| (which == operand).then_some(one));
            if let Some(slope) = slope {
                let share = graph.multiply(adjoint, slope);
                accumulate(graph, &mut adjoints, operand, share);
            }
        }
    }
    ends
}

fn accumulate(
    graph: &mut Graph,
    adjoints: &mut HashMap<NodeId, NodeId>,
    node: NodeId,
    share: NodeId,
) {
    let sum = match adjoints.get(&node) {
        Some(before) => graph.add(*before, share),
        None => share,
    };
    adjoints.insert(node, sum);
}
