//! Rates that contradict the changes of their values, and runs that lack them.

use std::f64::consts::PI;

use crate::campaign::{Role, Run, Track};
use crate::diagnostic::Diagnostic;
use crate::engine::Part;
use crate::units::decimal;

use super::LOOK;

/// Compares each recorded rate with the change of its value from sample to sample.
pub(super) fn rates(part: &Part, run: &Run) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    let head = run.record.head(LOOK);
    for (input, track) in part.system.assembly.names.inputs.iter().zip(&head.inputs) {
        let Track::Captured { value, rate: Some(rate), .. } = track else { continue };
        let turns = input.unit.is_angle();
        let (run, name) = (&run.name, &input.name);
        let warning = match compare(&head.time, value, rate, turns) {
            Rates::Agree => continue,
            Rates::Times(ratio) if ratio < -0.5 => format!(
                "run `{run}`: `{name}_rate` says the opposite sense of rotation to the change of `{name}` itself"
            ),
            Rates::Times(ratio) => format!(
                "run `{run}`: `{name}` changes {} times as fast as `{name}_rate` says{}",
                decimal(ratio, 4),
                unit_guess(ratio)
            ),
            Rates::Differ => format!(
                "run `{run}`: `{name}` does not change from sample to sample as `{name}_rate` and `time` say"
            ),
        };
        found.push(Diagnostic::warning(warning).help(format!(
            "check sign and unit of the columns `{name}_rate` and `time`; delays follow from them"
        )));
    }
    found
}

/// How recorded rates go with the changes of their values.
enum Rates {
    Agree,
    /// Values change so many times as fast as their rates say.
    Times(f64),
    /// They have nothing to do with each other.
    Differ,
}

/// A step of this size (rad) and more may hide a turn.
const CLEAR: f64 = 0.5;
/// Steps that do not go with their rates by that much (rad), in the middle, are others.
const OTHER: f64 = 0.3;
/// Ratios that differ from 1 by less are not told: a delay is known no better.
const SAME_RATE: f64 = 0.01;
/// ... and by fewer standard uncertainties.
const SURE: f64 = 5.0;

/// Where the end correction is a larger part of the way, samples are too far apart for the motion.
const RESOLVED: f64 = 0.05;

/// By the trapezoidal rule with its end correction, rates of rates from neighbours: what that
/// changes is how well the rule does.
fn compare(time: &[f64], value: &[f64], rate: &[f64], turns: bool) -> Rates {
    let turn = 2.0 * PI;
    let slope = |i: usize| (rate[i + 1] - rate[i - 1]) / (time[i + 1] - time[i - 1]);
    let mut clear: Vec<[f64; 3]> = Vec::new();
    let mut apart: Vec<f64> = Vec::new();
    let (mut bends, mut ways) = (0.0, 0.0);
    for i in 2..value.len().saturating_sub(1) {
        let elapsed = time[i] - time[i - 1];
        let plain = 0.5 * (rate[i] + rate[i - 1]) * elapsed;
        let expected = plain - elapsed * elapsed / 12.0 * (slope(i) - slope(i - 1));
        let mut change = value[i] - value[i - 1];
        if !(plain.is_finite() && expected.is_finite() && change.is_finite()) {
            continue;
        }
        bends += (expected - plain).powi(2);
        ways += plain.powi(2);
        if turns {
            let off = change - plain;
            apart.push((off - turn * (off / turn).round()).abs());
            // A wrong sign or a moderate factor shows only while a step stays well below a turn.
            change -= turn * (change / turn).round();
            if plain.abs() > CLEAR || change.abs() > CLEAR {
                continue;
            }
        }
        clear.push([change, plain, expected]);
    }
    if bends > RESOLVED * RESOLVED * ways {
        return Rates::Agree;
    }
    if clear.len() < 5 {
        apart.sort_by(f64::total_cmp);
        let differ = apart.len() >= 5 && apart[apart.len() / 2] > OTHER;
        return if differ { Rates::Differ } else { Rates::Agree };
    }
    let sum = |of: &dyn Fn(&[f64; 3]) -> f64| clear.iter().map(of).sum::<f64>();
    let squares = sum(&|[_, _, expected]| expected * expected);
    if squares == 0.0 {
        return Rates::Agree;
    }
    let ratio = sum(&|[change, _, expected]| change * expected) / squares;
    let plain = sum(&|[change, plain, _]| change * plain) / sum(&|[_, plain, _]| plain * plain);
    let left = sum(&|[change, _, expected]| (change - ratio * expected).powi(2));
    let sigma = (left / (clear.len() - 1) as f64 / squares).sqrt();
    let tolerance = SAME_RATE.max((ratio - plain).abs()) + SURE * sigma;
    if (ratio - 1.0).abs() > tolerance { Rates::Times(ratio) } else { Rates::Agree }
}

/// Runs in motion without a rate that others of the campaign have: there nothing is delayed.
pub(super) fn missing_rates(part: &Part) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    let moving = part.runs.iter().filter(|run| run.role == Role::Kinematic);
    let heads: Vec<_> = moving.map(|run| (run, run.record.head(LOOK))).collect();
    for (index, input) in part.system.assembly.names.inputs.iter().enumerate() {
        let (with, without): (Vec<_>, Vec<_>) = heads
            .iter()
            .filter_map(|(run, head)| match &head.inputs[index] {
                Track::Captured { value, rate, .. } => {
                    let moves = value.iter().any(|one| *one != value[0]);
                    moves.then_some((run, rate.is_some()))
                }
                _ => None,
            })
            .partition(|(_, has_rate)| *has_rate);
        if with.is_empty() {
            continue;
        }
        let name = &input.name;
        found.extend(without.iter().map(|(run, _)| {
            let words =
                format!("run `{}`: `{name}` moves, but there is no column `{name}_rate`", run.name);
            Diagnostic::warning(words)
                .help("it is taken for standing still at each reading, as if nothing were late")
        }));
    }
    found
}

fn unit_guess(ratio: f64) -> String {
    let guesses = [
        (180.0 / PI, "deg for rad"),
        (PI / 180.0, "rad for deg"),
        (200.0 / PI, "gon for rad"),
        (PI / 200.0, "rad for gon"),
        (1000.0, "a factor 1000"),
        (1e-3, "a factor 1000"),
        (60.0, "minutes for seconds"),
        (1.0 / 60.0, "minutes for seconds"),
    ];
    guesses
        .iter()
        .find(|(factor, _)| (ratio / factor - 1.0).abs() < 0.05)
        .map_or_else(String::new, |(_, words)| format!(": {words}?"))
}
