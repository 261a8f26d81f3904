//! What errors of smoothed streams do to the readings of each run.
//!
//! A stream becomes a curve whose error follows from the scatter of the raw
//! values about it: noise of that size, smoothed in the same way. Values, rates and accelerations
//! of the curve are all off by it, together. How far that moves the predictions is computed with
//! one draw of such noise for each stream; its root mean square joins the standard uncertainty of
//! the measurand. Errors of a curve are alike over the time constant of the smoothing: the weights
//! do not hold that, the test of the residuals for autocorrelation shows it.
//!
//! Where the `sigma` of an input is stated, what that says of it is in the weights already, and
//! only the rest is added.

use std::sync::Arc;

use rand::SeedableRng;
use rand_chacha::ChaCha12Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::campaign::record::Record;
use crate::campaign::signal::Track;
use crate::campaign::spline::Spline;
use crate::engine::noise::{CHUNK, active_randoms, covariance_of};
use crate::engine::part::Part;
use crate::engine::point::Point;
use crate::engine::problem::Problem;
use crate::number::Gradient;

/// Samples of a run that are looked at.
const SAMPLES: usize = 8192;
/// Part of a reading's variance below which an added one is not worth counting.
const NOTICED: f64 = 0.1;
/// What it adds to chi squared of all readings of a measurand, from which it may look like an effect.
const SHOWS: f64 = 10.0;

/// What errors of smoothed streams do to a measurand in a run.
#[derive(Clone, Copy, Debug, Default)]
struct Moved {
    /// The variance of its readings that they make (SI), and that which is counted already.
    variance: f64,
    counted: f64,
    /// The stated variance.
    own: f64,
}

impl Problem {
    /// Lets the weights count what errors of smoothed streams add to each measurand, at a point.
    /// Whether they add anything that can be noticed; what was counted before stays.
    pub fn count_smoothing(&mut self, point: &Point) -> bool {
        let mut is_noticed = false;
        for p in 0..self.parts.len() {
            if !self.parts[p].smoothing_sigma.is_empty() {
                continue;
            }
            let runs = self.parts[p].runs.len();
            let moved: Vec<Vec<Moved>> = (0..runs).map(|r| self.moved_in(p, r, point)).collect();
            let part = &mut self.parts[p];
            let mut chi_squared = vec![0.0; part.sigma.len()];
            for (run, own) in moved.iter().enumerate() {
                for (m, (one, present)) in own.iter().zip(part.present_in(run)).enumerate() {
                    chi_squared[m] += present as f64 * one.variance / one.own;
                }
            }
            part.has_stream_noise = chi_squared.iter().any(|one| *one > SHOWS);
            let sigma = |one: &Moved| {
                let added = one.variance - one.counted;
                if added > NOTICED * one.own { added.sqrt() } else { 0.0 }
            };
            let found: Vec<Vec<f64>> =
                moved.iter().map(|run| run.iter().map(sigma).collect()).collect();
            if found.iter().flatten().any(|sigma| *sigma > 0.0) {
                part.smoothing_sigma = found;
                is_noticed = true;
            }
        }
        is_noticed
    }

    /// The same readings over streams with as much noise again as they have, and with that noise
    /// the other way round: sums over both, less those without, are what the noise does to a product
    /// of two things that it moves. `None` where no stream is smoothed, or only as it is usual and too
    /// little of its noise is in the readings to look like an effect.
    pub fn with_noisier_streams(&self) -> Option<[Self; 2]> {
        let noisier = |times: f64| {
            self.with_streams(&|part, tracks, (run, input)| {
                let (spline, sigma) = smoothed(part, tracks, input)?;
                if !part.has_stream_noise && !spline.is_stated() {
                    return None;
                }
                let seed = ((run << 16) | input) as u64;
                spline.noisier(sigma, times, &mut normal(seed))
            })
        };
        Some([noisier(1.0)?, noisier(-1.0)?])
    }

    /// The same readings over streams that are smoothed once more: what that does is about what their
    /// smoothing has done. `None` where no stream is smoothed.
    pub fn with_streams_smoothed_again(&self) -> Option<Self> {
        self.with_streams(&|part, tracks, (_, input)| {
            smoothed(part, tracks, input)?.0.smoothed_again()
        })
    }

    /// The same readings over other streams, if any is another.
    fn with_streams(&self, other: Other<'_>) -> Option<Self> {
        let mut changed = self.clone();
        let mut is_any = false;
        for (p, part) in self.parts.iter().enumerate() {
            for (r, run) in part.runs.iter().enumerate() {
                let tracks = run.record.inputs();
                let number = self.run_index(p, r);
                let curves = (0..tracks.len()).filter_map(|input| {
                    let curve = other(part, tracks, (number, input))?;
                    Some((input, Track::Logged(Arc::new(curve))))
                });
                let curves: Vec<(usize, Track)> = curves.collect();
                if !curves.is_empty() {
                    is_any = true;
                    changed.parts[p].runs[r].record.replace_streams(curves);
                }
            }
        }
        is_any.then_some(changed)
    }

