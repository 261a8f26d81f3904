//! Cheap looks at the set-up before any fit: rates that contradict their angles, and mistakes that
//! would make the coordinates fit far better if they were undone (a swapped column, a mirrored
//! circle, an elevation read as a zenith angle, gon read as deg, mm read as m).
//!
//! Each finding is a sentence; nothing is changed. A planar target path hides a mirrored instrument
//! and a reversed arm: both are then a turn of the transformation and do no harm to the delays.

use std::f64::consts::PI;

use crate::campaign::{Role, Run, Track};
use crate::diagnostic::Diagnostic;
use crate::engine::{Part, Point, Problem};
use crate::estimate::align::{Pair, align};
use crate::estimate::start::pairs;
use crate::graph::MeasurandKind;
use crate::units::Dimension;

/// An alternative must fit this many times better to be mentioned.
const FACTOR: f64 = 5.0;
/// And that well, beside the extent of the motion: what shrinks everything shrinks the misfit, too.
const CLOSE: f64 = 0.1;
/// Samples of a run that are looked at.
const LOOK: usize = 400;

/// Looks at every campaign of a problem.
pub fn check(problem: &Problem) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    let start = Point::start(&problem.layout);
    for p in 0..problem.parts.len() {
        let part = &problem.parts[p];
        for run in &part.runs {
            found.extend(rates(part, run));
        }
        found.extend(missing_rates(part));
        found.extend(angles(part));
        found.extend(alternatives(problem, p, &start));
    }
    found
}

