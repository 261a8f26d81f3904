//! What an effect does, by the nodes that it makes: however its formulas are written.

use std::collections::BTreeSet;

use crate::graph::derivative::tangent;
use crate::graph::table::Table;
use crate::graph::{Assembly, Graph, Leaf, Node, NodeId};

/// The factor by which a random quantity shifts the moment of every reading, if it does nothing
/// else: 1 for `t + jitter`, -2 for `t - 2 * jitter`. `None` where it shifts some readings alone,
/// shifts them unequally, or enters a reading or a noise level in another way.
pub fn time_shift(assembly: &Assembly, random: u32) -> Option<f64> {
    let leaf = assembly.graph.find(Node::Leaf(Leaf::Random(random)))?;
    let mut graph = assembly.graph.clone();
    let seed = Table::from_iter([(leaf, graph.constant(1.0))]);
    let mut factor = None;
    for measurand in &assembly.measurands {
        let nodes = graph.needed_by(&[measurand.offset]);
        let slope = *tangent(&mut graph, &nodes, &seed).get(&measurand.offset)?;
        let own = graph.constant_value(slope)?;
        let outputs = measurand.value.nodes().iter().chain(&measurand.sigma_factor);
        let passes_by = outputs.copied().any(|output| {
            output != measurand.offset && reaches(&assembly.graph, output, leaf, measurand.offset)
        });
        if passes_by || factor.is_some_and(|known| known != own) {
            return None;
        }
        factor = Some(own);
    }
    factor
}

/// Whether a node is made of `end` on a way that does not lead through `gate`.
fn reaches(graph: &Graph, node: NodeId, end: NodeId, gate: NodeId) -> bool {
    let mut seen = BTreeSet::from([gate]);
    let mut waiting = vec![node];
    while let Some(next) = waiting.pop() {
        if next == end {
            return true;
        }
        if seen.insert(next) {
            waiting.extend(graph.node(next).operands());
        }
    }
    false
}

/// The moving inputs, by index, whose second or a higher derivative enters a reading.
pub fn accelerations(assembly: &Assembly) -> BTreeSet<u32> {
    let outputs = assembly.measurands.iter().flat_map(|measurand| measurand.value.nodes());
    let needed = assembly.graph.needed_by(&outputs.copied().collect::<Vec<_>>());
    let of = |node| match assembly.graph.node(node) {
        Node::Signal { input, order: 2.., .. } => Some(input),
        _ => None,
    };
    needed.into_iter().filter_map(of).collect()
}
