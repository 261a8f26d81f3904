//! Members of effects that the model absorbs: held at zero by the program itself.
//!
//! An offset of the first joint of an arm is a turn of its base: no reading tells the two apart, and
//! what an effect leaves open in this way says nothing of its other members. Such a member is held
//! at zero, so that the nominal parameter keeps its meaning, and that is said. So is the value of a run
//! on which no reading depends, as the share of jumps in a run whose stamps never jump, where those of
//! other runs are determined. An effect of which every member is absorbed cannot be estimated at all:
//! nothing is held then.

use std::collections::BTreeSet;

use crate::engine::layout::Instance;
use crate::engine::problem::Problem;
use crate::estimate::batch::{FitError, Options, Outcome};
use crate::estimate::calibrate::{Calibration, Held, calibrate};
use crate::estimate::nested::is_of;
use crate::estimate::observability::{Direction, Kind as Exactness, NEGLIGIBLE, examine};
use crate::estimate::withheld::limits;
use crate::estimate::words::describe;
use crate::graph::{Kind, Scope};
use crate::model::Component;
use crate::model::component::AXES;

/// Rounds of holding members and fitting again.
const ROUNDS: usize = 4;

/// Estimates everything, with members of these effects (`NAME` or `NAME.HEAD`) held at zero where
/// the model absorbs them.
///
/// # Errors
/// As [`calibrate`].
pub fn calibrate_holding(
    problem: Problem,
    effects: &[String],
    options: &Options,
) -> Result<Calibration, FitError> {
    let mut result = calibrate(problem, options)?;
    let mut held: Vec<Held> = Vec::new();
    for _ in 0..ROUNDS {
        let found = absorbed(&result, effects);
        if found.is_empty() {
            break;
        }
        let problem = holding(&result.problem, &found);
        held.extend(found.into_iter().map(|one| Held {
            name: one.name(),
            of: one.run.and_then(|index| result.problem.layout.instances[index].of.clone()),
            why: one.why,
        }));
        result = calibrate(problem, options)?;
    }
    result.held = held;
    Ok(result)
}

/// A member that is absorbed.
struct Absorbed {
    parameter: String,
    /// The component, of a vector.
    component: Option<usize>,
    /// The instance of the run in which alone it is held.
    run: Option<usize>,
    why: String,
}

impl Absorbed {
    fn name(&self) -> String {
        match self.component {
            Some(component) => format!("{}.{}", self.parameter, AXES[component]),
            None => self.parameter.clone(),
        }
    }
}

