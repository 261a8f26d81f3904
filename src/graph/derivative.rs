//! Derivatives as new nodes of the same graph: tangents along a direction, gradients of an output.
//!
//! *Forward*: where a direction moves some leaves, every node that hangs on them moves by
//! `Σ partial · change` of its operands; what does not hang on them is left out. This is the
//! definition. *Backward* (the adjoint sweep): the same sums in the opposite order, which costs no
//! more for many directions than for one; it stops where nodes no longer move from sample to
//! sample, and the forward tangents of those few, made once for all samples, finish the chain. Both
//! are expressions like any other: shared, folded, and evaluated by whatever evaluates the graph.

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

/// How `output` moves where the seeds do, if it moves; `nodes` are all that it needs, in their
/// order.
///
/// Where all of a direction goes through one node, as a delay goes through its signal, this is the
/// derivative by that node times how fast it moves: directions through one node share the rest, and
/// with them those that do what the node does (a turn about the axis of an angle).
pub fn slope(
    graph: &mut Graph,
    nodes: &[NodeId],
    output: NodeId,
    seeds: &Tangent,
) -> Option<NodeId> {
    let Some(neck) = neck(graph, nodes, seeds) else {
        return tangent(graph, nodes, seeds).get(&output).copied();
    };
    let rate = *tangent(graph, &nodes[..=neck], seeds).get(&nodes[neck])?;
    let one = graph.constant(1.0);
    let by_neck = Table::from_iter([(nodes[neck], one)]);
    let slope = *tangent(graph, nodes, &by_neck).get(&output)?;
    Some(graph.multiply(rate, slope))
}

/// Where among `nodes` is the first that moves from sample to sample and without which the seeds
/// move nothing after it.
fn neck(graph: &Graph, nodes: &[NodeId], seeds: &Tangent) -> Option<usize> {
    let mut last_use: Table<NodeId, usize> = seeds.keys().map(|seed| (*seed, 0)).collect();
    for (place, node) in nodes.iter().enumerate() {
        for operand in graph.node(*node).operands() {
            if let Some(last) = last_use.get_mut(&operand) {
                *last = place;
                last_use.entry(*node).or_insert(place);
            }
        }
    }
    let mut needed_until = 0;
    nodes.iter().enumerate().find_map(|(place, node)| {
        let last = last_use.get(node)?;
        let is_neck = needed_until <= place && graph.is_moving(*node);
        needed_until = needed_until.max(*last);
        is_neck.then_some(place)
    })
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
/// `nodes` are all that the output needs (operands before users), `is_active` says which of them
/// hang on an unknown. The sweep ends at nodes for which `is_end` holds; the derivative of the
/// output by one of them is the sum of `adjoint · slope` over its arrivals.
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
/// Where a node moves as another moving one is, but for the sign (the columns of a rotation's
/// matrix turn into each other), terms with the same slope are added first: such a sum is the
/// adjoint of what the other one multiplies, and mostly is there already. For `p = R v` with
/// adjoint `g` this gives `v × (Rᵀ g)` instead of a derivative by each of the nine numbers in `R`.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_goes_through_one_node_is_its_rate_times_the_derivative_by_it() {
        let mut graph = Graph::default();
        let [x, y] = [0, 1].map(|index| graph.leaf(Leaf::Given(index)));
        let [p, q] =
            [0, 1].map(|parameter| graph.leaf(Leaf::Parameter { parameter, component: 0 }));
        // z² y + q z with z = p x: along p through z; along q there is nothing but the sum.
        let z = graph.multiply(p, x);
        let square = graph.multiply(z, z);
        let terms = [(square, y), (q, z)];
        let output = graph.sum_of_products(&terms);
        let nodes = graph.needed_by(&[output]);
        let one = graph.constant(1.0);
        let seeded = |node| Table::from_iter([(node, one)]);
        let place = neck(&graph, &nodes, &seeded(p)).map(|place| nodes[place]);
        assert_eq!(place, Some(z));
        let by_z = tangent(&mut graph, &nodes, &seeded(z))[&output];
        let expected = graph.multiply(x, by_z);
        assert_eq!(slope(&mut graph, &nodes, output, &seeded(p)), Some(expected));
        assert_eq!(slope(&mut graph, &nodes, output, &seeded(q)), Some(z));
        let elsewhere = graph.leaf(Leaf::Given(2));
        assert_eq!(slope(&mut graph, &nodes, output, &seeded(elsewhere)), None);
    }
}
