//! One or several campaigns with their models: what is to be explained, and by which unknowns.
//!
//! Answers: which unknowns act in which run, and with what its lanes are computed. It does not
//! estimate.

use std::collections::HashMap;
use std::sync::Arc;

use rayon::prelude::*;

use crate::campaign::signal::moving_signals;
use crate::engine::found_starts::FoundStart;
use crate::engine::lanes::InstructionSet;
use crate::engine::layout::{Layout, Share};
use crate::engine::part::Part;
use crate::engine::point::{Point, seeded};
use crate::engine::programs::Programs;
use crate::engine::rows::{Direction, Sweep};
use crate::engine::whitening::{RunPrograms, Whitening};
use crate::number::{Gradient, Number};
use crate::progress::Progress;
use crate::system::System;

/// Campaigns together with the layout of their unknowns.
#[derive(Clone, Debug)]
pub struct Problem {
    /// The campaigns.
    pub parts: Vec<Part>,
    /// The unknowns.
    pub layout: Layout,
    /// Frozen whitening of every sample's readings, by campaign and run; copies share it.
    pub(crate) whitening: Arc<[Vec<Whitening>]>,
    /// The lane programs of each campaign's model.
    pub(crate) programs: Vec<Arc<Programs>>,
    /// With what the lanes are computed.
    pub(crate) set: InstructionSet,
    /// Who is told how far estimates have come.
    pub progress: Progress,
    /// Iteration of the fit that goes on.
    pub(crate) iteration: usize,
}

impl Problem {
    /// Puts campaigns together; the weights are those at the starting point.
    pub fn new(parts: Vec<Part>) -> Self {
        let mut layout = layout_of(&parts);
        layout.begin_at_found(parts.iter().flat_map(|part| &part.found_starts));
        let mut problem = Self {
            parts,
            layout,
            whitening: Arc::default(),
            programs: Vec::new(),
            set: InstructionSet::best(),
            progress: Progress::default(),
            iteration: 0,
        };
        problem.compute_with(problem.set, Sweep::Backward);
        let start = Point::start(&problem.layout);
        problem.refresh_weights(&start);
        problem
    }

    /// A problem of other campaigns whose fits report to the same progress.
    #[must_use]
    pub fn with_parts(&self, parts: Vec<Part>) -> Self {
        Self { progress: self.progress.clone(), ..Self::new(parts) }
    }

    /// Lets a parameter start where a search found it, in this problem and in all that are made of
    /// its parts.
    pub fn begin_at_found(&mut self, instance: usize, components: Vec<f64>) {
        let one = &self.layout.instances[instance];
        let found = FoundStart { name: one.name.clone(), of: one.of.clone(), components };
        self.layout.begin_at_found(std::iter::once(&found));
        for (part, used) in self.parts.iter_mut().zip(&self.layout.used) {
            if used.iter().any(|used| used.contains(&instance)) {
                part.found_starts.push(found.clone());
            }
        }
    }

    /// Whether a signal moves in any run; else there are no delays.
    pub fn moves(&self) -> bool {
        let moves = |part: &Part| {
            let inputs = &part.system.assembly.names.inputs;
            part.runs
                .iter()
                .any(|run| moving_signals(inputs, run.record.inputs()).any(|moves| moves))
        };
        self.parts.iter().any(moves)
    }

    /// The parameters of a run at a point, as constants.
    pub fn parameters<N: Number>(&self, part: usize, run: usize, point: &Point) -> Vec<[N; 4]> {
        self.layout.used[part][run]
            .iter()
            .map(|instance| point.values[*instance].map(N::constant))
            .collect()
    }

    /// The tangent components that act in a run: instance and component, free ones only.
    pub fn tangents(&self, part: usize, run: usize) -> Vec<(usize, usize)> {
        let mut tangents = Vec::new();
        for instance in &self.layout.used[part][run] {
            for component in 0..self.layout.instances[*instance].dimension() {
                if !self.layout.columns_of(*instance, component).is_empty() {
                    tangents.push((*instance, component));
                }
            }
        }
        tangents
    }

    /// Computes the lanes with an instruction set and makes derivatives by a sweep. All give the
    /// same to rounding; the widest set and the backward sweep, which is faster, are the defaults.
    pub fn compute_with(&mut self, set: InstructionSet, sweep: Sweep) {
        self.set = set;
        self.programs = (0..self.parts.len())
            .map(|part| {
                let measurands = self.parts[part].slots().len();
                Arc::new(Programs::new(self.directions(part), sweep, measurands))
            })
            .collect();
    }

    /// With what the lanes are computed.
    pub fn instruction_set(&self) -> InstructionSet {
        self.set
    }

