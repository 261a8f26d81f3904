//! What the instrument's head must follow in a run: angular rates, the target's speed, and where on
//! the arm each angle reverses.
//!
//! Rates come from the model at the estimate, not from differences of readings: `dm/dt` of each
//! angle measurand while time runs on (see [`crate::engine::moving`]), the target's velocity from
//! `[coordinates]`. On the axis before a circle of radius r, at the distance a from its plane, the
//! horizontal angle turns at `r ω / a` at most, the vertical at `r ω / √(a² + r²)` (Depenthal 2009,
//! section 4). A reversal is a root of an angle's rate between two samples, found on the arm's
//! motion itself. Where the target does not move on a circle there are rates, but no arm angles.

use std::f64::consts::TAU;

use crate::campaign::{Sample, Samples};
use crate::engine::lanes::LANES;
use crate::engine::moving::MovingLeaves;
use crate::engine::part::SampleLeaves;
use crate::engine::pointwise::Program;
use crate::engine::problem::Problem;
use crate::engine::{Part, Point};
use crate::estimate::start::ENOUGH;
use crate::graph::{MeasurandKind, NodeId};
use crate::number::{Dual, Number, derivative};
use crate::quaternion::Quaternion;

/// Radius and height of a circle may change by this part of the radius.
pub(super) const ROUND: f64 = 1e-9;
/// Reversals nearer than this (rad) are the same place on the arm.
const SAME_PLACE: f64 = 0.1;
/// More places than this are no places: the angle reverses everywhere.
const MOST_PLACES: usize = 8;
/// Halvings that find a reversal within a step.
const HALVINGS: u32 = 40;

/// The largest size of something in a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Largest {
    /// Its size (SI).
    pub value: f64,
    /// Where.
    pub sample: usize,
}

/// A place on the arm where an angle reverses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reversal {
    /// Arm angle from the homepoint, in [0, 2π).
    pub arm_angle: f64,
    /// How often it was passed.
    pub count: usize,
    /// Whether the angle grows after it.
    pub grows_after: bool,
}

/// How an angle moves in a run.
#[derive(Clone, Debug)]
pub struct AngleMotion {
    /// The measurand.
    pub measurand: usize,
    /// Its rate (rad/s), one a sample.
    pub rates: Vec<f64>,
    /// The largest rate, whichever the sense.
    pub largest: Option<Largest>,
    /// Where it reverses; `None` where that is everywhere, or on no circle.
    pub reversals: Option<Vec<Reversal>>,
}

/// How head and target move in a run.
#[derive(Clone, Debug)]
pub struct Head {
    /// Each angle measurand.
    pub angles: Vec<AngleMotion>,
    /// Speed of the target (m/s), one a sample: whole, across the line of sight, along it.
    pub speeds: [Vec<f64>; 3],
    /// The largest of each.
    pub largest_speeds: [Option<Largest>; 3],
}

/// A run at some offset from the reference times of its samples.
struct Motion<'a> {
    part: &'a Part,
    samples: &'a Samples,
    parameters: Vec<[Dual; 4]>,
    randoms: Vec<Dual>,
    program: Program,
    angles: Vec<usize>,
}

impl Motion<'_> {
    /// All outputs of a sample, `offset` seconds after its reference time.
    fn at<'w>(&self, sample: usize, offset: f64, workspace: &'w mut Vec<Dual>) -> &'w [Dual] {
        let sample = SampleLeaves {
            parameters: &self.parameters,
            randoms: &self.randoms,
            columns: self.part.columns(),
            sample: Sample { samples: self.samples, at: sample, number: sample },
        };
        self.program.evaluate(&MovingLeaves::after(sample, offset), workspace)
    }

    /// The target in the rig's frame.
    fn target(&self, outputs: &[Dual]) -> Option<[Dual; 3]> {
        outputs.get(self.angles.len()..)?.first_chunk::<3>().copied()
    }

    /// Angle of the target about the arm's axis, in [0, 2π).
    fn arm_angle(&self, outputs: &[Dual]) -> f64 {
        let angle = self.target(outputs).map(|[x, y, _]| y.value().atan2(x.value()));
        angle.unwrap_or(f64::NAN).rem_euclid(TAU)
    }

    /// Where an angle's rate is zero between a sample and `step` seconds after it.
    fn root(&self, angle: usize, sample: usize, step: f64) -> (f64, f64) {
        let mut workspace = Vec::new();
        let mut rate = |offset| derivative(self.at(sample, offset, &mut workspace)[angle]);
        let (mut low, mut high) = (0.0, step);
        let grows = rate(low) < 0.0;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            *(if (rate(middle) < 0.0) == grows { &mut low } else { &mut high }) = middle;
        }
        let outputs = self.at(sample, low, &mut workspace);
        (self.arm_angle(outputs), if grows { 1.0 } else { -1.0 })
    }
}

