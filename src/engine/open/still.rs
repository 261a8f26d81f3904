//! Delays that change no reading: those of campaigns in which nothing moves, and of measurands that
//! no signal acts on. They are not estimated.

use std::collections::BTreeSet;

use crate::campaign::load::Campaign;
use crate::campaign::signal::a_signal_moves;
use crate::diagnostic::Diagnostics;
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
        if moves(&system, campaign) {
            acting.extend(delays_that_act(&system));
        }
    }
    for recipe in recipes {
        let held = delay_names(&recipe.model).filter(|name| !acting.contains(name));
        let held = held.map(|name| Override {
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

/// Whether a signal moves while readings are taken.
fn moves(system: &System, campaign: &Campaign) -> bool {
    campaign
        .runs
        .iter()
        .any(|run| a_signal_moves(&system.assembly.names.inputs, run.record.inputs()))
}

/// The delays on which the value of a measurand depends.
fn delays_that_act(system: &System) -> impl Iterator<Item = String> + '_ {
    let assembly = &system.assembly;
    let measurands = assembly.names.measurands.iter().zip(&assembly.measurands);
    let acting = measurands.filter(|(own, graph)| {
        let needed = assembly.graph.needed_by(graph.value.nodes());
        let is_delay = |node: &Node| match node {
            Node::Leaf(Leaf::Parameter { parameter, .. }) => *parameter as usize == own.delay,
            _ => false,
        };
        needed.iter().any(|node| is_delay(&assembly.graph.node(*node)))
    });
    acting.map(|(own, _)| assembly.names.parameters[own.delay].name.clone())
}