    /// The lane programs of a campaign's model.
    pub fn programs(&self, part: usize) -> &Programs {
        &self.programs[part]
    }

    /// The directions along which some run of a campaign is free to move.
    fn directions(&self, part: usize) -> Vec<Direction> {
        let mut directions: Vec<Direction> = Vec::new();
        for used in &self.layout.used[part] {
            for (parameter, instance) in used.iter().enumerate() {
                for component in 0..self.layout.instances[*instance].dimension() {
                    if !self.layout.columns_of(*instance, component).is_empty() {
                        directions.push((parameter, component));
                    }
                }
            }
        }
        directions.sort_unstable();
        directions.dedup();
        directions
    }

    /// For each direction of a campaign, the columns that move a run along it, by their place among
    /// the columns that the run touches, with their coefficients.
    pub fn movers(&self, part: usize, run: usize) -> Vec<Vec<(usize, f64)>> {
        let touched = self.layout.columns.touched_by(self.run_index(part, run));
        let place: HashMap<usize, usize> =
            touched.iter().enumerate().map(|(place, column)| (*column, place)).collect();
        self.programs[part]
            .directions()
            .iter()
            .map(|(parameter, component)| {
                let instance = self.layout.used[part][run][*parameter];
                let columns = self.layout.columns_of(instance, *component);
                columns.into_iter().filter_map(|(c, by)| Some((*place.get(&c)?, by))).collect()
            })
            .collect()
    }

    /// The parameters of a run at a point, with `tangents` as the variables of the gradient.
    pub fn seeded_parameters<const N: usize>(
        &self,
        part: usize,
        run: usize,
        point: &Point,
        tangents: &[(usize, usize)],
    ) -> Vec<[Gradient<N>; 4]> {
        self.layout.used[part][run]
            .iter()
            .map(|&instance| {
                let seed = |component| {
                    tangents.iter().position(|t| *t == (instance, component)).unwrap_or(usize::MAX)
                };
                let kind = self.layout.instances[instance].kind;
                seeded(kind, point.values[instance], [seed(0), seed(1), seed(2)])
            })
            .collect()
    }

    /// A run with what its samples are evaluated.
    pub(crate) fn run_programs(&self, part: usize, run: usize) -> RunPrograms<'_> {
        RunPrograms { part: &self.parts[part], programs: &self.programs[part], set: self.set, run }
    }

    /// Lets the weights follow a point.
    pub fn refresh_weights(&mut self, point: &Point) {
        // Those before are not wanted any more: they make room.
        self.whitening = Arc::default();
        let of_run = |part: usize, run: usize| {
            let parameters = || self.parameters(part, run, point);
            Whitening::new(self.run_programs(part, run), parameters)
        };
        let of_part = |part: usize| {
            let runs = (0..self.parts[part].runs.len()).into_par_iter();
            runs.map(|run| of_run(part, run)).collect()
        };
        self.whitening = (0..self.parts.len()).map(of_part).collect();
    }

    /// Whether a part of the noise of any row is autocorrelated.
    pub fn has_autocorrelated_noise(&self) -> bool {
        self.parts.iter().any(|part| part.gauss_markov.iter().any(Option::is_some))
    }

    /// Number of readings there are, a rotation counting as one.
    pub fn reading_count(&self) -> usize {
        let runs = self.parts.iter().flat_map(|part| (0..part.runs.len()).map(move |r| (part, r)));
        runs.flat_map(|(part, run)| part.present_in(run)).sum()
    }

    /// Number of residual components there are, a rotation counting as three: what a sum of their
    /// squares is compared with.
    pub fn component_count(&self) -> usize {
        self.parts.iter().flat_map(Part::components_present).sum()
    }
}

/// The unknowns of campaigns together.
fn layout_of(parts: &[Part]) -> Layout {
    layout_with(parts, parts.iter().map(|part| &part.system))
}

/// The unknowns of campaigns together, were these their models with effects.
pub(crate) fn layout_with<'a>(
    parts: &'a [Part],
    systems: impl Iterator<Item = &'a System>,
) -> Layout {
    let runs: Vec<Vec<(String, usize)>> = parts
        .iter()
        .map(|part| part.runs.iter().map(|run| (run.name.clone(), run.setup)).collect())
        .collect();
    let shares: Vec<Share<'_>> = parts
        .iter()
        .zip(&runs)
        .zip(systems)
        .map(|((part, runs), system)| Share {
            system,
            instrument: part.instrument.as_deref(),
            rig: part.rig.as_deref(),
            setups: &part.setups,
            runs,
            label: part.label.as_deref(),
            held: &part.held,
        })
        .collect();
    Layout::new(&shares)
}
