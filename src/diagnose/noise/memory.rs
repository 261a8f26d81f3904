//! Noise with a memory: readings next to each other in time are alike.
//!
//! The correlation of neighbours is tested one-sidedly, `r √n` being normal without a memory. What
//! is found joins the covariance as a Gauss-Markov process ([`GaussMarkov`]) of largest likelihood,
//! one for each component of each measurand, and is judged again beside all else: residuals are
//! then white, and every test is what it would be with white noise. Only what such a process cannot
//! follow is left to the stretches over which scores are summed.
//!
//! | file | answers |
//! |---|---|
//! | `correlated` | whether neighbours in time are alike, and for how long |
//! | `likeliest` | the memory of largest likelihood |

use crate::diagnose::evidence::Entry;
use crate::diagnose::evidence::score::of_gain;
use crate::diagnose::evidence::thresholds::{FURTHER, level};
use crate::diagnose::fitted::Fitted;
use crate::diagnose::found::{Apart, Noise, NoiseEffect};
use crate::diagnose::library::candidate::Candidate;
use crate::diagnose::sequences::{Sequence, sequences};
use crate::diagnose::stage::Stage;
use crate::engine::Problem;
use crate::engine::gauss_markov::{GaussMarkov, NoiseClock};
use crate::estimate::median::upper_median;
use crate::model::Process;

use super::apart::few;

mod correlated;
mod likeliest;

pub(super) use correlated::memory;
pub(in crate::diagnose) use correlated::remembered;
pub(in crate::diagnose) use likeliest::likelihood_of_memory;
use likeliest::{likeliest, likelihood};

/// The residuals that an entry leaves, as if their noise had no memory.
pub(super) fn left_white(stage: &Stage, entry: &Entry) -> Vec<Sequence> {
    let problem = without_memory(&stage.fitted.problem);
    let left = stage.evidence.left(&problem, &stage.fitted.fit.point, entry, usize::MAX);
    sequences(&problem, &left)
}

fn without_memory(problem: &Problem) -> Problem {
    let mut problem = problem.clone();
    for part in &mut problem.parts {
        part.gauss_markov.fill(None);
    }
    problem
}

/// Gain of the likelihood for which a memory is changed.
const WORTH_IT: f64 = 3.0;

/// Lets the memories of a stage's noise follow what is left. `None` where nothing changes.
///
/// Structure is taken off first if it is less probable by chance than memories could make it, an
/// oscillation if far less and it leaves no memory; what each run has for itself never is, for a
/// long memory looks just so.
pub(super) fn remember(stage: &Stage, noise: &mut Noise) -> Option<Fitted> {
    let mut fitted = stage.fitted.clone();
    let structures = stage.structures_over_runs();
    let structure = stage.together(&structures);
    let mut white = left_white(stage, &structure);
    let level = level(white.len() + stage.noise.len());
    let is_off = !noise.apart.is_empty();
    noise.apart.clear();
    if let Some((rest, apart)) = beside_few(stage, &structures, &white, is_off) {
        noise.apart.push(apart);
        white = rest;
    } else if !fitted.problem.has_memory() {
        let own = beside(stage, &white, &structures, &structure);
        if let Some(left) = beside_waves(stage, own, level) {
            white = left;
        } else if !structures.is_empty() {
            let alone = left_white(stage, &stage.evidence.together(&[]));
            if likelihood_of_memory(&alone) > own {
                white = alone;
            }
        }
    }
    let mut changed = false;
    for one in &white {
        let own = &mut fitted.problem.parts[one.part].gauss_markov[one.row];
        if own.is_none() && remembered(one, level).is_none() {
            continue;
        }
        let Some((found, likelihood_found)) = likeliest(one) else { continue };
        if found.time > LONGEST * longest_duration(&white) {
            continue;
        }
        let known = own.unwrap_or(GaussMarkov { share: 0.0, ..found });
        if likelihood_found > likelihood(one, known) + WORTH_IT {
            *own = Some(found);
            changed = true;
        }
    }
    let all = || fitted.problem.parts.iter().flat_map(|part| part.gauss_markov.iter().flatten());
    noise.runs_scatter = all().any(|one| one.time > LONG * typical_duration(&white));
    changed.then_some(fitted)
}

/// Logarithm of the likelihood ratio of memories of what structures leave, these paid for.
fn beside(stage: &Stage, white: &[Sequence], structures: &[usize], together: &Entry) -> f64 {
    likelihood_of_memory(white) - by_chance(stage, structures, together)
}

/// What structure with an oscillation leaves, where that has no memory and is far likelier than
/// something else.
fn beside_waves(stage: &Stage, other: f64, level: f64) -> Option<Vec<Sequence>> {
    let structures = stage.structures_over_samples();
    if !structures.iter().any(|n| stage.is_oscillation(*n)) {
        return None;
    }
    let together = stage.together(&structures);
    let white = left_white(stage, &together);
    let is_likelier = beside(stage, &white, &structures, &together) > other + FURTHER.ln();
    (is_likelier && white.iter().all(|one| remembered(one, level).is_none())).then_some(white)
}

