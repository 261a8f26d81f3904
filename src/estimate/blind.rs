//! Arm angles at which a measurand does not show its delay, as ranges.
//!
//! A measurand that stands still for a moment, though the arm moves, tells nothing of time: readings
//! there are blind ([`crate::estimate::newton`]). Sorted by arm angle, those of a
//! setup's runs make ranges, each reaching halfway to the nearest reading that sees. It does not look between
//! readings: a range is as sharp as they are dense, and says nothing of angles that no run came by.

use std::f64::consts::TAU;

use crate::engine::problem::Part;
use crate::estimate::newton::{ReadingDelay, State};

/// The input that is the arm's angle, in every model that has one.
const ARM_ANGLE: &str = "arm_angle";
/// Ranges closer together than this (rad) are one: between them only noise decides.
const CLOSE: f64 = TAU / 360.0;
/// Neighbours farther apart than this (rad) do not speak for what is between them.
const APART: f64 = 10.0 * TAU / 360.0;

/// A range of arm angles without sight, from `from` in [0, 2π) on in the positive sense to `to`, which
/// may go beyond 2π.
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

/// The blind ranges of one measurand's readings, setup by setup; none for a model without arm angle.
pub fn ranges(part: &Part, readings: &[ReadingDelay], measurand: usize) -> Vec<BlindRange> {
    let inputs = &part.system.assembly.names.inputs;
    let Some(input) = inputs.iter().position(|input| input.name == ARM_ANGLE) else {
        return Vec::new();
    };
    let mut found = Vec::new();
    for (setup, name) in part.setups.iter().enumerate() {
        let own = readings
            .iter()
            .filter(|one| one.measurand == measurand && part.runs[one.run].setup == setup);
        let mut seen: Vec<(f64, bool)> = own
            .map(|reading| {
                let samples = part.runs[reading.run].held();
                let time = samples.time[reading.sample];
                let angle: f64 = samples.inputs[input].at(reading.sample, time, 0.0, 0);
                (angle.rem_euclid(TAU), reading.state == State::Blind)
            })
            .filter(|(angle, _)| angle.is_finite())
            .collect();
        seen.sort_by(|a, b| a.0.total_cmp(&b.0));
        found.extend(of_sorted(&seen).into_iter().map(|(from, to, readings)| BlindRange {
            setup: name.clone(),
            from,
            to,
            readings,
        }));
    }
    found
}

/// Ranges of blind ones among angles in order on the circle, as start, end and number.
fn of_sorted(seen: &[(f64, bool)]) -> Vec<(f64, f64, usize)> {
    let count = seen.len();
    // Begin after one that sees, so that no range is cut at zero.
    let Some(begin) = seen.iter().position(|(_, blind)| !blind) else {
        return if count == 0 { Vec::new() } else { vec![(0.0, TAU, count)] };
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
        match ranges.last_mut() {
            Some(last) if from - last.1 < CLOSE => *last = (last.0, to, last.2 + k - first),
            _ => ranges.push((from, to, k - first)),
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
        let seen: Vec<_> = (0..360).step_by(step).map(|d| (d as f64 * D, blind(d))).collect();
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
        let seen: Vec<_> =
            (0..720).map(|d| (d as f64 * 0.5 * D, (180..190).contains(&d) && d != 185)).collect();
        assert_eq!(of_sorted(&seen).len(), 1);
    }

    #[test]
    fn where_no_run_came_by_is_not_blind() {
        // Readings every 20 deg: one blind one speaks for itself alone.
        assert_eq!(of(|d| d == 100, 20), [(1000, 1000, 1)]);
    }
}
