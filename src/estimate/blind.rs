//! Arm angles at which a measurand does not show its delay, as ranges.
//!
//! A measurand that stands still for a moment, though the arm moves, tells nothing of time:
//! readings there are blind ([`crate::estimate::newton`]). Sorted by arm angle, those of a setup's
//! runs make ranges, each reaching halfway to the nearest reading that sees. It does not look
//! between readings: a range is as sharp as they are dense, and says nothing of angles that no run
//! came by.

use std::f64::consts::TAU;

use crate::campaign::{Run, Samples};
use crate::engine::part::Part;
use crate::estimate::nearby::Nearby;
use crate::estimate::newton::{ReadingDelay, Solved, State};

/// The input that is the arm's angle, in every model that has one, or what has its role.
const ARM_ANGLE: &str = "arm_angle";
/// The arm's angle at the reference times of readings, in whatever order they come.
#[derive(Debug)]
pub struct ArmAngle {
    /// The input, if the model has one.
    input: Option<usize>,
    nearby: Nearby,
}

impl ArmAngle {
    /// Of the readings of a campaign.
    pub fn of(part: &Part) -> Self {
        let input = part.system.input(ARM_ANGLE);
        Self { input, nearby: Nearby::default() }
    }

    /// At a reading, in [0, 2π).
    pub fn at(&mut self, part: &Part, reading: &ReadingDelay) -> Option<f64> {
        let input = self.input?;
        let sample = self.nearby.sample(part, reading);
        let angle: f64 = sample.samples.inputs[input].at(sample.at, reading.time, 0.0, 0);
        angle.is_finite().then(|| angle.rem_euclid(TAU))
    }
}

/// Ranges closer together than this (rad) are one: between them only noise decides.
const CLOSE: f64 = TAU / 360.0;
/// Neighbours farther apart than this (rad) do not speak for what is between them.
const APART: f64 = 10.0 * TAU / 360.0;

/// A range of arm angles without sight, from `from` in [0, 2π) on in the positive sense to `to`,
/// which may go beyond 2π.
#[derive(Clone, Debug, PartialEq)]
pub struct BlindRange {
    /// Name of the setup: where the instrument stands decides what it is blind to.
    pub setup: String,
    /// Where it begins (rad).
    pub from: f64,
    /// Where it ends (rad).
    pub to: f64,
    /// Blind readings in it.
    pub readings: usize,
}

/// Classes of arm angle (a turn has so many) in which readings are put together; fewer readings
/// than that stay apart.
const CLASSES: usize = 7200;

/// Where a measurand was blind and where not, setup by setup; memory does not grow with readings.
#[derive(Debug)]
pub(crate) struct Sight {
    /// The arm's angle among the inputs, if the model has one.
    input: Option<usize>,
    /// For each setup and class, blind readings and the others.
    classes: Vec<Vec<[Class; 2]>>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Class {
    count: usize,
    /// Sum of their angles (rad).
    sum: f64,
}

impl Sight {
    pub(crate) fn new(part: &Part) -> Self {
        let input = part.system.input(ARM_ANGLE);
        let count = if input.is_some() { CLASSES } else { 0 };
        let classes = vec![vec![[Class::default(); 2]; count]; part.setups.len()];
        Self { input, classes }
    }

    /// The arm's angle among the inputs, if the model has one.
    pub(crate) fn input(&self) -> Option<usize> {
        self.input
    }

    /// Takes readings of a run of a setup.
    pub(crate) fn see(&mut self, setup: usize, readings: &[(f64, bool)]) {
        for (angle, is_blind) in readings {
            let class = ((angle / TAU * CLASSES as f64) as usize).min(CLASSES - 1);
            let class = &mut self.classes[setup][class][usize::from(*is_blind)];
            class.count += 1;
            class.sum += angle;
        }
    }

