//! Lost samples: stretches of a run whose readings belong to moments whole sample periods away.
//!
//! An instrument that drops a sample, or a logger that skips a trigger, puts reading `i` beside the
//! stamp of trigger `i`, though it was taken at trigger `i + n`. For each of some dozen shifts `n`
//! every reading is compared with the prediction at sample `i + n`; the stretch over which that
//! lowers the sum of squares most is the stretch of largest sum (Bentley's and Kadane's scan). A
//! shift is a simple hypothesis, so for one stretch and one shift the probability of such a gain
//! `G` by chance is below `exp(-G / 2)` (Markov's inequality for a likelihood ratio), and all
//! stretches and shifts are corrected for.
//!
//! A step of the clock shifts a stretch, too, but by any time. Samples were lost only where the
//! stamps of whole samples fit as well as the best shift of the clock (`shifted`), and better than an
//! offset of the stretch: a table of stops with equal steps cannot tell the two apart. Other shifts are
//! *jumps* of the clock: no model that is linear in the step sees one that is long beside the
//! motion, so the search begins with them (`budget::driver`).
//!
//! A shift by a whole period is large: several degrees of a fast arm. It spoils the fit in which it
//! is looked for, so that is made without what is far out (`trimmed`), residuals are measured by
//! their own robust scatter, and only stretches that a shift carries from far out (`FAR`) back
//! among the others (`NEAR`) count. Where no part of a run has the majority, no such fit is right:
//! then fits to an eighth of each run are tried. What is found is left out, the rest is fitted
//! again, and the search is repeated. It looks at single shifts of a run's own readings; a delay
//! that wanders is not its business.

use std::ops::Range;

use crate::diagnose::found::Lost;
use crate::diagnose::thresholds::LOST;
use crate::engine::{Point, Problem};
use crate::estimate::batch::{FitError, Options, fit};
use crate::estimate::residuals::{Residuals, residuals_from};
use crate::estimate::trimmed::{TrimmedFit, starts, trimmed_fit};
use crate::statistics::robust;

use super::shifted::Shifted;

/// Stretches of one run at most.
const MOST: usize = 10;
/// Rounds of fitting without what is far out.
const ROUNDS: usize = 6;
/// What is far out, in robust standard deviations.
const OUTLIER: f64 = 3.5;
/// Variance factor below which no samples are looked for that were lost.
pub(super) const GROSS_FACTOR: f64 = 4.0;
/// A variance factor beyond which something is wrong altogether: a few runs, or many readings.
pub(super) const SPOILT: f64 = 100.0;
/// Mean squares of the rest that differ by such a factor at most are alike.
const ALIKE: f64 = 2.0;
/// Rounds of looking for lost samples, leaving them out and fitting again.
pub const LOOKS: usize = 4;

/// A stretch of a run whose stamps are off by another time than whole samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Jump {
    /// Index of the campaign.
    pub part: usize,
    /// Index of the run.
    pub run: usize,
    /// Its samples.
    pub samples: Range<usize>,
    /// How much later its readings were taken than the others by their stamps (s).
    pub seconds: f64,
}

/// Stretches of runs that belong to other moments.
#[derive(Clone, Debug, Default)]
pub struct Elsewhere {
    /// Whole samples away.
    pub lost: Vec<Lost>,
    /// Any time away.
    pub jumps: Vec<Jump>,
}

impl Elsewhere {
    fn is_empty(&self) -> bool {
        self.lost.is_empty() && self.jumps.is_empty()
    }

    /// How many samples that are.
    fn samples(&self) -> usize {
        let jumps = self.jumps.iter().map(|one| &one.samples);
        self.lost.iter().map(|one| &one.samples).chain(jumps).map(Range::len).sum()
    }

    /// Leaves their readings out.
    fn leave_out(&self, problem: &mut Problem) {
        leave_out(problem, &self.lost);
        self.jumps.iter().for_each(|one| without(problem, (one.part, one.run), &one.samples));
    }
}

