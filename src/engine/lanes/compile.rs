//! From steps to instructions: numbers that stand still apart, memory used again as soon as its
//! value has been used for the last time.

use std::collections::HashMap;

use crate::engine::lanes::instruction::{Column, Instruction, Operand, Slot, Still};
use crate::engine::lanes::schedule::{Form, operands, results, schedule};
use crate::engine::pointwise::Program;
use crate::graph::{Binary, Clock, Graph, Leaf, Node, NodeId};

/// Outputs that are there at the same time.
#[derive(Clone, Debug)]
pub(super) struct Group {
    /// Number of instructions after which they are there.
    pub(super) end: usize,
    /// Where each is.
    pub(super) outputs: Vec<Slot>,
}

/// A graph's outputs as a program over chunks of samples.
#[derive(Clone, Debug)]
pub struct Code {
    /// What to compute, group after group.
    pub(super) instructions: Vec<Instruction>,
    /// The outputs.
    pub(super) groups: Vec<Group>,
    /// What the first slots hold.
    pub(super) columns: Vec<Column>,
    /// Number of slots.
    pub(super) slots: usize,
    /// What is computed once for all samples of a run.
    pub(super) stills: Program,
}

impl Code {
    /// Number of groups.
    pub fn group_count(&self) -> usize {
        self.groups.len()
    }

    /// Compiles groups of outputs. Those of a group are valid until the next group is computed.
    pub fn new(graph: &mut Graph, groups: &[Vec<NodeId>]) -> Self {
        let zero = graph.constant(0.0);
        let schedule = schedule(graph, groups);
        let mut compiler = Compiler {
            graph,
            zero,
            columns: HashMap::new(),
            column_list: Vec::new(),
            stills: HashMap::new(),
            still_list: Vec::new(),
            slots: HashMap::new(),
            free: Vec::new(),
            count: 0,
        };
        compiler.find_columns(&schedule.steps, groups);
        let last = last_uses(graph, &schedule.steps, &schedule.ends, groups);
        let mut ending: Vec<Vec<NodeId>> =
            vec![Vec::new(); schedule.steps.len() + groups.len() + 1];
        for (node, moment) in &last {
            ending[*moment].push(*node);
        }
        ending.iter_mut().for_each(|nodes| nodes.sort_unstable());
        let mut instructions = Vec::with_capacity(schedule.steps.len());
        let mut made = Vec::with_capacity(groups.len());
        let (mut moment, mut step) = (0, 0);
        for (group, end) in groups.iter().zip(&schedule.ends) {
            while step < *end {
                instructions.push(compiler.instruction(schedule.steps[step]));
                compiler.release(&ending[moment]);
                step += 1;
                moment += 1;
            }
            let outputs = group.iter().map(|node| compiler.lane(*node)).collect();
            made.push(Group { end: instructions.len(), outputs });
            compiler.release(&ending[moment]);
            moment += 1;
        }
        let stills = Program::new(compiler.graph, &compiler.still_list);
        let (columns, slots) = (compiler.column_list, compiler.count);
        Self { instructions, groups: made, columns, slots, stills }
    }
}

/// For each value in a slot, the moment of its last use: steps and ends of groups count.
fn last_uses(
    graph: &Graph,
    steps: &[Form],
    ends: &[usize],
    groups: &[Vec<NodeId>],
) -> HashMap<NodeId, usize> {
    let mut last = HashMap::new();
    let (mut moment, mut step) = (0, 0);
    for (group, end) in groups.iter().zip(ends) {
        while step < *end {
            for node in operands(graph, steps[step]) {
                last.insert(node, moment);
            }
            // A value that nobody uses (the unwanted half of a pair) ends at once.
            for node in results(steps[step]).into_iter().flatten() {
                last.insert(node, moment);
            }
            step += 1;
            moment += 1;
        }
        for node in group {
            last.insert(*node, moment);
        }
        moment += 1;
    }
    last
}

struct Compiler<'a> {
    graph: &'a Graph,
    zero: NodeId,
    columns: HashMap<Column, Slot>,
    column_list: Vec<Column>,
    stills: HashMap<NodeId, Still>,
    still_list: Vec<NodeId>,
    /// Slots of the values that wait.
    slots: HashMap<NodeId, Slot>,
    free: Vec<Slot>,
    count: usize,
}