/// How head and target move in a run at a point; `on_circle` if the target moves on one.
pub fn head(problem: &Problem, part: usize, run: usize, point: &Point, on_circle: bool) -> Head {
    let data = &problem.parts[part];
    let assembly = &data.system.assembly;
    let is_angle =
        |m: &usize| matches!(assembly.names.measurands[*m].kind, MeasurandKind::Angle { .. });
    let angles: Vec<usize> = (0..assembly.measurands.len()).filter(is_angle).collect();
    let mut outputs: Vec<NodeId> =
        angles.iter().flat_map(|m| assembly.measurands[*m].value.nodes()).copied().collect();
    outputs.extend(assembly.coordinates.iter().flat_map(|coordinates| coordinates.from));
    let motion = Motion {
        part: data,
        samples: data.runs[run].record.whole(),
        parameters: problem.parameters(part, run, point),
        randoms: vec![Dual::constant(0.0); data.random_sigma.len()],
        program: Program::new(&assembly.graph, &outputs),
        angles,
    };
    let count = data.runs[run].record.len();
    let mut rates: Vec<Vec<f64>> = vec![Vec::with_capacity(count); motion.angles.len()];
    let mut speeds: [Vec<f64>; 3] = Default::default();
    let mut workspace = Vec::new();
    for sample in 0..count {
        let outputs = motion.at(sample, 0.0, &mut workspace);
        for (rates, output) in rates.iter_mut().zip(outputs) {
            rates.push(derivative(*output));
        }
        if let (Some(target), Some(coordinates)) = (motion.target(outputs), &assembly.coordinates) {
            let [rotation, translation] = [coordinates.rotation, coordinates.translation]
                .map(|index| motion.parameters[index]);
            let found = speeds_of(target, rotation, translation);
            speeds.iter_mut().zip(found).for_each(|(speeds, one)| speeds.push(one));
        }
    }
    let angles = (0..motion.angles.len())
        .map(|index| AngleMotion {
            measurand: motion.angles[index],
            largest: largest(&rates[index]),
            reversals: on_circle.then(|| reversals(&motion, index, &rates[index])).flatten(),
            rates: std::mem::take(&mut rates[index]),
        })
        .collect();
    let largest_speeds = speeds.each_ref().map(|speeds| largest(speeds));
    Head { angles, speeds, largest_speeds }
}

/// Mean rate of the arm (rad/s) in a run, in the sense in which it turns; `None` where the target
/// does not move on a circle about the z-axis of its frame. Of a long run [`ENOUGH`] samples tell,
/// spread evenly.
pub fn arm_rate(problem: &Problem, part: usize, run: usize, point: &Point) -> Option<f64> {
    let data = &problem.parts[part];
    let assembly = &data.system.assembly;
    let program = Program::new(&assembly.graph, &assembly.coordinates.as_ref()?.from);
    let parameters: Vec<[Dual; 4]> = problem.parameters(part, run, point);
    let randoms = vec![Dual::constant(0.0); data.random_sigma.len()];
    let record = &data.runs[run].record;
    let share = ENOUGH as f64 / record.len().max(1) as f64;
    let (mut workspace, mut scratch) = (Vec::new(), Samples::default());
    let mut circle: Option<[f64; 2]> = None;
    let (mut count, mut turned, mut moved) = (0, 0.0, 0.0);
    for range in record.share(share, LANES) {
        for sample in record.stretch(range, &mut scratch).each() {
            let (parameters, randoms, columns) = (&parameters[..], &randoms[..], data.columns());
            let leaves = SampleLeaves { parameters, randoms, columns, sample };
            let out = program.evaluate(&MovingLeaves::after(leaves, 0.0), &mut workspace);
            let [x, y, z] = [out[0].value(), out[1].value(), out[2].value()];
            let radius = x.hypot(y);
            let rate = (x * derivative(out[1]) - y * derivative(out[0])) / (radius * radius);
            if !rate.is_finite() || !z.is_finite() {
                continue;
            }
            let [first, height] = *circle.get_or_insert([radius, z]);
            if (radius - first).abs().max((z - height).abs()) > ROUND * first {
                return None;
            }
            count += 1;
            turned += rate;
            moved += rate.abs();
        }
    }
    circle.map(|_| (moved / f64::from(count)).copysign(turned))
}

