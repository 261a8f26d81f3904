//! Residuals that several inputs decide together. Each block is a function of one covariate; what
//! depends on a place and on the side from which it was reached is in none of them.
//!
//! Of each reading the nearest other one is looked for, in all inputs that vary and the sense in
//! which signals move. Where noise is all there is, the residuals of such neighbours are
//! uncorrelated: the sum of their products, over its root mean square, is a standard score.
//! Neighbours in time are left out, whose noise may be alike. It does not say of which form the
//! error is.

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;

use crate::diagnose::budget::autocorrelation::Component;
use crate::diagnose::budget::linear::Linear;
use crate::diagnose::budget::noise::{Outlier, components};
use crate::diagnose::budget::selection::Selection;
use crate::diagnose::thresholds::{LONE_OUTLIER, NEIGHBOURS, NOISE};
use crate::engine::Problem;
use crate::statistics::robust;

/// Readings of a component that are looked at, at most.
const MOST: usize = 2000;
/// Fewer say nothing.
const LEAST: usize = 30;
/// Robust standard deviations beyond which residuals count as if they were there: a few large ones
/// decide nothing.
const FAR: f64 = 2.0;
/// Share of an outlier's residual from which its neighbour has it, too.
const SHARED: f64 = 0.3;
/// Samples of a run that are neighbours in time.
const NEAR_IN_TIME: usize = 3;

/// A measurand whose residuals depend on inputs together.
#[derive(Clone, Debug, PartialEq)]
pub struct OfInputs {
    /// The measurand, of all campaigns.
    pub measurand: usize,
    /// Root mean square of the error, in standard deviations as they are weighted.
    pub rms: f64,
}

/// Measurands whose residuals of a model depend on inputs together.
pub fn of_inputs(linear: &Linear, selection: &Selection<'_>, model: &[usize]) -> Vec<OfInputs> {
    let problem = &linear.fitted.problem;
    let mut found: Vec<OfInputs> = Vec::new();
    let mut places: BTreeMap<usize, Places> = BTreeMap::new();
    for ((part, measurand, _), runs) in components(linear, selection, model, &mut |_, _| {}) {
        let places = places.entry(part).or_insert_with(|| places_of(problem, part));
        let readings = readings_of(&runs, problem.layout.first_run[part], places);
        let Some((score, rms)) = alike(&readings) else { continue };
        let is_new = found.last().is_none_or(|one| one.measurand != measurand);
        if score > NEIGHBOURS && is_new {
            found.push(OfInputs { measurand, rms });
        }
    }
    found
}

/// Takes out of outliers those of which the nearest reading has a share, and those that are not far out
/// by themselves, where the residuals of a model depend on inputs together: these are no outliers but a
/// form that the model lacks.
pub fn without_shared(
    outliers: &mut Vec<Outlier>,
    linear: &Linear,
    selection: &Selection<'_>,
    model: &[usize],
) {
    if outliers.is_empty() {
        return;
    }
    let problem = &linear.fitted.problem;
    for ((part, measurand, _), runs) in components(linear, selection, model, &mut |_, _| {}) {
        if outliers.iter().all(|one| one.at.2 != measurand) {
            continue;
        }
        let places = places_of(problem, part);
        let readings = readings_of(&runs, problem.layout.first_run[part], &places);
        if !alike(&readings).is_some_and(|(score, _)| score > NEIGHBOURS) {
            continue;
        }
        let deviation = robust(readings.iter().map(|one| &one.1)).unwrap_or(0.0);
        let (some, stride) = some_of(&readings);
        outliers.retain(|one| {
            let (run, sample, own) = one.at;
            if own != measurand {
                return true;
            }
            let at = readings.binary_search_by_key(&(run, sample), |reading| reading.0);
            // It may be one of another component of the measurand.
            let outlier = at.ok().map(|at| &readings[at]);
            let Some(outlier) = outlier.filter(|one| one.1.abs() > NOISE * deviation) else {
                return true;
            };
            let is_shared =
                |at: usize| some[at].1 / outlier.1 >= SHARED || one.deviations <= LONE_OUTLIER;
            !nearest(outlier, &some, stride).is_some_and(is_shared)
        });
    }
}

/// For each run and sample its coordinates.
type Places = Vec<Vec<Vec<f64>>>;

