//! Readings that do not respond: for a while an instrument goes on without following what it measures,
//! as a tube that is clogged or a contact that is lost, its reading still but for noise and leakage.
//!
//! Frozen readings repeat bit for bit; these have noise of their own. In windows of a run in which the
//! prediction varies far more than residuals do elsewhere, they vary by little, and not with it. A spike
//! of a few samples, as of a mistyped input, is no variation of the prediction. A few
//! long stretches of a run are wrong readings; what stands still at a place of an input, as with a dead
//! zone or at a limit, is structure.

use std::ops::Range;

use crate::diagnose::found::{LeftOut, Wrong};
use crate::estimate::batch::Options;
use crate::estimate::calibrate::Calibration;
use crate::estimate::refit::calibrate_near;
use crate::estimate::residuals::{OfRun, Residuals, residuals_from};
use crate::statistics::upper_median;

use super::Cleaned;
use super::left_out::{OfSamples, if_sound, in_order, stretches_out};
use super::places::comes_back;

/// Windows are one in so many parts of a run, but of so many readings.
const PARTS: usize = 20;
const WINDOW: std::ops::RangeInclusive<usize> = 24..=400;
/// Samples of a spike of the prediction at most, which is no variation of it.
const SPIKE: usize = 2;
/// Slope of readings over predictions, and their scatter in parts of that of predictions, up to which
/// they do not follow.
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
    for (p, part) in problem.parts.iter().enumerate() {
        for (measurand, slot) in part.slots().iter().enumerate().filter(|(_, one)| one.width == 1) {
            let Some(own) = all.iter().find(|one| one.of() == (p, measurand)) else { continue };
            let readings = part.readings_of(slot.column);
            for (run, readings) in readings.iter().enumerate() {
                let of = OfRun { part: p, measurand, run };
                found.extend(stretches(own, run, readings).into_iter().map(|one| (of, one)));
            }
        }
    }
    let measurands: Vec<(usize, usize)> = found.iter().map(|one| one.0.of()).collect();
    let returning: Vec<(usize, usize)> =
        measurands.into_iter().filter(|of| comes_back(problem, *of, &found)).collect();
    found.retain(|(of, _)| !returning.contains(&of.of()));
    if found.is_empty() {
        return Ok(None);
    }
    let mut rest = problem.clone();
    let stretches = stretches_out(&mut rest, &all, &in_order(found), Wrong::Unresponsive);
    let left_out = LeftOut { stretches, ..LeftOut::default() };
    Ok(if_sound(nominal, calibrate_near(rest, point, options)?, left_out))
}

/// The samples of a run whose readings do not respond; none where they are many.
fn stretches(own: &Residuals, run: usize, readings: &[f64]) -> Vec<Range<usize>> {
    let present: Vec<(usize, f64, f64)> = own
        .readings(run)
        .into_iter()
        .map(|(at, residual)| (at, readings[at], readings[at] - residual))
        .collect();
    let size = (present.len() / PARTS).clamp(*WINDOW.start(), *WINDOW.end());
    if present.len() < 4 * size {
        return Vec::new();
    }
    let starts: Vec<usize> = (0..=present.len() - size).step_by(size / 2).collect();
    let smooth = without_spikes(&present);
    let windows: Vec<Window> =
        starts.iter().map(|start| Window::of(&smooth[*start..start + size])).collect();
    let mut residuals: Vec<f64> = windows.iter().map(|one| one.residual).collect();
    let usual = upper_median(&mut residuals).unwrap_or(f64::INFINITY);
    let flagged: Vec<usize> =
        (0..windows.len()).filter(|at| windows[*at].does_not_respond(usual)).collect();
    let groups = flagged.chunk_by(|a, b| b - a == 1).filter(|group| group.len() > 1);
    // The model may be off elsewhere, too.
    let mut offsets: Vec<f64> = present.iter().map(|(_, reading, at)| reading - at).collect();
    let offset = upper_median(&mut offsets).unwrap_or(0.0);
    let found: Vec<Range<usize>> = groups
        .map(|group| {
            let core = starts[group[0]]..starts[group[group.len() - 1]] + size;
            let ends = with_ends(&present, core, size, offset);
            present[ends.start].0..present[ends.end - 1].0 + 1
        })
        .collect();
    let count: usize = found.iter().map(Range::len).sum();
    let are_few = found.len() <= STRETCHES && count as f64 <= MOST * readings.len() as f64;
    if are_few { found } else { Vec::new() }
}

/// Standard deviations within a window, and the slope of readings over predictions.
struct Window {
    reading: f64,
    prediction: f64,
    residual: f64,
    slope: f64,
}

impl Window {
    fn of(samples: &[(usize, f64, f64)]) -> Self {
        let count = samples.len() as f64;
        let mean = |of: fn(&(usize, f64, f64)) -> f64| samples.iter().map(of).sum::<f64>() / count;
        let (reading, prediction) = (mean(|one| one.1), mean(|one| one.2));
        let sums = samples.iter().fold([0.0; 3], |sums, (_, y, p)| {
            let (y, p) = (y - reading, p - prediction);
            [sums[0] + y * y, sums[1] + p * p, sums[2] + y * p]
        });
        let [yy, pp, yp] = sums.map(|sum| sum / count);
        let residual = (yy + pp - 2.0 * yp).max(0.0).sqrt();
        Self { reading: yy.sqrt(), prediction: pp.sqrt(), residual, slope: yp / pp }
    }

    fn does_not_respond(&self, usual: f64) -> bool {
        self.slope.abs() < SLOPE
            && self.reading < STILL * self.prediction
            && self.residual > UNUSUAL * usual
    }
}

/// Samples with the running median of their predictions: a mistyped input is a spike of few samples.
fn without_spikes(samples: &[(usize, f64, f64)]) -> Vec<(usize, f64, f64)> {
    let median = |at: usize| {
        let near = at.saturating_sub(SPIKE)..(at + SPIKE + 1).min(samples.len());
        upper_median(&mut samples[near].iter().map(|one| one.2).collect::<Vec<f64>>())
    };
    let each = samples.iter().enumerate();
    each.map(|(at, one)| (one.0, one.1, median(at).unwrap_or(one.2))).collect()
}

/// A stretch with its ends where readings leave the line through its middle half for the prediction, with
/// its usual offset, at most a window beyond.
fn with_ends(
    present: &[(usize, f64, f64)],
    core: Range<usize>,
    size: usize,
    offset: f64,
) -> Range<usize> {
    let quarter = core.len() / 4;
    let middle = core.start + quarter..core.end - quarter;
    let count = middle.len() as f64;
    let samples = || middle.clone().map(|at| (at as f64, present[at].1));
    let (x, y) = samples().fold((0.0, 0.0), |sum, one| (sum.0 + one.0, sum.1 + one.1));
    let (x, y) = (x / count, y / count);
    let (xx, xy) = samples().fold((0.0, 0.0), |sum, (at, reading)| {
        (sum.0 + (at - x).powi(2), sum.1 + (at - x) * (reading - y))
    });
    let excess = |at: usize| {
        let (_, reading, prediction) = present[at];
        (reading - prediction - offset).powi(2) - (reading - y - xy / xx * (at as f64 - x)).powi(2)
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
