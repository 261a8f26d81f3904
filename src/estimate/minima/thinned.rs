//! Some samples of a problem, later by an offset of the clock, and fits of them.
//!
//! A delay that all readings share is the same as samples that are taken later, so that an offset
//! of any size is tried without asking the model for it. Samples for which no stream is there say
//! nothing.

use std::ops::Range;

use crate::campaign::Samples;
use crate::campaign::signal::Track;
use crate::engine::{Point, Problem};
use crate::estimate::batch::{Options, fit};
use crate::estimate::minima::clocks::Clock;

/// Samples that stand together.
const STRETCH: usize = 4;
/// Samples of a run at least.
const LEAST: usize = 8;
/// The part of all readings that must remain within the streams.
const REMAINING: f64 = 0.3;
/// Margin (s) to the ends of streams that is kept behind a search.
const MARGIN: f64 = 0.5;

/// Some samples of a problem.
pub(in crate::estimate) struct Thinned {
    problem: Problem,
    /// Readings of these samples.
    readings: usize,
    /// How many times more readings the problem has.
    pub(in crate::estimate) times: f64,
}

impl Thinned {
    /// About so many samples, evenly spread over all runs.
    pub(in crate::estimate) fn of(problem: &Problem, most: usize) -> Self {
        let all = problem.sample_count();
        let mut parts = problem.parts.clone();
        if all > most {
            for run in parts.iter_mut().flat_map(|part| &mut part.runs) {
                let own = (most * run.record.len() / all).max(LEAST);
                run.record = run.record.spread(own, STRETCH).into();
            }
        }
        let mut thinned = problem.clone();
        thinned.parts = parts;
        let readings = thinned.reading_count();
        let times = problem.reading_count() as f64 / readings.max(1) as f64;
        Self { problem: thinned, readings, times }
    }

    /// Readings of these samples.
    pub(in crate::estimate) fn readings(&self) -> usize {
        self.readings
    }

    /// The samples taken later by an offset (s): those for which streams are there at all of some
    /// offsets. `None` where too few remain.
    pub(in crate::estimate) fn late_by(&self, offset: f64, within: &[f64]) -> Option<Problem> {
        let mut problem = self.problem.clone();
        for run in problem.parts.iter_mut().flat_map(|part| &mut part.runs) {
            run.record.edit(|samples| {
                let lost: Vec<usize> = (0..samples.len())
                    .filter(|at| !is_covered(samples, *at, within, 0.0))
                    .collect();
                for column in &mut samples.readings {
                    lost.iter().for_each(|at| column[*at] = f64::NAN);
                }
                samples.time.iter_mut().for_each(|time| *time += offset);
            });
        }
        let remaining = problem.reading_count();
        let enough = remaining as f64 >= REMAINING * self.readings as f64
            && remaining > 2 * problem.layout.columns.len();
        enough.then_some(problem)
    }
}

/// Whether all streams are there for a sample at some offsets, with a margin (s).
fn is_covered(samples: &Samples, at: usize, offsets: &[f64], margin: f64) -> bool {
    let time = samples.time[at];
    samples.inputs.iter().all(|track| match track {
        Track::Logged(spline) => offsets
            .iter()
            .all(|offset| spline.covers(time + offset - margin, time + offset + margin)),
        _ => true,
    })
}

/// Leaves the samples of a clock out for which no stream is there at an offset; how many.
pub(in crate::estimate) fn cut(problem: &mut Problem, clock: &Clock, offset: f64) -> usize {
    let mut count = 0;
    for (p, part) in problem.parts.iter_mut().enumerate() {
        let width = part.slots().iter().map(|slot| slot.columns().end).max().unwrap_or(0);
        let [low, high] = part.delay_range.hull();
        let margin = (0.5 * (high - low)).min(MARGIN);
        let own = part.runs.iter_mut().enumerate();
        for (_, run) in own.filter(|(r, _)| clock.runs.contains(&(p, *r))) {
            let mut lost: Vec<Range<usize>> = Vec::new();
            run.record.walk(|stretch| {
                for sample in stretch.each() {
                    if is_covered(sample.samples, sample.at, &[offset], margin) {
                        continue;
                    }
                    count += 1;
                    match lost.last_mut() {
                        Some(range) if range.end == sample.number => range.end += 1,
                        _ => lost.push(sample.number..sample.number + 1),
                    }
                }
            });
            run.record.leave_out(lost.into_iter().map(|range| (range, 0..width)));
        }
    }
    count
}

/// A fit from a start.
#[derive(Clone)]
pub(in crate::estimate) struct Tried {
    /// By how much samples are later (s).
    pub(in crate::estimate) offset: f64,
    /// Where it ended; delays count from the offset.
    pub(in crate::estimate) point: Point,
    /// Sum of squares there.
    pub(in crate::estimate) chi_squared: f64,
    /// Readings that it is a fit of.
    pub(in crate::estimate) readings: usize,
    /// The sum of squares over the degrees of freedom.
    pub(in crate::estimate) variance_factor: f64,
    /// Whether the unknowns settled.
    pub(in crate::estimate) is_settled: bool,
}

impl Tried {
    /// `None` where the model has no values.
    pub(in crate::estimate) fn fit(
        mut problem: Problem,
        start: Point,
        offset: f64,
        iterations: usize,
    ) -> Option<Self> {
        let readings = problem.reading_count();
        let free = problem.component_count().checked_sub(problem.layout.columns.len())?;
        let options = Options { max_iterations: iterations, ..Options::default() };
        let found = fit(&mut problem, start, &options).ok()?;
        let variance_factor = found.cost / free.max(1) as f64;
        variance_factor.is_finite().then_some(Self {
            is_settled: found.outcome.is_result(),
            offset,
            point: found.point,
            chi_squared: found.cost,
            readings,
            variance_factor,
        })
    }
}
