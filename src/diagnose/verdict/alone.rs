//! A reading that is off in a part of a run: told from noise with a memory, from noisier runs and
//! from wild readings.
//!
//! An instrument that is knocked while a run is recorded, a clock that jumps or a stream that drops
//! out puts what follows in that run beside the model. One run's readings are then like their
//! neighbours, which noise with a memory explains, too, and a few of them pass for wild ones. But
//! noise has its memory in all runs. Readings of the run that shows most are left out, one after
//! the other, and the model is fitted again; where nothing is left that has a memory after a few,
//! and a memory of those alone is far likelier than one of all, they are what happened. Whether the
//! other readings fit without them is for [`mod@crate::diagnose::search`] to say.
//!
//! What is off in a run from its beginning to its end is told by [`crate::diagnose::noise::apart`]
//! or [`crate::diagnose::gross::wild`], too.

use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;

use crate::diagnose::evidence::thresholds::{FURTHER, level};
use crate::diagnose::fitted::Fitted;
use crate::diagnose::found::{LeftOut, Lost};
use crate::diagnose::gross::empty_runs::without_empty_runs;
use crate::diagnose::gross::left_out::{leave_runs_out, runs_out};
use crate::diagnose::gross::wild::{ONE_OF, TRIM};
use crate::diagnose::library::place::Place;
use crate::diagnose::library::wanted::Wanted;
use crate::diagnose::noise::given::Given;
use crate::diagnose::noise::memory::{likelihood_of_memory, remembered};
use crate::diagnose::search::{Search, search};
use crate::diagnose::sequences::{Neighbours, OfRun, Sequence, seen_from};
use crate::diagnose::verdict;
use crate::engine::Problem;
use crate::estimate::batch::{FitError, Options};
use crate::estimate::calibrate::{Calibration, calibrate};
use crate::estimate::median::upper_median;

/// Part of all that neighbours have in common that the run which shows most has at least.
const MOST_OF_IT: f64 = 0.25;
/// Part of what a run has beyond noise that one value in a stretch of it explains, for that to be
/// what happened.
const ONE_VALUE: f64 = 0.9;
/// Ends of stretches that are looked at in a run.
const ENDS: usize = 150;

/// What a few runs have for themselves.
pub(super) struct Alone {
    /// The residuals as they are seen where the model was fitted without them.
    all: Vec<Sequence>,
    /// Beyond what those of each sequence are wild.
    limits: Vec<f64>,
    /// The measurands and runs.
    off: BTreeSet<OfRun>,
}

/// What is found without the readings of a few runs that are off there alone, be it beside the
/// effects that were adopted with them, and the nominal model without them; `None` where there are
/// none, where effects or other runs explain what is there, or where something is left without
/// them.
pub(in crate::diagnose) fn without_alone(
    found: &Search,
    fitted: &Fitted,
    (lost, gross): (&[Lost], &LeftOut),
    wanted: &Wanted,
    options: &Options,
) -> Result<Option<(Calibration, Search)>, FitError> {
    let (of_nominal, beside_effects) = verdict::runs_in_doubt(found);
    let mut models = vec![(fitted.clone(), of_nominal)];
    let is_beside = beside_effects > 0 && !found.adopted.is_empty();
    if let Some(last) = found.stages.last().filter(|_| is_beside) {
        let mut with = last.fitted.clone();
        Given::of(&fitted.problem).put_into(&mut with.problem);
        models.push((with.without(&last.noise_found.selected(), options)?, beside_effects));
    }
    for (model, most) in models.into_iter().filter(|(_, most)| *most > 0) {
        let Some(alone) = alone(&model, most, options)? else { continue };
        let (mut problem, mut gross) = (fitted.problem.clone(), gross.clone());
        gross.extend(alone.leave_out(&mut problem));
        problem = without_empty_runs(&problem).unwrap_or(problem);
        let nominal = calibrate(problem.clone(), options)?;
        if !nominal.is_sound() {
            continue;
        }
        let recipes = fitted.recipes.clone();
        let rest = Fitted { recipes, problem, fit: nominal.fit.clone() };
        let found = search(rest, (lost, &gross), wanted, options)?;
        if let Some(found) = found.filter(verdict::is_clear) {
            return Ok(Some((nominal, found)));
        }
    }
    Ok(None)
}

