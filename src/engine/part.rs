//! One campaign with its model: its readings, and their predictions over any number.
//!
//! Answers: where each measurand stands among predictions, reading columns and residuals; the
//! prediction and the residual of a reading. Whose unknowns are shared is [`super::problem`]'s
//! business.

mod leaves;
mod present;
mod slot;

use std::ops::Range;

use crate::campaign::delay_range::DelayRange;
use crate::campaign::loaded::HeadUnit;
use crate::campaign::{Run, Sample, Track};
use crate::engine::found_starts::FoundStart;
use crate::engine::gauss_markov::GaussMarkov;
use crate::engine::layout::qualified;
use crate::engine::pointwise::Program;
use crate::graph::{NodeId, Value};
use crate::number::Number;
use crate::system::System;
use crate::units::{DisplayUnits, Unit};

pub use leaves::{ParameterLeaves, SampleLeaves};
pub use slot::{Slot, wrapped};

/// One campaign with its model, ready for evaluation.
#[derive(Clone, Debug)]
pub struct Part {
    /// How the campaign is called where several are used together.
    pub label: Option<String>,
    /// Name of the instrument, if stated.
    pub instrument: Option<String>,
    /// Name of the rig, if stated.
    pub rig: Option<String>,
    /// The model with its effects.
    pub system: System,
    /// Names of the setups.
    pub setups: Vec<String>,
    /// The runs' data.
    pub runs: Vec<Run>,
    /// Stated standard uncertainty of one reading of each measurand (SI).
    pub sigma: Vec<f64>,
    /// For each run a factor on that for each measurand; empty where all are 1.
    pub run_levels: Vec<Vec<f64>>,
    /// For each run what errors of smoothed streams add to each measurand (SI); empty where it is
    /// not counted.
    pub smoothing_sigma: Vec<Vec<f64>>,
    /// Whether errors of smoothed streams, of all its readings together, are large enough to look like an
    /// effect.
    pub has_stream_noise: bool,
    /// Standard deviation of each random quantity (SI); 0 switches it off.
    pub random_sigma: Vec<f64>,
    /// Units in which people read its values, where stated.
    pub output: DisplayUnits,
    /// Between which delays readings may lie.
    pub delay_range: DelayRange,
    /// Starts that a search found.
    pub found_starts: Vec<FoundStart>,
    /// From when the times of samples count (s).
    pub zero: i64,
    /// The units in which columns of inputs and measurands are read, each once.
    pub head_units: Vec<HeadUnit>,
    /// Standard uncertainty (SI) that the calibration of each input leaves open, the same whenever
    /// the same position comes by; 0 where nothing is said. The estimates' weights do not hold it.
    pub calibration: Vec<f64>,
    /// Parameters that are held at zero in single runs, where no reading depends on them: the names of
    /// the run and of the parameter.
    pub held: Vec<(String, String)>,
    /// For each residual component the autocorrelated part of its noise; `None`
    /// where the noise is white.
    pub gauss_markov: Vec<Option<GaussMarkov>>,
    program: Program,
    readers: Vec<Program>,
    slots: Vec<Slot>,
    columns: Vec<usize>,
}

impl Part {
    /// Makes a campaign's model ready for evaluation.
    pub fn new(system: System, setups: Vec<String>, runs: Vec<Run>, sigma: Vec<f64>) -> Self {
        let assembly = &system.assembly;
        let mut outputs: Vec<NodeId> = Vec::new();
        let mut slots = Vec::with_capacity(assembly.measurands.len());
        let (mut column, mut residual) = (0, 0);
        for (measurand, graph) in assembly.names.measurands.iter().zip(&assembly.measurands) {
            let output = outputs.len();
            outputs.extend_from_slice(graph.value.nodes());
            let sigma_factor = graph.sigma_factor.map(|node| {
                outputs.push(node);
                outputs.len() - 1
            });
            let (columns, components) = match graph.value {
                Value::Scalar(_) => (1, 1),
                Value::Vector(_) => (3, 3),
                Value::Rotation(_) => (4, 3),
            };
            slots.push(Slot {
                kind: measurand.kind,
                output,
                sigma_factor,
                column,
                width: columns,
                residual,
                components,
            });
            column += columns;
            residual += components;
        }
        let program = Program::new(&assembly.graph, &outputs);
        let readers = assembly
            .measurands
            .iter()
            .map(|graph| Program::new(&assembly.graph, graph.value.nodes()))
            .collect();
        Self {
            label: None,
            instrument: None,
            rig: None,
            random_sigma: system.randoms.iter().map(|one| one.sigma.unwrap_or(0.0)).collect(),
            system,
            setups,
            runs,
            sigma,
            run_levels: Vec::new(),
            smoothing_sigma: Vec::new(),
            has_stream_noise: false,
            output: DisplayUnits::default(),
            delay_range: DelayRange::default(),
            found_starts: Vec::new(),
            zero: 0,
            head_units: Vec::new(),
            calibration: Vec::new(),
            held: Vec::new(),
            gauss_markov: vec![None; residual],
            program,
            readers,
            columns: slots.iter().map(|slot| slot.column).collect(),
            slots,
        }
    }

