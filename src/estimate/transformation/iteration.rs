//! Transformation and delays in turn, until they agree, and what that does to errors.
//!
//! From the second round on the answer of the delays to themselves is known and taken into the step
//! (Newton's iteration on `D(θ(τ)) - τ`): a handful of fits instead of dozens where the slow run is
//! not slow.
//!
//! With the delays τ held, the reference runs give the transformation θ(τ), and the other runs the
//! mean delays D(θ). At the end `τ = D(θ(τ))`. Let B = ∂θ/∂τ, S = ∂D/∂θ, A = S B, and G = (1 -
//! A)⁻¹, about 1 / (1 - ω_slow / ω). With Σ the covariance of θ at held delays, and R that of the
//! random part of D, what was wrong by δθ and r is in the end wrong by
//!
//! ```text
//! δτ = G (S δθ + r)        δθ_end = (1 + B G S) δθ + B G r
//! ```
//!
//! so the transformation at the end has the covariance `F Σ Fᵀ + B G R Gᵀ Bᵀ` with F = 1 + B G S,
//! which delays of single readings and means take like any other. A mean has its own r in it once
//! more: the transformation that it used was made with it. That cross term is counted for means (of
//! some runs with the random part of all, which is what both have in common where weights are
//! `1 / u²`); for a single reading it is left out, a share of about `2 ω_slow / ω` over their
//! number.

use nalgebra::{DMatrix, DVector};

use crate::engine::Problem;
use crate::estimate::delays::{Delays, Summary};
use crate::estimate::transformation::held::Held;
use crate::estimate::transformation::{NoTransformation, Transformation, wanted};

/// Rounds of the iteration before giving up.
const ROUNDS: usize = 30;
/// Errors that grow by more leave nothing to say.
const MOST_GROWTH: f64 = 1e3;
/// Means that change by less than this part of their random uncertainty stand: a fit stops at some
/// part of it, too, and with less two fits could take turns for ever.
const STANDS: f64 = 1e-5;
/// Nor do changes below this (s) matter.
const LEAST: f64 = 1e-13;
/// Change of a delay (s) from which derivatives are found.
const TRIAL: f64 = 1e-6;

/// What the iteration does to errors.
#[derive(Clone, Debug)]
pub(super) struct Gain {
    /// For each delay parameter the measurands that it is the delay of.
    measurands: Vec<Vec<usize>>,
    /// `B G`: what errors of the delays do to the transformation in the end.
    response: DMatrix<f64>,
    /// `F = 1 + B G S`.
    carries: DMatrix<f64>,
    /// R, a diagonal: the random part of the means' variances.
    random: DVector<f64>,
}

/// Transformation and delays in turn.
pub(super) fn iterated(
    problem: &Problem,
    levels: Option<&Problem>,
    part: usize,
) -> Result<Transformation, NoTransformation> {
    let mut fits = Held::new(problem, levels, part)?;
    let runs = wanted(problem, part);
    let declared = &problem.parts[part].system.declared;
    let measurands: Vec<Vec<usize>> =
        fits.delays.iter().map(|parameter| declared[*parameter].delay_of.clone()).collect();
    let names = &problem.parts[part].system.assembly.names.measurands;
    let mut found = |values: &[f64]| -> Result<(Transformation, Vec<Means>), NoTransformation> {
        let given = fits.fit(values)?;
        let solved = given.means(part, &runs).measurands;
        let of =
            |own: &Vec<usize>| Means::of(own.iter().filter_map(|m| summary(&solved, names, *m)));
        Ok((given, measurands.iter().map(of).collect()))
    };
    let mut held = vec![0.0; measurands.len()];
    let mut linear: Option<Linear> = None;
    for round in 1..=ROUNDS {
        let (mut given, means) = found(&held)?;
        let stands = |(before, after): (&f64, &Means)| {
            (before - after.value).abs() <= (STANDS * after.random.sqrt()).max(LEAST)
        };
        let is_settled = held.iter().zip(&means).all(stands);
        let change = DVector::from_iterator(
            held.len(),
            held.iter().zip(&means).map(|(before, after)| after.value - before),
        );
        let Some(known) = &linear else {
            // The first step is the plain one; what is near its end is near enough for derivatives.
            held.iter_mut().zip(&change).for_each(|(held, change)| *held += change);
            linear = Some(Linear::at(&held, &mut found)?);
            continue;
        };
        if is_settled {
            let random = DVector::from_iterator(means.len(), means.iter().map(|one| one.random));
            let gain = Gain::new(known, measurands.clone(), random);
            let brought = &gain.response * DMatrix::from_diagonal(&gain.random);
            given.covariance =
                gain.carried(&given.covariance) + brought * gain.response.transpose();
            given.rounds = round;
            given.gain = Some(gain);
            return Ok(given);
        }
        let step = &known.growth * change;
        held.iter_mut().zip(&step).for_each(|(held, step)| *held += step);
    }
    Err(NoTransformation::NotConverged)
}

