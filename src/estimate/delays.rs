//! The delays of all readings and their mean for each measurand, and their comparison with the
//! joint estimate.
//!
//! Weights follow the random part of each reading's uncertainty, with the slope at the reference
//! time: a weight that knew the reading's own error would bias the mean. The common part (the
//! transformation and whatever else the readings share) does not shrink with their number:
//! `u(mean)² = s̄ Σ s̄ᵀ + Σ w² u_random² / (Σ w)²` with the weighted mean sensitivity `s̄`.
//! Readings are summed up as they are solved, block by block: memory does not grow with their
//! number, and every number of threads gives the same bits.

use std::convert::Infallible;

use nalgebra::{DMatrix, DVector};

use crate::engine::Point;
use crate::engine::problem::Problem;
use crate::estimate::blind::{BlindRange, Sight, seen};
use crate::estimate::median::Median;
use crate::estimate::newton::{Given, ReadingDelay, Solved, State, each_delay};
use crate::graph::MeasurandKind;

/// What came of one measurand's readings.
#[derive(Clone, Debug)]
pub struct Summary {
    /// The measurand.
    pub measurand: String,
    /// Readings that were there.
    pub readings: usize,
    /// Solved ones.
    pub solved: usize,
    /// Blind ones.
    pub blind: usize,
    /// Failed ones.
    pub failed: usize,
    /// Weighted mean delay (s), if any reading was solved.
    pub mean: Option<f64>,
    /// Its standard uncertainty (s).
    pub sigma_of_mean: Option<f64>,
    /// Common part of it (s).
    pub common: Option<f64>,
    /// Random part of it (s).
    pub random: Option<f64>,
    /// Median expanded uncertainty (k = 2) of a solved reading (s), see [`super::median`].
    pub median_expanded_uncertainty: Option<f64>,
    /// Derivatives of the mean with respect to all columns.
    pub sensitivity: DVector<f64>,
    /// Arm angles at which it does not show its delay.
    pub blind_ranges: Vec<BlindRange>,
}

/// What came of the readings of one campaign.
#[derive(Clone, Debug)]
pub struct Delays {
    /// One for each measurand that has a delay of its own reading by reading.
    pub measurands: Vec<Summary>,
    /// Measurands left out, with the reason.
    pub left_out: Vec<(String, String)>,
}

/// Solves every reading of a campaign for its delay; `given` says at which point and how far.
///
/// `runs` are the runs to use. `visit` sees every reading once: measurand by measurand, run by run,
/// in the order of samples.
///
/// # Errors
/// The first that `visit` gives; nothing more is solved then.
pub fn each<E>(
    given: &Given<'_>,
    part: usize,
    runs: &[usize],
    visit: &mut dyn FnMut(&ReadingDelay) -> Result<(), E>,
) -> Result<Delays, E> {
    summarised(
        given,
        part,
        runs,
        |found| found,
        |all| all.each().try_for_each(|reading| visit(&reading)),
    )
}

/// The same without looking at each reading.
///
/// `range` (s) is the farthest delay looked for.
pub fn delays(
    problem: &Problem,
    part: usize,
    runs: &[usize],
    point: &Point,
    covariance: &DMatrix<f64>,
    range: f64,
) -> Delays {
    let given = Given { problem, point, covariance, range };
    let Ok(all) = summarised(&given, part, runs, |_| (), |()| Ok::<_, Infallible>(()));
    all
}

