//! Bias of estimates by the smoothing of streams.
//!
//! A parameter that multiplies a rate or an acceleration of a noisy stream has an error in its
//! variable: the estimate is too small, however many readings there are, and no weight mends that. With
//! as much noise again it moves by about as much again (simulation and linear extrapolation, Cook and
//! Stefanski 1994). Smoothing takes something off the motion, too; once more, nearly as much again. The
//! first order is all that is found: where an estimate has lost half of its size, the bias is larger than
//! found. It corrects nothing, and does not look at rotations.

use std::collections::BTreeMap;

use nalgebra::DVector;

use crate::engine::Problem;
use crate::engine::gram::LeastSquares;
use crate::estimate::arrow::normal_matrix;
use crate::estimate::calibrate::{Calibration, Estimate};
use crate::estimate::inverse_factor::Factor;
use crate::graph::Kind;

/// Standard uncertainties of an estimate from which its bias is reported.
const LEAST: f64 = 1.0;

/// An estimate with its bias.
#[derive(Clone, Debug)]
pub struct StreamBias {
    /// The estimate.
    pub estimate: Estimate,
    /// By how much it is off (SI), about.
    pub bias: f64,
    /// What makes it so.
    pub by: Cause,
}

/// What of a stream biases an estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// The noise that smoothing leaves in it.
    Noise,
    /// What smoothing takes off the motion.
    Smoothing,
}

/// The estimates that either moves by a standard uncertainty and more, in their order. Where noise does,
/// smoothing once more takes mostly noise off, and little of the motion.
pub fn stream_biases(result: &Calibration) -> Vec<StreamBias> {
    let Calibration { problem, fit, .. } = result;
    if !fit.outcome.is_result() {
        return Vec::new();
    }
    let step = |problem: &Problem| {
        let (hessian, score) = normal_matrix(&problem.normal(&fit.point)).ok()?;
        let is_sound = hessian.iter().chain(score.iter()).all(|value| value.is_finite());
        let factor = is_sound.then(|| Factor::of(&hessian))?;
        Some(factor.values(&factor.half(&score)))
    };
    let steps = || {
        let [one, other] = problem.with_noisier_streams()?;
        // At a bound, or near a jump, there is a step without any change, too.
        let without = step(problem)?;
        // With the noise the other way round, so that what is odd in it cancels.
        let by_noise = 0.5 * (step(&one)? + step(&other)?) - &without;
        Some([by_noise, step(&problem.with_streams_smoothed_again()?)? - without])
    };
    let Some(steps) = steps() else { return Vec::new() };
    let mut component: BTreeMap<usize, usize> = BTreeMap::new();
    let biased = |estimate: Estimate| {
        let instance = estimate.instance?;
        let k = component.entry(instance).or_default();
        let columns = problem.layout.columns_of(instance, *k);
        *k += 1;
        let moved =
            |step: &DVector<f64>| columns.iter().map(|(at, by)| by * step[*at]).sum::<f64>();
        let [of_noise, of_smoothing] = steps.each_ref().map(moved);
        let least = LEAST * estimate.sigma.filter(|sigma| *sigma > 0.0)?;
        let is_of_noise = of_noise.abs() >= least;
        let by = if is_of_noise { Cause::Noise } else { Cause::Smoothing };
        let bias = if is_of_noise { of_noise } else { of_smoothing };
        // Components of a rotation are no steps of its tangent space.
        let is_plain = problem.layout.instances[instance].kind != Kind::Rotation;
        (is_plain && estimate.value.is_some() && bias.abs() >= least).then_some(StreamBias {
            estimate,
            bias,
            by,
        })
    };
    result.estimates().into_iter().filter_map(biased).collect()
}
