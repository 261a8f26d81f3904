//! Noise with a memory: readings next to each other in time are alike.
//!
//! The correlation of neighbours is tested one-sidedly, `r √n` being normal without a memory. What is
//! found joins the covariance as a Gauss-Markov process ([`GaussMarkov`]) of largest likelihood, one for
//! each component of each measurand, and is judged again beside all else: residuals are then white, and
//! every test is what it would be with white noise. Only what such a process cannot follow is left to
//! the stretches over which scores are summed. Whether a random walk of the whole station is the better
//! reason, likelihoods decide.

use crate::diagnose::evidence::Entry;
use crate::diagnose::evidence::score::of_gain;
use crate::diagnose::evidence::tail::ln_normal;
use crate::diagnose::evidence::thresholds::{FURTHER, LEAST_RUNS, level};
use crate::diagnose::fitted::Fitted;
use crate::diagnose::found::{Apart, Noise, NoiseEffect};
use crate::diagnose::library::candidates::Candidate;
use crate::diagnose::sequences::{Neighbours, Sequence, median, sequences};
use crate::diagnose::stage::Stage;
use crate::engine::Problem;
use crate::engine::gauss_markov::{GaussMarkov, NoiseClock};
use crate::model::Process;

use super::apart::few;
use super::wander::{Found, walk};

/// A random walk that shows, unless one is in the model already, the runs are too few to tell one from
/// structure, or a memory of each measurand by itself is the likelier reason. Its rivals are noted.
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

/// Whether a random walk could be told from structure: there is one in the library, and runs enough.
pub(super) fn may_wander(stage: &Stage) -> bool {
    let runs: usize = stage.fitted.problem.parts.iter().map(|part| part.runs.len()).sum();
    runs >= LEAST_RUNS && stage.noise.iter().any(Candidate::is_walk)
}

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

/// Logarithm of the largest likelihood ratio of noise with memories against white noise of unit variance.
pub(in crate::diagnose) fn likelihood_of_memory(all: &[Sequence]) -> f64 {
    all.iter().map(|one| likeliest(one).map_or(0.0, |(_, likelihood)| likelihood)).sum()
}

/// Logarithm of the likelihood ratio of some noise, with the scatter that is there, against white noise
/// of unit variance.
fn likelihood(one: &Sequence, noise: GaussMarkov) -> f64 {
    let (variance, mut sum) = (one.variance(), 0.0);
    let white = variance.ln();
    // Weights mostly are the same from sample to sample.
    let mut weight = (1.0, 0.0);
    for (run, times) in one.runs.iter().zip(one.times(noise.clock)) {
        let (mut filter, mut state) = (noise.filter(), 0.0);
        for (value, time) in run.iter().zip(times) {
            let gains = filter.next(*time, !value.is_nan());
            state *= gains.decay;
            if !value.is_nan() {
                let left = value - state;
                let squares = value * value - (left * gains.weight).powi(2) / variance;
                if weight.0 != gains.weight {
                    weight = (gains.weight, gains.weight.ln());
                }
                sum += 0.5 * (squares - white) + weight.1;
                state += gains.gain * left;
            }
        }
    }
    sum
}

/// Shares and times (in intervals between samples) from which the likeliest are looked for.
const SHARES: [f64; 7] = [0.03, 0.08, 0.2, 0.4, 0.6, 0.8, 0.95];
const TIMES: usize = 9;
const FIRST_TIME: f64 = 0.7;
const TIME_RATIO: f64 = 2.2;
/// A memory that is shorter than this part of an interval is none.
const LEAST_TIME: f64 = 0.3;
/// Refinements of both.
const REFINED: usize = 24;

/// The Gauss-Markov noise of largest likelihood, with the logarithm of that.
fn likeliest(one: &Sequence) -> Option<(GaussMarkov, f64)> {
    let by_stamps = likeliest_by(one, NoiseClock::Stamps);
    // Both clocks say the same where samples are evenly spaced.
    let interval = |clock| one.interval(clock);
    let (stamps, numbers) = (interval(NoiseClock::Stamps), interval(NoiseClock::Numbers)?);
    if stamps.is_some_and(|stamps| (stamps / numbers).ln().abs() < EVEN) {
        return by_stamps;
    }
    let by_numbers = likeliest_by(one, NoiseClock::Numbers);
    by_stamps.into_iter().chain(by_numbers).max_by(|a, b| a.1.total_cmp(&b.1))
}

/// Logarithm of the ratio of median to mean interval below which samples are evenly spaced.
const EVEN: f64 = 0.05;

