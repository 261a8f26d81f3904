//! Random walks, tested in the variance.
//!
//! A walk `W` over a time `T` is a sum of sines with independent coefficients (Karhunen and Loève):
//! `W(t) = σ Σ ξ_k √(2 T) / ((k - ½) π) sin((k - ½) π t / T)`. The first sines of every run, and
//! where the walk has come to when the run begins, are columns like those of an effect; of few runs
//! there are more.
//!
//! | file | answers |
//! |---|---|
//! | `sequence` | in which order runs came |
//! | `course` | how a walk goes on from run to run |
//! | `variance` | how large it is, and how unlikely by chance |
//! | `wandering` | what of it is left beyond something known |
//! | `beside` | what is known beside it, and which effects cannot be told from it |
//! | `columns` | how it stands in the model |
//! | [`displaced`] | whether the rig was displaced between runs instead |
//!
//! A walk looks like structure over time and runs, and structure like a walk: significant structure
//! is taken off first as long as it and what it leaves of the walk are clearly likelier than the
//! walk alone. Of the walk and an effect that does for all of it the likelier one is taken; if not
//! clearly so, they are [`Rival`]s. What is accepted joins the model as those columns with a prior
//! each, so that everything that comes later is judged against it. Whether a memory of each
//! measurand by itself is the better reason, likelihoods decide.

use std::ops::RangeInclusive;

use beside::{Close, Structure, beside_structure, of_an_effect};
use columns::select;
use course::{Course, Times};
use displaced::Suspect;
use wandering::{Likeliest, Wandering};

use crate::diagnose::evidence::Entry;
use crate::diagnose::evidence::thresholds::{LEAST_RUNS, level};
use crate::diagnose::found::{Displaced, Noise, NoiseEffect, Rival};
use crate::diagnose::library::candidate::{Candidate, fitting};
use crate::diagnose::library::place::Place;
use crate::diagnose::sequences::sequences;
use crate::diagnose::stage::Stage;

use super::memory::{left_white, likelihood_of_memory};

mod beside;
mod columns;
mod course;
pub mod displaced;
pub(in crate::diagnose) mod sequence;
mod variance;
mod wandering;

/// Sines of each run, of all runs together if these are few: 93 % of a walk's variance, and 98 % of
/// one that goes on in few long runs.
const TERMS: RangeInclusive<usize> = 3..=12;
const OF_ALL: usize = 48;

/// A walk that was found.
pub(super) struct Found {
    pub(super) effect: NoiseEffect,
    /// The logarithm of its likelihood ratio against white noise of unit variance, a memory of what
    /// it leaves included.
    pub(super) likelihood: f64,
    /// The displacements that do for it, if it is no walk.
    pub(super) displaced: Option<Displaced>,
}

/// A random walk that shows, unless one is in the model already, the runs are too few to tell one
/// from structure, or a memory of each measurand by itself is the likelier reason. Its rivals are
/// noted.
pub(super) fn found_walk(stage: &Stage, noise: &mut Noise) -> Option<Found> {
    if noise.wanders(&stage.noise) || !may_wander(stage) {
        return None;
    }
    let rows: usize = stage.fitted.problem.parts.iter().map(|part| part.residual_count()).sum();
    let (found, rivals) = walk(stage, level(rows + stage.noise.len()));
    noise.rivals = rivals;
    let found = found?;
    let alone = likelihood_of_memory(&left_white(stage, &stage.evidence.together(&[])));
    if found.likelihood <= alone {
        noise.rivals.clear();
        return None;
    }
    Some(found)
}

/// Whether a random walk could be told from structure: there is one in the library, and runs
/// enough.
pub(super) fn may_wander(stage: &Stage) -> bool {
    let runs: usize = stage.fitted.problem.parts.iter().map(|part| part.runs.len()).sum();
    runs >= LEAST_RUNS && stage.noise.iter().any(Candidate::is_walk)
}

/// The walk of the library that shows, if one does, and effects from which one cannot be told.
/// `level` is the logarithm of its share of the false alarms.
fn walk(stage: &Stage, level: f64) -> (Option<Found>, Vec<Rival>) {
    let mut rivals = Vec::new();
    let walks = stage.noise.iter().filter(|one| one.is_walk());
    let found = walks.filter_map(|one| tested(stage, one, level, &mut rivals));
    (found.max_by(|a, b| a.likelihood.total_cmp(&b.likelihood)), rivals)
}