/// What a few runs, so many at most, have for themselves in a model with noise as it is stated;
/// `None` where there is nothing of the kind.
pub(super) fn alone(
    whole: &Fitted,
    most: usize,
    options: &Options,
) -> Result<Option<Alone>, FitError> {
    let count: usize = whole.problem.parts.iter().map(|part| part.runs.len()).sum();
    let first = seen_from(&whole.problem, &whole.fit.point);
    let mut off: BTreeSet<OfRun> = BTreeSet::new();
    let (mut rest, mut left) = (whole.clone(), clipped(&first, &limits_of(&first)));
    while let Shown::InOne(one) = shown(&left) {
        off.insert(one);
        let runs: BTreeSet<(usize, usize)> = off.iter().map(|one| (one.part, one.run)).collect();
        if runs.len() > most || ONE_OF * runs.len() > count {
            return Ok(None);
        }
        leave_runs_out(&mut rest.problem, &BTreeSet::from([one]));
        rest = rest.again(options)?;
        if !rest.is_sound() {
            return Ok(None);
        }
        let seen = seen_from(&rest.problem, &rest.fit.point);
        left = clipped(&seen, &limits_of(&seen));
    }
    if off.is_empty() || matches!(shown(&left), Shown::InAll) {
        return Ok(None);
    }
    let all = seen_from(&whole.problem, &rest.fit.point);
    let limits = limits_of(&left);
    let [before, after] = [&first, &all].map(|seen| clipped(seen, &limits));
    let places: usize =
        whole.problem.parts.iter().map(|one| one.runs.len() * one.slots().len()).sum();
    let choices = (off.len() as f64) * (places as f64 * FURTHER).ln();
    let is_likelier = likelihood_apart(&after, &off) - choices > likelihood_together(&before, &off);
    Ok(is_likelier.then_some(Alone { all, limits, off }))
}

impl Alone {
    /// Leaves those readings out of campaigns.
    pub(super) fn leave_out(&self, problem: &mut Problem) -> LeftOut {
        runs_out(problem, &self.all, &self.off, |problem, one| self.place(problem, one))
    }

    /// Where one of them is off.
    fn place(&self, problem: &Problem, one: OfRun) -> Place {
        let record = &problem.parts[one.part].runs[one.run].record;
        let (run, name) = one.names(problem);
        let is_own = |all: &Sequence| (all.part, all.measurand) == (one.part, one.measurand);
        let own = self.all.iter().zip(&self.limits).filter(|(all, _)| is_own(all));
        // Of several components the one that shows most.
        let shown = own.map(|(all, limit)| without_wild(&all.runs[one.run], *limit));
        let products = |run: &[f64]| Neighbours::of(run).products;
        let most = shown.max_by(|a, b| products(a).total_cmp(&products(b)));
        let samples = most.and_then(|run| Some((stretch_off(&run)?, run.len())));
        let rows = samples.map(|(samples, count)| {
            let last = (samples.end < count).then(|| record.row(samples.end - 1));
            (record.row(samples.start), last)
        });
        Place::of_rows(&name, &run, rows)
    }
}

/// Beyond what residuals of each sequence are wild.
fn limits_of(all: &[Sequence]) -> Vec<f64> {
    all.iter().map(|one| TRIM * one.deviation().unwrap_or(f64::INFINITY)).collect()
}

/// Residuals of which wild ones count as their limit: a few of them next to each other are no
/// stretch.
fn clipped(all: &[Sequence], limits: &[f64]) -> Vec<Sequence> {
    let clip = |(one, limit): (&Sequence, &f64)| {
        // NaN stays.
        let clip = |value: &f64| value.clamp(-limit, *limit);
        let runs = one.runs.iter().map(|run| Arc::new(run.iter().map(clip).collect()));
        Sequence { runs: runs.collect(), ..one.clone() }
    };
    all.iter().zip(limits).map(clip).collect()
}

/// A run of which the wild readings are no more than twice as far out as most beyond a limit: a few
/// are no stretch.
fn without_wild(run: &[f64], limit: f64) -> Vec<f64> {
    let beyond = run.iter().map(|value| value.abs()).filter(|size| *size > limit);
    let most = 2.0 * upper_median(&mut beyond.collect::<Vec<f64>>()).unwrap_or(0.0);
    let limit = limit.max(most);
    run.iter().map(|value| value.clamp(-limit, limit)).collect()
}

