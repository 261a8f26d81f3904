//! The residuals of one sample and their derivatives, as nodes: what the lanes compute of a model.
//!
//! A *row* is one residual component: `reading - prediction`, brought into one period for an angle;
//! for a rotation the three components of the rotation vector from predicted to read. Derivatives
//! are those of the prediction (the residual's with the opposite sign), along *tangents*: the
//! components of the parameters' tangent spaces. Random quantities stand at their mean, zero; the
//! derivatives with respect to them are the sensitivities that make a sample's covariance.

use std::ops::Range;

use crate::graph::derivative::{Tangent, adjoint, along, seeds, slope, tangent};
use crate::graph::import::Import;
use crate::graph::table::Set;
use crate::graph::{Assembly, Graph, Leaf, MeasurandKind, NodeId, Unary, Value};

/// Which sweep makes the derivatives. They agree to rounding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Sweep {
    /// Tangents along every direction: the definition.
    Forward,
    /// Adjoints: cheaper for many directions.
    Backward,
}

/// A direction in parameter space: a parameter (by index) and a component of its tangent space.
pub type Direction = (usize, usize);

/// The residual components of a model as nodes, in the order of its measurands.
#[derive(Clone, Debug)]
pub struct Rows {
    /// The nodes.
    pub graph: Graph,
    /// One node for each residual component.
    pub residuals: Vec<NodeId>,
}

/// One row with its derivatives.
#[derive(Clone, Debug, Default)]
pub struct Derivatives {
    /// Which directions it hangs on, by index.
    pub directions: Vec<usize>,
    /// The derivative of the prediction along each of them.
    pub nodes: Vec<NodeId>,
}

impl Rows {
    /// The rows of a model.
    pub fn new(assembly: &Assembly) -> Self {
        Self::some(assembly, 0..assembly.names.measurands.len())
    }

    /// The rows of one measurand.
    pub fn of(assembly: &Assembly, measurand: usize) -> Self {
        Self::some(assembly, measurand..measurand + 1)
    }

    fn some(assembly: &Assembly, measurands: Range<usize>) -> Self {
        let mut rows = Self { graph: Graph::boundless(), residuals: Vec::new() };
        let mut import = Import::default();
        for index in measurands {
            let mut leaf = |graph: &mut Graph, leaf| graph.leaf(leaf);
            let value = &assembly.measurands[index].value;
            let nodes: Vec<NodeId> = value
                .nodes()
                .iter()
                .map(|node| import.node(&assembly.graph, *node, &mut rows.graph, &mut leaf))
                .collect();
            rows.add(index as u32, assembly.names.measurands[index].kind, value, &nodes);
        }
        rows
    }

    fn add(&mut self, measurand: u32, kind: MeasurandKind, value: &Value, predicted: &[NodeId]) {
        let graph = &mut self.graph;
        let read =
            |graph: &mut Graph, component| graph.leaf(Leaf::Reading { measurand, component });
        if let (MeasurandKind::Rotation, [w, x, y, z]) = (kind, predicted) {
            let inverse = graph.inverse([*w, *x, *y, *z]);
            let reading = [0, 1, 2, 3].map(|component| read(graph, component));
            let difference = graph.compose(inverse, reading);
            self.residuals.extend(graph.rotation_vector(difference));
            return;
        }
        for (component, node) in (0..).zip(predicted.iter().take(value.nodes().len())) {
            let reading = read(graph, component);
            let difference = graph.subtract(reading, *node);
            let wrapped = match kind {
                MeasurandKind::Angle { period } if period > 0.0 => {
                    wrapped(graph, difference, period)
                }
                _ => difference,
            };
            self.residuals.push(wrapped);
        }
    }

    /// The same rows with every random quantity at its mean.
    pub fn at_mean(&self) -> Self {
        let mut rows = Self { graph: Graph::boundless(), residuals: Vec::new() };
        let mut import = Import::default();
        rows.residuals = self
            .residuals
            .iter()
            .map(|node| import.node(&self.graph, *node, &mut rows.graph, &mut mean))
            .collect();
        rows
    }