/// The same by one clock.
fn likeliest_by(one: &Sequence, clock: NoiseClock) -> Option<(GaussMarkov, f64)> {
    let interval = one.interval(clock)?;
    if one.variance() == 0.0 {
        return None;
    }
    let at = |share: f64, time: f64| {
        let time = time.max(LEAST_TIME * interval);
        let noise = GaussMarkov { share: share.clamp(1e-4, 0.999), time, clock };
        (noise, likelihood(one, noise))
    };
    let times = (0..TIMES).map(|k| FIRST_TIME * interval * TIME_RATIO.powi(k as i32));
    let grid = times.flat_map(|time| SHARES.map(|share| at(share, time)));
    let mut best = grid.max_by(|a, b| a.1.total_cmp(&b.1))?;
    // Shares move on the scale on which 0 and 1 are far away.
    let (mut odds, mut ratio) = (2.0_f64, TIME_RATIO.sqrt());
    for _ in 0..REFINED {
        let GaussMarkov { share, time, .. } = best.0;
        let of_odds = |by: f64| by * share / (1.0 - share + by * share);
        let near = [
            at(of_odds(odds), time),
            at(of_odds(odds.recip()), time),
            at(share, time * ratio),
            at(share, time / ratio),
        ];
        let found = near.into_iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
        if found.1 > best.1 {
            best = found;
        } else {
            (odds, ratio) = (odds.sqrt(), ratio.sqrt());
        }
    }
    Some(best)
}

/// Gain of the likelihood for which a memory is changed.
const WORTH_IT: f64 = 3.0;

/// Lets the memories of a stage's noise follow what is left. `None` where nothing changes.
///
/// Structure is taken off first if it is less probable by chance than memories could make it, an oscillation if
/// far less and it leaves no memory; what each run has for itself never is, for a long memory looks just so.
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

/// What structure with an oscillation leaves, where that has no memory and is far likelier than something else.
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

/// What is left beside changes in a few runs, and these, where they are far likelier than what `white` says
/// beside the structures that do without them. Once they are found (`is_off`) memories of other readings
/// do not change that.
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

/// A memory so many times as long as any run is what each run has for itself: no noise, but structure.
const LONGEST: f64 = 20.0;

/// The median duration of the runs (s).
fn typical_duration(all: &[Sequence]) -> f64 {
    median(&mut durations(all).collect::<Vec<f64>>()).unwrap_or(0.0)
}

/// The longest duration of a run (s).
fn longest_duration(all: &[Sequence]) -> f64 {
    durations(all).fold(0.0, f64::max)
}

fn durations(all: &[Sequence]) -> impl Iterator<Item = f64> {
    let runs = all.iter().flat_map(|one| one.times(NoiseClock::Stamps));
    runs.filter_map(|times| Some(times.last()? - times.first()?))
}

/// Noise with a memory: neighbours in time are alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::diagnose) struct Memory {
    /// Part of the variance that has it.
    share: f64,
    /// Number of pairs of neighbours.
    pairs: f64,
    /// Logarithm of the probability of the neighbours' correlation by chance.
    ln_p: f64,
}

/// Lags at which a memory is fitted.
const LAGS: usize = 24;

/// The memory of a measurand, if it has one: `share · exp(-lag / samples)` through its correlations, by
/// least squares over a grid of times.
pub(in crate::diagnose) fn remembered(one: &Sequence, level: f64) -> Option<Memory> {
    let correlation = |lag: usize| {
        let (mut products, mut count) = (0.0, 0.0);
        for run in &one.runs {
            for (a, b) in run.iter().zip(run.iter().skip(lag)) {
                if !a.is_nan() && !b.is_nan() {
                    products += a * b;
                    count += 1.0;
                }
            }
        }
        (products, count)
    };
    let (squares, all) = correlation(0);
    let (neighbours, pairs) = correlation(1);
    if all == 0.0 || pairs == 0.0 || squares <= 0.0 {
        return None;
    }
    let variance = squares / all;
    let ln_p = ln_normal(neighbours / pairs / variance * f64::sqrt(pairs));
    if ln_p > level {
        return None;
    }
    let lags: Vec<(f64, f64)> = (1..=LAGS)
        .map(|lag| (lag as f64, correlation(lag)))
        .filter(|(_, (_, count))| *count > 0.0)
        .map(|(lag, (products, count))| (lag, products / count / variance))
        .collect();
    let fitted = |samples: f64| {
        let decay = |lag: f64| (-lag / samples).exp();
        let own: f64 = lags.iter().map(|(lag, _)| decay(*lag).powi(2)).sum();
        let both: f64 = lags.iter().map(|(lag, value)| decay(*lag) * value).sum();
        let share = (both / own).clamp(0.0, 1.0);
        let misfit = |(lag, value): &(f64, f64)| (value - share * decay(*lag)).powi(2);
        (lags.iter().map(misfit).sum::<f64>(), share)
    };
    let times = (0..80).map(|k| 0.3 * 1.12_f64.powi(k));
    let best = times.map(fitted).min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(Memory { share: best.1, pairs, ln_p })
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

/// Names noise with a memory; the strongest where there is more. Beside a walk it is the walk's fast end,
/// which its series leaves. `all` is what is left as if there were none.
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
        of: None,
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

/// The largest correlation of neighbours that is more than chance; 0 where there is none.
pub(super) fn memory(all: &[Sequence], level: f64) -> f64 {
    all.iter()
        .map(|one| {
            let mut all = Neighbours::of(&[]);
            for run in &one.runs {
                let own = Neighbours::of(run);
                all.products += own.products;
                all.squares += own.squares;
                all.pairs += own.pairs;
            }
            if all.ln_p() <= level { all.correlation().min(0.99) } else { 0.0 }
        })
        .fold(0.0, f64::max)
}