/// The members that are absorbed, one for each direction that is not determined at all.
fn absorbed(result: &Calibration, effects: &[String]) -> Vec<Absorbed> {
    let problem = &result.problem;
    if effects.is_empty() || result.fit.outcome == Outcome::NotFinite {
        return Vec::new();
    }
    let own = of_effects(problem, effects);
    if own.is_empty() {
        return Vec::new();
    }
    let Ok(examined) = examine(&result.fit.normal, &limits(problem, &result.fit)) else {
        return Vec::new();
    };
    let layout = &problem.layout;
    // Instances and components with their columns.
    let mut columns: Vec<(usize, usize, usize)> = Vec::new();
    for index in own.iter().copied().filter(|index| layout.instances[*index].kind != Kind::Rotation)
    {
        columns.extend(layout.own_columns(index).map(|(k, column)| (index, k, column)));
    }
    let mut chosen: Vec<(usize, usize, String)> = Vec::new();
    // Those on which no reading depends.
    let mut idle: Vec<usize> = Vec::new();
    for direction in examined.directions.iter().filter(|one| one.kind == Exactness::Exact) {
        let share = |column: usize| share_of(direction, column);
        let is_own = |column: usize| columns.iter().any(|(_, _, own)| *own == column);
        let carriers = direction.weights.iter().map(|(column, _)| *column);
        let nominal = carriers.filter(|column| share(*column) >= NEGLIGIBLE && !is_own(*column));
        let members = columns.iter().filter(|(_, _, column)| share(*column) >= NEGLIGIBLE).count();
        // Members that are alike among themselves are a matter of the effect, not of the model.
        let is_alone = nominal.count() == 0;
        if members == 0 || (is_alone && members > 1) {
            continue;
        }
        let is_free = |one: &&(usize, usize, usize)| {
            !chosen.iter().any(|(index, component, _)| (*index, *component) == (one.0, one.1))
        };
        let rounded = |column: usize| (share(column) * 1e6).round();
        let best = columns
            .iter()
            .filter(is_free)
            .reduce(|best, one| if rounded(one.2) > rounded(best.2) { one } else { best });
        if let Some((index, component, column)) = best.copied()
            && share(column) >= NEGLIGIBLE
        {
            chosen.push((index, component, describe(problem, direction, String::new()).words));
            idle.extend(is_alone.then_some(index));
        }
    }
    // A parameter with several values is held as a whole or not at all, but for runs without any
    // influence of it.
    let mut found: Vec<Absorbed> = Vec::new();
    for (index, component, why) in &chosen {
        let name = &layout.instances[*index].name;
        let is_vector = layout.instances[*index].kind == Kind::Vector;
        let mut same = (0..layout.instances.len())
            .filter(|other| layout.instances[*other].name == *name && layout.is_free(*other));
        let is_whole = same.all(|other| {
            chosen.iter().any(|(index, own, _)| (*index, *own) == (other, *component))
        });
        let component = is_vector.then_some(*component);
        let known = found.iter().any(|one| one.parameter == *name && one.component == component);
        let Instance { kind, setting, .. } = &layout.instances[*index];
        let is_of_run = *kind == Kind::Scalar && setting.scope == Scope::Run;
        let run = (!is_whole).then_some(*index);
        if (is_whole && !known) || (!is_whole && is_of_run && idle.contains(index)) {
            found.push(Absorbed { parameter: name.clone(), component, run, why: why.clone() });
        }
    }
    found.retain(|one| leaves_some(problem, one, &columns, &chosen));
    found
}

/// How much a column carries of a direction.
fn share_of(direction: &Direction, column: usize) -> f64 {
    let place = direction.weights.iter().position(|(own, _)| *own == column);
    place.map_or(0.0, |place| direction.shares[place].abs())
}

/// Whether a member's effect has others that are estimated.
fn leaves_some(
    problem: &Problem,
    one: &Absorbed,
    columns: &[(usize, usize, usize)],
    chosen: &[(usize, usize, String)],
) -> bool {
    let owner = |name: &str| name.split('.').next().unwrap_or_default().to_owned();
    columns.iter().any(|(index, component, _)| {
        owner(&problem.layout.instances[*index].name) == owner(&one.parameter)
            && !chosen.iter().any(|(own, k, _)| (own, k) == (index, component))
    })
}

/// The instances of what these effects leave free.
fn of_effects(problem: &Problem, effects: &[String]) -> BTreeSet<usize> {
    let mut own = BTreeSet::new();
    for (p, part) in problem.parts.iter().enumerate() {
        for used in &problem.layout.used[p] {
            for (parameter, index) in used.iter().enumerate() {
                let effect = part.system.declared[parameter].effect;
                if effect.is_some_and(|effect| is_of(part, effect, effects)) {
                    own.insert(*index);
                }
            }
        }
    }
    own
}

/// The problem with some members held at zero.
fn holding(problem: &Problem, absorbed: &[Absorbed]) -> Problem {
    let mut parts = problem.parts.clone();
    for (part, used) in parts.iter_mut().zip(&problem.layout.used) {
        for one in absorbed {
            if let Some(index) = one.run {
                let runs = part.runs.iter().zip(used).filter(|(_, used)| used.contains(&index));
                part.held.extend(runs.map(|(run, _)| (run.name.clone(), one.parameter.clone())));
                continue;
            }
            let names = &part.system.assembly.names.parameters;
            let Some(parameter) = names.iter().position(|own| own.name == one.parameter) else {
                continue;
            };
            for setting in part.system.settings_mut(parameter) {
                match one.component {
                    None => setting.hold_at(vec![0.0]),
                    Some(component) => {
                        let all = setting.components.get_or_insert_with(Box::default);
                        all[component] = Component {
                            value: Some(0.0),
                            fixed: Some(true),
                            ..Component::default()
                        };
                    }
                }
            }
        }
    }
    let mut made = Problem::new(parts);
    made.progress = problem.progress.clone();
    made
}
