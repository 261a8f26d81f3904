//! Groups of readings in which a row may have values of its own: what a campaign varies on purpose
//! (setups, the rate and the sense of each signal), and its measurands.

use indexmap::IndexMap;

use crate::diagnose::library::variant::Variant;
use crate::engine::Problem;
use crate::graph::names::Input;

/// What groups of readings differ in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Label {
    /// Setups.
    Setup,
    /// Angles that an effect acts on.
    Angle,
    /// The sense of a signal.
    Sense(String),
    /// The rate of a signal.
    Rate(String),
}

impl Label {
    /// What it is.
    pub fn words(&self) -> String {
        match self {
            Self::Setup => "setup".to_owned(),
            Self::Angle => "angle".to_owned(),
            Self::Sense(signal) => format!("sense of {signal}"),
            Self::Rate(signal) => format!("rate of {signal}"),
        }
    }

    /// The form of an effect whose values may differ so.
    pub fn variant(&self) -> Option<Variant> {
        match self {
            Self::Setup => Some(Variant::EachSetup),
            Self::Angle => Some(Variant::EachAngle),
            Self::Sense(_) | Self::Rate(_) => None,
        }
    }
}

/// Relative difference of mean rates within one group.
const SAME_RATE: f64 = 0.05;
/// Samples of a run that its mean rates are found from.
pub(in crate::diagnose) const SAMPLES: usize = 2048;
/// Mean rate of a run, in parts of its rms rate, from which a signal moves steadily in it.
const STEADY: f64 = 0.3;
/// Mean rate, in parts of the largest, below which a signal stands still.
const STILL: f64 = 1e-3;

/// Groups of readings: of runs, or of measurands over all campaigns.
#[derive(Clone, Debug)]
pub struct Grouping {
    /// What they differ in.
    pub label: Label,
    /// The group of each run, or of each measurand.
    pub groups: Vec<usize>,
}

impl Grouping {
    /// Number of groups.
    pub fn count(&self) -> usize {
        self.groups.iter().max().map_or(0, |most| most + 1)
    }

    /// Whether a reading of a run and a measurand belongs to a group.
    pub fn holds(&self, group: usize, run: usize, measurand: usize) -> bool {
        let at = if self.label == Label::Angle { measurand } else { run };
        self.groups[at] == group
    }
}

/// Groupings; those that divide nothing are not among them.
pub fn labels(problem: &Problem) -> Vec<Grouping> {
    let parts = || problem.parts.iter().enumerate();
    let setups: Vec<(usize, usize)> = parts()
        .flat_map(|(number, part)| part.runs.iter().map(move |run| (number, run.setup)))
        .collect();
    let mut rates: IndexMap<String, Vec<f64>> = IndexMap::new();
    each_input(problem, 1, |run, input, rates_here| {
        let of_runs = rates.entry(input.name.clone()).or_insert_with(|| vec![0.0; setups.len()]);
        of_runs[run] = steady_rate(&rates_here);
    });
    let names = problem.parts.iter().flat_map(|part| &part.system.assembly.names.measurands);
    let names: Vec<&str> = names.map(|one| one.name.as_str()).collect();
    let mut labels = vec![
        Grouping { label: Label::Setup, groups: groups(&setups, |a, b| a == b) },
        Grouping { label: Label::Angle, groups: groups(&names, |a, b| a == b) },
    ];
    for (name, rates) in rates {
        let most = rates.iter().fold(0.0_f64, |most, rate| most.max(rate.abs()));
        let sense: Vec<i8> = rates
            .iter()
            .map(|rate| if rate.abs() < STILL * most { 0 } else { rate.signum() as i8 })
            .collect();
        let groups_of_sense = groups(&sense, |a, b| a == b);
        labels.push(Grouping { label: Label::Sense(name.clone()), groups: groups_of_sense });
        let same = |a: &f64, b: &f64| (a.abs() - b.abs()).abs() <= SAME_RATE * most;
        labels.push(Grouping { label: Label::Rate(name), groups: groups(&rates, same) });
    }
    labels.retain(|one| one.groups.iter().any(|group| *group != one.groups[0]));
    labels
}

/// The mean of rates; 0 where a signal goes to and fro, which has none to compare.
pub(in crate::diagnose) fn steady_rate(rates: &[f64]) -> f64 {
    let count = rates.len().max(1) as f64;
    let mean = rates.iter().sum::<f64>() / count;
    let rms = (rates.iter().map(|rate| rate * rate).sum::<f64>() / count).sqrt();
    if mean.abs() < STEADY * rms { 0.0 } else { mean }
}

/// Shows of each run (of all) and input the values at some samples, or those of a derivative by time,
/// as far as they are numbers.
pub(super) fn each_input(
    problem: &Problem,
    order: u8,
    mut see: impl FnMut(usize, &Input, Vec<f64>),
) {
    let runs = problem.parts.iter().flat_map(|part| part.runs.iter().map(move |run| (part, run)));
    for (number, (part, run)) in runs.enumerate() {
        let samples = run.record.spread(SAMPLES, 1);
        for (input, track) in part.system.assembly.names.inputs.iter().zip(&samples.inputs) {
            let all = (0..samples.len()).map(|at| track.at(at, samples.time[at], 0.0_f64, order));
            see(number, input, all.filter(|value| value.is_finite()).collect());
        }
    }
}

/// Numbers of groups whose values are the same as that of the first in them.
fn groups<T>(values: &[T], same: impl Fn(&T, &T) -> bool) -> Vec<usize> {
    let mut firsts: Vec<&T> = Vec::new();
    values
        .iter()
        .map(|value| {
            firsts.iter().position(|first| same(first, value)).unwrap_or_else(|| {
                firsts.push(value);
                firsts.len() - 1
            })
        })
        .collect()
}
