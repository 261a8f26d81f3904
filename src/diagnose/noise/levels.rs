//! Levels of the noise: by how much readings scatter otherwise than stated, of each measurand, and in
//! single runs.
//!
//! A run is compared with the median of all by the median of its absolute residuals, which neither wild
//! readings nor long tails move: the logarithm of their ratio has the standard deviation `1.17 / √n`. By how
//! much it scatters otherwise, those of its residuals say that are not wild. What one run has beyond the others
//! would else be taken for an effect that acts there.

use std::collections::BTreeMap;
use std::f64::consts::SQRT_2;

use crate::diagnose::evidence::tail::{ln_below, ln_chi_squared, ln_normal};
use crate::diagnose::evidence::thresholds::{LEAST_RUNS, level};
use crate::diagnose::fitted::Fitted;
use crate::diagnose::found::{Level, Noise, NoiseEffect};
use crate::diagnose::gross::wild::TRIM;
use crate::diagnose::library::candidates::Candidate;
use crate::diagnose::sequences::{NORMAL, OF_A_MEDIAN, Sequence, median, seen_from, sequences};
use crate::diagnose::stage::Stage;
use crate::effect::Target;
use crate::engine::layout::qualified;
use crate::engine::stretches::Left;
use crate::engine::{Part, Point, Problem};
use crate::graph::MeasurandKind;

use super::whiten::Given;

/// Readings of a run from which on its scatter is looked at.
const LEAST_READINGS: usize = 20;
/// A run that scatters less than so many times as much as most is like them.
const UNEVEN: f64 = 1.25;
/// Standard uncertainties by which a level that is not as stated may differ from the scatter.
const FOLLOWS: f64 = 2.0;

/// Neighbours that differ so many times as much as is stated say that this is wrong.
const FAR: f64 = 10.0;

/// Lets runs that scatter otherwise than most have a level of their own, once.
pub(super) fn uneven(stage: &Stage, left: &[Left], noise: &Noise) -> Option<Fitted> {
    let problem = &stage.fitted.problem;
    if problem.parts.iter().any(|part| !part.run_levels.is_empty()) {
        return None;
    }
    let beside = left_beside_oscillations(stage, noise);
    let all = sequences(problem, beside.as_deref().unwrap_or(left));
    let runs: usize = problem.parts.iter().map(|part| part.runs.len()).sum();
    let level = level(runs * all.len()) - std::f64::consts::LN_2;
    let mut fitted = stage.fitted.clone();
    let parts = fitted.problem.parts.iter_mut().enumerate();
    for (p, part) in parts {
        for measurand in 0..part.sigma.len() {
            let own = |one: &&Sequence| one.part == p && one.measurand == measurand;
            let own: Vec<&Sequence> = all.iter().filter(own).collect();
            let scatter: Vec<(usize, Scatter)> = (0..part.runs.len())
                .filter_map(|run| Some((run, Scatter::of(&own, run)?)))
                .collect();
            let usual = |of: &dyn Fn(&Scatter) -> f64| {
                median(&mut scatter.iter().map(|(_, one)| of(one)).collect::<Vec<f64>>())
            };
            let (Some(size), Some(rms)) = (usual(&|one| one.median), usual(&|one| one.rms)) else {
                continue;
            };
            if scatter.len() < LEAST_RUNS {
                continue;
            }
            for (run, one) in &scatter {
                let ratio: f64 = one.rms / rms;
                let deviations = (one.median / size).ln().abs()
                    * (noise.alike() * one.count).sqrt()
                    / OF_A_MEDIAN;
                if ratio.ln().abs() < UNEVEN.ln() || ln_normal(deviations) > level {
                    continue;
                }
                if part.run_levels.is_empty() {
                    part.run_levels = vec![vec![1.0; part.sigma.len()]; part.runs.len()];
                }
                part.run_levels[*run][measurand] = ratio;
            }
        }
    }
    fitted.problem.parts.iter().any(|part| !part.run_levels.is_empty()).then_some(fitted)
}

/// What is left of runs that are compared with each other, where an oscillation was taken off: a noisier
/// run makes one, which must stay.
fn left_beside_oscillations(stage: &Stage, noise: &Noise) -> Option<Vec<Left>> {
    let swings = stage.structures().iter().any(|one| stage.is_oscillation(*one));
    let (problem, point) = (&stage.fitted.problem, &stage.fitted.fit.point);
    swings.then(|| {
        let rest = stage.together(&stage.structures_beside_noise());
        stage.evidence.left(problem, point, &rest, noise.stretch)
    })
}

