//! Signatures of effects that are not in the model: how each would change the readings, in one pass
//! with the nominal derivatives.
//!
//! An effect's signature is the derivative of the predictions with respect to one of its parameters
//! where it is switched off. It is an expression in the nominal model's own quantities, so the
//! signatures of a whole library share most of what they need with the nominal pass and with each
//! other: they are nodes of one graph, made by one program. Each candidate is a system of its own
//! (the nominal effects and one more); an effect whose parameters are all random has no signature,
//! nor has a parameter that acts only together with another one that is zero.
//!
//! What the sums mean is not its business.

use std::collections::HashMap;

use crate::engine::blocks::Plan;
use crate::engine::gram::{Growing, PartGram, RunGram};
use crate::engine::kept::Memories;
use crate::engine::point::Point;
use crate::engine::problem::Problem;
use crate::engine::programs::{RowNodes, RowsProgram, weights};
use crate::engine::rows::{Derivatives, Rows, Sweep};
use crate::engine::switched_off::off;
use crate::graph::derivative::seeds;
use crate::graph::import::Import;
use crate::graph::{Graph, Leaf, Scope};
use crate::system::System;

/// A model with one more effect.
#[derive(Clone, Copy, Debug)]
pub struct Candidate<'a> {
    /// Its number among those of its caller.
    pub number: usize,
    /// The nominal model and its effects with this one.
    pub system: &'a System,
}

/// What one column stands for.
#[derive(Clone, Debug, PartialEq)]
pub struct Signature {
    /// The number of its candidate.
    pub candidate: usize,
    /// The parameter's full name.
    pub parameter: String,
    /// Component of its tangent space.
    pub component: usize,
    /// Where one value of it holds.
    pub scope: Scope,
    /// The magnitude that it usually has, if its declaration says so.
    pub typical: Option<f64>,
}

/// The signatures of some effects in one campaign.
#[derive(Clone, Debug)]
pub struct Signatures {
    /// The columns, after those of the nominal unknowns.
    pub columns: Vec<Signature>,
    /// For each of them the number of its candidate, from 1 on.
    pub(super) groups: Vec<usize>,
    /// Whether the nominal columns are computed, too.
    pub(super) among: bool,
    pub(crate) program: RowsProgram,
    part: usize,
}