/// Where neighbours are alike.
enum Shown {
    /// Nowhere.
    Nowhere,
    /// In one measurand of one run more than anywhere else.
    InOne(OfRun),
    /// Not in one run more than in others.
    InAll,
}

fn shown(all: &[Sequence]) -> Shown {
    let runs: usize = all.iter().map(|one| one.runs.len()).sum();
    let (mut most, mut has_memory): (Option<(f64, OfRun)>, _) = (None, false);
    for one in all.iter().filter(|one| remembered(one, level(runs)).is_some()) {
        let Some(deviation) = one.deviation().filter(|deviation| *deviation > 0.0) else {
            continue;
        };
        let each: Vec<Neighbours> = one.runs.iter().map(|run| Neighbours::of(run)).collect();
        let common: f64 = each.iter().map(|run| run.products.max(0.0)).sum();
        let is_alike = |run: &&(usize, &Neighbours)| {
            run.1.ln_p() <= level(runs) && run.1.products >= MOST_OF_IT * common
        };
        let strongest = each.iter().enumerate().filter(|run| is_alike(&run));
        has_memory = true;
        let strongest = strongest.max_by(|a, b| a.1.products.total_cmp(&b.1.products));
        // What is off in one run bends the fit of others, too: they are looked at without it.
        let Some((run, found)) = strongest else { continue };
        let size = found.products / deviation.powi(2);
        if most.is_none_or(|(known, _)| size > known) {
            most = Some((size, OfRun { part: one.part, measurand: one.measurand, run }));
        }
    }
    match most {
        Some((_, one)) => Shown::InOne(one),
        None if has_memory => Shown::InAll,
        None => Shown::Nowhere,
    }
}

/// Logarithm of the likelihood of residuals with a memory of each sequence, but for a constant.
fn likelihood(all: &[Sequence]) -> f64 {
    let squares: f64 = all.iter().flat_map(Sequence::present).map(|value| value * value).sum();
    likelihood_of_memory(all) - 0.5 * squares
}

/// The same where readings of some runs have a memory and a level of their own.
fn likelihood_apart(all: &[Sequence], off: &BTreeSet<OfRun>) -> f64 {
    let others = all.iter().map(|one| one.among(|run| !one.is_among(off, run)));
    let each = all.iter().flat_map(|one| {
        let own = (0..one.runs.len()).filter(|run| one.is_among(off, *run));
        own.map(|run| one.among(|other| other == run))
    });
    likelihood(&others.chain(each).collect::<Vec<_>>())
}

/// The same where they have a level of their own, but one memory with the others.
fn likelihood_together(all: &[Sequence], off: &BTreeSet<OfRun>) -> f64 {
    let mut of_levels = 0.0;
    let even = all.iter().map(|one| {
        let rest = one.among(|run| !one.is_among(off, run)).variance();
        let mut even = one.clone();
        for run in (0..one.runs.len()).filter(|run| one.is_among(off, *run)) {
            let own = one.among(|other| other == run);
            let ratio = (own.variance() / rest).sqrt();
            if ratio.is_finite() && ratio > 0.0 {
                of_levels -= own.present().count() as f64 * ratio.ln();
                even.runs[run] =
                    Arc::new(one.runs[run].iter().map(|value| value / ratio).collect());
            }
        }
        even
    });
    let even: Vec<Sequence> = even.collect();
    likelihood(&even) + of_levels
}