/// How residuals of a measurand scatter in a run.
struct Scatter {
    /// The median of their sizes, by which a run is found to be uneven.
    median: f64,
    /// The root mean square of those that are not wild, which says by how much: of runs that are chosen for an
    /// extreme median that is too far out.
    rms: f64,
    count: f64,
}

impl Scatter {
    fn of(own: &[&Sequence], run: usize) -> Option<Self> {
        let values = own.iter().flat_map(|one| one.runs[run].iter());
        let mut sizes: Vec<f64> =
            values.filter(|value| !value.is_nan()).map(|value| value.abs()).collect();
        let median = median(&mut sizes).filter(|size| *size > 0.0)?;
        let tame = || sizes.iter().filter(|size| **size <= TRIM * NORMAL * median);
        let rms = (tame().map(|size| size * size).sum::<f64>() / tame().count() as f64).sqrt();
        let count = sizes.len() as f64;
        (sizes.len() >= LEAST_READINGS).then_some(Self { median, rms, count })
    }
}

/// Tells levels that are not as stated, and names the effects of the library that stand for scatter beyond it.
/// What has a memory is no matter of levels: `white` is the part of the variance without.
pub(super) fn name_levels(
    stage: &Stage,
    stated: &[Vec<f64>],
    white: &[(usize, usize, f64)],
    noise: &mut Noise,
) {
    let parts = &stage.fitted.problem.parts;
    for part in parts {
        for (run, levels) in part.runs.iter().zip(&part.run_levels) {
            for (one, factor) in part.system.assembly.names.measurands.iter().zip(levels) {
                if *factor != 1.0 {
                    let run = qualified(part.label.as_deref(), &run.name);
                    noise.run_levels.push((one.name.clone(), run, *factor));
                }
            }
        }
    }
    for (part, stated) in parts.iter().zip(stated) {
        let names = &part.system.assembly.names.measurands;
        for ((measurand, sigma), stated) in names.iter().zip(&part.sigma).zip(stated) {
            if sigma != stated {
                let (measurand, of) = (measurand.name.clone(), part.label.clone());
                noise.levels.push(Level { measurand, of, factor: sigma / stated });
            }
        }
    }
    for candidate in &stage.noise {
        let each: Vec<(Option<String>, Size)> = (0..parts.len())
            .filter_map(|p| {
                Some((parts[p].label.clone(), beyond(stage, candidate, p, stated, white)?))
            })
            .collect();
        let tests = 2 * stage.noise.len() + 1;
        let together = Size::of_all(each.iter().map(|(_, size)| size));
        let differ = together.as_ref().filter(|_| each.len() > 1).is_some_and(|all| {
            let squares = each.iter().map(|(_, one)| ((one.value - all.value) / one.sigma).powi(2));
            ln_chi_squared(squares.sum(), each.len() - 1) <= level(tests)
        });
        let told =
            if differ { each } else { together.map(|size| (None, size)).into_iter().collect() };
        for (of, Size { value, sigma, .. }) in told {
            let ln_p = ln_normal(value / sigma);
            if value > 0.0 && ln_p <= level(tests) {
                noise.effects.extend(named(candidate, of, (value, sigma), ln_p));
            }
        }
    }
}

/// By how much readings scatter beyond what is stated.
struct Size {
    value: f64,
    sigma: f64,
    /// Sum of the squared factors on what is stated, and their number.
    squares: f64,
    count: f64,
    /// Twice the readings that say so.
    freedom: f64,
}

impl Size {
    fn of(squares: f64, count: f64, freedom: f64) -> Self {
        let value = (squares / count).sqrt() - 1.0;
        Self { value, sigma: (1.0 + value) / freedom.max(1.0).sqrt(), squares, count, freedom }
    }

    /// That of several together; `None` of none.
    fn of_all<'a>(all: impl Iterator<Item = &'a Self>) -> Option<Self> {
        let (squares, count, freedom) = all.fold((0.0, 0.0, 0.0), |(s, c, f), one| {
            (s + one.squares, c + one.count, f + one.freedom)
        });
        (count > 0.0).then(|| Self::of(squares, count, freedom))
    }
}