    /// The blind ranges; none for a model without arm angle.
    pub(crate) fn ranges(&self, part: &Part) -> Vec<BlindRange> {
        let mut found = Vec::new();
        for (setup, classes) in part.setups.iter().zip(&self.classes) {
            let mut seen: Vec<Seen> = classes
                .iter()
                .flat_map(|class| class.iter().zip([false, true]))
                .filter(|(class, _)| class.count > 0)
                .map(|(class, blind)| (class.sum / class.count as f64, blind, class.count))
                .collect();
            seen.sort_by(|a, b| a.0.total_cmp(&b.0));
            let ranges = of_sorted(&seen).into_iter();
            found.extend(ranges.map(|(from, to, readings)| BlindRange {
                setup: setup.clone(),
                from,
                to,
                readings,
            }));
        }
        found
    }
}

/// The arm's angle (rad, in [0, 2π)) at readings of a run, in their order, and whether they are
/// blind; nothing of a model that has none.
pub(crate) fn seen(input: Option<usize>, run: &Run, readings: &Solved) -> Vec<(f64, bool)> {
    let (Some(input), Some(samples)) = (input, readings.samples()) else { return Vec::new() };
    let mut scratch = Samples::default();
    let stretch = run.record.stretch(samples, &mut scratch);
    let track = &stretch.samples.inputs[input];
    let angle = |reading: ReadingDelay| {
        let at = stretch.start + reading.sample - stretch.first;
        let angle: f64 = track.at(at, reading.time, 0.0, 0);
        (angle.rem_euclid(TAU), reading.state == State::Blind)
    };
    readings.each().map(angle).filter(|(angle, _)| angle.is_finite()).collect()
}

/// An angle, whether it is blind, and how many readings say so.
type Seen = (f64, bool, usize);

/// Ranges of blind ones among angles in order on the circle, as start, end and number.
fn of_sorted(seen: &[Seen]) -> Vec<(f64, f64, usize)> {
    let count = seen.len();
    // Begin after one that sees, so that no range is cut at zero.
    let Some(begin) = seen.iter().position(|(_, blind, _)| !blind) else {
        let all = seen.iter().map(|(_, _, readings)| readings).sum();
        return if count == 0 { Vec::new() } else { vec![(0.0, TAU, all)] };
    };
    let at = |k: usize| {
        let index = begin + k;
        seen[index % count].0 + if index >= count { TAU } else { 0.0 }
    };
    let is_blind = |k: usize| seen[(begin + k) % count].1;
    let halfway = |a: f64, b: f64, near: f64| if b - a < APART { 0.5 * (a + b) } else { near };
    let mut ranges: Vec<(f64, f64, usize)> = Vec::new();
    let mut k = 1;
    while k < count {
        if !is_blind(k) {
            k += 1;
            continue;
        }
        let first = k;
        while k < count && is_blind(k) && (k == first || at(k) - at(k - 1) < APART) {
            k += 1;
        }
        let from = halfway(at(first - 1), at(first), at(first));
        let to = halfway(at(k - 1), at(k), at(k - 1));
        let readings: usize = (first..k).map(|k| seen[(begin + k) % count].2).sum();
        match ranges.last_mut() {
            Some(last) if from - last.1 < CLOSE => *last = (last.0, to, last.2 + readings),
            _ => ranges.push((from, to, readings)),
        }
    }
    let turned = |(from, to, count): (f64, f64, usize)| {
        let turns = (from / TAU).floor() * TAU;
        (from - turns, to - turns, count)
    };
    ranges.into_iter().map(turned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const D: f64 = TAU / 360.0;

    fn of(blind: impl Fn(usize) -> bool, step: usize) -> Vec<(i64, i64, usize)> {
        let seen: Vec<_> = (0..360).step_by(step).map(|d| (d as f64 * D, blind(d), 1)).collect();
        let whole = |angle: f64| (10.0 * angle / D).round() as i64;
        of_sorted(&seen).into_iter().map(|(a, b, n)| (whole(a), whole(b), n)).collect()
    }

    #[test]
    fn ranges_reach_halfway_to_readings_that_see() {
        assert_eq!(of(|d| (90..95).contains(&d) || d == 200, 1), [(895, 945, 5), (1995, 2005, 1)]);
        assert_eq!(of(|_| false, 1), []);
        assert_eq!(of(|_| true, 1), [(0, 3600, 360)]);
    }

    #[test]
    fn a_range_may_go_on_past_the_homepoint() {
        assert_eq!(of(|d| !(4..357).contains(&d), 1), [(3565, 3635, 7)]);
    }

    #[test]
    fn noise_at_the_ends_does_not_tear_a_range() {
        assert_eq!(of(|d| (90..95).contains(&d) || d == 97, 1), [(895, 945, 5), (965, 975, 1)]);
        let half = of(|d| d == 90 || d == 91, 1);
        assert_eq!(half, [(895, 915, 2)]);
        let seen: Vec<_> = (0..720)
            .map(|d| (d as f64 * 0.5 * D, (180..190).contains(&d) && d != 185, 1))
            .collect();
        assert_eq!(of_sorted(&seen).len(), 1);
    }

    #[test]
    fn where_no_run_came_by_is_not_blind() {
        // Readings every 20 deg: one blind one speaks for itself alone.
        assert_eq!(of(|d| d == 100, 20), [(1000, 1000, 1)]);
    }
}
