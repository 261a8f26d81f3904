//! The library before a design: every effect with what a fit to its readings would say of it.

use crate::diagnose::evidence::Entry;
use crate::diagnose::evidence::Evidence;
use crate::diagnose::fitted::Fitted;
use crate::diagnose::library::candidate::{Candidate, NotTestable};
use crate::effect::Target;
use crate::engine::Problem;
use crate::graph::MeasurandKind;
use crate::model::Process;
use crate::units::Unit;

/// Samples that are looked at, at most.
const MOST_SAMPLES: usize = 100_000;

/// Effects before a design.
#[derive(Clone, Debug)]
pub struct Prospect {
    /// The design, as if just fitted.
    pub fitted: Fitted,
    /// Effects at every head with every member of their families.
    pub candidates: Vec<Candidate>,
    /// For each of them the number of members of its family.
    pub members: Vec<usize>,
    /// Effects on the noise.
    pub noise: Vec<Candidate>,
    /// Effects that cannot be tested.
    pub not_testable: Vec<NotTestable>,
    /// What the pass over the design says of each candidate.
    pub evidence: Evidence,
}

impl Prospect {
    /// What the pass says of a candidate.
    pub fn entry(&self, candidate: usize) -> &Entry {
        &self.evidence.entries[candidate]
    }
}

/// One sample of so many is looked at.
pub(super) fn stride(problem: &Problem) -> usize {
    let runs = problem.parts.iter().flat_map(|part| &part.runs);
    runs.map(|run| run.record.len()).sum::<usize>().div_ceil(MOST_SAMPLES).max(1)
}

/// The random quantities of an effect that are independent from sample to sample.
pub(super) fn white_randoms(candidate: &Candidate) -> Vec<(String, Unit)> {
    let Some(system) = candidate.systems.iter().flatten().next() else { return Vec::new() };
    let name = &candidate.name;
    let own = |effect: &Option<String>| effect.as_ref().is_some_and(|own| own == name);
    system
        .randoms
        .iter()
        .filter(|random| own(&random.effect) && random.process == Process::White)
        .map(|random| (random.name.clone(), random.unit.clone()))
        .collect()
}

/// Whether an effect patches the noise level of a measurand of a campaign.
pub(super) fn patches_level(
    candidate: &Candidate,
    fitted: &Fitted,
    (campaign, measurand): (usize, usize),
) -> bool {
    let Fitted { problem, recipes, .. } = fitted;
    let one = &problem.parts[campaign].system.assembly.names.measurands[measurand];
    let model = &recipes[campaign].model;
    let head = candidate.selected.head.as_ref().and_then(|head| model.heads.get(head));
    let role = |name: &String| head.and_then(|own| own.get(name)).or_else(|| model.roles.get(name));
    let is_called = |name: &String| role(name).map_or(name, |role| &role.owner) == &one.name;
    let is_read = || head.is_none_or(|own| own.values().any(|role| role.owner == one.name));
    candidate.selected.effect.patches.iter().any(|line| match &line.target {
        Target::Sigma(name) => is_called(name),
        Target::EachAngleSigma => matches!(one.kind, MeasurandKind::Angle { .. }) && is_read(),
        _ => false,
    })
}