/// By how much the measurands of a campaign that an effect patches scatter beyond what is stated; `None`
/// where it patches none.
fn beyond(
    stage: &Stage,
    candidate: &Candidate,
    p: usize,
    stated: &[Vec<f64>],
    white: &[(usize, usize, f64)],
) -> Option<Size> {
    let part = &stage.fitted.problem.parts[p];
    let (present, mut squares, mut count, mut freedom) = (part.present(), 0.0, 0.0, 0.0);
    for (measurand, (sigma, stated)) in part.sigma.iter().zip(&stated[p]).enumerate() {
        if patches_level(candidate, stage, (p, measurand)) {
            let own = white.iter().filter(|(q, m, _)| (*q, *m) == (p, measurand));
            let white = own.map(|(.., part)| *part).fold(1.0, f64::min);
            squares += white * (sigma / stated).powi(2);
            count += 1.0;
            // How much of the variance has a memory is known less well than the variance.
            freedom += 2.0 * present[measurand] as f64 / if white < 1.0 { 9.0 } else { 1.0 };
        }
    }
    (count > 0.0).then(|| Size::of(squares, count, freedom))
}

/// An effect on the level of noise; `None` where it has no parameter.
fn named(
    candidate: &Candidate,
    of: Option<String>,
    (value, sigma): (f64, f64),
    ln_p: f64,
) -> Option<NoiseEffect> {
    let parameter = candidate.selected.effect.parameters.first()?;
    Some(NoiseEffect {
        name: candidate.name.clone(),
        selected: None,
        parameter: format!("{}.{}", candidate.name, parameter.name),
        of,
        unit: parameter.unit.clone(),
        value,
        sigma,
        also: Vec::new(),
        aliases: Vec::new(),
        memory: None,
        ln_p,
    })
}

/// Whether an effect patches the noise level of a measurand of a campaign.
pub(in crate::diagnose) fn patches_level(
    candidate: &Candidate,
    stage: &Stage,
    (campaign, measurand): (usize, usize),
) -> bool {
    let Fitted { problem, recipes, .. } = &stage.fitted;
    let one = &problem.parts[campaign].system.assembly.names.measurands[measurand];
    let heads = &recipes[campaign].model.heads;
    let head = candidate.selected.head.as_ref().and_then(|head| heads.get(head));
    let is_called = |name: &String| head.and_then(|own| own.get(name)).unwrap_or(name) == &one.name;
    let is_read = || head.is_none_or(|own| own.values().any(|name| *name == one.name));
    candidate.selected.effect.patches.iter().any(|line| match &line.target {
        Target::Sigma(name) => is_called(name),
        Target::EachAngleSigma => matches!(one.kind, MeasurandKind::Angle { .. }) && is_read(),
        _ => false,
    })
}

/// Lets stated uncertainties that are far too small follow how neighbours differ, before anything is judged; whether
/// some are. What is weighed far too much bends the fit of all else, and everything is structure beside it. No
/// effect does that: in a quarter of the runs, those in which they differ least, it moves slowly.
pub(super) fn follow_neighbours(problem: &mut Problem, point: &Point) -> bool {
    let mut found: BTreeMap<(usize, usize), f64> = BTreeMap::new();
    for one in seen_from(problem, point) {
        let mut sizes: Vec<f64> = one.runs.iter().filter_map(|run| of_neighbours(run)).collect();
        sizes.sort_by(f64::total_cmp);
        let Some(quiet) = sizes.get(sizes.len() / 4) else { continue };
        let factor = quiet / problem.parts[one.part].sigma[one.measurand];
        if factor > FAR && factor.is_finite() {
            let known = found.entry((one.part, one.measurand)).or_insert(factor);
            *known = known.min(factor);
        }
    }
    for ((part, measurand), factor) in &found {
        problem.parts[*part].sigma[*measurand] *= factor;
    }
    !found.is_empty()
}

/// The standard deviation of a run's noise, from how neighbours differ: what moves slowly adds nothing. `None` of few.
pub(in crate::diagnose) fn of_neighbours(run: &[f64]) -> Option<f64> {
    let pairs = run.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let mut sizes: Vec<f64> = pairs.filter(|size| !size.is_nan()).collect();
    let are_enough = sizes.len() >= LEAST_READINGS;
    median(&mut sizes).filter(|_| are_enough).map(|size| NORMAL * size / SQRT_2)
}

