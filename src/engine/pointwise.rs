//! One sample at a time over any number type: the definition every faster engine must equal.
//!
//! Answers: the values of some nodes of a graph, for given leaves, over plain numbers or numbers
//! that carry derivatives. It does not know what the leaves stand for, nor about readings.

use crate::graph::table::Table;
use crate::graph::{Binary, Graph, Leaf, Node, NodeId, Unary};
use crate::number::Number;

/// Where a program's values from outside come from: one sample at one point of parameter space.
pub trait Leaves<N> {
    /// A parameter, a random, a still input, a clock or a reading; SI.
    fn leaf(&self, leaf: Leaf) -> N;

    /// The `order`-th time derivative of a moving input at `offset` seconds from the sample's
    /// reference time; SI. The derivatives of `offset` must flow into the result.
    fn signal(&self, input: u32, order: u8, offset: N) -> N;
}

/// One step; its result goes to the slot of its own number.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Step {
    Constant(f64),
    Leaf(Leaf),
    Signal { input: u32, order: u8, offset: u32 },
    Unary(Unary, u32),
    Binary(Binary, u32, u32),
}

/// The steps that compute some nodes of a graph, and nothing else.
#[derive(Clone, Debug)]
pub struct Program {
    steps: Vec<Step>,
    outputs: Vec<u32>,
}

impl Program {
    /// The program for these nodes of the graph, in their order; nodes they do not need are left
    /// out.
    pub fn new(graph: &Graph, outputs: &[NodeId]) -> Self {
        let needed = graph.needed_by(outputs);
        let slots: Table<NodeId, u32> =
            needed.iter().enumerate().map(|(slot, id)| (*id, slot as u32)).collect();
        let steps = needed
            .iter()
            .map(|id| match graph.node(*id) {
                Node::Constant(bits) => Step::Constant(f64::from_bits(bits)),
                Node::Leaf(leaf) => Step::Leaf(leaf),
                Node::Signal { input, order, offset } => {
                    Step::Signal { input, order, offset: slots[&offset] }
                }
                Node::Unary(function, a) => Step::Unary(function, slots[&a]),
                Node::Binary(function, a, b) => Step::Binary(function, slots[&a], slots[&b]),
            })
            .collect();
        Self { steps, outputs: outputs.iter().map(|id| slots[id]).collect() }
    }

    /// Number of values computed.
    pub fn outputs(&self) -> usize {
        self.outputs.len()
    }

    /// Number of steps.
    pub fn len(&self) -> usize {
        self.steps.len()
    }

    /// Whether there are no steps.
    pub fn is_empty(&self) -> bool {
        self.steps.is_empty()
    }

    /// The leaves it asks for, each once.
    pub fn leaves(&self) -> impl Iterator<Item = Leaf> {
        self.steps.iter().filter_map(|step| match step {
            Step::Leaf(leaf) => Some(*leaf),
            _ => None,
        })
    }

    /// The moving inputs it asks for, with the order of derivative; an input may come repeatedly
    /// (at several offsets).
    pub fn signals(&self) -> impl Iterator<Item = (u32, u8)> {
        self.steps.iter().filter_map(|step| match step {
            Step::Signal { input, order, .. } => Some((*input, *order)),
            _ => None,
        })
    }

    /// Runs all steps; the outputs, in the order given to [`Program::new`]. `workspace` is scratch:
    /// keep it between calls and nothing is allocated.
    pub fn evaluate<'a, N: Number>(
        &self,
        leaves: &impl Leaves<N>,
        workspace: &'a mut Vec<N>,
    ) -> &'a [N] {
        workspace.clear();
        workspace.reserve(self.steps.len() + self.outputs.len());
        for step in &self.steps {
            let value = match *step {
                Step::Constant(value) => N::constant(value),
                Step::Leaf(leaf) => leaves.leaf(leaf),
                Step::Signal { input, order, offset } => {
                    leaves.signal(input, order, workspace[offset as usize])
                }
                Step::Unary(function, a) => function.apply(workspace[a as usize]),
                Step::Binary(function, a, b) => {
                    function.apply(workspace[a as usize], workspace[b as usize])
                }
            };
            workspace.push(value);
        }
        for slot in &self.outputs {
            workspace.push(workspace[*slot as usize]);
        }
        &workspace[self.steps.len()..]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::Clock;
    use crate::number::{Dual, derivative, variable};

    /// One moving input: `sin` of time.
    struct Pendulum<N>(N);

    impl<N: Number> Leaves<N> for Pendulum<N> {
        fn leaf(&self, leaf: Leaf) -> N {
            if leaf == Leaf::Clock(Clock::Time) { self.0 } else { N::constant(0.25) }
        }
        fn signal(&self, _: u32, order: u8, offset: N) -> N {
            (self.0 + offset + f64::from(order) * std::f64::consts::FRAC_PI_2).sin()
        }
    }

    #[test]
    fn values_and_derivatives_reach_the_outputs_and_unneeded_nodes_are_left_out() {
        let mut graph = Graph::default();
        let time = graph.leaf(Leaf::Clock(Clock::Time));
        let delay = graph.leaf(Leaf::Parameter { parameter: 0, component: 0 });
        let signal = graph.signal(0, 0, delay);
        let square = graph.multiply(signal, signal);
        let unneeded = graph.unary(Unary::Exp, square);
        let program = Program::new(&graph, &[square, time]);
        assert_eq!(program.outputs(), 2);
        assert_eq!(program.len(), graph.needed_by(&[unneeded]).len());
        let mut workspace = Vec::new();
        let out = program.evaluate(&Pendulum(variable(0.5)), &mut workspace);
        let x: Dual = variable(0.75);
        let expected = Number::powi(Number::sin(x), 2);
        assert!((out[0].value() - expected.value()).abs() < 1e-15);
        assert!((derivative(out[0]) - derivative(expected)).abs() < 1e-15);
        assert_eq!((out[1].value(), derivative(out[1])), (0.5, 1.0));
        assert_eq!(program.signals().collect::<Vec<_>>(), [(0, 0)]);
        assert_eq!(program.leaves().count(), 2);
    }
}