/// The samples of a run from which on, or in which alone, one value explains what there is beyond
/// noise; `None` where that is not what happened.
fn stretch_off(run: &[f64]) -> Option<Range<usize>> {
    let (mut sums, mut counts) = (vec![0.0], vec![0.0]);
    for value in run {
        let present = !value.is_nan();
        sums.push(sums[sums.len() - 1] + if present { *value } else { 0.0 });
        counts.push(counts[counts.len() - 1] + f64::from(u8::from(present)));
    }
    let count = counts[run.len()];
    if count == 0.0 {
        return None;
    }
    let explained = |range: &Range<usize>| {
        let count: f64 = counts[range.end] - counts[range.start];
        let sum: f64 = sums[range.end] - sums[range.start];
        if count > 0.0 { sum * sum / count } else { 0.0 }
    };
    let best = |starts: &[usize], ends: &[usize]| {
        let pairs = starts.iter().flat_map(|start| ends.iter().map(|end| *start..*end));
        pairs
            .filter(|range| range.start < range.end)
            .max_by(|a, b| explained(a).total_cmp(&explained(b)))
    };
    // Roughly first, then sample by sample about each end.
    let step = run.len().div_ceil(ENDS).max(1);
    let rough: Vec<usize> = (0..run.len()).step_by(step).chain([run.len()]).collect();
    let found = best(&rough, &rough)?;
    let about = |at: usize| -> Vec<usize> {
        (at.saturating_sub(step)..=(at + step).min(run.len())).collect()
    };
    let found = best(&about(found.start), &[found.end])?;
    let found = best(&[found.start], &about(found.end))?;
    // Where two ends do no more than chance lets the best ones do, the run is off as a whole.
    let squares: f64 = run.iter().filter(|value| !value.is_nan()).map(|value| value * value).sum();
    let noise = (squares - explained(&found)) / count;
    let gain = explained(&found) - explained(&(0..run.len()));
    let is_whole = gain <= 4.0 * count.ln() * noise;
    // Neighbours have in common what is no noise.
    let beyond = Neighbours::of(run).products;
    (!is_whole && explained(&found) >= ONE_VALUE * beyond).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stream::Stream;

    /// Noise of unit variance.
    fn noise(seed: u64, count: usize) -> Vec<f64> {
        let mut stream = Stream(seed);
        (0..count).map(|_| stream.normal()).collect()
    }

    fn with_a_step(mut run: Vec<f64>, samples: Range<usize>, by: f64) -> Vec<f64> {
        run[samples].iter_mut().for_each(|value| *value += by);
        run
    }

    #[test]
    fn a_stretch_is_found_where_it_is() {
        let run = |samples| with_a_step(noise(5, 300), samples, 8.0);
        assert_eq!(stretch_off(&run(120..300)), Some(120..300));
        assert_eq!(stretch_off(&run(0..31)), Some(0..31));
        assert_eq!(stretch_off(&run(77..190)), Some(77..190));
        assert_eq!(stretch_off(&run(0..300)), None);
        // Nor has a small offset of a whole run an end.
        for seed in 0..50 {
            for by in [1.0, 2.0, 4.0] {
                assert_eq!(stretch_off(&with_a_step(noise(seed, 119), 0..119, by)), None);
            }
        }
        // A wild reading is no stretch, before a step or without one.
        let mut wild = run(120..300);
        wild[40..43].fill(900.0);
        assert_eq!(stretch_off(&without_wild(&wild, 4.5)), Some(120..300));
        assert_eq!(stretch_off(&[f64::NAN; 9]), None);
        // Missing readings belong to no side of an end.
        let mut holey = run(120..300);
        holey[110..125].fill(f64::NAN);
        holey[290..].fill(f64::NAN);
        let found = stretch_off(&holey).map_or(0..0, |found| found);
        assert!((110..=125).contains(&found.start) && found.end >= 290, "{found:?}");
        // What grows is no step.
        let ramp = noise(6, 300)
            .iter()
            .enumerate()
            .map(|(k, value)| value + 0.05 * k as f64)
            .collect::<Vec<_>>();
        assert_eq!(stretch_off(&ramp), None);
        assert_eq!(stretch_off(&[]), None);
        // A long run is looked at roughly first.
        assert_eq!(
            stretch_off(&with_a_step(noise(7, 20_000), 6_543..20_000, 8.0)),
            Some(6_543..20_000)
        );
    }

    #[test]
    fn what_one_run_shows_is_not_in_all() {
        let of =
            |each: Vec<Vec<f64>>| vec![Sequence::of_runs(each.into_iter().map(Arc::new).collect())];
        let plain = |run: u64| noise(run + 1, 300);
        assert!(matches!(shown(&of((0..8).map(plain).collect())), Shown::Nowhere));
        let one = |run| if run == 5 { with_a_step(plain(run), 100..300, 2.0) } else { plain(run) };
        let found = shown(&of((0..8).map(one).collect()));
        assert!(matches!(found, Shown::InOne(one) if one.run == 5));
        let all = |run| with_a_step(plain(run), 100..300, 2.0);
        assert!(matches!(shown(&of((0..8).map(all).collect())), Shown::InAll));
    }
}