/// Compares each recorded rate with the change of its value from sample to sample.
fn rates(part: &Part, run: &Run) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    let head = run.record.head(LOOK);
    for (input, track) in part.system.assembly.names.inputs.iter().zip(&head.inputs) {
        let Track::Captured { value, rate: Some(rate), .. } = track else { continue };
        let turns = input.unit.dimension == Dimension::NONE;
        let (run, name) = (&run.name, &input.name);
        let warning = match compare(&head.time, value, rate, turns) {
            Rates::Agree => continue,
            Rates::Times(ratio) if ratio < -0.5 => format!(
                "run `{run}`: `{name}_rate` says the opposite sense of rotation to the change of `{name}` itself"
            ),
            Rates::Times(ratio) => format!(
                "run `{run}`: `{name}` changes {ratio:.4} times as fast as `{name}_rate` says{}",
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

/// By the trapezoidal rule with its end correction, rates of rates from neighbours: what that changes is
/// how well the rule does.
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
fn missing_rates(part: &Part) -> Vec<Diagnostic> {
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

/// Angles that cannot be: beyond two turns.
fn angles(part: &Part) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    for (measurand, slot) in part.system.assembly.names.measurands.iter().zip(part.slots()) {
        if !matches!(measurand.kind, MeasurandKind::Angle { .. }) {
            continue;
        }
        for run in &part.runs {
            let mut reading = None;
            run.record.walk(|stretch| {
                let readings = &stretch.samples.readings[slot.column][stretch.range()];
                let wide = || readings.iter().find(|value| value.abs() > 4.0 * PI);
                reading = reading.or_else(|| wide().copied());
            });
            let Some(reading) = reading else { continue };
            found.push(
                Diagnostic::warning(format!(
                    "run `{}`: `{}` reads {:.3} rad, more than two turns",
                    run.name, measurand.name, reading
                ))
                .help(
                    "check the unit in the column's header: deg, gon and rad are easily confused",
                ),
            );
            break;
        }
    }
    found
}

/// One mistake that may have been made, undone.
struct Alternative {
    words: String,
    undo: Undo,
}

/// Changes a run's readings or inputs.
type Undo = Box<dyn Fn(&mut Run)>;

fn alternatives(problem: &Problem, p: usize, start: &Point) -> Vec<Diagnostic> {
    let part = &problem.parts[p];
    if part.system.assembly.coordinates.is_none() {
        return Vec::new();
    }
    let mut found = Vec::new();
    let mut looked_at = Vec::new();
    for (r, run) in part.runs.iter().enumerate() {
        let setup = run.setup;
        let has_reference = part.runs.iter().any(|o| o.setup == setup && o.role == Role::Reference);
        if looked_at.contains(&setup) || (has_reference && run.role != Role::Reference) {
            continue;
        }
        looked_at.push(setup);
        let parameters = problem.parameters::<f64>(p, r, start);
        let fit = |run: &Run| {
            let pairs = pairs(part, run, &parameters, 1.0);
            let alignment = align(&pairs, false).ok()?;
            Some((alignment.rms, extent(&pairs)))
        };
        let short = shortened(run);
        let Some((as_given, _)) = fit(&short) else { continue };
        let mut best: Option<(f64, String)> = None;
        for alternative in candidates(part) {
            let mut changed = short.clone();
            (alternative.undo)(&mut changed);
            if let Some((rms, extent)) = fit(&changed)
                && rms < CLOSE * extent
                && FACTOR * rms < as_given
                && best.as_ref().is_none_or(|(known, _)| rms < *known)
            {
                best = Some((rms, alternative.words));
            }
        }
        if let Some((rms, words)) = best {
            found.push(
                Diagnostic::warning(format!(
                    "setup `{}`: the coordinates of run `{}` fit to {:.3} mm as given, but to {:.3} mm if {words}",
                    part.setups[setup],
                    run.name,
                    as_given * 1e3,
                    rms * 1e3,
                ))
                .help("compare the columns and their units with the instrument's conventions"),
            );
        }
    }
    found
}

/// How far the points of the model are from their mean (rms, m).
fn extent(pairs: &[Pair]) -> f64 {
    let count = pairs.len().max(1) as f64;
    let of_axis = |axis: usize| {
        let mean = pairs.iter().map(|pair| pair.source[axis]).sum::<f64>() / count;
        pairs.iter().map(|pair| (pair.source[axis] - mean).powi(2)).sum::<f64>() / count
    };
    (0..3).map(of_axis).sum::<f64>().sqrt()
}

/// The first samples of a run.
fn shortened(run: &Run) -> Run {
    Run { record: run.record.head(LOOK).into(), ..run.clone() }
}

fn candidates(part: &Part) -> Vec<Alternative> {
    let mut all = Vec::new();
    let names = &part.system.assembly.names;
    let slots = part.slots();
    let is_angle = |m: usize| matches!(names.measurands[m].kind, MeasurandKind::Angle { .. });
    for a in 0..slots.len() {
        let (column, name) = (slots[a].column, names.measurands[a].name.clone());
        let scaled = move |factor: f64, words: String| Alternative {
            words,
            undo: Box::new(move |run: &mut Run| {
                run.record.edit(|samples| {
                    samples.readings[column].iter_mut().for_each(|value| *value *= factor);
                });
            }),
        };
        if is_angle(a) {
            all.push(scaled(-1.0, format!("`{name}` counted in the other sense")));
            all.push(Alternative {
                words: format!("`{name}` were 90 deg less its reading (zenith angle or elevation)"),
                undo: Box::new(move |run| {
                    run.record.edit(|samples| {
                        samples.readings[column]
                            .iter_mut()
                            .for_each(|value| *value = PI / 2.0 - *value);
                    });
                }),
            });
            for (factor, read, given) in [(0.9, "gon", "deg"), (1.0 / 0.9, "deg", "gon")] {
                all.push(scaled(factor, format!("`{name}` were in {read}, not in {given}")));
            }
            for (b, other) in slots.iter().enumerate().skip(a + 1) {
                if is_angle(b) {
                    let (other, other_name) = (other.column, names.measurands[b].name.clone());
                    all.push(Alternative {
                        words: format!("the columns `{name}` and `{other_name}` were swapped"),
                        undo: Box::new(move |run| {
                            run.record.edit(|samples| samples.readings.swap(column, other));
                        }),
                    });
                }
            }
        } else if names.measurands[a].unit.dimension == Dimension::LENGTH {
            all.push(scaled(1e-3, format!("`{name}` were in mm, not in m")));
            all.push(scaled(1e3, format!("`{name}` were in m, not in mm")));
            for (b, other) in slots.iter().enumerate().skip(a + 1) {
                if names.measurands[b].unit.dimension == Dimension::LENGTH {
                    let (other, other_name) = (other.column, names.measurands[b].name.clone());
                    all.push(Alternative {
                        words: format!("the columns `{name}` and `{other_name}` were swapped"),
                        undo: Box::new(move |run| {
                            run.record.edit(|samples| samples.readings.swap(column, other));
                        }),
                    });
                }
            }
        }
    }
    for (index, input) in names.inputs.iter().enumerate() {
        if input.signal {
            all.push(Alternative {
                words: format!("`{}` counted in the other sense", input.name),
                undo: Box::new(move |run| reverse(run, index)),
            });
        }
    }
    all
}

fn reverse(run: &mut Run, input: usize) {
    run.record.edit(|samples| {
        let values = samples
            .time
            .iter()
            .enumerate()
            .map(|(i, time)| -samples.inputs[input].at::<f64>(i, *time, 0.0, 0))
            .collect();
        samples.inputs[input] = Track::Captured { value: values, rate: None, acceleration: None };
    });
}
