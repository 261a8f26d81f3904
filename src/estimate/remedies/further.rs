//! Further runs that are not measured yet, made from those that are, and what they would say.
//!
//! Which ones there are follows from the model's own inputs: a motion the other way round or
//! slower; an attitude that is tilted (a ramp, a tilted rig, a hand that turns about another axis);
//! an input that is the same all along and could be another (a mass, a joint that was not moved).

use std::f64::consts::FRAC_PI_2;

use nalgebra::{DMatrix, DVector};

use crate::campaign::record::{Change, Record};
use crate::campaign::{Samples, Track};
use crate::engine::point::Point;
use crate::engine::problem::Problem;
use crate::estimate::eigen::least_squares;
use crate::estimate::observability::Direction;
use crate::estimate::remedies::Open;
use crate::estimate::remedies::tried::Tried;
use crate::quaternion::Quaternion;
use crate::units::Dimension;

/// Singular values of a run's own values below this part of all are none.
const RANK: f64 = 1e-12;
/// A useful run answers so many times more than all present ones do together.
const USEFUL: f64 = 1e4;
/// Samples of a run that is made with other inputs.
const SAMPLES: usize = 4096;
/// Angle (rad) by which an attitude is tilted, or a joint turned.
const TILT: f64 = 20.0 * FRAC_PI_2 / 90.0;
/// Part of its size by which any other input is changed.
const CHANGED: f64 = 0.5;

/// The run that answers most along a direction among those that are there, the other way round or
/// slower, in words; `None` where none answers enough, or where it was tried in vain.
pub(super) fn best_of_its_motion(
    open: &Open<'_>,
    direction: &Direction,
    tried: &Tried<'_>,
) -> Option<String> {
    let problem = open.problem;
    let mut step = vec![0.0; problem.layout.columns.len()];
    for (column, weight) in &direction.weights {
        step[*column] = *weight;
    }
    let now = response(open, &step);
    let mut best: Option<(f64, usize, DMatrix<f64>, String)> = None;
    for (p, part) in problem.parts.iter().enumerate() {
        for (r, run) in part.runs.iter().enumerate() {
            if !run.record.inputs().iter().any(Track::moves) {
                continue;
            }
            for (factor, how) in
                [(-1.0, "with the opposite sense of motion"), (0.1, "at a tenth of its rate")]
            {
                let record = run.record.changed(Change::Retimed(factor));
                let Some(sums) = sums_of(problem, open.point, (p, r), record) else { continue };
                let index = problem.run_index(p, r);
                let gain = along(&sums, &problem.layout.columns.touched_by(index), &step);
                let words = format!("measure one more run like `{}` {how}", run.name);
                if gain.is_finite() && best.as_ref().is_none_or(|known| gain > 1.1 * known.0) {
                    best = Some((gain, index, sums, words));
                }
            }
        }
    }
    let (gain, index, sums, words) = best?;
    let is_useful = gain > USEFUL * now.max(f64::MIN_POSITIVE) && gain > 0.0;
    (is_useful && tried.determined_by_run(index, &sums)).then_some(words)
}

/// Further runs with other inputs that determine a direction, in words: of each kind the first run
/// for which it does.
pub(super) fn others(open: &Open<'_>, direction: &Direction, tried: &Tried<'_>) -> Vec<String> {
    let problem = open.problem;
    let mut found: Vec<(String, Vec<&str>)> = Vec::new();
    for (p, part) in problem.parts.iter().enumerate() {
        // The run with the most readings that the direction touches stands for all.
        let touches = |r: &usize| {
            let touched = problem.layout.columns.touched_by(problem.run_index(p, *r));
            direction.weights.iter().any(|(column, _)| touched.contains(column))
        };
        let runs = (0..part.runs.len()).filter(touches);
        let Some(r) = runs.max_by_key(|r| part.runs[*r].record.len()) else { continue };
        let thinned: Record = part.runs[r].record.spread(SAMPLES, 1).into();
        for other in changes(problem, p) {
            let mut record = thinned.clone();
            record.edit(|samples| other.apply(samples));
            let Some(sums) = sums_of(problem, open.point, (p, r), record) else { continue };
            if tried.determined_by_run(problem.run_index(p, r), &sums) {
                let words =
                    format!("measure one more run like `{}` {}", part.runs[r].name, other.words);
                match found.iter_mut().find(|(known, _)| *known == words) {
                    Some((_, axes)) => axes.extend(other.axis),
                    None => found.push((words, other.axis.into_iter().collect())),
                }
            }
        }
    }
    let whole = |(words, axes): (String, Vec<&str>)| match axes.is_empty() {
        true => words,
        false => format!("{words} about its {} axis", axes.join(" or ")),
    };
    found.into_iter().map(whole).collect()
}

