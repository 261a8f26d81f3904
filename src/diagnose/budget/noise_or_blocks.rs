//! Noise in competition with basis blocks: which of them explains more of what rows leave.
//!
//! A random walk, a slow noise or a noisier run is fitted by many blocks one after the other, each of
//! which looks significant under white noise that is the same everywhere; and an unmodelled effect
//! makes residuals that are correlated in time and larger in some runs. The log likelihoods decide,
//! each with its price: that of the rows with such noise against that of the rows with the blocks
//! and white noise.

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;

use super::autocorrelation::{Component, gauss_markov, gauss_markov_again, price};
use super::linear::Linear;
use super::noise::{Components, components};
use super::noise_of_runs::{OfRun, noise_of_runs};
use super::selection::Selection;
use super::terms::Term;
use crate::diagnose::thresholds::{ENTER, FAR_BEYOND_STATED};
use crate::engine::Problem;
use crate::engine::gauss_markov::GaussMarkov;

/// Residuals of a component whose noise may be autocorrelated at least.
const LEAST_OF_COMPONENT: usize = 50;
/// Log likelihood beyond which noise is autocorrelated at all: five standard deviations, and the
/// price of two values.
const SURE: f64 = 20.0;
/// The same of a component beside another one of which that is sure.
const LIKELY: f64 = ENTER;
/// Change points that are tried beside autocorrelated noise.
const MOST_CHANGES: usize = 2;
/// Terms that are tried beside it together, and the ln Bayes factor of each.
const MOST_STRONG: u8 = 3;
const STRONG: f64 = 20.0;

/// Gauss-Markov noise of a campaign's residual component.
pub type OfComponent = (usize, usize, GaussMarkov);

/// Noise that explains more than blocks do.
#[derive(Clone, Debug)]
pub enum Instead {
    /// It is autocorrelated.
    Autocorrelated(Vec<OfComponent>),
    /// It differs from run to run.
    OfRuns(Vec<OfRun>),
}

/// The noise that explains more than the blocks of a model do, if there is one. What changes at a
/// moment is no noise: it stays beside it, as rows do, unless the noise explains it, too. Noise that is
/// autocorrelated may be estimated anew where it `may_change`.
pub fn instead_of_blocks(
    linear: &Linear,
    selection: &Selection<'_>,
    model: &[usize],
    may_change: bool,
) -> Option<Instead> {
    let problem = &linear.fitted.problem;
    let those = |stays: &dyn Fn(&Term) -> bool| -> Vec<usize> {
        model.iter().copied().filter(|term| stays(&selection.terms[*term])).collect()
    };
    let with_changes = those(&|term| term.is_effect() || term.change.is_some());
    let rows = those(&Term::is_effect);
    // Without structure autocorrelation is looked for in what is left in the end.
    let has_structure = model.len() > rows.len();
    let has_own_levels = problem.parts.iter().any(|part| !part.run_levels.is_empty());
    if !has_structure && has_own_levels {
        return None;
    }
    let least = if problem.has_autocorrelated_noise() { LIKELY } else { SURE };
    let mut best: Option<(f64, Instead)> = None;
    let mut take = |beyond: f64, found: Instead| {
        if beyond > best.as_ref().map_or(0.0, |(known, _)| *known) {
            best = Some((beyond, found));
        }
    };
    let mut all_kept = vec![(with_changes.clone(), 0.0)];
    if has_structure {
        all_kept.extend(with_one_change(selection, model, &rows));
        all_kept.extend(with_the_strongest(selection, model, &rows));
        if rows != with_changes {
            all_kept.push((rows, 0.0));
        }
    }
    for (kept, price) in &all_kept {
        let mut of_rows = selection.clone();
        of_rows.set_scale(kept);
        let groups = by_blocks(selection, &of_rows, model, kept);
        let by_blocks: f64 = groups.iter().map(|one| one.gained).sum();
        let residuals = components(linear, &of_rows, kept, &mut |_, _| {});
        if has_structure {
            // What blocks explain in one measurand is no noise because that of another one is.
            let may_change =
                |measurand: usize| may_change && of_rows.scale[measurand] <= FAR_BEYOND_STATED;
            let all = autocorrelated(problem, &residuals, &may_change);
            let (mut gained, mut beyond, mut found) = (0.0, 0.0, Vec::new());
            for group in &groups {
                let own = || group.measurands.iter().filter_map(|one| all.get(one));
                let of_noise: f64 = own().map(|one| one.0).sum();
                if of_noise > group.gained {
                    gained += of_noise;
                    beyond += of_noise - group.gained;
                    found.extend(own().flat_map(|one| one.1.iter().copied()));
                }
            }
            if gained > least {
                take(beyond - price, Instead::Autocorrelated(found));
            }
        }
        if !has_own_levels {
            let (gained, found) = noise_of_runs(linear, &residuals);
            if !found.is_empty() {
                take(gained - by_blocks - price, Instead::OfRuns(found));
            }
        }
    }
    best.map(|(_, found)| found)
}

/// The rows with one change point each, and the price of one that the model lacks. A change that
/// blocks absorbed makes the noise look slower and larger than it is; of several in the model some may
/// be that noise.
fn with_one_change(
    selection: &Selection<'_>,
    model: &[usize],
    rows: &[usize],
) -> Vec<(Vec<usize>, f64)> {
    let is_open = |term: &usize| {
        let own = &selection.terms[*term];
        own.change.is_some() && own.may_enter
    };
    let changes: Vec<usize> = (0..selection.terms.len()).filter(is_open).collect();
    let ranked = selection.ranked(rows, &changes);
    let best = ranked.iter().take(MOST_CHANGES).filter(|one| one.ln_bayes >= ENTER);
    let with = best.map(|one| {
        let with = [rows, &[one.term]].concat();
        let is_known = model.contains(&one.term);
        let price = || selection.prices(&with).last().copied().unwrap_or(0.0) + ENTER;
        let price = if is_known { 0.0 } else { price() };
        (with, price)
    });
    with.collect()
}