impl Compiler<'_> {
    /// Gives the first slots to what is read from the samples.
    fn find_columns(&mut self, steps: &[Form], groups: &[Vec<NodeId>]) {
        let inner = steps.iter().flat_map(|form| operands(self.graph, *form));
        let results = steps.iter().flat_map(|form| results(*form)).flatten();
        let outputs = groups.iter().flatten().copied();
        let nodes: Vec<NodeId> = inner.chain(results).chain(outputs).collect();
        for node in nodes {
            match self.graph.node(node) {
                Node::Leaf(Leaf::Input(input)) | Node::Signal { input, .. } => {
                    for order in 0..3 {
                        self.column(Column::Input(input, order));
                    }
                    self.column(Column::Clock(Clock::Time));
                }
                Node::Leaf(leaf) => {
                    column_of(leaf).map(|column| self.column(column));
                }
                _ => {}
            }
        }
    }

    fn column(&mut self, column: Column) -> Slot {
        let next = self.column_list.len();
        *self.columns.entry(column).or_insert_with(|| {
            self.column_list.push(column);
            self.count = self.count.max(next + 1);
            next as Slot
        })
    }

    fn release(&mut self, nodes: &[NodeId]) {
        for node in nodes {
            self.free.extend(self.slots.remove(node));
        }
    }

    /// A slot for a new value.
    fn place(&mut self, node: NodeId) -> Slot {
        let slot = match self.free.pop() {
            Some(slot) => slot,
            None => {
                self.count += 1;
                self.count as Slot - 1
            }
        };
        self.slots.insert(node, slot);
        slot
    }

    fn operand(&mut self, node: NodeId) -> Operand {
        if let Some(slot) = self.slots.get(&node) {
            return Operand::Lane(*slot);
        }
        if self.graph.is_moving(node) {
            return Operand::Lane(self.lane(node));
        }
        Operand::Still(self.still(node))
    }

    fn still(&mut self, node: NodeId) -> Still {
        if let Some(still) = self.stills.get(&node) {
            return *still;
        }
        let still = self.still_list.len() as Still;
        self.still_list.push(node);
        self.stills.insert(node, still);
        still
    }

    /// The slot of a node that moves, or was filled.
    fn lane(&self, node: NodeId) -> Slot {
        if let Some(slot) = self.slots.get(&node) {
            return *slot;
        }
        match self.graph.node(node) {
            Node::Leaf(leaf) => {
                column_of(leaf).and_then(|column| self.columns.get(&column).copied())
            }
            _ => None,
        }
        .unwrap_or(0)
    }

    fn instruction(&mut self, form: Form) -> Instruction {
        match form {
            Form::Fill(node) => {
                let value = self.still(node);
                Instruction::Fill { value, out: self.place(node) }
            }
            Form::SinCos { angle, sin, cos } => {
                let a = self.lane(angle);
                Instruction::SinCos { a, sin: self.place(sin), cos: self.place(cos) }
            }
            Form::MultiplyAdd { node, sign, factors: [a, b], addend } => {
                let (a, b, c) = (self.lane(a), self.operand(b), self.operand(addend));
                Instruction::MultiplyAdd { sign, a, b, c, out: self.place(node) }
            }
            Form::Node(node) => self.node(node),
        }
    }

    fn node(&mut self, node: NodeId) -> Instruction {
        match self.graph.node(node) {
            Node::Leaf(Leaf::Input(input)) => self.signal(node, input, 0, self.zero),
            Node::Signal { input, order, offset } => self.signal(node, input, order, offset),
            Node::Unary(function, a) => {
                let a = self.lane(a);
                Instruction::Unary { function, a, out: self.place(node) }
            }
            Node::Binary(function, a, b) => self.binary(node, function, a, b),
            // Columns and numbers are there already.
            Node::Constant(_) | Node::Leaf(_) => {
                let value = self.still(self.zero);
                Instruction::Fill { value, out: self.place(node) }
            }
        }
    }

    fn signal(&mut self, node: NodeId, input: u32, order: u8, offset: NodeId) -> Instruction {
        let columns = [0, 1, 2].map(|order| self.column(Column::Input(input, order)));
        let time = self.column(Column::Clock(Clock::Time));
        let offset = self.operand(offset);
        Instruction::Signal { input, order, offset, columns, time, out: self.place(node) }
    }

    fn binary(&mut self, node: NodeId, function: Binary, a: NodeId, b: NodeId) -> Instruction {
        let (a, b) = match function {
            Binary::Add | Binary::Multiply if !self.graph.is_moving(a) => (b, a),
            _ => (a, b),
        };
        if !self.graph.is_moving(a) && matches!(function, Binary::Subtract | Binary::Divide) {
            let (b, a) = (self.still(a), self.lane(b));
            let out = self.place(node);
            return if function == Binary::Subtract {
                Instruction::SubtractFrom { a, b, out }
            } else {
                Instruction::DivideInto { a, b, out }
            };
        }
        let left = self.lane(a);
        match function {
            Binary::Add => {
                let b = self.operand(b);
                Instruction::Add { a: left, b, out: self.place(node) }
            }
            Binary::Subtract => {
                let b = self.operand(b);
                Instruction::Subtract { a: left, b, out: self.place(node) }
            }
            Binary::Multiply => {
                let b = self.operand(b);
                Instruction::Multiply { a: left, b, out: self.place(node) }
            }
            Binary::Divide => {
                let b = self.operand(b);
                Instruction::Divide { a: left, b, out: self.place(node) }
            }
            _ => {
                let b = self.lane(b);
                Instruction::Binary { function, a: left, b, out: self.place(node) }
            }
        }
    }
}

/// The column of a leaf that is read before the chunk is computed.
fn column_of(leaf: Leaf) -> Option<Column> {
    match leaf {
        Leaf::Clock(clock) => Some(Column::Clock(clock)),
        Leaf::Reading { measurand, component } => Some(Column::Reading(measurand, component)),
        Leaf::Given(index) => Some(Column::Given(index)),
        Leaf::Parameter { .. } | Leaf::Random(_) | Leaf::Input(_) => None,
    }
}
