//! Other starts and other minima of the joint estimate.
//!
//! A sum of squares may have many minima: clocks far apart, a sensor mounted turned, a motion that
//! repeats, a parameter that acts by its square. [`improved`] asks whether another start fits far
//! better than the stated one, and moves the start there; [`others`] asks which other minima the
//! readings cannot exclude. Both look at a part of the samples, later by an offset of the clock, in
//! several attitudes. Neither proves that nothing else fits.
//!
//! | file | answers |
//! |---|---|
//! | `clocks` | which runs share a clock |
//! | `thinned` | some samples of a problem, later by an offset |
//! | `comparison` | which of two starts fits better, and whether by enough |
//! | `held` | a problem of which some unknowns stay where they are |
//! | `starts` | the offsets and attitudes to start from |
//! | `signs` | scalars that are stated to start with one sign and end with the other |
//! | `compared` | whether a fit is another minimum, which the readings cannot exclude |
//! | `other_values` | minima at which a scalar or a component of a vector has another value |
//! | `turned` | minima at which a rotation is another one |

use rayon::prelude::*;

use crate::engine::{Point, Problem};
use crate::estimate::batch::{Options, fit};
use crate::estimate::calibrate::Calibration;
use crate::estimate::repeats::{long_repeats, without};
use crate::estimate::start::start;

pub(super) mod clocks;
mod compared;
mod comparison;
mod held;
mod other_values;
mod signs;
pub(super) mod starts;
pub(super) mod thinned;
mod turned;

use clocks::Clock;
use comparison::{far_better_for_most, is_better, is_enough};
use held::Held;
use other_values::other_values;
use signs::{start_that_keeps_signs, stated_signs};
use starts::{Attitudes, Offsets, is_open};
use thinned::{Thinned, Tried, cut};
use turned::other_turns;

/// Samples on which each start is tried; those on which the best of them are fitted further; those
/// on which two minima are compared.
const SAMPLES: [usize; 3] = [240, 4_000, 20_000];
/// Iterations of each.
const ITERATIONS: [usize; 3] = [8, 40, 60];
/// Iterations with the delays held before.
const ITERATIONS_HELD: usize = 1;
/// Samples and iterations of a first glance at every start.
const FEWEST: (usize, usize) = (96, 2);
/// One in so many of them is looked at further, but at least so many.
const HOPEFUL: usize = 6;
const LEAST: usize = 60;
/// A variance factor with which a start needs no other.
const GOOD: f64 = 4.0;
/// Another start must fit so many times better.
const BETTER: f64 = 0.5;
/// The same of one that fits badly all the same, and the part of all readings that it must fit.
const FAR_BETTER: f64 = 0.2;
const KEPT: f64 = 0.9;
/// The part of the samples of which none is wrong.
pub const MOST: f64 = 0.8;
/// Starts of a first look that are fitted further.
const FURTHER: usize = 6;
/// Other minima that are compared.
const COMPARED: usize = 4;
/// Other minima fit on some samples up to so many times worse before they are compared.
const NEAR: f64 = 3.0;
/// A variance factor beyond which the model is wrong, and other minima say nothing.
const WRONG: f64 = 30.0;
/// Difference in chi squared, in units of the variance factor, up to which the readings cannot
/// exclude a minimum: five standard deviations.
const EXCLUDED: f64 = 25.0;

/// Another start that fits far better.
#[derive(Clone, Debug)]
pub struct Found {
    /// How many starts were tried.
    pub tried: usize,
    /// Over which offsets of the clock (s).
    pub offsets: [f64; 2],
    /// Offset of the clock (s) of the best.
    pub offset: f64,
    /// Variance factors of some samples: from the stated start, and from the best.
    pub variance_factors: [f64; 2],
    /// Where wrong readings are most of both: the normalized residuals that most samples keep below.
    pub most: Option<[f64; 2]>,
    /// Samples that no stream covers at that offset.
    pub left_out: usize,
    /// Attitudes that were not tried, because there are too many.
    pub attitudes_left_out: usize,
    /// A delay of the clock.
    pub delay: Option<String>,
}

/// A minimum that the readings cannot exclude.
#[derive(Clone, Debug)]
pub struct Other {
    /// The parameter that tells it from the estimate.
    pub instance: usize,
    /// Which component of it.
    pub component: usize,
    /// Its value there (SI), and at the estimate.
    pub values: [f64; 2],
    /// How much larger chi squared is there.
    pub chi_squared: f64,
    /// Others (instance, component) that differ there, too, with their values (SI): they are not
    /// ambiguous by themselves.
    pub with: Vec<(usize, usize, f64)>,
}

