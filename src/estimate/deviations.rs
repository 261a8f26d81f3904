//! The deviations of a run: how far the measured points lie from where the arm was, in two frames.
//!
//! Depenthal 2009, section 4, Figs. 5-8. In the *arm's frame* the points are carried back by the
//! transformation and compared with the arm itself: planar is along its axis, radial outwards,
//! tangential in the sense of growing arm angle, `r` times the difference of angles. In the
//! *circle's frame* they are compared with the circle fitted to the run: planar and radial need no
//! transformation at all, and tangential is free of the run's mean. Both are at the reference time,
//! so a delay τ shows as a tangential deviation `r ω τ`. A target that does not move on a circle
//! about the z-axis of its frame has no such deviations; it says so.

use std::f64::consts::TAU;

use crate::engine::Point;
use crate::engine::part::wrapped;
use crate::engine::problem::Problem;
use crate::estimate::align::Pair;
use crate::estimate::circle::{Circle, NoCircle};
use crate::estimate::head::{Head, ROUND, arm_rate, head};
use crate::estimate::start::numbered_pairs;
use crate::quaternion::Quaternion;

/// Planar, radial and tangential deviation (m).
pub type Triple = [f64; 3];

/// One sample's deviations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    /// The sample.
    pub sample: usize,
    /// Arm angle from the homepoint at the reference time, in [0, 2π).
    pub arm_angle: f64,
    /// In the arm's frame.
    pub arm: Triple,
    /// In the fitted circle's frame; NaN where no circle fits.
    pub circle: Triple,
    /// The point from the sample's readings, in the instrument's frame (m).
    pub point: [f64; 3],
}

/// What a deviation does over a run (m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Its mean.
    pub mean: f64,
    /// Its standard deviation.
    pub deviation: f64,
    /// Its smallest value.
    pub minimum: f64,
    /// Its largest value.
    pub maximum: f64,
}

/// Mean tangential deviation while an angle of the head grows, and while it falls: an effect that
/// follows the head's direction shows in their difference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ByDirection {
    /// The measurand.
    pub measurand: usize,
    /// While it grows (m).
    pub growing: f64,
    /// While it falls (m).
    pub falling: f64,
    /// Standard uncertainty of the difference (m), of white scatter.
    pub sigma: f64,
}

/// The deviations of one run.
#[derive(Clone, Debug)]
pub struct RunDeviations {
    /// The run.
    pub run: usize,
    /// One for each sample that has all its readings.
    pub samples: Vec<Deviation>,
    /// The circle fitted to its points, in the instrument's frame.
    pub circle: Result<Circle, NoCircle>,
    /// Radius of the arm (m).
    pub radius: f64,
    /// Mean rate of the arm (rad/s).
    pub arm_rate: f64,
    /// Planar, radial, tangential in the arm's frame.
    pub in_arm_frame: [Spread; 3],
    /// The same in the circle's frame.
    pub in_circle_frame: Option<[Spread; 3]>,
    /// Tangential deviations by the direction of each angle.
    pub by_direction: Vec<ByDirection>,
}

impl RunDeviations {
    /// The delay (s) that would give the mean tangential deviation; `None` where the arm stands.
    pub fn delay(&self) -> Option<f64> {
        let speed = self.radius * self.arm_rate;
        (speed != 0.0).then(|| self.in_arm_frame[2].mean / speed)
    }
}

/// Why a run has no deviations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoDeviations {
    /// The model has no coordinates.
    #[error("the model has no [coordinates], which give the target from a sample's readings")]
    NoCoordinates,
    /// No sample has all readings.
    #[error("no sample has all the readings that its coordinates need")]
    NoPoints,
    /// Not a circle.
    #[error("the target does not move on a circle about the z-axis of its frame")]
    NotACircle,
}

/// What a run shows at a point: its head's motion, and its deviations if it has any.
pub fn deviations(
    problem: &Problem,
    part: usize,
    run: usize,
    point: &Point,
) -> (Head, Result<RunDeviations, NoDeviations>) {
    let found = points(problem, part, run, point);
    let on_circle = found.is_ok();
    let head = head(problem, part, run, point, on_circle);
    let found = found.map(|found| {
        let mut found = found;
        found.by_direction = by_direction(&head, &found.samples);
        found.arm_rate = arm_rate(problem, part, run, point).unwrap_or(f64::NAN);
        found
    });
    (head, found)
}

