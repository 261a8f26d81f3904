//! The model beside which moments are looked for: its noise is white, and as large as neighbours
//! differ.
//!
//! What is off for a while adds nothing to that, whatever levels, memories and wild readings it was
//! taken for.

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::diagnose::fitted::{Fitted, carried};
use crate::diagnose::found::{Level, Reading};
use crate::diagnose::gross::spikes::NEIGHBOURS;
use crate::diagnose::noise::neighbours::of_neighbours;
use crate::diagnose::sequences::{Sequence, seen_from, sequences};
use crate::diagnose::stage::Stage;
use crate::engine::Problem;
use crate::engine::layout::qualified;
use crate::engine::stretches::Left;
use crate::estimate::batch::{FitError, Options};
use crate::estimate::median::upper_median;
use crate::system::Selected;

/// A run scatters otherwise than most by so much at least, and by so many standard uncertainties.
const UNEVEN: f64 = 1.25;
const CLEARLY: f64 = 4.0;
/// Readings that say as much of a standard deviation by how they differ from their neighbours as
/// one does by itself.
pub(super) const WORTH: f64 = 3.3;

/// The model of a stage with white noise as neighbours differ, some runs as they are given; `None`
/// where it cannot be fitted.
pub(super) fn white(
    stage: &Stage,
    given: &Problem,
    back: &[String],
    options: &Options,
) -> Result<Option<Fitted>, FitError> {
    let is_walk = |name: &str| stage.noise.iter().any(|one| one.is_walk() && one.name == name);
    let walks = stage.noise_found.effects.iter().filter(|one| is_walk(&one.name));
    let walks: Vec<&Selected> = walks.filter_map(|one| one.selected.as_ref()).collect();
    let mut model = match walks.as_slice() {
        [] => stage.fitted.clone(),
        walks => stage.fitted.without(walks, options)?,
    };
    if !back.is_empty() {
        let mut parts = model.problem.parts.clone();
        for (own, given) in parts.iter_mut().zip(&given.parts) {
            let known = std::mem::replace(&mut own.runs, given.runs.clone());
            for run in &mut own.runs {
                let is_back = back.contains(&qualified(own.label.as_deref(), &run.name));
                let known = known.iter().find(|one| !is_back && one.name == run.name);
                if let Some(known) = known {
                    run.clone_from(known);
                }
            }
        }
        let problem = Problem::new(parts);
        model.fit.point = carried(&model.problem, &model.fit.point, &problem);
        model.problem = problem;
    }
    for part in &mut model.problem.parts {
        part.gauss_markov.fill(None);
        part.run_levels.clear();
    }
    let seen = seen_from(&model.problem, &model.fit.point);
    levelled(model, &seen, options)
}

/// The runs in which more readings next to each other are wild than single ones are: something is
/// off there.
pub(super) fn lasting<'a>(wild: impl Iterator<Item = &'a Reading>) -> BTreeSet<String> {
    let mut all: Vec<_> = wild.map(|one| (&one.run, &one.measurand, one.row)).collect();
    all.sort_unstable();
    let groups = all.chunk_by(|a, b| (a.0, a.1, a.2 + 1) == (b.0, b.1, b.2));
    groups.filter(|group| group.len() > NEIGHBOURS).map(|group| group[0].0.to_string()).collect()
}

/// A model with the levels that sequences say, by how neighbours differ; `None` where it cannot be
/// fitted.
pub(super) fn levelled(
    mut model: Fitted,
    all: &[Sequence],
    options: &Options,
) -> Result<Option<Fitted>, FitError> {
    for (p, part) in model.problem.parts.iter_mut().enumerate() {
        part.run_levels = vec![vec![1.0; part.sigma.len()]; part.runs.len()];
        for (measurand, sigma) in part.sigma.iter_mut().enumerate() {
            let own = || all.iter().filter(|one| (one.part, one.measurand) == (p, measurand));
            let of_run = |run: usize| {
                let all = own().filter_map(|one| of_neighbours(&one.runs[run]));
                upper_median(&mut all.collect::<Vec<f64>>()).filter(|size| *size > 0.0)
            };
            let each: Vec<Option<f64>> = (0..part.runs.len()).map(of_run).collect();
            let Some(usual) =
                upper_median(&mut each.iter().flatten().copied().collect::<Vec<f64>>())
            else {
                continue;
            };
            *sigma = usual;
            for (run, size) in each.iter().enumerate() {
                let count = own().map(|one| one.readings(run).len()).sum();
                let ratio = size.unwrap_or(usual) / usual;
                // A few readings may seem quiet by chance; to count them as noisy only hides
                // something.
                if ratio > 1.0 && differs(ratio, count) {
                    part.run_levels[run][measurand] = ratio;
                }
            }
        }
    }
    let model = model.again(options)?;
    Ok(model.is_sound().then_some(model))
}

/// Whether a standard deviation from so many neighbours is clearly another one than what it is a
/// multiple of.
fn differs(ratio: f64, count: usize) -> bool {
    let uncertainty = (WORTH / (2.0 * count.max(1) as f64)).sqrt();
    ratio.ln().abs() > UNEVEN.ln().max(CLEARLY * uncertainty)
}

/// The levels that are not as given.
pub(super) fn levels(problem: &Problem, given: &Problem) -> Vec<Level> {
    let mut all = Vec::new();
    for (part, given) in problem.parts.iter().zip(&given.parts) {
        let names = &part.system.assembly.names.measurands;
        let each = names.iter().zip(&part.sigma).zip(&given.sigma).zip(part.present());
        for (((one, sigma), stated), count) in each {
            let factor = sigma / stated;
            if differs(factor, count) {
                all.push(Level { measurand: one.name.clone(), of: part.label.clone(), factor });
            }
        }
    }
    all
}

/// Whitened residuals as they are.
pub(super) fn as_read(problem: &Problem, left: &[Left]) -> Vec<Sequence> {
    let mut all = sequences(problem, left);
    for one in &mut all {
        let part = &problem.parts[one.part];
        for (run, values) in one.runs.iter_mut().enumerate() {
            let level = part.run_levels.get(run).map_or(1.0, |levels| levels[one.measurand]);
            let sigma = level * part.sigma[one.measurand];
            *values = Arc::new(values.iter().map(|value| sigma * value).collect());
        }
    }
    all
}