impl Signatures {
    /// The signatures of candidates in a campaign of a problem.
    pub fn new(problem: &Problem, part: usize, candidates: &[Candidate<'_>]) -> Self {
        Self::open(problem, part, candidates, "", true)
    }

    /// The same with a constant of each candidate left open, by its name in the effect's file: its
    /// values are given with each pass ([`Passes`](super::passes::Passes)). Not `among` the nominal
    /// columns, those are not computed.
    pub fn open(
        problem: &Problem,
        part: usize,
        candidates: &[Candidate<'_>],
        open: &str,
        among: bool,
    ) -> Self {
        let system = &problem.parts[part].system;
        let directions = problem.programs(part).directions();
        let computed = if among { directions } else { &[] };
        let mut made = RowsProgram::nodes(&system.assembly, computed, Sweep::Backward);
        let nominal: HashMap<&str, u32> = (0..)
            .zip(&system.assembly.names.parameters)
            .map(|(index, parameter)| (parameter.name.as_str(), index))
            .collect();
        let (mut columns, mut groups) = (Vec::new(), Vec::new());
        for (number, candidate) in candidates.iter().enumerate() {
            let mut rows = Rows::new(&candidate.system.assembly);
            let (weights, _) = weights(&mut rows.graph, &candidate.system.assembly);
            let (open, import) = ((open, number), Import::default());
            let mut adding = Adding { nominal: &nominal, candidate, open, rows, import };
            for parameter in 0..candidate.system.settings.len() {
                if !adding.is_own(parameter) || candidate.system.settings[parameter].fixed {
                    continue;
                }
                let kind = candidate.system.assembly.names.parameters[parameter].kind;
                for component in 0..kind.dimension() {
                    let column = directions.len() + columns.len();
                    let seeds = seeds(&mut adding.rows.graph, parameter as u32, kind, component);
                    // Switched off, the adjoints of all candidates are those of the nominal model.
                    let found = adding.rows.derivatives(&[seeds], &weights, Sweep::Backward);
                    if adding.append(column, &found, &mut made) {
                        columns.push(adding.signature(parameter, component));
                        groups.push(number + 1);
                    }
                }
            }
        }
        Self { columns, groups, among, program: made.compile(), part }
    }
}

impl Signatures {
    /// The campaign.
    pub fn part(&self) -> usize {
        self.part
    }

    /// For each residual component, the number of columns that it hangs on, nominal ones counted.
    pub fn columns_by_row(&self) -> Vec<usize> {
        self.program.rows.iter().map(|row| row.directions.len()).collect()
    }
}

/// Puts the derivatives of one candidate into the graph of all.
struct Adding<'a> {
    nominal: &'a HashMap<&'a str, u32>,
    candidate: &'a Candidate<'a>,
    /// The constant that is left open, and the number of the candidate.
    open: (&'a str, usize),
    rows: Rows,
    import: Import,
}

impl Adding<'_> {
    /// Whether a parameter is the effect's and not the nominal model's.
    fn is_own(&self, parameter: usize) -> bool {
        let name = &self.candidate.system.assembly.names.parameters[parameter].name;
        !self.nominal.contains_key(name.as_str())
    }

    fn signature(&self, parameter: usize, component: usize) -> Signature {
        let system = self.candidate.system;
        Signature {
            candidate: self.candidate.number,
            parameter: system.assembly.names.parameters[parameter].name.clone(),
            component,
            scope: system.settings[parameter].scope,
            typical: system.settings[parameter].typical,
        }
    }

    /// Adds one column to the rows that hang on it; whether any does.
    fn append(&mut self, number: usize, found: &[Derivatives], made: &mut RowNodes) -> bool {
        let (system, nominal, (open, candidate)) = (self.candidate.system, self.nominal, self.open);
        let names = &system.assembly.names.parameters;
        let mut absent = |graph: &mut Graph, leaf| match leaf {
            Leaf::Random(_) => graph.constant(0.0),
            Leaf::Parameter { parameter, component } => {
                let index = parameter as usize;
                if let Some(parameter) = nominal.get(names[index].name.as_str()) {
                    return graph.leaf(Leaf::Parameter { parameter: *parameter, component });
                }
                if system.declared[index].local == open {
                    let parameter = (nominal.len() + candidate) as u32;
                    return graph.leaf(Leaf::Parameter { parameter, component });
                }
                graph.constant(off(system, index, component))
            }
            other => graph.leaf(other),
        };
        let zero = made.graph.constant(0.0);
        let mut acts = false;
        for (row, derivative) in found.iter().enumerate() {
            let Some(node) = derivative.nodes.first() else { continue };
            let node = self.import.node(&self.rows.graph, *node, &mut made.graph, &mut absent);
            if node != zero {
                made.derivatives[row].directions.push(number);
                made.derivatives[row].nodes.push(node);
                acts = true;
            }
        }
        acts
    }
}

impl Problem {
    /// The Gram sums of every run of a campaign at a point, the signatures' columns among them:
    /// first the columns that the run touches, then the signatures', last the residual.
    pub fn gram_with(&self, signatures: &Signatures, point: &Point) -> Vec<RunGram> {
        let part = signatures.part;
        let plans = self.plans_with(signatures, point);
        let mut sums = Growing::new(plans.len());
        let most = plans.iter().map(|plan| plan.size).max().unwrap_or(0);
        self.in_order(
            &Memories::default(),
            most * most,
            |block| block.part == part,
            |memory, block| self.block_gram(block, &signatures.program, &plans[block.run], memory),
            |block, made| sums.add(block.run, made),
        );
        sums.finish(plans.iter().map(|plan| plan.size))
    }

    /// The Gram sums of [`Problem::gram_with`] measurand by measurand, each with the columns that its
    /// readings hang on, block after block of each run; nothing is kept here. `take` gets the run's
    /// index in the campaign.
    pub fn grams_by_measurand(
        &self,
        signatures: &Signatures,
        point: &Point,
        mut take: impl FnMut(usize, Vec<PartGram>),
    ) {
        let part = signatures.part;
        let plans = self.plans_with(signatures, point);
        let numbers = signatures.columns_by_row().iter().map(|columns| columns * columns).sum();
        self.in_order(
            &Memories::default(),
            numbers,
            |block| block.part == part,
            |memory, block| self.block_grams(block, &signatures.program, &plans[block.run], memory),
            |block, made| take(block.run, made),
        );
    }

    /// The plans of a campaign's runs, with a column for each signature.
    pub(super) fn plans_with(&self, signatures: &Signatures, point: &Point) -> Vec<Plan> {
        let (part, more) = (signatures.part, signatures.columns.len());
        let runs = 0..self.parts[part].runs.len();
        runs.map(|run| self.plan(part, run, point, more)).collect()
    }

    /// Computes the rows of every run of a campaign and forgets them: what [`Problem::gram_with`]
    /// does but for the sums. The number of readings comes back.
    pub fn rows_with(&self, signatures: &Signatures, point: &Point) -> usize {
        let part = signatures.part;
        let plans = self.plans_with(signatures, point);
        let mut readings = 0;
        self.in_order(
            &Memories::default(),
            1,
            |block| block.part == part,
            |memory, block| self.block_rows(block, &signatures.program, &plans[block.run], memory),
            |_, made| readings += made,
        );
        readings
    }
}
