//! Groups of readings in which a row may have values of its own: what a campaign varies on purpose
//! (setups, the rate and the sense of each signal), and its measurands.

use std::f64::consts::TAU;

use indexmap::IndexMap;

use crate::diagnose::library::structure::spread::Spread;
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
const SAMPLES: usize = 2048;
/// Values of an input, in parts of its span, within one place.
const SAME_PLACE: f64 = 1e-6;
/// Places that each have a value of their own at most.
const MOST_PLACES: usize = 16;
/// The same of a block for inputs with more places, and the readings of each on average at least.
const MOST_LEVELS: usize = 48;
const READINGS_OF_A_LEVEL: usize = 2;
/// Spans between the knots of an input with more places.
const KNOTS: usize = 8;
/// Span (rad) above which an angle is treated as periodic.
const PERIODIC: f64 = 1.0;
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
        let count = rates_here.len().max(1) as f64;
        let mean = rates_here.iter().sum::<f64>() / count;
        let rms = (rates_here.iter().map(|rate| rate * rate).sum::<f64>() / count).sqrt();
        // A signal that goes to and fro in a run has no mean rate to compare.
        of_runs[run] = if mean.abs() < STEADY * rms { 0.0 } else { mean };
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

/// How the inputs that vary are spread, with the places at which a line over each may bend: all of a few, or
/// octiles of many; none of an angle that is treated as periodic.
pub(super) fn spreads(problem: &Problem) -> Vec<Spread> {
    let mut values: IndexMap<String, (bool, Vec<f64>)> = IndexMap::new();
    each_input(problem, 0, |_, input, here| {
        let (is_angle, all) = values.entry(input.name.clone()).or_default();
        *is_angle |= input.unit.is_angle();
        all.extend(here);
    });
    values
        .into_iter()
        .filter_map(|(name, (is_angle, mut all))| {
            all.sort_by(f64::total_cmp);
            let span = all.last()? - all.first()?;
            if is_angle && span > PERIODIC {
                let mut places: Vec<f64> = all.iter().map(|one| one.rem_euclid(TAU)).collect();
                places.sort_by(f64::total_cmp);
                let levels = levels(&distinct(&places, TAU), all.len());
                return Some(Spread::of_angle(name, &all, span).with_levels(levels));
            }
            let mut places = distinct(&all, span);
            if places.len() < 3 {
                return None;
            }
            let levels = levels(&places, all.len());
            if places.len() > MOST_PLACES {
                places = (0..=KNOTS).map(|k| all[k * (all.len() - 1) / KNOTS]).collect();
                places = distinct(&places, span);
            }
            let inner = places.len().checked_sub(1)?;
            let knots = places.get(1..inner).filter(|knots| !knots.is_empty())?.to_vec();
            Some(Spread::of_knots(name, knots, span).with_levels(levels))
        })
        .collect()
}

/// The places among values in order that go over a span.
fn distinct(sorted: &[f64], span: f64) -> Vec<f64> {
    let mut places = sorted.to_vec();
    places.dedup_by(|a, b| (*a - *b).abs() <= SAME_PLACE * span);
    places
}

/// Places that are too many for knots, where each has several of so many readings: none else.
fn levels(places: &[f64], readings: usize) -> Vec<f64> {
    let is_read_again = readings >= READINGS_OF_A_LEVEL * places.len();
    let is_some = (MOST_PLACES + 1..=MOST_LEVELS).contains(&places.len()) && is_read_again;
    if is_some { places.to_vec() } else { Vec::new() }
}

/// Shows of each run (of all) and input the values at some samples, or those of a derivative by time,
/// as far as they are numbers.
fn each_input(problem: &Problem, order: u8, mut see: impl FnMut(usize, &Input, Vec<f64>)) {
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