/// Sums up the delays of all readings; `kept` is what is wanted of those of a block, and `visit`
/// sees it, block by block.
fn summarised<K: Send, E>(
    given: &Given<'_>,
    part: usize,
    runs: &[usize],
    kept: impl Fn(Solved) -> K + Sync,
    mut visit: impl FnMut(K) -> Result<(), E>,
) -> Result<Delays, E> {
    let (problem, covariance) = (given.problem, given.covariance);
    let data = &problem.parts[part];
    let mut all = Delays { measurands: Vec::new(), left_out: Vec::new() };
    let touched = |run| problem.layout.columns.touched_by(problem.run_index(part, run));
    let columns: Vec<Vec<usize>> = (0..data.runs.len()).map(touched).collect();
    for (measurand, declared) in data.system.assembly.names.measurands.iter().enumerate() {
        if declared.kind == MeasurandKind::Rotation {
            let why =
                "a rotation has three components and no single delay; the joint estimate has it";
            all.left_out.push((declared.name.clone(), why.to_owned()));
            continue;
        }
        let mut tally = Tally::new(covariance.nrows());
        let mut sight = Sight::new(data);
        let input = sight.input();
        let look = |run: usize, found: Solved| {
            let angles = seen(input, &data.runs[run], &found);
            (Sums::of(&found), angles, kept(found))
        };
        each_delay(given, part, runs, measurand, look, |run, (sums, angles, kept)| {
            tally.add(&columns[run], &sums);
            sight.see(data.runs[run].setup, &angles);
            visit(kept)
        })?;
        let mut summary = tally.summary(declared.name.clone(), covariance);
        summary.blind_ranges = sight.ranges(data);
        all.measurands.push(summary);
    }
    Ok(all)
}

/// Sums over the readings of a block.
#[derive(Debug, Default)]
struct Sums {
    /// Solved, blind, failed.
    counts: [usize; 3],
    weights: f64,
    weighted: f64,
    variance: f64,
    /// `Σ w dt/dθ` over the columns that the run touches.
    sensitivity: DVector<f64>,
    /// Expanded uncertainties of the solved ones (s).
    expanded: Vec<f64>,
}

impl Sums {
    fn of(found: &Solved) -> Self {
        let sensitivity = found.weighted_sensitivity.clone();
        let mut sums = Self { sensitivity, ..Self::default() };
        for reading in found.each() {
            let place = match reading.state {
                State::Solved => 0,
                State::Blind => 1,
                State::Failed => 2,
            };
            sums.counts[place] += 1;
            if reading.state == State::Solved {
                let weight = reading.random_at_reference.powi(-2);
                sums.variance += (weight * reading.random).powi(2);
                sums.weights += weight;
                sums.weighted += weight * reading.delay;
                sums.expanded.push(reading.expanded_uncertainty());
            }
        }
        sums
    }
}

/// What is known of the readings of one measurand.
#[derive(Default)]
struct Tally {
    counts: [usize; 3],
    weights: f64,
    weighted: f64,
    variance: f64,
    /// `Σ w dt/dθ` over all columns.
    sensitivity: DVector<f64>,
    expanded: Median,
}

impl Tally {
    fn new(columns: usize) -> Self {
        Self { sensitivity: DVector::zeros(columns), ..Self::default() }
    }

    /// Adds readings of a run that touches these columns.
    fn add(&mut self, columns: &[usize], sums: &Sums) {
        self.counts.iter_mut().zip(sums.counts).for_each(|(all, more)| *all += more);
        self.weights += sums.weights;
        self.weighted += sums.weighted;
        self.variance += sums.variance;
        self.expanded.see_all(&sums.expanded);
        for (column, value) in columns.iter().zip(sums.sensitivity.iter()) {
            self.sensitivity[*column] += value;
        }
    }

    fn summary(self, measurand: String, covariance: &DMatrix<f64>) -> Summary {
        let [solved, blind, failed] = self.counts;
        let any = self.weights > 0.0;
        let mean_sensitivity = self.sensitivity / if any { self.weights } else { 1.0 };
        let common =
            (mean_sensitivity.transpose() * covariance * &mean_sensitivity)[(0, 0)].max(0.0).sqrt();
        let random = self.variance.sqrt() / self.weights;
        Summary {
            measurand,
            readings: solved + blind + failed,
            solved,
            blind,
            failed,
            mean: any.then(|| self.weighted / self.weights),
            sigma_of_mean: any.then(|| common.hypot(random)),
            common: any.then_some(common),
            random: any.then_some(random),
            median_expanded_uncertainty: self.expanded.value(),
            sensitivity: mean_sensitivity,
            blind_ranges: Vec::new(),
        }
    }
}
