//! Readings that do not respond: for a while an instrument goes on without following what it measures,
//! as a tube that is clogged or a contact that is lost, its reading still but for noise and leakage.
//!
//! Frozen readings repeat bit for bit; these have noise of their own. In windows of a run in which the
//! prediction varies far more than residuals do elsewhere, they vary by little, and not with it. A spike
//! of a few samples, as of a mistyped input, is no variation of the prediction. A few
//! long stretches of a run are wrong readings; what stands still at a place of an input, as with a dead
//! zone or at a limit, is structure.

use std::ops::Range;

use crate::diagnose::found::Wrong;
use crate::estimate::batch::Options;
use crate::estimate::calibrate::Calibration;
use crate::estimate::residuals::{Residuals, residuals_from};
use crate::statistics::upper_median;

use super::Cleaned;
use super::left_out::{OfSamples, without_stretches};
use super::places::comes_back;

/// Windows are one in so many parts of a run, but of so many readings.
const PARTS: usize = 20;
const WINDOW: std::ops::RangeInclusive<usize> = 24..=400;
/// Samples of a spike of the prediction at most, which is no variation of it.
const SPIKE: usize = 2;
/// Slope of readings over predictions, and scatter in parts of theirs, up to which they do not follow.
const SLOPE: f64 = 0.3;
const STILL: f64 = 0.5;
/// Residuals of such a window scatter so many times as those of the usual one.
const UNUSUAL: f64 = 2.5;
/// Stretches of a run at most, and the part of its readings.
const STRETCHES: usize = 3;
const MOST: f64 = 0.25;

/// Leaves readings out that do not respond and fits again; `None` where there are none.
pub(super) fn without_unresponsive(nominal: &Calibration, options: &Options) -> Cleaned {
    let (problem, point) = (&nominal.problem, &nominal.fit.point);
    let all = residuals_from(problem, point);
    let mut found: Vec<OfSamples> = Vec::new();
    for one in &all {
        let part = &problem.parts[one.part];
        let slot = &part.slots()[one.measurand];
        if slot.width == 1 {
            let readings = part.readings_of(slot.column).into_iter().enumerate();
            let stretches = readings.flat_map(|(run, readings)| {
                let own = stretches(one, run, &readings).into_iter();
                own.map(move |samples| (one.in_run(run), samples))
            });
            let stretches: Vec<OfSamples> = stretches.collect();
            if !comes_back(problem, one.of(), &stretches) {
                found.extend(stretches);
            }
        }
    }
    without_stretches(nominal, (point, &all), found, Wrong::Unresponsive, options)
}

/// Sample, reading and prediction.
type Read = (usize, f64, f64);

/// The samples of a run whose readings do not respond; none where they are many.
fn stretches(own: &Residuals, run: usize, readings: &[f64]) -> Vec<Range<usize>> {
    let read = |(at, residual): (usize, f64)| (at, readings[at], readings[at] - residual);
    let present: Vec<Read> = own.readings(run).into_iter().map(read).collect();
    let size = (present.len() / PARTS).clamp(*WINDOW.start(), *WINDOW.end());
    if present.len() < 4 * size {
        return Vec::new();
    }
    let starts: Vec<usize> = (0..=present.len() - size).step_by(size / 2).collect();
    let smooth = without_spikes(&present);
    let window = |start: &usize| smooth[*start..start + size].iter().map(|one| (one.2, one.1));
    let windows: Vec<Moments> = starts.iter().map(|start| Moments::of(window(start))).collect();
    let mut residuals: Vec<f64> = windows.iter().map(Moments::residual).collect();
    let usual = upper_median(&mut residuals).unwrap_or(f64::INFINITY);
    let flagged: Vec<usize> =
        (0..windows.len()).filter(|at| windows[*at].does_not_respond(usual)).collect();
    let groups = flagged.chunk_by(|a, b| b - a == 1).filter(|group| group.len() > 1);
    // The model may be off elsewhere, too.
    let mut offsets: Vec<f64> = present.iter().map(|(_, reading, at)| reading - at).collect();
    let offset = upper_median(&mut offsets).unwrap_or(0.0);
    let samples = |group: &[usize]| {
        let core = starts[group[0]]..starts[group[group.len() - 1]] + size;
        let ends = with_ends(&present, core, size, offset);
        present[ends.start].0..present[ends.end - 1].0 + 1
    };
    let found: Vec<Range<usize>> = groups.map(samples).collect();
    let count: usize = found.iter().map(Range::len).sum();
    let are_few = found.len() <= STRETCHES && count as f64 <= MOST * readings.len() as f64;
    if are_few { found } else { Vec::new() }
}

/// Means and second central moments of pairs of numbers, in windows of predictions and readings.
struct Moments {
    x: f64,
    y: f64,
    xx: f64,
    yy: f64,
    xy: f64,
}

