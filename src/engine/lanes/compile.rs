//! From steps to instructions: numbers that stand still apart, memory used again as soon as its
//! value has been used for the last time.

use crate::engine::lanes::added::is_fused;
use crate::engine::lanes::identities::rewritten;
use crate::engine::lanes::instruction::{
    Column, Instruction, Kind, MOST_TERMS, MOST_TOGETHER, Operand, Product, Slot, Still,
};
use crate::engine::lanes::schedule::{Form, Schedule, results, schedule};
use crate::engine::lanes::sums::Sum;
use crate::engine::pointwise::Program;
use crate::graph::table::Table;
use crate::graph::{Binary, Graph, Leaf, Node, NodeId};

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
    /// Of what its sums are made.
    pub(super) products: Vec<Product>,
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
    pub fn new(graph: &Graph, groups: &[Vec<NodeId>]) -> Self {
        let (mut graph, groups) = rewritten(graph, groups);
        let zero = graph.constant(0.0);
        let schedule = schedule(&mut graph, &groups);
        let mut compiler = Compiler {
            graph: &graph,
            zero,
            products: Vec::new(),
            columns: Table::default(),
            column_list: Vec::new(),
            stills: Table::default(),
            still_list: Vec::new(),
            slots: Table::default(),
            free: Vec::new(),
            count: 0,
        };
        let groups = &schedule.outputs;
        compiler.find_columns(&schedule, groups);
        let last = last_uses(compiler.graph, &schedule, groups);
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
                instructions.push(compiler.instruction(&schedule, schedule.steps[step]));
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
        let (products, columns) = (compiler.products, compiler.column_list);
        Self { instructions, products, groups: made, columns, slots: compiler.count, stills }
    }
}

