//! From nodes to steps in an order of computation: which nodes are computed lane by lane, which of
//! them one instruction computes together, and when.
//!
//! Outputs come in groups; what a group needs is computed as late as possible, so few values wait
//! at a time and their memory stays in the nearest cache.

use indexmap::IndexMap;

use crate::engine::lanes::instruction::MOST_TOGETHER;
use crate::engine::lanes::sums::{Sum, Sums, sums};
use crate::graph::table::Table;
use crate::graph::{Binary, Graph, Leaf, Node, NodeId, Unary};

/// What one instruction computes.
#[derive(Clone, Copy, Debug)]
pub(super) enum Form {
    /// A node from its operands.
    Node(NodeId),
    /// A node that stands still, in all lanes.
    Fill(NodeId),
    /// A node as the sum of its terms, see [`super::sums`].
    Sum(NodeId),
    /// Sums of the same nodes, see [`Sum::map_of`]; at least two.
    Map([Option<NodeId>; MOST_TOGETHER]),
    /// Sine and cosine of one node.
    SinCos { angle: NodeId, sin: NodeId, cos: NodeId },
}

/// The steps for some groups of outputs.
#[derive(Clone, Debug, Default)]
pub(super) struct Schedule {
    /// What is computed, in order.
    pub(super) steps: Vec<Form>,
    /// For each group, the number of steps after which its outputs are there.
    pub(super) ends: Vec<usize>,
    /// What the nodes that are sums are sums of.
    pub(super) sums: Sums,
    /// The outputs by group; of two that are the same sum the first stands for both.
    pub(super) outputs: Vec<Vec<NodeId>>,
}

impl Schedule {
    /// The nodes that a step is made of.
    pub(super) fn operands(&self, graph: &Graph, form: Form) -> Vec<NodeId> {
        match form {
            Form::Node(node) => graph.node(node).operands().collect(),
            Form::Fill(_) => Vec::new(),
            // Those of a map are the same.
            Form::Sum(node) | Form::Map([Some(node), ..]) => {
                self.sums.get(node).iter().flat_map(|sum| sum.lanes()).collect()
            }
            Form::Map(_) => Vec::new(),
            Form::SinCos { angle, .. } => vec![angle],
        }
    }

    /// Whether a term stands still where a sum cannot take a number.
    pub(super) fn adds_what_stands_still(&self) -> bool {
        let adds = |sum: &Sum| {
            let mut terms = sum.terms.iter().enumerate();
            terms.any(|(n, term)| term.lanes == [None, None] && !sum.takes_number(n))
        };
        self.steps.iter().any(|form| match form {
            Form::Sum(node) => self.sums.get(*node).is_some_and(adds),
            _ => false,
        })
    }
}

/// Puts the steps for some groups of outputs in order.
pub(super) fn schedule(graph: &mut Graph, groups: &[Vec<NodeId>]) -> Schedule {
    let mut scheduler = Scheduler::new(graph, groups);
    // Which sums there are shows when all is in order; those of the same numbers are then computed
    // together.
    scheduler.order(groups);
    if scheduler.find_maps() {
        scheduler.order(groups);
    }
    scheduler.schedule
}

/// Whether a function of two numbers has an instruction for a second operand that stands still.
fn is_arithmetic(function: Binary) -> bool {
    matches!(function, Binary::Divide)
}

struct Scheduler<'a> {
    graph: &'a Graph,
    /// Sine and cosine of a node, where both are needed.
    pairs: Table<NodeId, (NodeId, NodeId)>,
    /// The sums that are computed with a sum.
    maps: Table<NodeId, [Option<NodeId>; MOST_TOGETHER]>,
    done: Vec<bool>,
    schedule: Schedule,
}

impl<'a> Scheduler<'a> {
    fn new(graph: &'a mut Graph, groups: &[Vec<NodeId>]) -> Self {
        let outputs: Vec<NodeId> = groups.iter().flatten().copied().collect();
        let mut uses = vec![0; graph.nodes().len()];
        outputs.iter().for_each(|output| uses[output.0 as usize] += 1);
        let needed = graph.needed_by(&outputs);
        let mut sines = Table::default();
        let mut cosines = Table::default();
        for &node in needed.iter().filter(|node| graph.is_moving(**node)) {
            graph.node(node).operands().for_each(|operand| uses[operand.0 as usize] += 1);
            match graph.node(node) {
                Node::Unary(Unary::Sin, angle) => sines.insert(angle, node),
                Node::Unary(Unary::Cos, angle) => cosines.insert(angle, node),
                _ => None,
            };
        }
        let pairs = sines
            .into_iter()
            .filter_map(|(angle, sin)| Some((angle, (sin, *cosines.get(&angle)?))))
            .collect();
        let sums = sums(graph, &needed, &uses);
        let done = vec![false; graph.nodes().len()];
        let schedule = Schedule { sums, ..Schedule::default() };
        Self { graph, pairs, maps: Table::default(), done, schedule }
    }