/// Coordinates of the samples of a campaign: inputs that vary, of those that turn cosine and sine,
/// and the sense of signals, each of unit variance.
fn places_of(problem: &Problem, part: usize) -> Places {
    let data = &problem.parts[part];
    let inputs = &data.system.assembly.names.inputs;
    let mut places: Places = Vec::new();
    for run in &data.runs {
        let mut rows = Vec::new();
        run.record.walk(|stretch| {
            for at in stretch.range() {
                let mut row = Vec::new();
                for (input, track) in inputs.iter().zip(&stretch.samples.inputs) {
                    let of = |order| track.at(at, stretch.samples.time[at], 0.0_f64, order);
                    let value: f64 = of(0);
                    if input.unit.is_angle() {
                        row.extend([value.cos(), value.sin()]);
                    } else {
                        row.push(value);
                    }
                    let rate: f64 = if track.moves() { of(1) } else { 0.0 };
                    row.push(if rate == 0.0 { 0.0 } else { rate.signum() });
                }
                rows.push(row);
            }
        });
        places.push(rows);
    }
    let columns = places.iter().flatten().next().map_or(0, Vec::len);
    for column in 0..columns {
        let all = || places.iter().flatten().map(|row| row[column]).filter(|x| x.is_finite());
        let count = all().count().max(1) as f64;
        let mean = all().sum::<f64>() / count;
        let variance = all().map(|x| (x - mean).powi(2)).sum::<f64>() / count;
        let by = if variance > 0.0 { variance.sqrt().recip() } else { 0.0 };
        places.iter_mut().flatten().for_each(|row| row[column] *= by);
    }
    places
}

/// A reading: its run and sample, its residual, and its place.
type Reading<'a> = ((usize, usize), f64, &'a [f64]);

/// The readings of a component that have a place.
fn readings_of<'a>(runs: &Component, first_run: usize, places: &'a Places) -> Vec<Reading<'a>> {
    let all = runs.iter().flat_map(|(run, values)| values.iter().map(move |one| (*run, one)));
    let placed = |(run, (sample, _, residual)): (usize, &(usize, f64, f64))| {
        let place = places.get(run - first_run)?.get(*sample)?.as_slice();
        place.iter().all(|x| x.is_finite()).then_some(((run, *sample), *residual, place))
    };
    all.filter_map(placed).collect()
}

/// The index of the reading that is nearest to one and not beside it in time; one of so many samples of
/// a run is among them.
fn nearest(one: &Reading<'_>, readings: &[Reading<'_>], stride: usize) -> Option<usize> {
    let far_in_time = |other: &Reading<'_>| {
        one.0.0 != other.0.0 || one.0.1.abs_diff(other.0.1) >= NEAR_IN_TIME * stride
    };
    let distance = |other: &Reading<'_>| -> f64 {
        one.2.iter().zip(other.2).map(|(x, y)| (x - y).powi(2)).sum()
    };
    let others = readings.iter().enumerate().filter(|(_, other)| far_in_time(other));
    let by_distance = others.map(|(at, other)| (distance(other), at));
    Some(by_distance.min_by(|a, b| a.0.total_cmp(&b.0))?.1)
}

/// At most so many readings as are looked at, and how many stand for one of them.
fn some_of<'a>(readings: &[Reading<'a>]) -> (Vec<Reading<'a>>, usize) {
    let stride = readings.len().div_ceil(MOST).max(1);
    (readings.iter().step_by(stride).copied().collect(), stride)
}

/// The standard score of products of neighbours' residuals, and the root of their mean; `None` of few
/// readings, and where nothing varies.
fn alike(readings: &[Reading<'_>]) -> Option<(f64, f64)> {
    let (readings, stride) = some_of(readings);
    if readings.len() < LEAST {
        return None;
    }
    let pair = |(i, one): (usize, &Reading<'_>)| {
        let j = nearest(one, &readings, stride)?;
        Some((i.min(j), i.max(j)))
    };
    // Two may be the nearest of each other.
    let pairs: BTreeSet<(usize, usize)> =
        readings.par_iter().enumerate().filter_map(pair).collect();
    let products = |most: f64| {
        let of = move |reading: &Reading<'_>| reading.1.clamp(-most, most);
        pairs.iter().map(|(i, j)| of(&readings[*i]) * of(&readings[*j])).collect::<Vec<f64>>()
    };
    let robust = products(FAR * robust(readings.iter().map(|one| &one.1))?);
    let score = robust.iter().sum::<f64>() / robust.iter().map(|x| x * x).sum::<f64>().sqrt();
    let mean = products(f64::INFINITY).iter().sum::<f64>() / pairs.len() as f64;
    Some((score, mean.max(0.0).sqrt()))
}