    /// The derivatives of some rows along some directions. `weights` are nodes, one a row, by which
    /// its derivatives are multiplied.
    pub fn derivatives(
        &mut self,
        directions: &[Tangent],
        weights: &[NodeId],
        sweep: Sweep,
    ) -> Vec<Derivatives> {
        match sweep {
            Sweep::Forward => self.forward(directions, weights),
            Sweep::Backward => self.backward(directions, weights),
        }
    }

    /// The nodes that move each parameter along its directions.
    pub fn seeds(&mut self, assembly: &Assembly, directions: &[Direction]) -> Vec<Tangent> {
        directions
            .iter()
            .map(|(parameter, component)| {
                let kind = assembly.names.parameters[*parameter].kind;
                seeds(&mut self.graph, *parameter as u32, kind, *component)
            })
            .collect()
    }

    fn forward(&mut self, directions: &[Tangent], weights: &[NodeId]) -> Vec<Derivatives> {
        let mut made = vec![Derivatives::default(); self.residuals.len()];
        for ((row, residual), weight) in made.iter_mut().zip(&self.residuals).zip(weights) {
            let needed = self.graph.needed_by(&[*residual]);
            for (index, seeds) in directions.iter().enumerate() {
                if let Some(slope) = slope(&mut self.graph, &needed, *residual, seeds) {
                    let prediction = self.graph.negate(slope);
                    row.directions.push(index);
                    row.nodes.push(self.graph.multiply(*weight, prediction));
                }
            }
        }
        made
    }

    fn backward(&mut self, directions: &[Tangent], weights: &[NodeId]) -> Vec<Derivatives> {
        let residuals = self.residuals.clone();
        let graph = &mut self.graph;
        let all = graph.needed_by(&residuals);
        // Where nodes stand still, tangents are made once for all samples.
        let still: Vec<NodeId> =
            all.iter().copied().filter(|node| !graph.is_moving(*node)).collect();
        let tangents: Vec<Tangent> =
            directions.iter().map(|seeds| tangent(graph, &still, seeds)).collect();
        let mut active: Set<NodeId> =
            tangents.iter().flat_map(|tangent| tangent.keys().copied()).collect();
        for node in &all {
            if graph.node(*node).operands().any(|operand| active.contains(&operand)) {
                active.insert(*node);
            }
        }
        let zero = graph.constant(0.0);
        let mut made = Vec::with_capacity(residuals.len());
        for (residual, weight) in residuals.iter().zip(weights) {
            let needed = graph.needed_by(&[*residual]);
            let root = graph.negate(*weight);
            let ends = adjoint(
                graph,
                &needed,
                *residual,
                root,
                |node| active.contains(&node),
                |graph, node| !graph.is_moving(node),
            );
            let mut row = Derivatives::default();
            for (index, tangent) in tangents.iter().enumerate() {
                let sum = along(graph, &ends, tangent);
                if sum != zero {
                    row.directions.push(index);
                    row.nodes.push(sum);
                }
            }
            made.push(row);
        }
        made
    }
}

/// Random quantities at their mean, other leaves as they are.
fn mean(graph: &mut Graph, leaf: Leaf) -> NodeId {
    match leaf {
        Leaf::Random(_) => graph.constant(0.0),
        other => graph.leaf(other),
    }
}

/// `difference - period · round(difference / period)`
fn wrapped(graph: &mut Graph, difference: NodeId, period: f64) -> NodeId {
    let (length, half) = (graph.constant(period), graph.constant(0.5));
    let turns = graph.divide(difference, length);
    let turns = graph.add(turns, half);
    let turns = graph.unary(Unary::Floor, turns);
    let whole = graph.multiply(turns, length);
    graph.subtract(difference, whole)
}