fn tested(
    stage: &Stage,
    candidate: &Candidate,
    level: f64,
    rivals: &mut Vec<Rival>,
) -> Option<Found> {
    let fitted = &stage.fitted;
    let runs = fitted.problem.run_names().len();
    let terms = (OF_ALL / runs.max(1)).clamp(*TERMS.start(), *TERMS.end());
    let times = Times::of(&fitted.problem, u8::try_from(terms).unwrap_or(u8::MAX));
    let anywhere = select(candidate, &times, Course::Anywhere, None)?;
    let structures = stage.structures_beside_noise();
    let others = stage.readings_over_runs().into_iter().filter(|one| !structures.contains(one));
    let beside = structures.iter().copied().chain(others).map(|n| &stage.candidates[n]);
    let beside: Vec<&Candidate> = beside.collect();
    let columns = fitting(&fitted.recipes, &anywhere, None)?;
    let wandering = Wandering::of(fitted, &beside, &columns, &times, level)?;
    let entries = &wandering.evidence.entries[..];
    let of_runs: Vec<(&Place, &Entry)> = beside
        .iter()
        .zip(entries)
        .filter_map(|(one, entry)| Some((one.place.as_ref()?, entry)))
        .filter(|(place, _)| place.is_of_runs())
        .collect();
    let displaced = |known: &[Entry], likelihood| {
        let (name, of_runs) = (&candidate.name[..], &of_runs[..]);
        let suspect = Suspect { name, wandering: &wandering, known, of_runs, likelihood };
        suspect.displaced(&fitted.problem)
    };
    // Structure over time follows displacements, too, but not as well.
    let mut found = wandering.beyond(&wandering.evidence.together(&[]))?;
    let (mut jumps, mut known) = (displaced(&[], found.likelihood), 0);
    let all: Vec<Structure> =
        structures.iter().map(|number| Structure::of(stage, *number)).collect();
    // One effect that does for all of them needs no displacements.
    let by_effect = of_an_effect(&wandering, &all);
    jumps = jumps.filter(|one| by_effect.is_none_or(|effect| effect <= one.likelihood));
    if jumps.is_none() {
        let (left, close) = beside_structure(&wandering, found, &all);
        rivals.extend(close.map(|Close { structure, score, likelier }| Rival {
            walk: candidate.name.clone(),
            effect: stage.candidates[structures[structure]].name.clone(),
            score,
            likelier,
        }));
        (found, known) = left?;
    }
    if found.walk.ln_p() > level {
        rivals.retain(|one| one.walk != candidate.name);
        return None;
    }
    if known > 0 {
        jumps = displaced(&entries[..known], found.likelihood);
    }
    let Likeliest { course, walk, likelihood } = found;
    let (variance, spread) = walk.variance();
    let sigma = variance.sqrt();
    let (parameter, others) = candidate.selected.effect.parameters.split_first()?;
    let full = |name: &str| format!("{}.{name}", candidate.name);
    let own = Entry::of(wandering.own.clone());
    let taken: Vec<&Entry> = entries[..known].iter().chain([&own]).collect();
    let rest = wandering.evidence.together(&taken);
    let instead = rivals.iter().filter(|one| one.walk == candidate.name);
    let aliases = instead.map(|one| one.effect.clone()).collect();
    let (problem, point) = (&fitted.problem, &fitted.fit.point);
    let rest = sequences(problem, &wandering.evidence.left(problem, point, &rest, usize::MAX));
    let effect = NoiseEffect {
        name: candidate.name.clone(),
        selected: select(candidate, &times, course, Some(sigma)),
        parameter: full(&parameter.name),
        also: others.iter().map(|one| full(&one.name)).collect(),
        of: None,
        unit: parameter.unit.clone(),
        value: sigma,
        sigma: if sigma > 0.0 { spread / (2.0 * sigma) } else { 0.0 },
        aliases,
        memory: None,
        ln_p: walk.ln_p(),
    };
    let likelihood = likelihood + likelihood_of_memory(&rest);
    Some(Found { effect, likelihood, displaced: jumps })
}