impl Moments {
    fn of(pairs: impl Iterator<Item = (f64, f64)> + Clone) -> Self {
        let count = pairs.clone().count() as f64;
        let [x, y] = pairs.clone().fold([0.0; 2], |sum, (x, y)| [sum[0] + x, sum[1] + y]);
        let (x, y) = (x / count, y / count);
        let about = pairs.map(|one| (one.0 - x, one.1 - y));
        let sums =
            about.fold([0.0; 3], |[xx, yy, xy], (x, y)| [xx + x * x, yy + y * y, xy + x * y]);
        let [xx, yy, xy] = sums.map(|sum| sum / count);
        Self { x, y, xx, yy, xy }
    }

    /// The standard deviation of the differences.
    fn residual(&self) -> f64 {
        (self.xx + self.yy - 2.0 * self.xy).max(0.0).sqrt()
    }

    fn slope(&self) -> f64 {
        self.xy / self.xx
    }

    fn does_not_respond(&self, usual: f64) -> bool {
        self.slope().abs() < SLOPE
            && self.yy.sqrt() < STILL * self.xx.sqrt()
            && self.residual() > UNUSUAL * usual
    }
}

/// Samples with the running median of their predictions: a mistyped input is a spike of few samples.
fn without_spikes(samples: &[Read]) -> Vec<Read> {
    let median = |at: usize| {
        let near = at.saturating_sub(SPIKE)..(at + SPIKE + 1).min(samples.len());
        upper_median(&mut samples[near].iter().map(|one| one.2).collect::<Vec<f64>>())
    };
    let each = samples.iter().enumerate();
    each.map(|(at, one)| (one.0, one.1, median(at).unwrap_or(one.2))).collect()
}

/// A stretch with its ends where readings leave the line through its middle half for the prediction, with
/// its usual offset, at most a window beyond.
fn with_ends(present: &[Read], core: Range<usize>, size: usize, offset: f64) -> Range<usize> {
    let quarter = core.len() / 4;
    let middle = core.start + quarter..core.end - quarter;
    let line = Moments::of(middle.clone().map(|at| (at as f64, present[at].1)));
    let excess = |at: usize| {
        let (_, reading, prediction) = present[at];
        let off_line = reading - line.y - line.slope() * (at as f64 - line.x);
        (reading - prediction - offset).powi(2) - off_line.powi(2)
    };
    // Where the sum of what the line does better is the largest.
    let best = |all: &mut dyn Iterator<Item = usize>, from: usize| {
        let (mut sum, mut most) = (0.0, (0.0, from));
        for at in all {
            sum += excess(at);
            if sum > most.0 {
                most = (sum, at);
            }
        }
        most.1
    };
    let start = best(&mut (core.start.saturating_sub(size)..middle.start).rev(), middle.start);
    let end = best(&mut (middle.end..(core.end + size).min(present.len())), middle.end - 1);
    start..end + 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stream::Stream;
    use std::sync::Arc;

    fn found(read: impl Fn(usize, f64) -> f64) -> Vec<Range<usize>> {
        let mut random = Stream(7);
        let path = |at: usize| (0.03 * at as f64).sin() + 0.6 * (0.071 * at as f64).sin();
        let readings: Vec<f64> =
            (0..2000).map(|at| read(at, path(at)) + 0.05 * random.normal()).collect();
        let residuals = (0..2000).map(|at| readings[at] - path(at)).collect();
        stretches(&Residuals::new((0, 0), vec![Arc::new(residuals)]), 0, &readings)
    }

    #[test]
    fn what_stands_still_while_the_prediction_moves_does_not_respond() {
        let all = found(|at, path| if (800..1100).contains(&at) { 0.4 } else { path });
        assert_eq!(all.len(), 1, "{all:?}");
        let one = &all[0];
        assert!(one.start.abs_diff(800) < 12 && one.end.abs_diff(1100) < 12, "{one:?}");
        // It leaks away.
        let leaking = |at: usize, path| match (800..1100).contains(&at) {
            true => 0.9 - 0.002 * (at - 800) as f64,
            false => path,
        };
        assert_eq!(found(leaking).len(), 1);
    }

    #[test]
    fn outliers_of_the_prediction_are_no_variation_of_it() {
        // The readings are good; inputs were mistyped, alone or close together.
        for spikes in [vec![900], vec![900, 907], vec![300, 301, 1500]] {
            let mut random = Stream(7);
            let path = |at: usize| (0.03 * at as f64).sin();
            let noise: Vec<f64> = (0..2000).map(|_| 0.05 * random.normal()).collect();
            let readings: Vec<f64> = (0..2000).map(|at| path(at) + noise[at]).collect();
            let mut residuals = noise;
            spikes.iter().for_each(|at| residuals[*at] += 40.0);
            let own = Residuals::new((0, 0), vec![Arc::new(residuals)]);
            assert!(stretches(&own, 0, &readings).is_empty(), "{spikes:?}");
        }
    }

    #[test]
    fn scales_limits_and_good_readings_respond() {
        assert!(found(|_, path| path).is_empty());
        assert!(found(|_, path| 0.5 * path).is_empty());
        assert!(found(|_, path| path.clamp(-0.7, 0.7)).is_empty());
        assert!(found(|at, path| if at > 900 { 0.1 } else { path }).is_empty());
    }
}