/// Speed of the target: whole, across the line of sight, along it.
fn speeds_of(target: [Dual; 3], rotation: [Dual; 4], translation: [Dual; 4]) -> [f64; 3] {
    let [w, x, y, z] = rotation;
    let turned = Quaternion { w, v: [x, y, z] }.rotate(target);
    let velocity = turned.map(derivative);
    let seen: [f64; 3] = std::array::from_fn(|i| turned[i].value() + translation[i].value());
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let speed = dot(velocity, velocity).sqrt();
    let distance = dot(seen, seen).sqrt();
    let along = if distance > 0.0 { dot(velocity, seen) / distance } else { 0.0 };
    [speed, (speed * speed - along * along).max(0.0).sqrt(), along.abs()]
}

fn largest(values: &[f64]) -> Option<Largest> {
    let sizes = values.iter().map(|value| value.abs()).enumerate();
    let best = sizes.filter(|(_, value)| value.is_finite()).max_by(|a, b| a.1.total_cmp(&b.1));
    best.map(|(sample, value)| Largest { value, sample })
}

/// The places where an angle reverses.
fn reversals(motion: &Motion<'_>, angle: usize, rates: &[f64]) -> Option<Vec<Reversal>> {
    let time = &motion.samples.time;
    let mut found: Vec<(f64, f64)> = Vec::new();
    for (sample, pair) in rates.windows(2).enumerate() {
        let step = time[sample + 1] - time[sample];
        // A zero rate at the second sample is found from there.
        if pair[0] * pair[1] < 0.0 || (pair[0] == 0.0 && pair[1] != 0.0 && sample > 0) {
            found.push(motion.root(angle, sample, step));
        }
    }
    let mut places = Vec::new();
    for sense in [1.0, -1.0] {
        let mut own: Vec<f64> =
            found.iter().filter(|one| one.1 == sense).map(|one| one.0).collect();
        own.sort_by(f64::total_cmp);
        for group in groups(&own) {
            let count = group.len();
            // Angles of a group are near each other; 0 and 2π are, too.
            let first = group[0];
            let mean =
                group.iter().map(|one| (one - first + TAU / 2.0).rem_euclid(TAU)).sum::<f64>()
                    / count as f64;
            let arm_angle = (first + mean - TAU / 2.0).rem_euclid(TAU);
            places.push(Reversal { arm_angle, count, grows_after: sense > 0.0 });
        }
    }
    places.sort_by(|a, b| a.arm_angle.total_cmp(&b.arm_angle));
    (places.len() <= MOST_PLACES).then_some(places)
}

/// Sorted angles in groups without gaps; the last and the first may be one.
fn groups(sorted: &[f64]) -> Vec<Vec<f64>> {
    let mut groups: Vec<Vec<f64>> = Vec::new();
    for angle in sorted {
        match groups.last_mut() {
            Some(group) if group.last().is_some_and(|last| angle - last < SAME_PLACE) => {
                group.push(*angle);
            }
            _ => groups.push(vec![*angle]),
        }
    }
    if groups.len() > 1 && sorted[0] + TAU - sorted[sorted.len() - 1] < SAME_PLACE {
        let last = groups.pop().unwrap_or_default();
        groups[0].extend(last);
    }
    groups
}