/// The problem with a start from which it fits far better than from its own, and what was found; each
/// clock is searched by itself.
pub fn improved(mut problem: Problem) -> (Problem, Vec<Found>) {
    let clocks = Clock::all(&problem);
    let signs = stated_signs(&problem);
    let mut all = Vec::new();
    let mut settled: Vec<usize> = Vec::new();
    let searched = without(&problem, &long_repeats(&problem)).unwrap_or_else(|| problem.clone());
    for clock in &clocks {
        let alone = if clocks.len() > 1 { clock.alone(&searched) } else { searched.clone() };
        let Some((start, mut found)) = better_start(&alone, clock) else { continue };
        found.left_out = cut(&mut problem, clock, found.offset);
        for index in clock.instances(&alone) {
            if problem.layout.is_free(index) && !settled.contains(&index) {
                let components = start.components(&problem.layout, index);
                problem.begin_at_found(index, components);
                settled.push(index);
            }
        }
        let delay = clock.delays.first().map(|index| &problem.layout.instances[*index]);
        found.delay = delay.map(|one| match &one.of {
            Some(of) => format!("{}@{of}", one.name),
            None => one.name.clone(),
        });
        all.push(found);
    }
    if let Some(start) = start_that_keeps_signs(&problem, &signs) {
        for index in 0..problem.layout.instances.len() {
            let was_found = problem.layout.instances[index].start_found;
            if is_open(&problem.layout, index) || was_found && problem.layout.is_free(index) {
                let components = start.components(&problem.layout, index);
                problem.begin_at_found(index, components);
            }
        }
    }
    (problem, all)
}

/// The start that fits far better than the stated one, if there is one.
pub(super) fn better_start(problem: &Problem, clock: &Clock) -> Option<(Point, Found)> {
    let attitudes = Attitudes::of(problem);
    let offsets = Offsets::of(problem, clock, attitudes.count());
    if offsets.all.len() < 2 && attitudes.count() < 2 {
        return None;
    }
    let few = Thinned::of(problem, SAMPLES[0]);
    let stated = |thinned: &Thinned, iterations: usize| {
        let problem = thinned.late_by(0.0, &[0.0])?;
        let point = start(&problem).0;
        Tried::fit(problem, point, 0.0, iterations)
    };
    let look = |thinned: &Thinned, offset: f64, attitude: usize, iterations: usize| {
        let mut problem = thinned.late_by(offset, &[offset])?;
        let mut point = start(&problem).0;
        attitudes.apply(attitude, &mut point);
        let mut held = Held::new(&mut problem, &clock.delays);
        let options = Options { max_iterations: ITERATIONS_HELD, ..Options::default() };
        let point = fit(&mut held, point, &options).ok()?.point;
        Tried::fit(problem, point, offset, iterations)
    };
    // A start outside the range that is stated is none.
    let is_in_range = offsets.holds(0.0);
    if is_in_range && stated(&few, ITERATIONS[1])?.variance_factor <= GOOD {
        return None;
    }
    let all: Vec<(f64, usize)> = (0..attitudes.count())
        .flat_map(|attitude| offsets.all.iter().map(move |offset| (*offset, attitude)))
        .collect();
    let fewest = Thinned::of(problem, FEWEST.0);
    let mut glanced: Vec<(f64, (f64, usize))> = all
        .par_iter()
        .filter_map(|start| {
            Some((look(&fewest, start.0, start.1, FEWEST.1)?.variance_factor, *start))
        })
        .collect();
    let count = glanced.len();
    glanced.sort_by(|a, b| a.0.total_cmp(&b.0));
    glanced.truncate((count / HOPEFUL).max(LEAST));
    let mut tried: Vec<Tried> = glanced
        .par_iter()
        .filter_map(|(_, (offset, attitude))| look(&few, *offset, *attitude, ITERATIONS[0]))
        .collect();
    tried.sort_by(|a, b| a.variance_factor.total_cmp(&b.variance_factor));
    let more = Thinned::of(problem, SAMPLES[1]);
    let further = |one: &Tried| {
        let problem = more.late_by(one.offset, &[one.offset])?;
        Tried::fit(problem, one.point.clone(), one.offset, ITERATIONS[1])
    };
    let own = if is_in_range { stated(&more, ITERATIONS[2]) } else { None };
    let mut best = own.clone();
    for one in tried.iter().take(FURTHER).filter_map(further) {
        if best.as_ref().is_none_or(|best| is_better(&more, &one, best)) {
            best = Some(one);
        }
    }
    let best = best?;
    let own_factor = own.as_ref().map_or(f64::INFINITY, |own| own.variance_factor);
    let factors = [own_factor, best.variance_factor];
    let most = match is_enough(&more, &best, factors) {
        true => None,
        false => Some(far_better_for_most(&more, &best, own.as_ref()?)?),
    };
    let found = Found {
        tried: count,
        offsets: offsets.span(),
        offset: best.offset + offsets.mean(&best.point),
        variance_factors: factors,
        most,
        left_out: 0,
        attitudes_left_out: attitudes.left_out,
        delay: None,
    };
    let mut point = best.point;
    offsets.delay(&mut point, best.offset);
    Some((point, found))
}