    /// What errors of smoothed streams do to each measurand of a run.
    fn moved_in(&self, p: usize, r: usize, point: &Point) -> Vec<Moved> {
        let part = &self.parts[p];
        let of_measurand = |m| Moved { own: part.sigma_in(r, m).powi(2), ..Moved::default() };
        let nothing: Vec<Moved> = (0..part.sigma.len()).map(of_measurand).collect();
        let tracks = part.runs[r].record.inputs();
        let curves: Vec<(usize, Track)> = (0..tracks.len())
            .filter_map(|input| Some((input, disturbed(part, tracks, input)?)))
            .collect();
        if curves.is_empty() {
            return nothing;
        }
        let mut thinned: Record = part.runs[r].record.spread(SAMPLES, 1).into();
        // Where a long stream has no draw there is nothing to compare.
        let end = curves.iter().map(|(_, track)| match track {
            Track::Logged(spline) => spline.span().1,
            _ => f64::INFINITY,
        });
        let end = end.fold(f64::INFINITY, f64::min);
        let delays = part.system.assembly.names.measurands.iter().map(|one| {
            let instance = self.layout.instance_in(p, r, one.delay);
            point.values[instance][0]
        });
        let slots: Vec<_> = part.slots().iter().zip(delays).collect();
        thinned.edit(|samples| {
            for (slot, delay) in &slots {
                let is_late = |at: &usize| samples.time[*at] + delay > end;
                let late: Vec<usize> = (0..samples.len()).filter(is_late).collect();
                for column in &mut samples.readings[slot.column..slot.column + slot.width] {
                    late.iter().for_each(|at| column[*at] = f64::NAN);
                }
            }
        });
        let residuals = |record: Record| {
            let mut problem = self.clone();
            problem.parts[p].runs[r].record = record;
            problem.residuals(p, r, point)
        };
        let mut moved = thinned.clone();
        moved.edit(|samples| {
            for (input, track) in curves {
                samples.inputs[input] = track;
            }
        });
        let counted = self.counted(p, r, point, &thinned);
        let (as_they_are, off) = (residuals(thinned), residuals(moved));
        let mut added = nothing;
        for (m, slot) in part.slots().iter().enumerate() {
            let rows = slot.residual..slot.residual + slot.components;
            let (mut squares, mut count) = (0.0, 0.0);
            for (one, other) in as_they_are.iter().zip(&off) {
                for row in rows.clone() {
                    let difference = one[row] - other[row];
                    if difference.is_finite() {
                        squares += difference * difference;
                        count += 1.0;
                    }
                }
            }
            (added[m].variance, added[m].counted) = (squares / f64::max(count, 1.0), counted[m]);
        }
        added
    }

    /// The mean variance that stated errors of inputs bring into each measurand of a run.
    fn counted(&self, p: usize, r: usize, point: &Point, record: &Record) -> Vec<f64> {
        let part = &self.parts[p];
        let active = active_randoms(part);
        let mut sums = vec![(0.0, 0.0); part.sigma.len()];
        if !active.is_empty() {
            let parameters = self.parameters::<Gradient<CHUNK>>(p, r, point);
            let mut workspace = Vec::new();
            record.walk(|stretch| {
                for sample in stretch.each() {
                    let made = covariance_of(part, r, sample, &parameters, &active, &mut workspace);
                    for (slot, sum) in part.slots().iter().zip(&mut sums) {
                        for row in slot.residual..slot.residual + slot.components {
                            for (column, random) in active.iter().enumerate() {
                                let by = made.sensitivities[(row, column)];
                                sum.0 += (by * part.random_sigma_in(r, *random)).powi(2);
                            }
                            sum.1 += 1.0;
                        }
                    }
                }
            });
        }
        sums.into_iter().map(|(sum, count)| sum / f64::max(count, 1.0)).collect()
    }
}

/// Another curve of a campaign's tracks, for a run (of all) and an input.
type Other<'a> = &'a dyn Fn(&Part, &[Track], (usize, usize)) -> Option<Spline>;

/// The curve of an input, with one draw of its error.
fn disturbed(part: &Part, tracks: &[Track], input: usize) -> Option<Track> {
    let (spline, sigma) = smoothed(part, tracks, input)?;
    let disturbed = spline.disturbed(sigma, &mut normal(input as u64 + 1))?;
    Some(Track::Logged(Arc::new(disturbed)))
}

/// The curve of an input, and the standard deviation that is stated of its raw values.
fn smoothed<'a>(
    part: &Part,
    tracks: &'a [Track],
    input: usize,
) -> Option<(&'a Spline, Option<f64>)> {
    let Track::Logged(spline) = &tracks[input] else { return None };
    let declared = &part.system.assembly.names.inputs[input];
    let stated = declared.error.map(|random| part.random_sigma[random]);
    Some((spline, stated.filter(|sigma| *sigma > 0.0)))
}

/// Normally distributed numbers.
fn normal(seed: u64) -> impl FnMut() -> f64 {
    let mut numbers = ChaCha12Rng::seed_from_u64(seed);
    move || StandardNormal.sample(&mut numbers)
}