/// Another input.
struct Other {
    words: String,
    /// About which axis it is tilted.
    axis: Option<&'static str>,
    change: Input,
}

enum Input {
    /// These four are tilted about an axis of theirs.
    Tilted([usize; 4], [f64; 3]),
    /// This one changes by so much in the course of the run.
    Swept(usize, f64),
}

impl Other {
    fn apply(&self, samples: &mut Samples) {
        let count = samples.len().max(2) as f64 - 1.0;
        let duration = match (samples.time.first(), samples.time.last()) {
            (Some(first), Some(last)) if last > first => last - first,
            _ => f64::INFINITY,
        };
        let moments = |track: &Track, order: u8| -> Vec<f64> {
            let each = samples.time.iter().enumerate();
            each.map(|(at, time)| track.at::<f64>(at, *time, 0.0, order)).collect()
        };
        match self.change {
            Input::Tilted(inputs, axis) => {
                let turn = Quaternion::turn(axis.map(|part| TILT * part));
                let turned = |order: u8| -> [Vec<f64>; 4] {
                    let [w, x, y, z] = inputs.map(|input| moments(&samples.inputs[input], order));
                    let own = w.into_iter().zip(x).zip(y).zip(z);
                    let all: Vec<[f64; 4]> = own
                        .map(|(((w, x), y), z)| {
                            let q = Quaternion { w, v: [x, y, z] } * turn;
                            [q.w, q.v[0], q.v[1], q.v[2]]
                        })
                        .collect();
                    [0, 1, 2, 3].map(|part| all.iter().map(|q| q[part]).collect())
                };
                let moves = inputs.iter().any(|input| samples.inputs[*input].moves());
                let [values, rates, accelerations] = [turned(0), turned(1), turned(2)];
                let all = values.into_iter().zip(rates).zip(accelerations);
                let all: Vec<_> = all.collect();
                for (input, ((value, rate), acceleration)) in inputs.into_iter().zip(all) {
                    let [rate, acceleration] =
                        [rate, acceleration].map(|column| moves.then_some(column));
                    samples.inputs[input] = Track::Captured { value, rate, acceleration };
                }
            }
            Input::Swept(input, by) => {
                let part = |at: usize| at as f64 / count;
                let value = moments(&samples.inputs[input], 0);
                let value = value.into_iter().enumerate().map(|(at, one)| one + by * part(at));
                let value = value.collect();
                // Only what moves may have a rate.
                let rate = duration.is_finite() && samples.inputs[input].moves();
                let rate = rate.then(|| vec![by / duration; samples.len()]);
                samples.inputs[input] = Track::Captured { value, rate, acceleration: None };
            }
        }
    }
}

