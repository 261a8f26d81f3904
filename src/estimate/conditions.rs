//! Self-calibration: each delay under reversed rotation, other rates and other distances.
//!
//! Depenthal 2009, section 4: delays were "derived by self-calibrating methods, such as changing
//! the rotation direction of the rotating arm and/or varying the test item distance", to separate
//! the rig from the instrument. Each kinematic run has its mean delay for each measurand; runs that
//! differ in one thing only are compared, with everything they share (the transformation) in the
//! uncertainty of the difference. An angle α by which the rig is wrong acts as a delay `α / ω`: it
//! changes sign with the direction of rotation; a delay of the instrument stays. The split
//! `τ + α / ω` estimates both.
//!
//! Readings that scatter more than stated widen a run's random part by √(χ² / (n - 1)).

use std::convert::Infallible;

use nalgebra::{DMatrix, DVector, Matrix2, Vector2};
use statrs::function::erf::erfc;

use crate::engine::Part;
use crate::estimate::delays::Delays;
use crate::estimate::head::arm_rate;
use crate::estimate::newton::State;
use crate::estimate::transformation::Transformation;

/// The input that is the platform's angle, in every model that has one.
const PLATFORM_ANGLE: &str = "platform_angle";
/// Rates count as the same if they differ by less than this part.
const SAME_RATE: f64 = 0.05;
/// Probability of a false alarm, split over the contrasts of one measurand and kind.
pub const LEVEL: f64 = 0.01;

/// The mean delay of one measurand in one run.
#[derive(Clone, Debug)]
pub struct Condition {
    /// The run.
    pub run: usize,
    /// Its setup.
    pub setup: usize,
    /// Rate of the arm (rad/s), its sense in the sign.
    pub rate: f64,
    /// Rate of the platform under the instrument (rad/s); zero without.
    pub platform_rate: f64,
    /// The measurand.
    pub measurand: String,
    /// Mean delay (s).
    pub mean: f64,
    /// Random part of its standard uncertainty (s).
    pub random: f64,
    /// Standard uncertainty (s).
    pub sigma: f64,
    sensitivity: DVector<f64>,
}

/// The one thing in which two runs differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Changed {
    /// The sense of rotation.
    Direction,
    /// The rate.
    Rate,
    /// The rate of the platform, its sense in it.
    Platform,
    /// The setup: distance and pose of the instrument.
    Setup,
}

impl Changed {
    /// The word programs read.
    pub fn word(self) -> &'static str {
        match self {
            Self::Direction => "direction",
            Self::Rate => "rate",
            Self::Platform => "platform",
            Self::Setup => "setup",
        }
    }
}

/// The difference of a delay between two runs that differ in one thing.
#[derive(Clone, Debug)]
pub struct Contrast {
    /// The measurand.
    pub measurand: String,
    /// What differs.
    pub changed: Changed,
    /// The two runs; the difference is the first less the second.
    pub runs: [usize; 2],
    /// Difference (s).
    pub difference: f64,
    /// Its standard uncertainty (s).
    pub sigma: f64,
}

impl Contrast {
    /// Probability of a difference as large by chance.
    pub fn probability(&self) -> f64 {
        erfc((self.difference / self.sigma).abs() / std::f64::consts::SQRT_2)
    }
}

/// A delay that stays and an angle that turns with the arm.
#[derive(Clone, Debug)]
pub struct Split {
    /// The measurand.
    pub measurand: String,
    /// Delay (s), of the instrument.
    pub delay: f64,
    /// Its standard uncertainty (s).
    pub delay_sigma: f64,
    /// Angle (rad), of the rig.
    pub angle: f64,
    /// Its standard uncertainty (rad).
    pub angle_sigma: f64,
    /// χ² of what is left over.
    pub chi_squared: f64,
    /// Its degrees of freedom.
    pub degrees_of_freedom: usize,
}

/// What runs under changed conditions say of each delay.
#[derive(Clone, Debug, Default)]
pub struct SelfCalibration {
    /// One for each run and measurand.
    pub conditions: Vec<Condition>,
    /// One for each pair of runs that differ in one thing.
    pub contrasts: Vec<Contrast>,
    /// One for each measurand with runs of both directions.
    pub splits: Vec<Split>,
}

