//! The delays of all readings and their mean for each measurand, and their comparison with the
//! joint estimate.
//!
//! Weights follow the random part of each reading's uncertainty, with the slope at the reference
//! time: a weight that knew the reading's own error would bias the mean. The common part (the
//! transformation and whatever else the readings share) does not shrink with their number:
//! `u(mean)² = s̄ Σ s̄ᵀ + Σ w² u_random² / (Σ w)²` with the weighted mean sensitivity `s̄`.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::engine::Point;
use crate::engine::problem::Problem;
use crate::estimate::newton::{Given, ReadingDelay, RunDelays, State, delays_of_run};
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
    /// Median expanded uncertainty (k = 2) of a solved reading (s).
    pub median_expanded_uncertainty: Option<f64>,
    /// Derivatives of the mean with respect to all columns.
    pub sensitivity: DVector<f64>,
}

/// All readings of one campaign with their delays.
#[derive(Clone, Debug)]
pub struct Delays {
    /// One for each measurand that has a delay of its own reading by reading.
    pub measurands: Vec<Summary>,
    /// One for each reading.
    pub readings: Vec<ReadingDelay>,
    /// Measurands left out, with the reason.
    pub left_out: Vec<(String, String)>,
}

/// Solves every reading of a campaign for its delay.
///
/// `runs` are the runs to use; `range` (s) is the farthest delay looked for.
pub fn delays(
    problem: &Problem,
    part: usize,
    runs: &[usize],
    point: &Point,
    covariance: &DMatrix<f64>,
    range: f64,
) -> Delays {
    let given = Given { problem, point, covariance, range };
    let data = &problem.parts[part];
    let mut all = Delays { measurands: Vec::new(), readings: Vec::new(), left_out: Vec::new() };
    for (measurand, declared) in data.system.assembly.names.measurands.iter().enumerate() {
        if declared.kind == MeasurandKind::Rotation {
            let why =
                "a rotation has three components and no single delay; the joint estimate has it";
            all.left_out.push((declared.name.clone(), why.to_owned()));
            continue;
        }
        let found: Vec<RunDelays> =
            runs.par_iter().map(|run| delays_of_run(&given, part, *run, measurand)).collect();
        let indices = runs.iter().map(|run| problem.run_index(part, *run));
        let columns: Vec<Vec<usize>> =
            indices.map(|run| problem.layout.columns.touched_by(run)).collect();
        all.measurands.push(summarise(declared.name.clone(), &columns, &found, covariance));
        all.readings.extend(found.into_iter().flat_map(|run| run.readings));
    }
    all
}

/// What came of one measurand; `columns` are those that each run touches.
fn summarise(
    measurand: String,
    columns: &[Vec<usize>],
    found: &[RunDelays],
    covariance: &DMatrix<f64>,
) -> Summary {
    let all = || found.iter().flat_map(|run| &run.readings);
    let count = |state| all().filter(|reading| reading.state == state).count();
    let mut mean_sensitivity = DVector::<f64>::zeros(covariance.nrows());
    let (mut weights, mut weighted, mut variance) = (0.0, 0.0, 0.0);
    let mut expanded = Vec::new();
    for reading in all().filter(|reading| reading.state == State::Solved) {
        let weight = reading.random_at_reference.powi(-2);
        variance += (weight * reading.random).powi(2);
        weights += weight;
        weighted += weight * reading.delay;
        expanded.push(reading.expanded_uncertainty());
    }
    for (columns, run) in columns.iter().zip(found) {
        for (column, value) in columns.iter().zip(run.weighted_sensitivity.iter()) {
            mean_sensitivity[*column] += value;
        }
    }
    let any = weights > 0.0;
    mean_sensitivity /= if any { weights } else { 1.0 };
    let common =
        (mean_sensitivity.transpose() * covariance * &mean_sensitivity)[(0, 0)].max(0.0).sqrt();
    let random = variance.sqrt() / weights;
    Summary {
        measurand,
        readings: all().count(),
        solved: count(State::Solved),
        blind: count(State::Blind),
        failed: count(State::Failed),
        mean: any.then(|| weighted / weights),
        sigma_of_mean: any.then(|| common.hypot(random)),
        common: any.then_some(common),
        random: any.then_some(random),
        median_expanded_uncertainty: median(&mut expanded),
        sensitivity: mean_sensitivity,
    }
}

fn median(values: &mut [f64]) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.len() {
        0 => None,
        n if n % 2 == 1 => Some(values[middle]),
        _ => Some(0.5 * (values[middle - 1] + values[middle])),
    }
}