/// What could be otherwise in a campaign.
fn changes(problem: &Problem, p: usize) -> Vec<Other> {
    let part = &problem.parts[p];
    let inputs = &part.system.assembly.names.inputs;
    let mut all = Vec::new();
    for quadruple in &part.system.attitudes {
        let names = quadruple.map(|input| inputs[input].name.as_str());
        for (axis, about) in
            [("x", [1.0, 0.0, 0.0]), ("y", [0.0, 1.0, 0.0]), ("z", [0.0, 0.0, 1.0])]
        {
            all.push(Other {
                words: format!(
                    "with the attitude `{}` ... `{}` tilted by 20 deg",
                    names[0], names[3]
                ),
                axis: Some(axis),
                change: Input::Tilted(*quadruple, about),
            });
        }
    }
    for (input, declared) in inputs.iter().enumerate() {
        if part.system.attitudes.iter().any(|quadruple| quadruple.contains(&input)) {
            continue;
        }
        let Some(value) = the_same(problem, p, input) else { continue };
        let is_angle = declared.unit.dimension == Dimension::NONE && declared.unit.is_angle();
        let by = match value.abs() {
            _ if is_angle => TILT,
            size if size > 0.0 => CHANGED * size,
            _ => declared.unit.factor,
        };
        all.push(Other {
            words: format!("in which `{}` takes other values", declared.name),
            axis: None,
            change: Input::Swept(input, by),
        });
    }
    all
}

/// The value of an input that is the same in all samples of a campaign.
fn the_same(problem: &Problem, p: usize, input: usize) -> Option<f64> {
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for run in &problem.parts[p].runs {
        run.record.walk(|stretch| {
            for sample in stretch.each() {
                let track = &sample.samples.inputs[input];
                let value = track.at::<f64>(sample.at, sample.time(), 0.0, 0);
                (least, most) = (least.min(value), most.max(value));
            }
        });
    }
    let size = least.abs().max(most.abs());
    (most - least <= 1e-6 * size).then_some(0.5 * (most + least)).filter(|value| value.is_finite())
}

/// Whitened squared change of all readings along a direction.
fn response(open: &Open<'_>, step: &[f64]) -> f64 {
    let normal = open.normal;
    let of = |(run, gram): (usize, &crate::engine::gram::RunGram)| {
        let touched = normal.columns.touched_by(run);
        let size = touched.len();
        along(&gram.gram.view((0, 0), (size, size)).into_owned(), &touched, step)
    };
    normal.runs.iter().enumerate().map(of).sum()
}

/// `stepᵀ sums step` over the first of the columns that a run touches.
fn along(sums: &DMatrix<f64>, touched: &[usize], step: &[f64]) -> f64 {
    let local = DVector::from_fn(sums.nrows(), |row, _| step[touched[row]]);
    local.dot(&(sums * &local)).max(0.0)
}

/// Whitened sums of products over a run that is not measured yet, of the columns that it shares
/// with others: what its own values, which a parameter with one for each run has for it, could not
/// follow. `None` where numbers are not finite.
fn sums_of(
    problem: &Problem,
    point: &Point,
    (p, r): (usize, usize),
    record: Record,
) -> Option<DMatrix<f64>> {
    let mut changed = problem.clone();
    changed.parts[p].runs[r].record = record;
    let index = changed.run_index(p, r);
    let size = changed.layout.columns.touched_by(index).len();
    let own = changed.layout.columns.of_run(index);
    let shared = size - own;
    let sigma: Vec<f64> = changed.parts[p]
        .slots()
        .iter()
        .zip(&changed.parts[p].sigma)
        .flat_map(|(slot, sigma)| std::iter::repeat_n(*sigma, slot.components))
        .collect();
    let mut sums = DMatrix::zeros(size, size);
    changed.visit_run(p, r, point, &mut |_, jacobian, _| {
        for (row, sigma) in sigma.iter().enumerate() {
            let line = jacobian.row(row).transpose() / *sigma;
            if line.iter().all(|value| value.is_finite()) {
                sums.syger(1.0, &line, &line, 1.0);
            }
        }
    });
    sums.fill_upper_triangle_with_lower_triangle();
    let mut common = sums.view((0, 0), (shared, shared)).into_owned();
    if own > 0 {
        let among = sums.view((shared, shared), (own, own)).into_owned();
        let between = sums.view((shared, 0), (own, shared)).into_owned();
        let least = RANK * among.norm();
        for column in 0..shared {
            let right = between.column(column).into_owned();
            let followed = least_squares(among.clone(), &right, least)?;
            let taken = between.transpose() * followed;
            let mut own = common.column_mut(column);
            own -= &taken;
        }
    }
    common.iter().all(|value| value.is_finite()).then_some(common)
}
