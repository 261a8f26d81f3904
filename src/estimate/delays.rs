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
use crate::estimate::newton::{Given, ReadingDelay, State, delays_of_run};
use crate::graph::MeasurandKind;

/// A reading whose uncertainty exceeds the smallest of its run and measurand by this factor is blind.
pub const BLIND_RATIO: f64 = 10.0;

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
        let found: Vec<Vec<ReadingDelay>> = runs
            .par_iter()
            .map(|run| {
                let mut readings = delays_of_run(&given, part, *run, measurand);
                mark_blind(&mut readings);
                readings
            })
            .collect();
        all.measurands.push(summarise(problem, part, declared.name.clone(), &found, covariance));
        all.readings.extend(found.into_iter().flatten());
    }
    all
}

/// Marks the readings that see their delay far worse than the best of their run: by the slope at
/// the reference time, and by that at the solution.
fn mark_blind(readings: &mut [ReadingDelay]) {
    let best = readings.iter().map(|one| one.random_at_reference).fold(f64::INFINITY, f64::min);
    for reading in readings {
        let solved = reading.state == State::Solved;
        let here = if solved { reading.random } else { reading.random_at_reference };
        let worst = reading.random_at_reference.max(here);
        if !worst.is_finite() || worst > BLIND_RATIO * best {
            reading.state = State::Blind;
        }
    }
}

fn summarise(
    problem: &Problem,
    part: usize,
    measurand: String,
    found: &[Vec<ReadingDelay>],
    covariance: &DMatrix<f64>,
) -> Summary {
    let count = |state| found.iter().flatten().filter(|reading| reading.state == state).count();
    let mut mean_sensitivity = DVector::<f64>::zeros(problem.layout.columns.len());
    let (mut weights, mut weighted, mut variance) = (0.0, 0.0, 0.0);
    let mut expanded = Vec::new();
    for reading in found.iter().flatten().filter(|reading| reading.state == State::Solved) {
        let weight = reading.random_at_reference.powi(-2);
        variance += (weight * reading.random).powi(2);
        weights += weight;
        weighted += weight * reading.delay;
        expanded.push(reading.expanded_uncertainty());
        let touched = problem.layout.columns.touched_by(problem.run_index(part, reading.run));
        for (column, value) in touched.iter().zip(reading.sensitivity.iter()) {
            mean_sensitivity[*column] += weight * value;
        }
    }
    let any = weights > 0.0;
    mean_sensitivity /= if any { weights } else { 1.0 };
    let common =
        (mean_sensitivity.transpose() * covariance * &mean_sensitivity)[(0, 0)].max(0.0).sqrt();
    let random = variance.sqrt() / weights;
    Summary {
        measurand,
        readings: found.iter().map(Vec::len).sum(),
        solved: count(State::Solved),
        blind: count(State::Blind),
        failed: count(State::Failed),
        mean: any.then(|| weighted / weights),
        sigma_of_mean: any.then(|| common.hypot(random)),
        common: any.then_some(common),
        random: any.then_some(random),
        median_expanded_uncertainty: median(&mut expanded),
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
