//! What cannot be determined, in words: which parameters act alike, and the run that would tell
//! them apart.

use nalgebra::{DMatrix, DVector};

use crate::campaign::Track;
use crate::campaign::record::Change;
use crate::engine::gram::Normal;
use crate::engine::point::Point;
use crate::engine::problem::Problem;
use crate::estimate::combination::{Combination, component_names, place_of};
use crate::estimate::eigen::least_squares;
use crate::estimate::observability::{Direction, Kind as Exactness, NEGLIGIBLE};
use crate::graph::Kind;

/// Singular values of a run's own values below this part of all are none.
const RANK: f64 = 1e-12;

/// A combination of parameters that the data do not determine.
#[derive(Clone, Debug)]
pub struct Unobservable {
    /// The sentence.
    pub words: String,
    /// Component name and weight in SI units, largest scaled weight 1.
    pub direction: Vec<(String, f64)>,
    /// What would determine it.
    pub remedy: String,
    /// What the readings determine in spite of it.
    pub determined: Vec<Combination>,
}

/// One instance's share of a direction: tangent components.
struct Share {
    instance: usize,
    change: Vec<f64>,
}

/// Puts a direction into words.
pub fn describe(
    problem: &Problem,
    point: &Point,
    normal: &Normal,
    direction: &Direction,
) -> Unobservable {
    let shares = shares(problem, direction);
    let named: Vec<(String, f64)> = shares
        .iter()
        .flat_map(|share| {
            let names = component_names(problem, share.instance);
            names.into_iter().zip(share.change.clone()).filter(|(_, weight)| *weight != 0.0)
        })
        .collect();
    Unobservable {
        words: sentence(problem, &shares, direction),
        direction: named,
        remedy: remedy(problem, point, normal, direction, &shares),
        determined: Vec::new(),
    }
}

/// The direction by instances. Contrasts spread over several.
fn shares(problem: &Problem, direction: &Direction) -> Vec<Share> {
    let mut step = vec![0.0; problem.layout.columns.len()];
    for ((column, weight), share) in direction.weights.iter().zip(&direction.shares) {
        if share.abs() >= NEGLIGIBLE {
            step[*column] = *weight;
        }
    }
    let mut shares = Vec::new();
    for (index, instance) in problem.layout.instances.iter().enumerate() {
        let change: Vec<f64> = (0..instance.dimension())
            .map(|component| {
                problem
                    .layout
                    .columns_of(index, component)
                    .iter()
                    .map(|(column, coefficient)| coefficient * step[*column])
                    .sum()
            })
            .collect();
        if change.iter().any(|value| *value != 0.0) {
            shares.push(Share { instance: index, change });
        }
    }
    shares
}

/// An instance's name in words, with its setup or run where the parameter has several.
fn placed_name(problem: &Problem, index: usize) -> String {
    let of = place_of(problem, index).map_or_else(String::new, |of| format!(" ({of})"));
    format!("`{}`{of}", problem.layout.instances[index].name)
}

fn sentence(problem: &Problem, shares: &[Share], direction: &Direction) -> String {
    let (delays, others): (Vec<&Share>, Vec<&Share>) = shares
        .iter()
        .partition(|share| problem.layout.instances[share.instance].name.ends_with(".delay"));
    let mut phrases = Vec::new();
    if !delays.is_empty() {
        phrases.push(delay_phrase(problem, &delays));
    }
    phrases.extend(others.iter().map(|share| change_phrase(problem, share)));
    match phrases.as_slice() {
        [] => "a combination of parameters has no effect on any reading".to_owned(),
        [only] if direction.kind == Exactness::Exact => {
            format!("{only} has no effect on any reading")
        }
        [only] => {
            let first = shares.first().map(|share| &problem.layout.instances[share.instance]);
            let unit = first.map_or_else(String::new, |one| one.unit.si_symbol());
            let size = direction.standard_uncertainty.map_or_else(String::new, |u| {
                format!(
                    " (standard uncertainty {})",
                    format!("{u:.2e} {unit}").trim_end_matches(" 1")
                )
            });
            format!("{only} cannot be told from noise by these readings{size}")
        }
        [first, rest @ ..] => {
            let also = if direction.kind == Exactness::Exact { "" } else { " (up to noise)" };
            format!("{first} acts as {}{also}", rest.join(" together with "))
        }
    }
}

fn delay_phrase(problem: &Problem, delays: &[&Share]) -> String {
    let all = problem
        .layout
        .instances
        .iter()
        .filter(|instance| instance.name.ends_with(".delay") && !instance.setting.fixed)
        .count();
    let first = delays[0].change[0];
    let alike = delays.iter().all(|share| (share.change[0] / first - 1.0).abs() < 0.05);
    let names: Vec<String> =
        delays.iter().map(|share| placed_name(problem, share.instance)).collect();
    if alike && delays.len() == all && all > 1 {
        format!("a common delay of all measurands ({})", names.join(", "))
    } else if delays.len() == 1 {
        format!("a change of {}", names[0])
    } else {
        format!("a joint change of {}", names.join(", "))
    }
}

fn change_phrase(problem: &Problem, share: &Share) -> String {
    let instance = &problem.layout.instances[share.instance];
    let name = placed_name(problem, share.instance);
    match instance.kind {
        Kind::Scalar => format!("a change of {name}"),
        Kind::Vector => format!("a shift of {name} along {}", axis_words(&share.change, "")),
        Kind::Rotation => {
            // The tangent is seen in the frame that the rotation turns from.
            let arm = problem.parts.iter().any(|part| part.system.input("arm_angle").is_some());
            let z =
                if arm && instance.name.starts_with("orientation") { "the arm axis" } else { "" };
            format!("a turn of {name} about {}", axis_words(&share.change, z))
        }
    }
}