/// The stretches that a fit shows, beside one that they do not spoil; none without a large misfit.
pub fn look(
    problem: &Problem,
    point: &Point,
    variance_factor: Option<f64>,
    options: &Options,
) -> Result<Elsewhere, FitError> {
    if variance_factor.is_none_or(|factor| factor < GROSS_FACTOR) {
        return Ok(Elsewhere::default());
    }
    let robust = robust_fit(problem, point, false, options)?;
    let found = find(problem, &robust.point, &robust.seen);
    if !found.lost.is_empty() || variance_factor.is_none_or(|factor| factor < SPOILT) {
        return Ok(found);
    }
    let others = starts(problem, point, options).filter_map(|(point, own)| {
        let found = find(problem, &point, &residuals_from(&own, &point));
        let mut rest = problem.clone();
        found.leave_out(&mut rest);
        let cost = fit(&mut rest, point, options).ok()?.cost;
        (!found.is_empty()).then(|| (cost / rest.component_count().max(1) as f64, found))
    });
    let others: Vec<(f64, Elsewhere)> = others.collect();
    // Each part of a run may be the one that all others are shifted against: the largest is.
    let least = others.iter().map(|one| one.0).fold(f64::INFINITY, f64::min);
    let alike = others.into_iter().filter(|one| one.0 <= ALIKE * least).map(|one| one.1);
    Ok(alike.min_by_key(Elsewhere::samples).unwrap_or_default())
}

/// The stretches of all runs, at a point; `sound` are residuals from which their scatter is taken.
fn find(problem: &Problem, point: &Point, sound: &[Residuals]) -> Elsewhere {
    let runs: usize = problem.parts.iter().map(|part| part.runs.len()).sum();
    let mut found = Elsewhere::default();
    for (p, part) in problem.parts.iter().enumerate() {
        for (r, run) in part.runs.iter().enumerate() {
            let mut shifted = Shifted::new(problem, (p, r), point, sound);
            let count = run.record.len() as f64;
            let shifts = (shifted.shifts().count() - 1) as f64;
            let price = (0.5 * count * count * shifts * runs as f64).max(1.0).ln();
            for is_between in [false, true] {
                for _ in 0..MOST {
                    let Some((periods, samples, gain)) = shifted.best(is_between) else { break };
                    let ln_p = (price - 0.5 * gain).min(0.0);
                    if ln_p > LOST.ln() {
                        break;
                    }
                    shifted.forget(&samples);
                    let nearest = shifted.nearest(periods, &samples);
                    // A motion that repeats is near itself at whole samples by chance, too.
                    let periods = nearest.map_or(periods, |nearest| nearest.round() as isize);
                    if !is_between && periods != 0 && shifted.is_whole(periods, &samples) {
                        if !shifted.is_no_offset(periods, &samples) {
                            continue;
                        }
                        let ends = run.record.ends(|samples| &samples.time);
                        let mean =
                            |[first, last]: [f64; 2]| (last - first) / (count - 1.0).max(1.0);
                        found.lost.push(Lost {
                            part: p,
                            run: r,
                            name: part.run_name(r),
                            rows: (run.record.row(samples.start), run.record.row(samples.end - 1)),
                            periods,
                            seconds: ends.map_or(0.0, mean) * periods as f64,
                            is_whole_run: samples.len() + periods.unsigned_abs()
                                >= run.record.len(),
                            samples,
                            ln_p,
                        });
                    } else if let Some(nearest) = nearest {
                        let seconds = nearest * shifted.period;
                        found.jumps.push(Jump { part: p, run: r, samples, seconds });
                    }
                }
            }
        }
    }
    found
}

/// A fit that outliers do not spoil. Readings are far out among all of their measurand, for
/// most of a run may be wrong; where noise grows with the rate, among those of their run, too
/// (`in_run`).
pub(in crate::diagnose) fn robust_fit(
    problem: &Problem,
    point: &Point,
    in_run: bool,
    options: &Options,
) -> Result<TrimmedFit, FitError> {
    let far = |one: &Residuals| {
        let of_all = one.scatter(problem);
        let of_run = |run: usize| {
            if in_run { robust(one.runs[run].iter()).unwrap_or(0.0) } else { 0.0 }
        };
        one.beyond(|run| OUTLIER * of_all.max(of_run(run)))
    };
    trimmed_fit(problem, point, ROUNDS, far, options)
}

/// Leaves the readings of these stretches out.
pub fn leave_out(problem: &mut Problem, lost: &[Lost]) {
    lost.iter().for_each(|one| without(problem, (one.part, one.run), &one.samples));
}

/// Leaves the readings of some samples of a run out.
fn without(problem: &mut Problem, (part, run): (usize, usize), samples: &Range<usize>) {
    let part = &mut problem.parts[part];
    let columns = part.reading_columns();
    part.runs[run].record.leave_out([(samples.clone(), columns)]);
}