fn points(
    problem: &Problem,
    part: usize,
    run: usize,
    point: &Point,
) -> Result<RunDeviations, NoDeviations> {
    let data = &problem.parts[part];
    let coordinates =
        data.system.assembly.coordinates.as_ref().ok_or(NoDeviations::NoCoordinates)?;
    let parameters = problem.parameters::<f64>(part, run, point);
    let pairs = numbered_pairs(data, &data.runs[run], &parameters, 1.0);
    let radius = circle_radius(&pairs)?;
    let [w, x, y, z] = parameters[coordinates.rotation];
    let rotation = Quaternion { w, v: [x, y, z] };
    let shift = parameters[coordinates.translation];
    let measured: Vec<[f64; 3]> = pairs.iter().map(|(_, pair)| pair.target).collect();
    let circle = Circle::fit(&measured, rotation.rotate([0.0, 0.0, 1.0]));
    let mut samples: Vec<Deviation> = pairs
        .iter()
        .map(|(sample, Pair { source, target, .. })| {
            let shifted = std::array::from_fn(|i| target[i] - shift[i]);
            let back = rotation.conjugate().rotate(shifted);
            let angle = source[1].atan2(source[0]);
            let ahead = wrapped(back[1].atan2(back[0]) - angle, TAU);
            let radial = back[0].hypot(back[1]) - source[0].hypot(source[1]);
            let arm = [back[2] - source[2], radial, radius * ahead];
            let circle = [f64::NAN; 3];
            Deviation {
                sample: *sample,
                arm_angle: angle.rem_euclid(TAU),
                arm,
                circle,
                point: *target,
            }
        })
        .collect();
    if let Ok(circle) = &circle {
        see(circle, &measured, &mut samples);
    }
    let channel = |of: fn(&Deviation) -> Triple| {
        std::array::from_fn(|k| spread(samples.iter().map(|one| of(one)[k])))
    };
    Ok(RunDeviations {
        run,
        radius,
        arm_rate: f64::NAN,
        in_arm_frame: channel(|one| one.arm),
        in_circle_frame: circle.is_ok().then(|| channel(|one| one.circle)),
        circle,
        by_direction: Vec::new(),
        samples,
    })
}

/// The deviations from a fitted circle; its angles start where they agree with the arm's on
/// average.
fn see(circle: &Circle, measured: &[[f64; 3]], samples: &mut [Deviation]) {
    let seen: Vec<_> = measured.iter().map(|point| circle.sees(*point)).collect();
    let ahead = |k: usize| seen[k].angle - samples[k].arm_angle;
    let (sine, cosine) = (0..seen.len())
        .map(|k| ahead(k).sin_cos())
        .fold((0.0, 0.0), |sum, one| (sum.0 + one.0, sum.1 + one.1));
    let mean = f64::atan2(sine, cosine);
    let off: Vec<f64> = (0..seen.len()).map(|k| wrapped(ahead(k) - mean, TAU)).collect();
    for ((sample, seen), off) in samples.iter_mut().zip(&seen).zip(off) {
        sample.circle = [seen.planar, seen.radial, circle.radius * off];
    }
}

/// The radius of the circle on which the target moves about the z-axis of its frame.
fn circle_radius(pairs: &[(usize, Pair)]) -> Result<f64, NoDeviations> {
    let (_, first) = pairs.first().ok_or(NoDeviations::NoPoints)?;
    let radius = first.source[0].hypot(first.source[1]);
    let round = pairs.iter().all(|(_, pair)| {
        let [x, y, z] = pair.source;
        let off = (x.hypot(y) - radius).abs().max((z - first.source[2]).abs());
        off <= ROUND * radius
    });
    if round && radius > 0.0 { Ok(radius) } else { Err(NoDeviations::NotACircle) }
}

/// Mean, deviation and ends of some values.
pub(crate) fn spread(values: impl Iterator<Item = f64> + Clone) -> Spread {
    let count = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / count;
    let squares: f64 = values.clone().map(|value| (value - mean).powi(2)).sum();
    Spread {
        mean,
        deviation: (squares / (count - 1.0).max(1.0)).sqrt(),
        minimum: values.clone().fold(f64::INFINITY, f64::min),
        maximum: values.fold(f64::NEG_INFINITY, f64::max),
    }
}

fn by_direction(head: &Head, samples: &[Deviation]) -> Vec<ByDirection> {
    let mean = |rates: &[f64], sense: f64| {
        let own = samples.iter().filter(move |one| rates[one.sample] * sense > 0.0);
        let own = own.map(|one| one.arm[2]);
        (own.clone().count(), spread(own))
    };
    head.angles
        .iter()
        .filter_map(|angle| {
            let (n, growing) = mean(&angle.rates, 1.0);
            let (m, falling) = mean(&angle.rates, -1.0);
            let part = |spread: Spread, count: usize| spread.deviation.powi(2) / count as f64;
            (n > 1 && m > 1).then(|| ByDirection {
                measurand: angle.measurand,
                growing: growing.mean,
                falling: falling.mean,
                sigma: (part(growing, n) + part(falling, m)).sqrt(),
            })
        })
        .collect()
}
