//! Where a joint estimate starts: Horn's closed form on the target's coordinates.
//!
//! A model's `[coordinates]` gives the target in the rig's frame and, from one sample's readings,
//! in the instrument's frame; the rotation and translation between them follow without iteration.
//! Reference runs (slow or static) are used where a transformation has any. What a user stated
//! (`start`, `value`, `fixed`) is left alone, and the other half fitted to it. Long runs are looked
//! at in [`ENOUGH`] samples, spread evenly: a start need not be better.

use crate::campaign::{Role, Run, Samples};
use crate::engine::lanes::LANES;
use crate::engine::part::{Part, SampleLeaves};
use crate::engine::point::Point;
use crate::engine::pointwise::Program;
use crate::engine::problem::Problem;
use crate::estimate::align::{Alignment, Degenerate, Pair, align};
use crate::quaternion::Quaternion;

/// Samples that are enough for one transformation's start.
pub const ENOUGH: usize = 1 << 17;
/// Pairs that fix a transformation, at least.
const LEAST_PAIRS: usize = 3;

/// What became of one transformation's start.
#[derive(Clone, Debug)]
pub struct Aligned {
    /// The setup or run it holds for, if not for all.
    pub of: Option<String>,
    /// Horn's result, or why there is none.
    pub result: Result<Alignment, Degenerate>,
}

/// The coordinates of the target in every sample of a run, or of this share of it, that has all its
/// readings.
pub fn pairs(part: &Part, run: &Run, parameters: &[[f64; 4]], share: f64) -> Vec<Pair> {
    numbered_pairs(part, run, parameters, share).into_iter().map(|(_, pair)| pair).collect()
}

/// The same, each with the number of its sample.
pub fn numbered_pairs(
    part: &Part,
    run: &Run,
    parameters: &[[f64; 4]],
    share: f64,
) -> Vec<(usize, Pair)> {
    let mut pairs = Vec::new();
    let Some(coordinates) = &part.system.assembly.coordinates else { return pairs };
    let mut outputs = coordinates.from.to_vec();
    outputs.extend_from_slice(&coordinates.measured);
    let program = Program::new(&part.system.assembly.graph, &outputs);
    let randoms = vec![0.0; part.random_sigma.len()];
    let (mut workspace, mut scratch) = (Vec::new(), Samples::default());
    for range in run.record.share(share, LANES) {
        for sample in run.record.stretch(range, &mut scratch).each() {
            let (randoms, columns) = (&randoms[..], part.columns());
            let leaves = SampleLeaves { parameters, randoms, columns, sample };
            let out = program.evaluate(&leaves, &mut workspace);
            if out.iter().all(|value| value.is_finite()) {
                let (source, target) = ([out[0], out[1], out[2]], [out[3], out[4], out[5]]);
                pairs.push((sample.number, Pair { source, target, weight: 1.0 }));
            }
        }
    }
    pairs
}

/// The starting point of a problem.
pub fn start(problem: &Problem) -> (Point, Vec<Aligned>) {
    let mut point = Point::start(&problem.layout);
    let mut report = Vec::new();
    let mut done = Vec::new();
    for (p, part) in problem.parts.iter().enumerate() {
        let Some(coordinates) = &part.system.assembly.coordinates else { continue };
        for r in 0..part.runs.len() {
            let rotation = problem.layout.instance_in(p, r, coordinates.rotation);
            let translation = problem.layout.instance_in(p, r, coordinates.translation);
            let of_user = [rotation, translation].map(|index| stated(problem, index));
            if done.contains(&(rotation, translation)) || of_user == [true, true] {
                continue;
            }
            done.push((rotation, translation));
            let all = gather(problem, p, (rotation, translation), &point);
            let result = align(&all, false);
            if of_user[0] {
                let turn = Quaternion::from_components(point.values[rotation]);
                let moved = shift(&all, turn);
                place(problem, &mut point, translation, moved);
            } else if let Ok(alignment) = &result {
                let q = alignment.rotation;
                point.values[rotation] = [q.w, q.v[0], q.v[1], q.v[2]];
                if !of_user[1] {
                    place(problem, &mut point, translation, alignment.translation);
                }
            }
            report.push(Aligned { of: problem.layout.instances[rotation].of.clone(), result });
        }
    }
    point.enter_bounds(&problem.layout);
    (point, report)
}

/// Puts a translation where it was found to be, but for components of which the user said where.
fn place(problem: &Problem, point: &mut Point, index: usize, found: [f64; 3]) {
    let setting = &problem.layout.instances[index].setting;
    for (component, found) in found.into_iter().enumerate() {
        if !setting.is_placed(component) {
            point.values[index][component] = found;
        }
    }
}

/// Whether the user said what a part of the transformation is.
fn stated(problem: &Problem, index: usize) -> bool {
    let setting = &problem.layout.instances[index].setting;
    setting.fixed || setting.start.is_some() || setting.value.is_some()
}

/// The mean translation (m) that is left once points are turned.
fn shift(pairs: &[Pair], rotation: Quaternion<f64>) -> [f64; 3] {
    let count = pairs.len().max(1) as f64;
    let mut sum = [0.0; 3];
    for Pair { source, target, .. } in pairs {
        let turned = rotation.rotate(*source);
        for (axis, sum) in sum.iter_mut().enumerate() {
            *sum += (target[axis] - turned[axis]) / count;
        }
    }
    sum
}

/// Pairs of all runs that share a transformation: its reference runs, where they have enough, else
/// all of them.
fn gather(
    problem: &Problem,
    p: usize,
    (rotation, translation): (usize, usize),
    point: &Point,
) -> Vec<Pair> {
    let part = &problem.parts[p];
    let Some(coordinates) = &part.system.assembly.coordinates else { return Vec::new() };
    let sharing: Vec<usize> = (0..part.runs.len())
        .filter(|r| {
            problem.layout.instance_in(p, *r, coordinates.rotation) == rotation
                && problem.layout.instance_in(p, *r, coordinates.translation) == translation
        })
        .collect();
    let of = |runs: &[usize]| -> Vec<Pair> {
        let samples: usize = runs.iter().map(|r| part.runs[*r].record.len()).sum();
        let share = ENOUGH as f64 / samples.max(1) as f64;
        let own = |r: &usize| {
            let parameters = problem.parameters::<f64>(p, *r, point);
            pairs(part, &part.runs[*r], &parameters, share)
        };
        runs.iter().flat_map(own).collect()
    };
    let is_reference = |r: &&usize| part.runs[**r].role == Role::Reference;
    let reference: Vec<usize> = sharing.iter().filter(is_reference).copied().collect();
    let all = of(&reference);
    // Two points leave a turn about their line open.
    if all.len() < LEAST_PAIRS { of(&sharing) } else { all }
}