/// For each value in a slot, the moment of its last use: steps and ends of groups count.
fn last_uses(graph: &Graph, schedule: &Schedule, groups: &[Vec<NodeId>]) -> Table<NodeId, usize> {
    let mut last = Table::default();
    let steps = &schedule.steps;
    let (mut moment, mut step) = (0, 0);
    for (group, end) in groups.iter().zip(&schedule.ends) {
        while step < *end {
            for node in schedule.operands(graph, steps[step]) {
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
    products: Vec<Product>,
    columns: Table<Column, Slot>,
    column_list: Vec<Column>,
    stills: Table<NodeId, Still>,
    still_list: Vec<NodeId>,
    /// Slots of the values that wait.
    slots: Table<NodeId, Slot>,
    free: Vec<Slot>,
    count: usize,
}

impl Compiler<'_> {
    /// Gives the first slots to what is read from the samples.
    fn find_columns(&mut self, schedule: &Schedule, groups: &[Vec<NodeId>]) {
        let steps = &schedule.steps;
        let inner = steps.iter().flat_map(|form| schedule.operands(self.graph, *form));
        let results = steps.iter().flat_map(|form| results(*form)).flatten();
        let outputs = groups.iter().flatten().copied();
        let nodes: Vec<NodeId> = inner.chain(results).chain(outputs).collect();
        if schedule.adds_what_stands_still() {
            self.column(Column::One);
        }
        for node in nodes {
            match self.graph.node(node) {
                Node::Leaf(Leaf::Input(input)) | Node::Signal { input, .. } => {
                    for order in 0..3 {
                        self.column(Column::Input(input, order));
                    }
                    self.column(Column::SignalTime);
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

    fn instruction(&mut self, schedule: &Schedule, form: Form) -> Instruction {
        match form {
            Form::Fill(node) => {
                let value = self.still(node);
                Instruction::Fill { value, out: self.place(node) }
            }
            Form::SinCos { angle, sin, cos } => {
                let a = self.lane(angle);
                Instruction::SinCos { a, sin: self.place(sin), cos: self.place(cos) }
            }
            Form::Map(nodes) => self.map(schedule, nodes),
            Form::Sum(node) => match schedule.sums.get(node) {
                Some(sum) => self.sum(node, sum),
                None => self.node(node),
            },
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

    fn sum(&mut self, node: NodeId, sum: &Sum) -> Instruction {
        let first = self.products.len() as u32;
        let kinds = self.kinds(sum);
        for (index, term) in sum.terms.iter().enumerate() {
            let factor = self.still(term.factor);
            let [a, b] = term.lanes;
            let a = match (a, kinds[index]) {
                (Some(a), _) => self.lane(a),
                // Nobody looks at it.
                (None, Kind::Number) => 0,
                (None, _) => self.column(Column::One),
            };
            self.products.push(Product { factor, a, b: b.map_or(a, |b| self.lane(b)) });
        }
        let (count, scale) = (sum.terms.len() as u8, sum.scale.map(|scale| self.lane(scale)));
        Instruction::Sum { first, count, kinds, scale, out: self.place(node) }
    }

    /// What the terms of a sum are computed as.
    fn kinds(&self, sum: &Sum) -> [Kind; MOST_TERMS] {
        let mut kinds = [Kind::default(); MOST_TERMS];
        let kinds_of_terms = &mut kinds[..sum.terms.len()];
        for (index, (kind, term)) in kinds_of_terms.iter_mut().zip(&sum.terms).enumerate() {
            *kind = match (term.lanes, self.graph.constant_value(term.factor)) {
                ([None, _], _) if sum.takes_number(index) => Kind::Number,
                ([_, None], _) => Kind::Single,
                (_, Some(1.0)) => Kind::Unit,
                (_, Some(-1.0)) => Kind::Minus,
                _ => Kind::Pair,
            };
        }
        // To multiply by one costs less than to read and write once more.
        if !is_fused(kinds_of_terms) {
            for kind in kinds_of_terms.iter_mut().filter(|kind| kind.has_unit_factor()) {
                *kind = Kind::Pair;
            }
        }
        kinds
    }

    /// Sums of the same numbers.
    fn map(&mut self, schedule: &Schedule, nodes: [Option<NodeId>; MOST_TOGETHER]) -> Instruction {
        let first = self.products.len() as u32;
        let (mut inputs, mut has_number) = (0, false);
        for sum in nodes.iter().flatten().filter_map(|node| schedule.sums.get(*node)) {
            for term in &sum.terms {
                let factor = self.still(term.factor);
                let a = term.lanes[0].map_or(0, |a| self.lane(a));
                self.products.push(Product { factor, a, b: a });
            }
            has_number = sum.terms.last().is_some_and(|term| term.lanes[0].is_none());
            inputs = (sum.terms.len() - usize::from(has_number)) as u8;
        }
        let mut outs = [0; MOST_TOGETHER];
        for (out, node) in outs.iter_mut().zip(nodes.iter().flatten()) {
            *out = self.place(*node);
        }
        let outputs = nodes.iter().flatten().count() as u8;
        Instruction::Map { first, inputs, has_number, outs, outputs }
    }

    fn signal(&mut self, node: NodeId, input: u32, order: u8, offset: NodeId) -> Instruction {
        let columns = [0, 1, 2].map(|order| self.column(Column::Input(input, order)));
        let time = self.column(Column::SignalTime);
        let offset = self.operand(offset);
        Instruction::Signal { input, order, offset, columns, time, out: self.place(node) }
    }

    fn binary(&mut self, node: NodeId, function: Binary, a: NodeId, b: NodeId) -> Instruction {
        if function != Binary::Divide {
            let (a, b) = (self.lane(a), self.lane(b));
            return Instruction::Binary { function, a, b, out: self.place(node) };
        }
        if self.graph.is_moving(a) {
            let (a, b) = (self.lane(a), self.lane(b));
            return Instruction::Divide { a, b, out: self.place(node) };
        }
        let (b, a) = (self.still(a), self.lane(b));
        Instruction::DivideInto { a, b, out: self.place(node) }
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
