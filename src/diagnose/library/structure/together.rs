//! What two quantities do together: products of two inputs, and loads by the sense of a motion.

use crate::model::{InputDeclaration, MeasurandDeclaration, Model};
use crate::units::Dimension;

use super::Spread;
use super::covariate::{Covariate, Term, offset_from, powers, sense_of, wave};

/// Inputs of which products are looked at, at most.
const MOST_TOGETHER: usize = 4;
/// Loads by senses of a reading at most.
const MOST_LOADS: usize = 12;

/// Loads by the sense of motion, for a reading that is one itself: what a gear, a seal or a bearing loses
/// grows with the force, the torque, the pressure or the current that goes through it. Senses are those
/// of rates that are inputs, and those in which signals move. None of models with many of both.
pub(super) fn loads_by_sense(model: &Model, of: &MeasurandDeclaration) -> Vec<Covariate> {
    if !of.unit.dimension.is_of_a_load() {
        return Vec::new();
    }
    let is_rate = |input: &InputDeclaration| {
        let way = input.unit.dimension * Dimension::TIME;
        [Dimension::NONE, Dimension::LENGTH].contains(&way)
    };
    let inputs = model.inputs.iter().map(|input| (&input.name, input.unit.dimension));
    let loads = inputs.filter(|one| one.1.is_of_a_load()).chain([(&of.name, of.unit.dimension)]);
    let loads: Vec<(&String, Dimension)> = loads.collect();
    let mut all = Vec::new();
    for moves in &model.inputs {
        let sense = match is_rate(moves) {
            true => format!("sign({})", moves.name),
            false if moves.signal && !moves.unit.dimension.is_of_a_load() => {
                sense_of(&moves.name).0
            }
            false => continue,
        };
        for (name, own) in &loads {
            let terms = [(*name).clone(), format!("abs({name})")];
            let terms = terms.map(|term| (format!("{sense} * {term}"), *own));
            let of = if is_rate(moves) { "" } else { "the rate of " };
            let moves = &moves.name;
            all.push(Covariate {
                words: format!("{name}, direction-dependent (sign of {of}{moves})"),
                ..Covariate::new(format!("{name} by sense of {moves}"), terms)
            });
        }
    }
    if all.len() > MOST_LOADS { Vec::new() } else { all }
}

/// Products of two inputs, of which one at least does not turn: powers from the middle of where its
/// values lie, and waves over what turns. What each of both does by itself is mostly no part of it.
pub(super) fn products(model: &Model, spreads: &[Spread]) -> Vec<Covariate> {
    if model.inputs.len() > MOST_TOGETHER {
        return Vec::new();
    }
    let factor = |input: &InputDeclaration| -> Option<Vec<Term>> {
        let (name, own) = (&input.name, input.unit.dimension);
        let Spread { knots, .. } = spreads.iter().find(|known| known.input == *name)?;
        Some(match knots.get(knots.len() / 2) {
            Some(middle) => powers(&format!("({})", offset_from(input, *middle)), own).to_vec(),
            None => (1..=2).flat_map(|order| wave(&format!("{order} * {name}"))).collect(),
        })
    };
    let turns = |input: &InputDeclaration| {
        spreads.iter().any(|known| known.input == input.name && known.knots.is_empty())
    };
    let inputs = model.inputs.iter().filter_map(|one| Some((one, factor(one)?)));
    let inputs: Vec<(&InputDeclaration, Vec<Term>)> = inputs.collect();
    let mut all = Vec::new();
    for (number, (first, left)) in inputs.iter().enumerate() {
        for (second, right) in &inputs[..number] {
            let turning = [first, second].iter().filter(|one| turns(one)).count();
            if turning > 1 {
                continue;
            }
            let product = |(k, (one, own)): (usize, &Term)| {
                // Squares of both are too much of a power.
                let others = right.iter().take(if turning == 0 && k > 0 { 1 } else { right.len() });
                let of_both = |(other, of): &Term| (format!("{one} * {other}"), *own * *of);
                others.map(of_both).collect::<Vec<_>>()
            };
            let terms = left.iter().enumerate().flat_map(product);
            let name = format!("{} and {} together", second.name, first.name);
            all.push(Covariate::new(name, terms));
        }
    }
    all
}
