//! What an effect does, by the nodes that it makes: however its formulas are written.

use std::collections::BTreeSet;

use crate::graph::{Assembly, Node};

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
