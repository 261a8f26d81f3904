//! The noise, before anything is tested against it: wild readings, levels, jitter, memory.
//!
//! Noise is judged on what is left once every significant structure, of the library or unknown, has
//! been taken off greedily: an effect that is not modelled yet must not pass for noise. Then, in
//! this order,
//!
//! - gross readings are left out ([`crate::diagnose::gross::wild`]), for what they do to a fit
//!   looks like all the rest;
//! - random quantities that the model has are judged again, and such as the readings of one sample
//!   share are looked for ([`super::jitter`]), and put in with their square where it counts
//!   (`square`);
//! - runs that are noisier than most have a level of their own, wild readings are left out
//!   ([`crate::diagnose::gross::wild`]), and the level of each measurand is its scatter over what
//!   is stated;
//! - what wanders from run to run is a random walk ([`super::wander`]), and memory the correlation
//!   of a measurand's neighbours in time ([`super::memory`]), before levels where no walk can be
//!   told from it.
//!
//! Where noise is far from what is stated it begins at how neighbours differ. All of these are
//! tested one-sidedly (but levels, which may be lower than stated, too), and what is accepted
//! enters the covariance. A memory that no Gauss-Markov process follows widens the stretches over
//! which scores are summed.

use crate::diagnose::evidence::score::{LEAST_STRETCHES, STRETCHES};
use crate::diagnose::evidence::thresholds::level;
use crate::diagnose::fitted::{Fitted, rebuilt};
use crate::diagnose::found::{Lost, Noise, NoiseEffect};
use crate::diagnose::gross::wild::{PEELS, name_wild, without_gross, without_wild};
use crate::diagnose::library::wanted::Wanted;
use crate::diagnose::sequences::sequences;
use crate::diagnose::stage::{Kept, Stage};
use crate::engine::Problem;
use crate::engine::stretches::Left;
use crate::estimate::batch::{FitError, Options};
use crate::units::Unit;

use super::excess::name_levels;
use super::given::Given;
use super::jitter::jitter;
use super::levels::levels;
use super::memory::{left_white, memory, name_memory, remember, white_parts};
use super::neighbours::follow_neighbours;
use super::square::square;
use super::uneven::uneven;
use super::variances::judged_again;
use super::wander::{Found, found_walk, may_wander};

/// Rounds of judging the noise and fitting again, and of leaving wild readings out.
const ROUNDS: usize = 8;
const TRIMS: usize = 12;

/// Correlation times in a stretch at least.
const TIMES: f64 = 3.0;

/// A stage whose noise is what its weights say: judged, changed and fitted again until it stands.
/// What was `known` of the noise is judged anew. `None` where the parameters are not determined.
///
/// # Errors
/// [`FitError`] where a model cannot be fitted at all.
pub fn prepare(
    mut fitted: Fitted,
    wanted: &Wanted,
    given: &Given,
    known: &Noise,
    options: &Options,
) -> Result<Option<Stage>, FitError> {
    let mut noise = given.noise();
    let mut kept = Kept::default();
    given.put_into(&mut fitted.problem);
    fitted = fitted.without(&known.selected(), options)?;
    if follow_neighbours(&mut fitted.problem, &fitted.fit.point) {
        fitted = fitted.again(options)?;
    }
    let (mut round, mut peels, mut trims) = (0, 0, 0);
    loop {
        let last = round + 1 >= ROUNDS;
        let Some(mut stage) = Stage::again(fitted, wanted, &mut kept) else {
            return Ok(None);
        };
        let structure = stage.structure();
        noise.stretch = stretch(&stage.fitted.problem, noise.memory);
        let (problem, point) = (&stage.fitted.problem, &stage.fitted.fit.point);
        let left = stage.evidence.left(problem, point, &structure, noise.stretch);
        let white = if problem.has_memory() {
            left_white(&stage, &structure)
        } else {
            sequences(problem, &left)
        };
        if peels < PEELS
            && let Some(changed) = without_gross(&stage, &white, &mut noise)
        {
            // What was scanned beside them, too.
            kept = Kept::default();
            fitted = changed.again(options)?;
            peels += 1;
            continue;
        }
        if !last
            && noise.square.is_none()
            && let Some(selected) = square(&stage, &noise)
            && let Some(changed) = stage.fitted.with(&selected, &[], options)?
        {
            noise.square = Some(selected);
            fitted = changed;
            round += 1;
            continue;
        }
        let unknowns = problem.layout.columns.len() + structure.degrees();
        let wild = noise.wild();
        let changed = if last {
            None
        } else {
            judged_again(&stage, &left, &mut noise)
                .or_else(|| shared(&stage, &left, &mut noise))
                .or_else(|| uneven(&stage, &left, &noise))
                .or_else(|| without_wild(&stage, &white, &mut noise))
                .or_else(|| remember_early(&stage, &mut noise))
                .or_else(|| levels(&stage, given, &left, unknowns, &noise))
        };
        if let Some(changed) = changed {
            fitted = changed.again(options)?;
            if noise.wild() > wild && trims < TRIMS {
                trims += 1;
            } else {
                round += 1;
            }
            continue;
        }
        if !last
            && let Some(found) = found_walk(&stage, &mut noise)
            && let Some(selected) = &found.effect.selected
            && let Some(changed) = given.anew(&stage, &noise, selected, options)?
        {
            // A walk passes for levels and jitter: they are judged again beside it.
            let Found { effect, displaced, .. } = found;
            let rivals = std::mem::take(&mut noise.rivals);
            noise = Noise { effects: vec![effect], rivals, displaced, ..given.noise() };
            fitted = changed;
            (round, peels, trims) = (0, 0, 0);
            continue;
        }
        if !last && let Some(changed) = remember(&stage, &mut noise) {
            fitted = changed.again(options)?;
            round += 1;
            continue;
        }
        if let (true, Some(whole)) = (noise.memory > 0.0, whole_runs(problem)) {
            (noise.stretch, noise.runs_scatter) = (whole, true);
            let structure = stage.together(&stage.structures_over_runs());
            let left = stage.evidence.left(problem, point, &structure, noise.stretch);
            stage.judge_scatter(&left);
        } else if noise.memory > 0.0 {
            noise.stretch = stretch(problem, noise.memory);
            let left = stage.evidence.left(problem, point, &structure, noise.stretch);
            stage.judge_scatter(&left);
        } else {
            stage.judge_scatter(&left);
        }
        name_levels(&stage, &given.stated, &white_parts(&stage, &white), &mut noise);
        name_memory(&stage, &white, &mut noise);
        name_wild(&stage, &mut noise);
        name_lost(&given.lost, &mut noise);
        stage.noise_found = noise;
        return Ok(Some(stage));
    }
}