    /// The same campaign with another system; readings, stated uncertainties, levels and memory of
    /// noise are as they are.
    pub fn with_system(&self, system: System) -> Self {
        let levels: Vec<(String, f64)> = self
            .system
            .randoms
            .iter()
            .zip(&self.random_sigma)
            .map(|(random, sigma)| (random.name.clone(), *sigma))
            .collect();
        let mut made =
            Part::new(system, self.setups.clone(), self.runs.clone(), self.sigma.clone());
        for (random, sigma) in made.system.randoms.iter().zip(&mut made.random_sigma) {
            if let Some((_, level)) = levels.iter().find(|(name, _)| *name == random.name) {
                *sigma = *level;
            }
        }
        made.label.clone_from(&self.label);
        made.output.clone_from(&self.output);
        made.instrument.clone_from(&self.instrument);
        made.rig.clone_from(&self.rig);
        made.delay_range.clone_from(&self.delay_range);
        made.found_starts.clone_from(&self.found_starts);
        made.zero = self.zero;
        made.head_units.clone_from(&self.head_units);
        made.calibration.clone_from(&self.calibration);
        made.held.clone_from(&self.held);
        made.gauss_markov.clone_from(&self.gauss_markov);
        made.run_levels.clone_from(&self.run_levels);
        made.smoothing_sigma.clone_from(&self.smoothing_sigma);
        made.has_stream_noise = self.has_stream_noise;
        made
    }

    /// The unit in which people read a measurand.
    pub fn unit_of(&self, measurand: usize) -> Unit {
        let one = &self.system.assembly.names.measurands[measurand];
        self.output.of(&one.name, &one.unit).unwrap_or_else(|| one.unit.clone())
    }

    /// The unit in which people read a parameter: as stated, else as declared; of an effect's angle
    /// that in which all angles are read, for its file knows no instrument.
    pub fn unit_of_parameter(&self, name: &str, declared: &Unit) -> Unit {
        let of_effect = name.contains('.') && !name.ends_with(".delay");
        let stated = self.output.of(name, declared);
        let angle = || self.unit_of_angles().filter(|_| of_effect && declared.symbol == "rad");
        stated.or_else(angle).unwrap_or_else(|| declared.clone())
    }

    /// The unit of all measurands that are angles, where they have one.
    fn unit_of_angles(&self) -> Option<Unit> {
        let all = 0..self.system.assembly.names.measurands.len();
        let mut angles = all.map(|index| self.unit_of(index)).filter(Unit::is_angle);
        let first = angles.next()?;
        angles.all(|other| other.factor == first.factor).then_some(first)
    }

    /// A name with the label of the campaign, where there are several campaigns.
    pub fn qualified(&self, name: &str) -> String {
        qualified(self.label.as_deref(), name)
    }

    /// Whether its data have no times.
    pub fn is_untimed(&self) -> bool {
        self.runs.iter().all(|run| run.record.is_untimed())
    }

    /// The name of a run, likewise.
    pub fn run_name(&self, run: usize) -> String {
        self.qualified(&self.runs[run].name)
    }

    /// Where each measurand stands.
    pub fn slots(&self) -> &[Slot] {
        &self.slots
    }

    /// All reading columns.
    pub fn reading_columns(&self) -> Range<usize> {
        0..self.slots.last().map_or(0, |slot| slot.columns().end)
    }

    /// First reading column of each measurand.
    pub fn columns(&self) -> &[usize] {
        &self.columns
    }

    /// The measurand of a residual component.
    pub fn measurand_of(&self, row: usize) -> usize {
        self.slots.partition_point(|slot| slot.residual <= row) - 1
    }

    /// Number of residual components of one sample.
    pub fn residual_count(&self) -> usize {
        self.slots.last().map_or(0, |slot| slot.residual + slot.components)
    }

    /// Standard deviation of a random quantity in a run: the error of a logged input is that of its
    /// smoothed curve, not that of one raw value.
    pub fn random_sigma_in(&self, run: usize, random: usize) -> f64 {
        let inputs = &self.system.assembly.names.inputs;
        let gain = match inputs.iter().position(|input| input.error == Some(random)) {
            Some(input) => match &self.runs[run].record.inputs()[input] {
                Track::Logged(spline) => spline.noise_gain(),
                Track::Absent | Track::Constant(_) | Track::Captured { .. } => 1.0,
            },
            None => 1.0,
        };
        gain * self.random_sigma[random]
    }

    /// Evaluates all measurands (and noise factors) of one sample.
    pub fn evaluate<'w, N: Number>(
        &self,
        leaves: &SampleLeaves<'_, N>,
        workspace: &'w mut Vec<N>,
    ) -> &'w [N] {
        self.program.evaluate(leaves, workspace)
    }

    /// Evaluates one measurand of one sample: its outputs alone, from 0.
    pub fn evaluate_one<'w, N: Number>(
        &self,
        measurand: usize,
        leaves: &SampleLeaves<'_, N>,
        workspace: &'w mut Vec<N>,
    ) -> &'w [N] {
        self.readers[measurand].evaluate(leaves, workspace)
    }

    /// `reading - prediction` of one measurand: wrapped for an angle, a rotation vector for a
    /// rotation (from predicted to read, in the predicted frame).
    pub fn residual<N: Number>(&self, sample: Sample<'_>, slot: &Slot, outputs: &[N]) -> [N; 3] {
        slot.residual(sample, outputs)
    }
}
