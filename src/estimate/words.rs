//! What cannot be determined, in words: which parameters act alike.

use crate::engine::problem::Problem;
use crate::estimate::combination::{Combination, component_names, place_of};
use crate::estimate::observability::{Direction, Kind as Exactness, NEGLIGIBLE};
use crate::graph::Kind;

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

/// Puts a direction into words, with its remedy.
pub fn describe(problem: &Problem, direction: &Direction, remedy: String) -> Unobservable {
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
        remedy,
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
    let (delays, others): (Vec<&Share>, Vec<&Share>) =
        shares.iter().partition(|share| problem.layout.instances[share.instance].is_delay());
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
        .filter(|instance| instance.is_delay() && !instance.setting.fixed)
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