/// Other minima that the readings cannot exclude: other offsets of the clock, nearest first, other
/// values of scalars and of components of vectors, and other rotations, each by itself.
pub fn others(fit: &Calibration) -> Vec<Other> {
    if !fit.is_sound() || fit.variance_factor().is_none_or(|factor| factor > WRONG) {
        return Vec::new();
    }
    let (problem, point) = (&fit.problem, &fit.fit.point);
    let clocks = Clock::all(problem);
    let of = |clock: &Clock| match clocks.len() {
        1 => other_offsets(problem, point, clock),
        _ => other_offsets(&clock.alone(problem), point, clock),
    };
    let mut found: Vec<Other> = clocks.iter().flat_map(of).collect();
    found.extend(other_values(fit));
    found.extend(other_turns(fit));
    found
}

fn other_offsets(problem: &Problem, point: &Point, clock: &Clock) -> Vec<Other> {
    let mut offsets = Offsets::of(problem, clock, 1);
    let Some(delay) = offsets.delays.first().copied() else { return Vec::new() };
    if offsets.is_stated {
        // Samples are later by their offset from the estimate, which may lie anywhere in the range.
        let mean = offsets.mean(point);
        offsets.all.iter_mut().for_each(|offset| *offset -= mean);
    }
    let few = Thinned::of(problem, SAMPLES[0]);
    let at = |thinned: &Thinned, offset: f64, iterations: usize| {
        Tried::fit(thinned.late_by(offset, &[0.0, offset])?, point.clone(), offset, iterations)
    };
    let Some(own) = at(&few, 0.0, ITERATIONS[0]) else { return Vec::new() };
    let moved = |one: &Tried| one.offset + offsets.mean(&one.point) - offsets.mean(point);
    let mut tried: Vec<Tried> = offsets
        .all
        .par_iter()
        .filter(|offset| offset.abs() > 0.5 * offsets.step)
        .filter_map(|offset| at(&few, *offset, ITERATIONS[0]))
        .filter(|one| one.variance_factor < NEAR * own.variance_factor.max(1.0))
        .filter(|one| moved(one).abs() > offsets.step)
        .collect();
    tried.sort_by(|a, b| moved(a).abs().total_cmp(&moved(b).abs()));
    let mut seen: Vec<f64> = Vec::new();
    tried.retain(|one| {
        let is_new = seen.iter().all(|other| (moved(one) - other).abs() > offsets.step);
        seen.extend(is_new.then(|| moved(one)));
        is_new
    });
    let many = Thinned::of(problem, SAMPLES[2]);
    let compared = tried.iter().take(COMPARED).filter_map(|one| {
        let there = many.late_by(one.offset, &[0.0, one.offset])?;
        let there = Tried::fit(there, one.point.clone(), one.offset, ITERATIONS[2])?;
        let here = many.late_by(0.0, &[0.0, one.offset])?;
        let here = Tried::fit(here, point.clone(), 0.0, ITERATIONS[2])?;
        let chi_squared = many.times * (there.chi_squared - here.chi_squared);
        let is_alike = chi_squared < EXCLUDED * here.variance_factor.max(1.0);
        let value = point.values[delay][0];
        (is_alike && moved(&there).abs() > offsets.step).then(|| Other {
            instance: delay,
            component: 0,
            values: [value + moved(&there), value],
            chi_squared,
            with: Vec::new(),
        })
    });
    compared.collect()
}