/// "its z axis", or the direction as numbers; `z` is what the z axis is called, if it has a name.
fn axis_words(direction: &[f64], z: &str) -> String {
    let length = direction.iter().map(|value| value * value).sum::<f64>().sqrt();
    for (value, axis) in direction.iter().zip(["x", "y", "z"]) {
        if value.abs() > 0.99 * length {
            return if axis == "z" && !z.is_empty() {
                z.to_owned()
            } else {
                format!("its {axis} axis")
            };
        }
    }
    let unit: Vec<String> =
        direction.iter().map(|value| format!("{:.2}", value / length)).collect();
    format!("({})", unit.join(", "))
}

/// A run that does not exist yet, made from one that does.
#[derive(Clone, Copy)]
enum Candidate {
    Reversed,
    Slower,
}

/// Looks for a further run that would determine the direction.
fn remedy(
    problem: &Problem,
    point: &Point,
    normal: &Normal,
    direction: &Direction,
    shares: &[Share],
) -> String {
    let mut step = vec![0.0; problem.layout.columns.len()];
    for (column, weight) in &direction.weights {
        step[*column] = *weight;
    }
    let now = response(normal, &step);
    let mut best: Option<(f64, String)> = None;
    for (p, part) in problem.parts.iter().enumerate() {
        for r in 0..part.runs.len() {
            for candidate in [Candidate::Reversed, Candidate::Slower] {
                let Some(gain) = candidate_response(problem, point, (p, r), candidate, &step)
                else {
                    continue;
                };
                let name = &part.runs[r].name;
                let words = match candidate {
                    Candidate::Reversed => {
                        format!(
                            "measure one more run like `{name}` with the opposite sense of motion"
                        )
                    }
                    Candidate::Slower => {
                        format!("measure one more run like `{name}` at a tenth of its rate")
                    }
                };
                if best.as_ref().is_none_or(|(known, _)| gain > 1.1 * known) {
                    best = Some((gain, words));
                }
            }
        }
    }
    let mut names: Vec<String> = Vec::new();
    for share in shares {
        let name = format!("`{}`", problem.layout.instances[share.instance].name);
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let one = if names.len() == 1 { "" } else { "one of " };
    let state =
        format!("state a value with its sigma for {one}{} or set it fixed", names.join(", "));
    match best {
        // A useful run answers far above what all present ones do together.
        Some((gain, words)) if gain > 1e4 * now.max(f64::MIN_POSITIVE) && gain > 0.0 => {
            format!("{words}; or {state}")
        }
        _ if shares.len() == 1 => format!("leave it out: {state}"),
        _ => state,
    }
}

/// Whitened squared change of all readings along a direction.
fn response(normal: &Normal, step: &[f64]) -> f64 {
    normal
        .runs
        .iter()
        .enumerate()
        .map(|(run, gram)| {
            let touched = normal.columns.touched_by(run);
            let local: Vec<f64> = touched.iter().map(|column| step[*column]).collect();
            let mut sum = 0.0;
            for (i, a) in local.iter().enumerate() {
                for (j, b) in local.iter().enumerate() {
                    sum += a * b * gram.gram[(i, j)];
                }
            }
            sum.max(0.0)
        })
        .sum()
}

/// The same for one run that is not measured yet: what its own values, which a parameter with one
/// for each run has for it, could not follow.
fn candidate_response(
    problem: &Problem,
    point: &Point,
    (p, r): (usize, usize),
    candidate: Candidate,
    step: &[f64],
) -> Option<f64> {
    let factor = match candidate {
        Candidate::Reversed => -1.0,
        Candidate::Slower => 0.1,
    };
    let run = &problem.parts[p].runs[r];
    if !run.record.inputs().iter().any(Track::moves) {
        return None;
    }
    let retimed = run.record.changed(Change::Retimed(factor));
    let mut changed = problem.clone();
    changed.parts[p].runs[r].record = retimed;
    let index = changed.run_index(p, r);
    let touched = changed.layout.columns.touched_by(index);
    let own = changed.layout.columns.of_run(index);
    let shared = touched.len() - own;
    let local = touched[..shared].iter().map(|column| step[*column]);
    let local = DVector::from_iterator(shared, local);
    let sigma: Vec<f64> = changed.parts[p]
        .slots()
        .iter()
        .zip(&changed.parts[p].sigma)
        .flat_map(|(slot, sigma)| std::iter::repeat_n(*sigma, slot.components))
        .collect();
    let (mut sum, mut along) = (0.0, DVector::zeros(own));
    let mut among = DMatrix::zeros(own, own);
    changed.visit_run(p, r, point, &mut |_, jacobian, _| {
        for (row, sigma) in sigma.iter().enumerate() {
            let line = jacobian.row(row);
            let change = line.columns(0, shared).transpose().dot(&local) / sigma;
            let values = line.columns(shared, own).transpose() / *sigma;
            if change.is_finite() && values.iter().all(|value| value.is_finite()) {
                sum += change * change;
                along += &values * change;
                among += &values * values.transpose();
            }
        }
    });
    let followed = match own {
        0 => 0.0,
        _ => {
            let least = RANK * among.norm();
            least_squares(among, &along, least).map_or(0.0, |values| along.dot(&values))
        }
    };
    // Numbers too large to be squared say nothing of the run.
    Some(sum - followed).filter(|gain| gain.is_finite()).map(|gain| gain.max(0.0))
}
