//! The lane programs of one campaign's model: residuals, rows with derivatives, sensitivities to
//! random quantities.
//!
//! Each is compiled when it is first wanted. Every residual is multiplied by a weight that the
//! caller gives for its measurand (value [`Leaf::Given`] of that index), and so are its
//! derivatives.

use std::ops::Range;
use std::sync::OnceLock;

use crate::engine::lanes::Code;
use crate::engine::rows::{Derivatives, Direction, Rows, Sweep};
use crate::graph::derivative::Tangent;
use crate::graph::import::Import;
use crate::graph::table::Table;
use crate::graph::{Assembly, Graph, Leaf, NodeId};
use crate::model::Process;
use crate::system::System;

/// The programs of one campaign's model.
#[derive(Debug)]
pub struct Programs {
    directions: Vec<Direction>,
    sweep: Sweep,
    residuals: OnceLock<RowsProgram>,
    rows: OnceLock<RowsProgram>,
    noise: OnceLock<NoiseProgram>,
    delays: Vec<OnceLock<DelayProgram>>,
}

/// Weighted residuals with their derivatives.
#[derive(Clone, Debug)]
pub struct RowsProgram {
    /// One group for each measurand. Of each row the residual comes first.
    pub code: Code,
    /// One for each residual component.
    pub rows: Vec<RowOutputs>,
}

/// Where one row is among the outputs.
#[derive(Clone, Debug)]
pub struct RowOutputs {
    /// Its group.
    pub group: usize,
    /// The residual among the group's outputs; the derivatives follow.
    pub first: usize,
    /// The directions of the derivatives, by index.
    pub directions: Vec<usize>,
}

/// One reading as a function of its delay, value [`Leaf::Given`] number 0, in three groups.
#[derive(Clone, Debug)]
pub struct DelayProgram {
    /// Group 0: `prediction - reading` and its derivative by the delay. Group 1: what makes the
    /// reading's own uncertainty. Group 2: the derivatives of the prediction.
    pub code: Code,
    /// In group 1: the factor on the standard uncertainty.
    pub factor: Option<usize>,
    /// In group 1: random quantity, and the output that is the prediction's derivative.
    pub sensitivities: Vec<(usize, usize)>,
    /// In group 2: the directions of the derivatives, by index.
    pub directions: Vec<usize>,
}

impl RowOutputs {
    /// Its outputs: the residual, then the derivatives.
    pub fn outputs(&self) -> Range<usize> {
        self.first..self.first + 1 + self.directions.len()
    }
}

/// What makes the covariance of a sample's readings.
#[derive(Clone, Debug)]
pub struct NoiseProgram {
    /// A single group.
    pub code: Code,
    /// For each measurand the output that is the factor on its standard uncertainty.
    pub factors: Vec<Option<usize>>,
    /// Row, random quantity, and the output that is the prediction's derivative.
    pub sensitivities: Vec<(usize, usize, usize)>,
}

impl Programs {
    /// For derivatives along these directions, by a sweep; of a model with so many measurands.
    pub fn new(directions: Vec<Direction>, sweep: Sweep, measurands: usize) -> Self {
        Self {
            directions,
            sweep,
            residuals: OnceLock::new(),
            rows: OnceLock::new(),
            noise: OnceLock::new(),
            delays: (0..measurands).map(|_| OnceLock::new()).collect(),
        }
    }

    /// The directions of the derivatives.
    pub fn directions(&self) -> &[Direction] {
        &self.directions
    }

    /// The weighted residuals alone.
    pub fn residuals(&self, assembly: &Assembly) -> &RowsProgram {
        self.residuals.get_or_init(|| RowsProgram::nodes(assembly, &[], self.sweep).compile())
    }

    /// The weighted residuals with their derivatives.
    pub fn rows(&self, assembly: &Assembly) -> &RowsProgram {
        self.rows
            .get_or_init(|| RowsProgram::nodes(assembly, &self.directions, self.sweep).compile())
    }

    /// A reading of a measurand as a function of its delay.
    pub fn delay(&self, system: &System, measurand: usize) -> &DelayProgram {
        self.delays[measurand]
            .get_or_init(|| DelayProgram::new(system, &self.directions, measurand))
    }

    /// Sensitivities to what is random from sample to sample.
    pub fn noise(&self, system: &System) -> &NoiseProgram {
        self.noise.get_or_init(|| NoiseProgram::new(system))
    }
}

impl DelayProgram {
    /// Of a measurand with one component.
    fn new(system: &System, directions: &[Direction], measurand: usize) -> Self {
        let assembly = &system.assembly;
        let mut rows = Rows::of(assembly, measurand);
        let own = assembly.names.measurands[measurand].delay;
        let delay = rows.graph.leaf(Leaf::Parameter { parameter: own as u32, component: 0 });
        let one = rows.graph.constant(1.0);
        let white = white(system);
        let mut seeds = vec![Table::from_iter([(delay, one)])];
        seeds.extend(random_seeds(&mut rows.graph, &white));
        let others: Vec<Direction> =
            directions.iter().copied().filter(|(parameter, _)| *parameter != own).collect();
        seeds.extend(rows.seeds(assembly, &others));
        let made = rows.derivatives(&seeds, &[one], Sweep::Forward).pop().unwrap_or_default();
        let mut graph = Graph::boundless();
        let mut leaf = |graph: &mut Graph, leaf| match leaf {
            Leaf::Random(_) => graph.constant(0.0),
            Leaf::Parameter { parameter, .. } if parameter as usize == own => {
                graph.leaf(Leaf::Given(0))
            }
            other => graph.leaf(other),
        };
        let mut import = Import::default();
        let residual = import.node(&rows.graph, rows.residuals[0], &mut graph, &mut leaf);
        let zero = graph.constant(0.0);
        let mut groups = vec![vec![graph.negate(residual), zero], Vec::new(), Vec::new()];
        let (mut sensitivities, mut kept) = (Vec::new(), Vec::new());
        for (seed, node) in made.directions.iter().zip(&made.nodes) {
            let node = import.node(&rows.graph, *node, &mut graph, &mut leaf);
            if *seed == 0 {
                groups[0][1] = node;
            } else if let Some(random) = white.get(seed - 1) {
                sensitivities.push((*random, groups[1].len()));
                groups[1].push(node);
            } else {
                let direction = others[seed - 1 - white.len()];
                kept.extend(directions.iter().position(|other| *other == direction));
                groups[2].push(node);
            }
        }
        let factor = assembly.measurands[measurand].sigma_factor.map(|node| {
            groups[1].push(Import::default().node(&assembly.graph, node, &mut graph, &mut leaf));
            groups[1].len() - 1
        });
        Self { code: Code::new(&graph, &groups), factor, sensitivities, directions: kept }
    }
}

