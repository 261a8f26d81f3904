//! Delays that change no reading: those of campaigns in which nothing moves, and of measurands that
//! no signal acts on. They are not estimated.

use std::collections::BTreeSet;

use crate::campaign::Run;
use crate::campaign::load::Campaign;
use crate::campaign::signal::moving_signals;
use crate::diagnostic::Diagnostics;
use crate::engine::Problem;
use crate::engine::open::recipe::Recipe;
use crate::graph::{Leaf, Node};
use crate::model::Override;
use crate::system::{System, delay_names};
use crate::units::Unit;

/// Holds at zero every delay that acts in none of the campaigns, before what is stated of it.
pub(super) fn hold(recipes: &mut [Recipe], campaigns: &[Campaign]) -> Result<(), Diagnostics> {
    let mut acting: BTreeSet<String> = BTreeSet::new();
    for (recipe, campaign) in recipes.iter().zip(campaigns) {
        let system = recipe.with(&[])?;
        let moving = moving(&system, &campaign.runs);
        if moving.contains(&true) {
            acting.extend(delays_that_act(&system, &moving));
        }
    }
    for recipe in recipes {
        let held = delay_names(&recipe.model).filter(|name| !acting.contains(name));
        let held: Vec<String> = held.collect();
        let is_open = |name: &&String| recipe.overrides.iter().all(|one| one.name != **name);
        recipe.held_delays = held.iter().filter(is_open).cloned().collect();
        let held = held.into_iter().map(|name| Override {
            name,
            value: Some(vec![(0.0, Unit::second())]),
            fixed: Some(true),
            ..Override::default()
        });
        let held: Vec<Override> = held.collect();
        recipe.overrides.splice(0..0, held);
    }
    Ok(())
}

/// The delays that are held and act on readings all the same with the effects of a problem: an effect may
/// be the first that depends on a signal.
pub fn held_that_act(recipes: &[Recipe], problem: &Problem) -> BTreeSet<String> {
    let each = recipes.iter().zip(&problem.parts).flat_map(|(recipe, part)| {
        let moving = moving(&part.system, &part.runs);
        let acting: Vec<String> = delays_that_act(&part.system, &moving).collect();
        acting.into_iter().filter(|name| recipe.held_delays.contains(name))
    });
    each.collect()
}

/// For each input whether it is a signal that moves in some run.
fn moving(system: &System, runs: &[Run]) -> Vec<bool> {
    let inputs = &system.assembly.names.inputs;
    let mut all = vec![false; inputs.len()];
    for run in runs {
        let here = moving_signals(inputs, run.record.inputs());
        all.iter_mut().zip(here).for_each(|(known, moves)| *known |= moves);
    }
    all
}

/// The delays on which the value of a measurand depends: through a signal that moves, or a time.
fn delays_that_act<'s>(
    system: &'s System,
    moving: &'s [bool],
) -> impl Iterator<Item = String> + 's {
    let assembly = &system.assembly;
    let measurands = assembly.names.measurands.iter().zip(&assembly.measurands);
    let acting = measurands.filter(|(own, graph)| {
        let needed = assembly.graph.needed_by(graph.value.nodes());
        let has = |is_one: &dyn Fn(&Node) -> bool| {
            needed.iter().any(|node| is_one(&assembly.graph.node(*node)))
        };
        let is_delay = |node: &Node| match node {
            Node::Leaf(Leaf::Parameter { parameter, .. }) => *parameter as usize == own.delay,
            _ => false,
        };
        let goes_on = |node: &Node| match node {
            Node::Signal { input, .. } => moving.get(*input as usize).copied().unwrap_or(false),
            Node::Leaf(Leaf::Clock(clock)) => clock.runs(),
            _ => false,
        };
        has(&is_delay) && has(&goes_on)
    });
    acting.map(|(own, _)| assembly.names.parameters[own.delay].name.clone())
}