/// Lets stated uncertainties follow the scatter, where they do not.
pub(super) fn levels(
    stage: &Stage,
    given: &Given,
    left: &[Left],
    unknowns: usize,
    noise: &Noise,
) -> Option<Fitted> {
    let mut fitted = stage.fitted.clone();
    let problem = &mut fitted.problem;
    let all = sequences(problem, left);
    let readings: usize = all.iter().map(|one| one.present().count()).sum();
    let freedom = readings.saturating_sub(unknowns).max(1) as f64 / readings.max(1) as f64;
    let tests = all.len() + stage.noise.len();
    let mut found: Vec<(usize, usize, f64)> = Vec::new();
    for (p, part) in problem.parts.iter().enumerate() {
        for measurand in 0..part.slots().len() {
            let own = || all.iter().filter(|one| one.part == p && one.measurand == measurand);
            let count: usize = own().map(|one| one.present().count()).sum();
            let squares: f64 = own().flat_map(Sequence::present).map(|value| value * value).sum();
            if count < 3 {
                continue;
            }
            let variance = squares / (count as f64 * freedom);
            // Readings without any scatter, as of a simulation, say nothing of their noise.
            if variance <= 0.0 {
                continue;
            }
            let effective = noise.alike() * freedom * count as f64;
            let degrees = (effective.floor() as usize).max(1);
            let squares = degrees as f64 * variance;
            let by_chance = if variance > 1.0 {
                ln_chi_squared(squares, degrees)
            } else {
                ln_below(squares, degrees)
            };
            // With the stated one structure looked stronger than it is, and took more of the scatter away.
            let is_stated = part.sigma[measurand] == given.stated[p][measurand];
            let least =
                if is_stated { level(tests) - std::f64::consts::LN_2 } else { ln_normal(FOLLOWS) };
            if by_chance <= least {
                found.push((p, measurand, variance.sqrt()));
            }
        }
    }
    for (p, measurand, factor) in &found {
        let part: &mut Part = &mut problem.parts[*p];
        part.sigma[*measurand] *= factor;
    }
    (!found.is_empty()).then_some(fitted)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;

    /// Numbers of unit variance.
    fn noise(state: &mut u64) -> f64 {
        let mut draw = || {
            *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (*state >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..12).map(|_| draw()).sum::<f64>() - 6.0
    }

    /// Of many runs alike those with the most extreme medians are not what these say.
    #[test]
    fn runs_chosen_for_their_median_scatter_less_unlike_others() {
        let mut state = 7;
        let runs = (0..400).map(|_| Arc::new((0..60).map(|_| noise(&mut state)).collect()));
        let all = Sequence::of_runs(runs.collect());
        let mut each: Vec<Scatter> = (0..400).filter_map(|run| Scatter::of(&[&all], run)).collect();
        each.sort_by(|a, b| a.median.total_cmp(&b.median));
        for (extreme, sign) in [(&each[..8], -1.0), (&each[392..], 1.0)] {
            let far = |of: &dyn Fn(&Scatter) -> f64| {
                sign * extreme.iter().map(|one| of(one).ln()).sum::<f64>() / 8.0
            };
            let (by_median, by_rms) = (far(&|one| NORMAL * one.median), far(&|one| one.rms));
            assert!(by_median > 0.25 && by_rms < 0.7 * by_median, "{by_median} {by_rms}");
        }
    }

    #[test]
    fn a_wild_reading_and_a_few_readings_say_nothing_of_a_run() {
        let mut state = 8;
        let mut run: Vec<f64> = (0..200).map(|_| noise(&mut state)).collect();
        run[20] = 1e6;
        run[30] = f64::NAN;
        let of = |run: Vec<f64>| Scatter::of(&[&Sequence::of_runs(vec![Arc::new(run)])], 0);
        let found = of(run.clone());
        assert!(found.is_some_and(|one| (one.rms - 1.0).abs() < 0.15 && one.count == 199.0));
        assert!(of(run[..LEAST_READINGS - 1].to_vec()).is_none() && of(vec![0.0; 99]).is_none());
    }
}
