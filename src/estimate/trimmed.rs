//! A fit that readings which are far out do not bend.
//!
//! It is trimmed as least trimmed squares are (Rousseeuw 1984), but from where another fit stopped:
//! what is far out is left out, the model is fitted again, all readings are looked at from there,
//! and so on until the same ones are out. The caller decides what is far out. Where a fit of
//! all readings is too far off for that, fits to parts of the runs are other starts, and of few
//! samples fits to some of them.

use std::ops::Range;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::engine::{Point, Problem};
use crate::estimate::batch::{FitError, Options, fit};
use crate::estimate::residuals::{Far, Residuals, leave_out, samples, seen_from};

/// Such a fit.
pub(crate) struct TrimmedFit {
    /// Where it stopped.
    pub(crate) point: Point,
    /// All residuals as they are seen from there.
    pub(crate) seen: Vec<Residuals>,
    /// The campaigns without what is far out.
    pub(crate) rest: Problem,
    /// Whether every fit converged.
    pub(crate) converged: bool,
}

/// Fits without what is far out from a point, so many times at most.
pub(crate) fn trimmed_fit(
    problem: &Problem,
    point: &Point,
    rounds: usize,
    far: impl Fn(&Residuals) -> Far,
    options: &Options,
) -> Result<TrimmedFit, FitError> {
    let seen = seen_from(problem, point);
    let mut now = TrimmedFit { point: point.clone(), seen, rest: problem.clone(), converged: true };
    let mut out = Vec::new();
    for _ in 0..rounds {
        let far: Vec<Far> = now.seen.iter().map(&far).collect();
        let new: Vec<Vec<Vec<usize>>> = far.iter().map(samples).collect();
        if new == out || (out.is_empty() && new.iter().flatten().all(Vec::is_empty)) {
            break;
        }
        now.rest = problem.clone();
        now.seen.iter().zip(&far).for_each(|(one, far)| leave_out(&mut now.rest, one.of(), far));
        let fitted = fit(&mut now.rest, now.point, options)?;
        now.converged &= fitted.outcome.is_result();
        (now.point, out) = (fitted.point, new);
        now.seen = seen_from(problem, &now.point);
    }
    Ok(now)
}

/// Parts of each run that other starts are fits to.
const PARTS: usize = 8;

/// Other starts: where fits to one part of each run stop, with the campaigns of that part alone.
/// Where readings are wrong in stretches, some part has few of them. A part that determines too
/// little is no start.
pub(crate) fn starts(
    problem: &Problem,
    point: &Point,
    options: &Options,
) -> impl Iterator<Item = (Point, Problem)> {
    let of_part = move |number: usize| {
        let others = |count: usize| {
            let own = number * count / PARTS..(number + 1) * count / PARTS;
            vec![0..own.start, own.end..count]
        };
        fit_without(problem, point, options, others)
    };
    (0..PARTS).filter_map(of_part)
}

/// Where a fit without some samples of each run stops, and the campaigns without them; `None` where it
/// does not converge. `out` are those of a run of so many samples, run after run.
fn fit_without(
    problem: &Problem,
    point: &Point,
    options: &Options,
    out: impl FnMut(usize) -> Vec<Range<usize>>,
) -> Option<(Point, Problem)> {
    let mut rest = problem.clone();
    rest.leave_out_samples(out);
    let fitted = fit(&mut rest, point.clone(), options).ok()?;
    (fitted.outcome.is_result()).then_some((fitted.point, rest))
}

/// Samples of campaigns that are few enough for other starts to be fits to some samples here and
/// there, and the number of such starts: of few unknowns one in three samples may be wrong, and some
/// start has none of them.
const FEW: usize = 1500;
const DRAWS: usize = 40;
/// Readings of such a start for each unknown.
const FOR_EACH: f64 = 1.5;
const SEED: u64 = 1;

/// Other starts where samples are few and stand for themselves: where fits to some of them stop, drawn
/// at random and always the same.
pub(crate) fn drawn_starts(problem: &Problem, point: &Point, options: &Options) -> Vec<Point> {
    let samples = problem.sample_count();
    let wanted = FOR_EACH * problem.layout.columns.len() as f64;
    let share = wanted / problem.reading_count().max(1) as f64;
    let count = (share * samples as f64).ceil() as usize + 1;
    if samples > FEW || 2 * count > samples {
        return Vec::new();
    }
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let draw = |_| {
        let mut kept = rand::seq::index::sample(&mut random, samples, count).into_vec();
        kept.sort_unstable();
        let mut first = 0;
        let out = |count: usize| {
            let own = first..first + count;
            first = own.end;
            let out = own.clone().filter(|sample| kept.binary_search(sample).is_err());
            out.map(|sample| sample - own.start..sample - own.start + 1).collect()
        };
        fit_without(problem, point, options, out).map(|(point, _)| point)
    };
    (0..DRAWS).filter_map(draw).collect()
}