/// The rows with the strongest structure of the model, one more each time: beside noise that remembers
/// an unmodelled effect is no noise. Each must gain more than its price, which both sides have, by what
/// a term needs to enter. A simpler block over the same covariate is tried in its place: under white noise
/// a wide one absorbs what of the noise goes with the covariate, too.
fn with_the_strongest(
    selection: &Selection<'_>,
    model: &[usize],
    rows: &[usize],
) -> Vec<(Vec<usize>, f64)> {
    let (mut kept, mut all) = (rows.to_vec(), Vec::new());
    for count in 1..=MOST_STRONG {
        let others: Vec<usize> =
            model.iter().copied().filter(|term| !kept.contains(term)).collect();
        let ranked = selection.ranked(&kept, &others);
        let Some(best) = ranked.first().filter(|best| best.ln_bayes >= STRONG) else { break };
        let least = ENTER * f64::from(count);
        for simpler in selection.simpler_over_the_same(best.term) {
            let with = [kept.as_slice(), &[simpler]].concat();
            let price = selection.prices(&with).last().copied().unwrap_or(0.0);
            all.push((with, price + least));
        }
        kept.push(best.term);
        all.push((kept.clone(), least));
    }
    all
}

impl Selection<'_> {
    /// Blocks with fewer values than one, of the same error over the same covariate.
    fn simpler_over_the_same(&self, block: usize) -> impl Iterator<Item = usize> {
        let own = &self.terms[block];
        let of = |term: &Term| {
            let place = term.place.as_ref().filter(|_| term.change.is_none())?;
            Some((place.of.clone(), place.covariate.clone()))
        };
        let place = of(own);
        let is_simpler = move |other: &usize| {
            let other = &self.terms[*other];
            other.may_enter
                && other.columns.len() < own.columns.len()
                && place.is_some()
                && of(other) == place
        };
        (0..self.terms.len()).filter(is_simpler)
    }
}

/// Measurands in which the same blocks act, and by how much these raise the log likelihood of their
/// readings, less their price.
struct Group {
    measurands: Vec<usize>,
    gained: f64,
}

/// What the terms of a model beyond those that are `kept` explain, in groups that have none in common.
fn by_blocks(
    selection: &Selection<'_>,
    of_kept: &Selection<'_>,
    model: &[usize],
    kept: &[usize],
) -> Vec<Group> {
    let gained = |measurand: usize| match selection.sums.readings[measurand] {
        0 => 0.0,
        count => count as f64 * (of_kept.scale[measurand] / selection.scale[measurand]).ln(),
    };
    let single = |one: usize| Group { measurands: vec![one], gained: gained(one) };
    let mut groups: Vec<Group> = (0..selection.scale.len()).map(single).collect();
    for (term, price) in model.iter().zip(selection.prices(model)) {
        if kept.contains(term) {
            continue;
        }
        let acts_in = selection.measurands_of(*term);
        let is_own = |group: &Group| group.measurands.iter().any(|one| acts_in.contains(one));
        let (own, others): (Vec<Group>, Vec<Group>) = groups.into_iter().partition(is_own);
        let sum = own.iter().map(|one| one.gained).sum::<f64>();
        let measurands = own.into_iter().flat_map(|one| one.measurands).collect();
        groups = others;
        groups.push(Group { measurands, gained: sum - price });
    }
    groups
}

/// Gauss-Markov noise of the components of each measurand, and by how much it raises the log likelihood,
/// less its price. Of one that has such noise another is taken: a fit with terms that went since then
/// had absorbed a part of it.
fn autocorrelated(
    problem: &Problem,
    components: &Components,
    may_change: &(dyn Fn(usize) -> bool + Sync),
) -> BTreeMap<usize, (f64, Vec<OfComponent>)> {
    let of_component = |((part, measurand, row), runs): (&(usize, usize, usize), &Component)| {
        let count: usize = runs.values().map(Vec::len).sum();
        if count < LEAST_OF_COMPONENT {
            return None;
        }
        let (noise, own) = match problem.parts[*part].gauss_markov[*row] {
            Some(_) if !may_change(*measurand) => return None,
            Some(known) => gauss_markov_again(runs, known)?,
            None => {
                let (noise, own) = gauss_markov(runs)?;
                (noise, own - price(noise, count))
            }
        };
        Some((*measurand, (*part, *row, noise), own))
    };
    let found: Vec<(usize, OfComponent, f64)> =
        components.par_iter().filter_map(of_component).collect();
    let parts = problem.parts.iter().enumerate();
    let known = parts.filter(|(_, part)| part.gauss_markov.iter().any(Option::is_some));
    let mut sure: BTreeSet<usize> = known.map(|(part, _)| part).collect();
    sure.extend(found.iter().filter(|one| one.2 > SURE).map(|(_, (part, ..), _)| *part));
    let mut all: BTreeMap<usize, (f64, Vec<OfComponent>)> = BTreeMap::new();
    for (measurand, noise, own) in found {
        if sure.contains(&noise.0) && own > LIKELY {
            let (gained, found) = all.entry(measurand).or_default();
            *gained += own;
            found.push(noise);
        }
    }
    all
}