    /// Puts the steps of all outputs in order.
    fn order(&mut self, groups: &[Vec<NodeId>]) {
        let sums = std::mem::take(&mut self.schedule.sums);
        self.schedule = Schedule { sums, ..Schedule::default() };
        self.done.fill(false);
        for group in groups {
            let sums = &self.schedule.sums;
            let outputs: Vec<NodeId> = group.iter().map(|node| sums.first_alike(*node)).collect();
            for output in &outputs {
                if self.graph.is_moving(*output) {
                    self.compute(*output);
                } else {
                    self.fill(*output);
                }
            }
            self.schedule.outputs.push(outputs);
            self.schedule.ends.push(self.schedule.steps.len());
        }
    }

    /// Finds among the steps sums of the same numbers for one group of outputs; whether there are
    /// any.
    fn find_maps(&mut self) -> bool {
        let Schedule { steps, ends, sums, .. } = &self.schedule;
        let mut start = 0;
        for end in ends {
            let mut alike: IndexMap<_, Vec<NodeId>> = IndexMap::new();
            for form in &steps[start..*end] {
                if let Form::Sum(node) = form
                    && let Some(numbers) = sums.get(*node).and_then(Sum::map_of)
                {
                    alike.entry(numbers).or_default().push(*node);
                }
            }
            for nodes in alike.values().flat_map(|nodes| nodes.chunks(MOST_TOGETHER)) {
                let mut together = [None; MOST_TOGETHER];
                for (place, node) in together.iter_mut().zip(nodes) {
                    *place = Some(*node);
                }
                if nodes.len() > 1 {
                    self.maps.extend(nodes.iter().map(|node| (*node, together)));
                }
            }
            start = *end;
        }
        !self.maps.is_empty()
    }

    fn is_done(&self, node: NodeId) -> bool {
        self.done[node.0 as usize]
    }

    /// Schedules what a node needs, then the node. Iterative: a deep graph does not exhaust the
    /// stack.
    fn compute(&mut self, output: NodeId) {
        let mut waiting = vec![output];
        while let Some(&node) = waiting.last() {
            if self.is_done(node) || is_column(self.graph, node) {
                waiting.pop();
                continue;
            }
            let form = self.form(node);
            let before = waiting.len();
            let operands = self.schedule.operands(self.graph, form);
            // The last one pushed is computed first: the first operand.
            waiting.extend(operands.into_iter().rev().filter(|operand| {
                self.graph.is_moving(*operand)
                    && !self.is_done(*operand)
                    && !is_column(self.graph, *operand)
            }));
            if waiting.len() == before {
                waiting.pop();
                self.emit(form);
            }
        }
    }

    /// Puts a node that stands still into all lanes.
    fn fill(&mut self, node: NodeId) {
        if !self.is_done(node) {
            self.done[node.0 as usize] = true;
            self.schedule.steps.push(Form::Fill(node));
        }
    }

    fn emit(&mut self, form: Form) {
        if let Form::Node(node) = form
            && let Node::Binary(function, a, b) = self.graph.node(node)
            && !is_arithmetic(function)
        {
            for operand in [a, b].into_iter().filter(|operand| !self.graph.is_moving(*operand)) {
                self.fill(operand);
            }
        }
        for node in results(form).into_iter().flatten() {
            self.done[node.0 as usize] = true;
        }
        self.schedule.steps.push(form);
    }

    /// How a node is computed.
    fn form(&self, node: NodeId) -> Form {
        match self.graph.node(node) {
            Node::Unary(Unary::Sin | Unary::Cos, angle) => match self.pairs.get(&angle) {
                Some((sin, cos)) => Form::SinCos { angle, sin: *sin, cos: *cos },
                None => Form::Node(node),
            },
            _ => match self.maps.get(&node) {
                Some(together) => Form::Map(*together),
                None if self.schedule.sums.get(node).is_some() => Form::Sum(node),
                None => Form::Node(node),
            },
        }
    }
}

/// The nodes that a step computes.
pub(super) fn results(form: Form) -> [Option<NodeId>; MOST_TOGETHER] {
    match form {
        Form::Node(node) | Form::Fill(node) | Form::Sum(node) => [Some(node), None, None],
        Form::SinCos { sin, cos, .. } => [Some(sin), Some(cos), None],
        Form::Map(nodes) => nodes,
    }
}

/// Whether a leaf is a column that is there before the chunk is computed; a still input is read
/// like a signal, as it may be logged.
pub(super) fn is_column(graph: &Graph, node: NodeId) -> bool {
    match graph.node(node) {
        Node::Leaf(leaf) => !matches!(leaf, Leaf::Input(_)),
        _ => false,
    }
}