/// Samples in a stretch: enough stretches over all runs, each of several correlation times.
pub(in crate::diagnose) fn stretch(problem: &Problem, memory: f64) -> usize {
    let runs = problem.parts.iter().flat_map(|part| &part.runs);
    let samples: usize = runs.map(|run| run.record.len()).sum();
    let time = if memory > 0.0 { -1.0 / memory.ln() } else { 0.0 };
    samples.div_ceil(STRETCHES).max((TIMES * time).ceil() as usize).max(1)
}

/// The length of the longest run, where there are runs enough to be stretches by themselves: then
/// memory of any length within a run does no harm.
fn whole_runs(problem: &Problem) -> Option<usize> {
    let lengths = problem.parts.iter().flat_map(|part| &part.runs).map(|run| run.record.len());
    (lengths.clone().count() >= LEAST_STRETCHES).then(|| lengths.max()).flatten()
}

/// Names samples that were lost.
fn name_lost(lost: &[Lost], noise: &mut Noise) {
    let Some(first) = lost.first() else { return };
    noise.effects.push(NoiseEffect {
        name: "lost_samples".to_owned(),
        selected: None,
        parameter: "lost_samples.periods".to_owned(),
        of: None,
        unit: Unit::one(),
        value: first.periods as f64,
        sigma: 0.0,
        also: Vec::new(),
        aliases: Vec::new(),
        memory: None,
        ln_p: lost.iter().map(|one| one.ln_p).fold(0.0, f64::min),
    });
}

/// Puts a random quantity into the model that the readings of a sample share, if one shows and
/// is not in it yet.
fn shared(stage: &Stage, left: &[Left], noise: &mut Noise) -> Option<Fitted> {
    let all = sequences(&stage.fitted.problem, left);
    let level = level(all.len() + stage.noise.len());
    noise.memory = memory(&all, level);
    let mut fitted = stage.fitted.clone();
    let (found, candidate) = jitter(stage, left, level, noise.alike(), &noise.effects)?;
    for (campaign, part) in fitted.problem.parts.iter_mut().enumerate() {
        if let Some(system) = &candidate.systems[campaign] {
            *part = rebuilt(part, (**system).clone());
            fitted.recipes[campaign].effects.push(candidate.selected.clone());
        }
    }
    fitted.set_random(&found.parameter, found.value);
    noise.effects.push(found);
    Some(fitted)
}

/// Where no walk can be told from a memory there is nothing to wait for: levels are judged beside
/// it.
fn remember_early(stage: &Stage, noise: &mut Noise) -> Option<Fitted> {
    if may_wander(stage) { None } else { remember(stage, noise) }
}
