//! Members of families that are frequencies: which of them the sampling of the runs can carry.

use crate::diagnose::evidence::sampling::Sampling;
use crate::diagnose::library::candidate::Candidate;
use crate::engine::Problem;
use crate::units::Unit;

/// Why no member of a family can be tested.
pub(in crate::diagnose) const ALL_BLIND: &str = "none of its frequencies can be told from nothing at the rates at which these runs are sampled: sample faster, or at uneven intervals";

/// The members of a family that the runs can tell from nothing.
pub(in crate::diagnose) fn told<'a>(
    problem: &Problem,
    family: &'a [Candidate],
) -> Vec<&'a Candidate> {
    let Some(first) = family.first().filter(|_| family.len() > 1) else {
        return family.iter().collect();
    };
    let shape = &first.selected.effect.shape;
    let frequencies: Vec<&String> =
        shape.iter().filter(|(_, one)| is_frequency(&one.unit)).map(|(name, _)| name).collect();
    if frequencies.is_empty() {
        return family.iter().collect();
    }
    let sampling = Sampling::of(problem);
    let is_blind = |one: &&Candidate| {
        let values = frequencies.iter().filter_map(|name| one.selected.member.get(*name));
        values.into_iter().any(|value| sampling.is_blind(*value))
    };
    family.iter().filter(|one| !is_blind(one)).collect()
}

pub(super) fn is_frequency(unit: &Unit) -> bool {
    Unit::parse("Hz").is_ok_and(|hertz| unit.dimension == hertz.dimension)
}
