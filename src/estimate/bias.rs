//! What the paper's transformation does to delays: the bias `-τ ω_slow / ω`, run by run.
//!
//! A slow run taken as if nothing were delayed is turned about the arm axis by `ω_slow τ`; runs
//! that take its transformation find that angle missing. Two slow directions of equal length
//! cancel. With unlike delays the turn is some mean of theirs, so the expectation holds for like
//! delays only; what counts is the difference from the iterated way.

use crate::campaign::Role;
use crate::estimate::deviations::deviations;
use crate::estimate::transformation::Transformation;

/// The bias of one measurand's mean delay in one run.
#[derive(Clone, Debug, PartialEq)]
pub struct Bias {
    /// The run.
    pub run: usize,
    /// The measurand.
    pub measurand: String,
    /// Mean delay with the paper's transformation (s).
    pub paper: f64,
    /// The same with the iterated one (s).
    pub iterated: f64,
    /// `-τ ω_slow / ω` (s); `None` where the target does not move on a circle.
    pub expected: Option<f64>,
}

/// The bias of the paper's way in each kinematic run.
pub fn bias(paper: &Transformation, iterated: &Transformation, part: usize) -> Vec<Bias> {
    let data = &iterated.problem.parts[part];
    let rates: Vec<Option<(f64, usize)>> = (0..data.runs.len())
        .map(|run| {
            let (_, found) = deviations(&iterated.problem, part, run, &iterated.point);
            found.ok().map(|found| (found.arm_rate, found.samples.len()))
        })
        .collect();
    // Mean rate of the slow runs of a setup, each sample counted.
    let slow = |setup: usize| {
        let own = (0..data.runs.len())
            .filter(|run| data.runs[*run].setup == setup)
            .filter(|run| data.runs[*run].role == Role::Reference)
            .filter_map(|run| rates[run]);
        let (sum, count) =
            own.fold((0.0, 0), |(sum, count), (rate, n)| (sum + rate * n as f64, count + n));
        (count > 0).then(|| sum / count as f64)
    };
    let mut found = Vec::new();
    for run in iterated.wanted(part) {
        let (by_paper, right) = (paper.means(part, &[run]), iterated.means(part, &[run]));
        for (a, b) in by_paper.measurands.iter().zip(&right.measurands) {
            if let (Some(paper), Some(iterated)) = (a.mean, b.mean) {
                let ratio = slow(data.runs[run].setup).zip(rates[run]);
                found.push(Bias {
                    run,
                    measurand: b.measurand.clone(),
                    paper,
                    iterated,
                    expected: ratio.map(|(slow, (fast, _))| -iterated * slow / fast),
                });
            }
        }
    }
    found
}