/// A fit at held delays, and the means that it gives.
type Found<'a> = dyn FnMut(&[f64]) -> Result<(Transformation, Vec<Means>), NoTransformation> + 'a;

/// What transformation and means answer to small changes of the delays held.
struct Linear {
    /// B.
    moved: DMatrix<f64>,
    /// S.
    slopes: DMatrix<f64>,
    /// G.
    growth: DMatrix<f64>,
}

impl Linear {
    fn at(held: &[f64], found: &mut Found<'_>) -> Result<Self, NoTransformation> {
        let (given, means) = found(held)?;
        let columns = given.covariance.nrows();
        let mut moved = DMatrix::zeros(columns, held.len());
        for column in 0..held.len() {
            let mut tried = held.to_vec();
            tried[column] += TRIAL;
            let (other, _) = found(&tried)?;
            let step = given.point.step_to(&given.problem.layout, &other.point);
            moved.set_column(column, &(step / TRIAL));
        }
        let mut slopes = DMatrix::zeros(held.len(), columns);
        for (row, mean) in means.iter().enumerate() {
            if mean.sensitivity.len() == columns {
                slopes.set_row(row, &mean.sensitivity.transpose());
            }
        }
        let own = DMatrix::identity(held.len(), held.len()) - &slopes * &moved;
        let growth = own.try_inverse().filter(|growth| growth.amax() < MOST_GROWTH);
        Ok(Self { moved, slopes, growth: growth.ok_or(NoTransformation::NotConverged)? })
    }
}

/// The mean of what the measurands of one delay say.
struct Means {
    value: f64,
    /// Variance of its random part (s²).
    random: f64,
    sensitivity: DVector<f64>,
}

impl Means {
    fn of<'a>(own: impl Iterator<Item = &'a Summary>) -> Self {
        let mut sum = Self { value: 0.0, random: 0.0, sensitivity: DVector::zeros(0) };
        let mut count = 0.0;
        for one in own {
            let Some((mean, random)) = one.mean.zip(one.random) else { continue };
            count += 1.0;
            sum.value += mean;
            sum.random += random * random;
            match sum.sensitivity.is_empty() {
                true => sum.sensitivity = one.sensitivity.clone(),
                false => sum.sensitivity += &one.sensitivity,
            }
        }
        let count = f64::max(count, 1.0);
        Self {
            value: sum.value / count,
            random: sum.random / (count * count),
            sensitivity: sum.sensitivity / count,
        }
    }
}

impl Gain {
    fn new(linear: &Linear, measurands: Vec<Vec<usize>>, random: DVector<f64>) -> Self {
        let Linear { moved, slopes, growth } = linear;
        let response = moved * growth;
        let columns = moved.nrows();
        let carries = DMatrix::identity(columns, columns) + &response * slopes;
        Self { measurands, response, carries, random }
    }

    /// A part of the covariance at held delays as it is in the end: `F Σ Fᵀ`.
    pub(super) fn carried(&self, covariance: &DMatrix<f64>) -> DMatrix<f64> {
        &self.carries * covariance * self.carries.transpose()
    }

    /// Counts in the means' random part what their own readings did to the transformation.
    pub(super) fn correlate(&self, found: &mut Delays, problem: &Problem, part: usize) {
        let names = &problem.parts[part].system.assembly.names.measurands;
        for one in &mut found.measurands {
            let place = |own: &Vec<usize>| own.iter().any(|m| names[*m].name == one.measurand);
            let Some(index) = self.measurands.iter().position(place) else { continue };
            let (Some(random), Some(common)) = (one.random, one.common) else { continue };
            let held = self.random[index];
            let cross = 2.0 * one.sensitivity.dot(&self.response.column(index)) * held;
            let random = (random * random + cross).max(0.0).sqrt();
            one.random = Some(random);
            one.sigma_of_mean = Some(common.hypot(random));
        }
    }
}

/// What came of a measurand.
fn summary<'a>(
    solved: &'a [Summary],
    names: &[crate::graph::Measurand],
    measurand: usize,
) -> Option<&'a Summary> {
    solved.iter().find(|one| one.measurand == names[measurand].name)
}