/// Compares the kinematic runs of a campaign. Empty where the target does not move on a circle.
pub fn self_calibration(given: &Transformation, part: usize) -> SelfCalibration {
    let data = &given.problem.parts[part];
    let mut conditions = Vec::new();
    for run in given.wanted(part) {
        let Some(rate) = arm_rate(&given.problem, part, run, &given.point) else { continue };
        let (solved, widening) = solved_with_scatter(given, part, run);
        for one in &solved.measurands {
            let setup = data.runs[run].setup;
            let names = &data.system.assembly.names.measurands;
            let index = names.iter().position(|declared| declared.name == one.measurand);
            let widening = index.map_or(1.0, |measurand| widening[measurand]);
            let (Some(mean), Some(random), Some(common)) = (one.mean, one.random, one.common)
            else {
                continue;
            };
            let random = random * widening;
            conditions.push(Condition {
                run,
                setup,
                rate,
                platform_rate: platform_rate(data, run),
                measurand: one.measurand.clone(),
                mean,
                random,
                sigma: random.hypot(common),
                sensitivity: one.sensitivity.clone(),
            });
        }
    }
    let names: Vec<String> = data
        .system
        .assembly
        .names
        .measurands
        .iter()
        .map(|measurand| measurand.name.clone())
        .filter(|name| conditions.iter().any(|one| one.measurand == *name))
        .collect();
    let mut whole = SelfCalibration::default();
    for name in &names {
        let own: Vec<&Condition> = conditions.iter().filter(|one| one.measurand == *name).collect();
        whole.contrasts.extend(contrasts(&own, &given.covariance));
        whole.splits.extend(split(&own, &given.covariance));
    }
    whole.conditions = conditions;
    whole
}

/// The delays of a run, and how much more the readings of each measurand scatter than stated; at
/// least 1.
fn solved_with_scatter(given: &Transformation, part: usize, run: usize) -> (Delays, Vec<f64>) {
    let count = given.problem.parts[part].slots().len();
    // Number, Σ w, Σ w τ, Σ w τ² of each measurand.
    let mut sums = vec![[0.0; 4]; count];
    let Ok(solved) = given.each_delay(part, &[run], &mut |one| {
        if one.state == State::Solved {
            let weight = one.random_at_reference.powi(-2);
            let new = [1.0, weight, weight * one.delay, weight * one.delay.powi(2)];
            sums[one.measurand].iter_mut().zip(new).for_each(|(sum, new)| *sum += new);
        }
        Ok::<_, Infallible>(())
    });
    let widening = sums.iter().map(|[n, weight, first, second]| {
        let squares = second - first * first / weight.max(f64::MIN_POSITIVE);
        (squares / (n - 1.0).max(1.0)).max(1.0).sqrt()
    });
    (solved, widening.collect())
}

/// Pairs of runs that differ in one thing.
fn contrasts(own: &[&Condition], covariance: &DMatrix<f64>) -> Vec<Contrast> {
    let mut found = Vec::new();
    for (i, a) in own.iter().enumerate() {
        for b in &own[i + 1..] {
            let Some(changed) = changed(a, b) else { continue };
            let shared = &a.sensitivity - &b.sensitivity;
            let common = (shared.transpose() * covariance * &shared)[(0, 0)].max(0.0);
            found.push(Contrast {
                measurand: a.measurand.clone(),
                changed,
                runs: [a.run, b.run],
                difference: a.mean - b.mean,
                sigma: (common + a.random.powi(2) + b.random.powi(2)).sqrt(),
            });
        }
    }
    found
}

fn changed(a: &Condition, b: &Condition) -> Option<Changed> {
    let same_rate = (a.rate.abs() - b.rate.abs()).abs() <= SAME_RATE * a.rate.abs();
    let same_sense = a.rate * b.rate > 0.0;
    let apart = (a.platform_rate - b.platform_rate).abs();
    let same_platform = apart <= SAME_RATE * a.platform_rate.abs();
    match (a.setup == b.setup, same_sense, same_rate, same_platform) {
        (true, false, true, true) => Some(Changed::Direction),
        (true, true, false, true) => Some(Changed::Rate),
        (true, true, true, false) => Some(Changed::Platform),
        (false, true, true, true) => Some(Changed::Setup),
        _ => None,
    }
}

/// Mean rate of the platform in a run (rad/s); zero where it stands or there is none.
fn platform_rate(data: &Part, run: usize) -> f64 {
    let Some(input) = data.system.input(PLATFORM_ANGLE) else {
        return 0.0;
    };
    let samples = data.runs[run].record.whole();
    let (Some(last), Some(begin)) = (samples.len().checked_sub(1), samples.time.first()) else {
        return 0.0;
    };
    let at = |row: usize| -> f64 { samples.inputs[input].at(row, samples.time[row], 0.0, 0) };
    let turned = (at(last) - at(0)) / (samples.time[last] - begin);
    if turned.is_finite() { turned } else { 0.0 }
}