/// Rows with derivatives as nodes, before they are compiled.
#[derive(Clone, Debug)]
pub struct RowNodes {
    /// The nodes.
    pub graph: Graph,
    /// The weighted residual of each row.
    pub residuals: Vec<NodeId>,
    /// The weighted derivatives of each row.
    pub derivatives: Vec<Derivatives>,
    /// The measurand of each row.
    pub measurands: Vec<usize>,
}

impl RowsProgram {
    /// The rows of a group, with their numbers.
    pub fn rows_of(&self, group: usize) -> impl Iterator<Item = (usize, &RowOutputs)> {
        self.rows.iter().enumerate().filter(move |(_, row)| row.group == group)
    }

    /// Rows with derivatives along some directions, before they are compiled.
    pub fn nodes(assembly: &Assembly, directions: &[Direction], sweep: Sweep) -> RowNodes {
        let mut rows = Rows::new(assembly).at_mean();
        let (weights, measurands) = weights(&mut rows.graph, assembly);
        let seeds = rows.seeds(assembly, directions);
        let derivatives = rows.derivatives(&seeds, &weights, sweep);
        let residuals = weighted(&mut rows, &weights);
        RowNodes { graph: rows.graph, residuals, derivatives, measurands }
    }
}

impl RowNodes {
    /// A program for these rows.
    pub fn compile(self) -> RowsProgram {
        let mut groups: Vec<Vec<NodeId>> = Vec::new();
        let mut rows = Vec::with_capacity(self.residuals.len());
        for (index, (residual, row)) in self.residuals.iter().zip(self.derivatives).enumerate() {
            let group = self.measurands[index];
            groups.resize(groups.len().max(group + 1), Vec::new());
            let first = groups[group].len();
            groups[group].push(*residual);
            groups[group].extend_from_slice(&row.nodes);
            rows.push(RowOutputs { group, first, directions: row.directions });
        }
        RowsProgram { code: Code::new(&self.graph, &groups), rows }
    }
}

impl NoiseProgram {
    fn new(system: &System) -> Self {
        let assembly = &system.assembly;
        let mut rows = Rows::new(assembly);
        let one = rows.graph.constant(1.0);
        let ones = vec![one; rows.residuals.len()];
        let white = white(system);
        let seeds = random_seeds(&mut rows.graph, &white);
        let derivatives = rows.derivatives(&seeds, &ones, Sweep::Forward);
        let mut graph = Graph::boundless();
        let mut mean = |graph: &mut Graph, leaf| match leaf {
            Leaf::Random(_) => graph.constant(0.0),
            other => graph.leaf(other),
        };
        let mut outputs = Vec::new();
        let mut import = Import::default();
        let factors = assembly
            .measurands
            .iter()
            .map(|measurand| {
                let factor = measurand.sigma_factor?;
                outputs.push(import.node(&assembly.graph, factor, &mut graph, &mut mean));
                Some(outputs.len() - 1)
            })
            .collect();
        let mut import = Import::default();
        let mut sensitivities = Vec::new();
        for (row, made) in derivatives.iter().enumerate() {
            for (direction, node) in made.directions.iter().zip(&made.nodes) {
                sensitivities.push((row, white[*direction], outputs.len()));
                outputs.push(import.node(&rows.graph, *node, &mut graph, &mut mean));
            }
        }
        Self { code: Code::new(&graph, &[outputs]), factors, sensitivities }
    }
}

/// The random quantities that are independent from sample to sample.
fn white(system: &System) -> Vec<usize> {
    (0..system.randoms.len())
        .filter(|random| system.randoms[*random].process == Process::White)
        .collect()
}

fn random_seeds(graph: &mut Graph, randoms: &[usize]) -> Vec<Tangent> {
    let one = graph.constant(1.0);
    randoms
        .iter()
        .map(|random| Table::from_iter([(graph.leaf(Leaf::Random(*random as u32)), one)]))
        .collect()
}

/// The weight of each row as a node, and its measurand.
pub(super) fn weights(graph: &mut Graph, assembly: &Assembly) -> (Vec<NodeId>, Vec<usize>) {
    let mut weights = Vec::new();
    let mut measurands = Vec::new();
    for (index, measurand) in assembly.measurands.iter().enumerate() {
        let weight = graph.leaf(Leaf::Given(index as u32));
        let components = measurand.value.nodes().len().min(3);
        weights.extend(std::iter::repeat_n(weight, components));
        measurands.extend(std::iter::repeat_n(index, components));
    }
    (weights, measurands)
}

fn weighted(rows: &mut Rows, weights: &[NodeId]) -> Vec<NodeId> {
    let residuals = rows.residuals.clone();
    residuals.iter().zip(weights).map(|(r, w)| rows.graph.multiply(*w, *r)).collect()
}