/// Logarithm of the probability of some structures by chance, the choice of each paid for.
fn by_chance(stage: &Stage, structures: &[usize], together: &Entry) -> f64 {
    let choice = |n: &usize| (stage.candidates.len() as f64 * stage.members[*n] as f64).ln();
    let choices: f64 = structures.iter().map(choice).sum();
    of_gain(together.gain(), together.degrees(), 1).ln_p + choices
}

/// What is left beside changes in a few runs, and these, where they are far likelier than what
/// `white` says beside the structures that do without them. Once they are found (`is_off`) memories
/// of other readings do not change that.
fn beside_few(
    stage: &Stage,
    structures: &[usize],
    white: &[Sequence],
    is_off: bool,
) -> Option<(Vec<Sequence>, Apart)> {
    if stage.fitted.problem.has_memory() && !is_off {
        return None;
    }
    let (known, few) = few(stage)?;
    let entries = known.iter().map(|n| stage.entry(*n)).chain([&few.entry]);
    let together = stage.evidence.together(&entries.collect::<Vec<_>>());
    let rest = left_white(stage, &together);
    if is_off {
        return Some((rest, few.apart));
    }
    let own = beside(stage, &rest, &known, &together) - few.choices;
    let other = beside(stage, white, structures, &stage.together(structures));
    (own > other + FURTHER.ln()).then_some((rest, few.apart))
}

/// A memory longer than this part of a run makes runs differ from each other.
const LONG: f64 = 0.05;

/// A memory so many times as long as any run is what each run has for itself: no noise, but
/// structure.
const LONGEST: f64 = 20.0;

/// The median duration of the runs (s).
fn typical_duration(all: &[Sequence]) -> f64 {
    upper_median(&mut durations(all).collect::<Vec<f64>>()).unwrap_or(0.0)
}

/// The longest duration of a run (s).
fn longest_duration(all: &[Sequence]) -> f64 {
    durations(all).fold(0.0, f64::max)
}

fn durations(all: &[Sequence]) -> impl Iterator<Item = f64> {
    let runs = all.iter().flat_map(|one| one.times(NoiseClock::Stamps));
    runs.filter_map(|times| Some(times.last()? - times.first()?))
}

/// The part of each measurand's variance that has no memory, by campaign and measurand.
pub(super) fn white_parts(stage: &Stage, all: &[Sequence]) -> Vec<(usize, usize, f64)> {
    let level = level(all.len() + stage.noise.len());
    let share = |one: &Sequence| match stage.fitted.problem.parts[one.part].gauss_markov[one.row] {
        Some(noise) => noise.share,
        None => remembered(one, level).map_or(0.0, |memory| memory.share),
    };
    all.iter().map(|one| (one.part, one.measurand, 1.0 - share(one))).collect()
}

/// Names noise with a memory; the strongest where there is more. Beside a walk it is the walk's
/// fast end, which its series leaves. `all` is what is left as if there were none.
pub(super) fn name_memory(stage: &Stage, all: &[Sequence], noise: &mut Noise) {
    noise.memories = memories(&stage.fitted.problem);
    let has_process = |candidate: &&Candidate| {
        candidate.selected.effect.parameters.iter().any(|one| one.process == Process::Memory)
    };
    let Some(candidate) = stage.noise.iter().find(has_process) else { return };
    if noise.wanders(&stage.noise) {
        return;
    }
    let level = level(all.len() + stage.noise.len());
    let found = all.iter().filter_map(|one| Some((one, remembered(one, level)?)));
    let Some((one, memory)) = found.min_by(|a, b| a.1.ln_p.total_cmp(&b.1.ln_p)) else { return };
    let part = &stage.fitted.problem.parts[one.part];
    let measurand = &part.system.assembly.names.measurands[one.measurand];
    let share = part.gauss_markov[one.row].map_or(memory.share, |own| own.share);
    let size = part.sigma[one.measurand] * share.sqrt();
    noise.effects.push(NoiseEffect {
        name: candidate.name.clone(),
        selected: None,
        parameter: format!("{}.{}", candidate.name, measurand.name),
        of: part.label.clone(),
        unit: measurand.unit.clone(),
        value: size,
        // The share is known as the correlation of neighbours is.
        sigma: 0.5 * size / (share.max(1e-12) * memory.pairs.sqrt()),
        also: Vec::new(),
        aliases: Vec::new(),
        memory: part.gauss_markov[one.row].map(|own| own.time),
        ln_p: memory.ln_p,
    });
}

/// The memories in the weights, of each measurand the one with the largest part of the variance.
fn memories(problem: &Problem) -> Vec<(String, Option<String>, GaussMarkov)> {
    let mut all = Vec::new();
    for part in &problem.parts {
        for (number, measurand) in part.system.assembly.names.measurands.iter().enumerate() {
            let rows = (0..part.residual_count()).filter(|row| part.measurand_of(*row) == number);
            let largest = rows
                .filter_map(|row| part.gauss_markov[row])
                .max_by(|a, b| a.share.total_cmp(&b.share));
            all.extend(largest.map(|one| (measurand.name.clone(), part.label.clone(), one)));
        }
    }
    all
}