/// Generalised least squares of `τ + α / ω` through the runs' means.
fn split(own: &[&Condition], covariance: &DMatrix<f64>) -> Option<Split> {
    let both = [1.0, -1.0].iter().all(|sense| own.iter().any(|one| one.rate * sense > 0.0));
    if !both {
        return None;
    }
    let weight = joint_covariance(own, covariance).try_inverse()?;
    let row = |one: &Condition| Vector2::new(1.0, 1.0 / one.rate);
    let (mut normal, mut right, mut square) = (Matrix2::zeros(), Vector2::zeros(), 0.0);
    for (i, a) in own.iter().enumerate() {
        for (j, b) in own.iter().enumerate() {
            normal += row(a) * row(b).transpose() * weight[(i, j)];
            right += row(a) * (weight[(i, j)] * b.mean);
            square += a.mean * weight[(i, j)] * b.mean;
        }
    }
    let inverse = normal.try_inverse()?;
    let solved = inverse * right;
    let sigma = |k: usize| inverse[(k, k)].max(0.0).sqrt();
    Some(Split {
        measurand: own.first()?.measurand.clone(),
        delay: solved.x,
        delay_sigma: sigma(0),
        angle: solved.y,
        angle_sigma: sigma(1),
        chi_squared: (square - right.dot(&solved)).max(0.0),
        degrees_of_freedom: own.len().saturating_sub(2),
    })
}

/// Covariance of the runs' means: what they share, and what is their own.
fn joint_covariance(own: &[&Condition], covariance: &DMatrix<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(own.len(), own.len(), |i, j| {
        let shared = (own[i].sensitivity.transpose() * covariance * &own[j].sensitivity)[(0, 0)];
        shared + if i == j { own[i].random.powi(2) } else { 0.0 }
    })
}

impl SelfCalibration {
    /// What a measurand's contrasts of one kind come to: the largest one, and whether chance is no
    /// explanation; `None` where no two runs differ in this alone.
    pub fn judged(&self, measurand: &str, changed: Changed) -> Option<(&Contrast, bool)> {
        let own: Vec<&Contrast> = self
            .contrasts
            .iter()
            .filter(|one| one.measurand == measurand && one.changed == changed)
            .collect();
        let size = |one: &&Contrast| (one.difference / one.sigma).abs();
        let largest = *own.iter().max_by(|a, b| size(a).total_cmp(&size(b)))?;
        Some((largest, largest.probability() < LEVEL / own.len() as f64))
    }

    /// The same in words, one sentence a finding.
    pub fn words(&self) -> Vec<String> {
        let mut words = Vec::new();
        let mut measurands: Vec<&str> = Vec::new();
        for one in &self.conditions {
            if !measurands.contains(&one.measurand.as_str()) {
                measurands.push(&one.measurand);
            }
        }
        for measurand in measurands {
            let kinds = [Changed::Direction, Changed::Rate, Changed::Setup, Changed::Platform];
            let told =
                kinds.map(|changed| self.judged(measurand, changed).map(|(_, differs)| differs));
            // What stays does so within what the best pair of runs could have shown.
            let within = |changed| {
                let sigmas = self
                    .contrasts
                    .iter()
                    .filter(|one| one.measurand == measurand && one.changed == changed);
                let least = sigmas.map(|one| 2e6 * one.sigma).fold(f64::INFINITY, f64::min);
                format!("to within {least:.*} µs (k = 2)", if least < 10.0 { 1 } else { 0 })
            };
            let mut say = |text: &str| words.push(format!("`{measurand}` {text}"));
            match told[0] {
                Some(true) => say(
                    "changes with the sense of rotation: something turns with the arm, which belongs to the rig (homepoint, encoder, runout, transformation)",
                ),
                Some(false) => say(&format!(
                    "stays when the arm turns the other way, {}: its delay belongs to the instrument",
                    within(Changed::Direction)
                )),
                None => say(
                    "was not read in both senses at one rate: rig and instrument are not told apart; add a run the other way",
                ),
            }
            if told[1] == Some(true) {
                say(match told[0] {
                    Some(true) => {
                        "changes with the rate, as an angle that turns with the arm does, too"
                    }
                    _ => {
                        "changes with the rate: the instrument's delay depends on how fast it moves"
                    }
                });
            }
            match told[2] {
                Some(true) => say(
                    "changes with the setup: it hangs on distance or pose, so on the transformation or on how the instrument sees the arm",
                ),
                Some(false) => {
                    say(&format!("stays when the distance changes, {}", within(Changed::Setup)));
                }
                None => {}
            }
            match told[3] {
                Some(true) => say(
                    "changes with the platform's rate: something turns with the platform, or the delay depends on how fast the head moves",
                ),
                Some(false) => say(&format!(
                    "stays when the platform turns at another rate, {}",
                    within(Changed::Platform)
                )),
                None => {}
            }
        }
        words
    }
}
