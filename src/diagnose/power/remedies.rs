//! What could be added to a campaign, tried one at a time on the design: a run of opposite sense or one
//! more like it, at another rate, with ramps, with a signal that stood still; another setup, the rig tilted or not; a
//! stated length. Whether it helps is no rule of thumb but the same computation with it added.

use crate::campaign::{Run, Samples, Track};
use crate::diagnose::fitted::Fitted;
use crate::engine::{Point, Problem};
use crate::graph::{Kind, Scope};
use crate::quaternion::Quaternion;
use crate::units::{Dimension, Unit};

use crate::diagnose::budget::labels::{SAMPLES, steady_rate};

use super::design::design;

/// Swings of a run with ramps.
const SWINGS: f64 = 4.0;
/// Rate of the slower run over that of the one it is made from.
const SLOWER: f64 = 0.4;
/// Rate of a signal that stood still (rad/s or its unit a second): 20 degrees a second.
const TURNING: f64 = 0.35;
/// Standard uncertainty of a length that is stated (m).
const LENGTH: f64 = 2e-6;

/// Designs with one thing more each, and words for it (`a run of opposite sense`), the cheapest first.
pub(super) fn remedies(fitted: &Fitted) -> Vec<(String, Fitted)> {
    let mut all = Vec::new();
    let Some(Template { part, run, signal, senses }) = template(&fitted.problem) else {
        return all;
    };
    let inputs = &fitted.problem.parts[part].system.assembly.names.inputs;
    let rate = mean_rate(&fitted.problem.parts[part].runs[run], signal);
    let in_words = |times: f64| in_words(times * rate.abs(), &inputs[signal].unit);
    let mut add = |words: &str, change: &dyn Fn(&mut Problem)| {
        let mut problem = fitted.problem.clone();
        change(&mut problem);
        let problem = Problem::new(problem.parts);
        let point = with_setups(&fitted.problem, &fitted.fit.point, &problem);
        let made = design(fitted.recipes.clone(), problem, point);
        all.push((words.to_owned(), made));
    };
    let more = |problem: &mut Problem, input, motion: &dyn Fn(&Moment) -> [f64; 3]| {
        let mut run: Run = problem.parts[part].runs[run].clone();
        run.name = "one_run_more".to_owned();
        run.record.edit(|samples| moved(samples, input, motion));
        problem.parts[part].runs.push(run);
    };
    if !has_sense(&fitted.problem.parts[part].runs[run], (signal, &inputs[signal].unit)) {
        let name = &fitted.problem.parts[part].runs[run].name;
        add(&format!("one more run like `{name}`"), &|problem| {
            more(problem, signal, &|m: &Moment| m.now);
        });
    } else if senses < 2 {
        add("a run of opposite sense", &|problem| {
            let opposite = |m: &Moment| [2.0 * m.first[0] - m.now[0], -m.now[1], -m.now[2]];
            more(problem, signal, &opposite);
        });
    }
    add(&format!("a slower run, at {},", in_words(SLOWER)), &|problem| {
        more(problem, signal, &|Moment { first, now, .. }| {
            [first[0] + SLOWER * (now[0] - first[0]), SLOWER * now[1], SLOWER * now[2]]
        });
    });
    add(&format!("a run whose rate swings by {} both ways", in_words(1.0)), &|problem| {
        more(problem, signal, &|Moment { first, time, duration, .. }| {
            // The rate goes as the sine of the phase.
            let turn = std::f64::consts::TAU * SWINGS / duration;
            let phase = turn * time;
            let angle = rate / turn * (1.0 - phase.cos());
            [first[0] + angle, rate * phase.sin(), rate * turn * phase.cos()]
        });
    });
    let names = &fitted.problem.parts[part].system.assembly.names;
    for (input, declared) in names.inputs.iter().enumerate() {
        if declared.signal && stands_still(&fitted.problem, part, input) {
            add(&format!("a run in which `{}` moves", declared.name), &|problem| {
                more(problem, input, &|m| [m.first[0] + TURNING * m.time, TURNING, 0.0]);
            });
        }
    }
    let settings = &fitted.problem.parts[part].system.settings;
    if settings.iter().any(|setting| setting.scope == Scope::Setup && !setting.fixed) {
        for name in [MOVED, TILTED] {
            add(name, &|problem| {
                let part = &mut problem.parts[part];
                let setup = part.runs[run].setup;
                let mut of_setup = part.system.of_setups.clone();
                of_setup.retain(|one| one.setup == part.setups[setup]);
                of_setup.iter_mut().for_each(|one| name.clone_into(&mut one.setup));
                part.system.of_setups.append(&mut of_setup);
                part.setups.push(name.to_owned());
                let mut again = part.runs.clone();
                again.retain(|run| run.setup == setup);
                for run in &mut again {
                    run.name = format!("{}_again", run.name);
                    run.setup = part.setups.len() - 1;
                    run.record.edit(forget);
                }
                part.runs.append(&mut again);
            });
        }
    }
    for (index, (parameter, setting)) in names.parameters.iter().zip(settings).enumerate() {
        let is_own = fitted.problem.parts[part].system.declared[index].effect.is_none();
        let is_length =
            (parameter.kind, parameter.unit.dimension) == (Kind::Scalar, Dimension::LENGTH);
        if is_own && is_length && !setting.fixed && setting.sigma.is_none() {
            let words = format!("a calibrated `{}` (to {:.0} µm)", parameter.name, 1e6 * LENGTH);
            let instance = fitted.problem.layout.instance_in(part, run, index);
            let value = fitted.fit.point.values[instance][0];
            add(&words, &|problem| {
                for setting in problem.parts[part].system.settings_mut(index) {
                    setting.value = Some(vec![value]);
                    setting.sigma = Some(vec![LENGTH]);
                }
            });
        }
    }
    all
}

/// Names of setups that are added: of a levelled instrument that stands elsewhere, and with the rig
/// tilted to it as well.
const MOVED: &str = "another setup";
const TILTED: &str = "another setup with the rig tilted otherwise";

/// The run from which further ones are made: the one that moves fastest.
struct Template {
    part: usize,
    run: usize,
    signal: usize,
    /// Senses in which the signal moves, over all runs.
    senses: usize,
}

fn template(problem: &Problem) -> Option<Template> {
    let mut best: Option<(f64, Template)> = None;
    for (part, own) in problem.parts.iter().enumerate() {
        let inputs = own.system.assembly.names.inputs.iter().enumerate();
        for (signal, _) in inputs.filter(|(_, input)| input.signal) {
            let rates: Vec<f64> = own.runs.iter().map(|run| mean_rate(run, signal)).collect();
            let is_there = |sense: &&f64| rates.iter().any(|rate| rate * **sense > 0.0);
            let senses = [1.0, -1.0].iter().filter(is_there).count();
            for (run, rate) in rates.iter().map(|rate| rate.abs()).enumerate() {
                let is_faster = best.as_ref().is_none_or(|(most, _)| rate > *most);
                if rate.is_finite() && rate > 0.0 && is_faster {
                    best = Some((rate, Template { part, run, signal, senses }));
                }
            }
        }
    }
    best.map(|(_, template)| template)
}

/// A rate of an input of this unit, for a person to set.
fn in_words(rate: f64, unit: &Unit) -> String {
    if unit.is_angle() {
        return format!("{} deg/s", two_digits(rate.to_degrees()));
    }
    format!("{} {}/s", two_digits(rate / unit.factor), unit.symbol)
}

/// A number above zero with at least two digits that count.
fn two_digits(number: f64) -> String {
    let decimals = (1.0 - number.log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{number:.decimals$}")
}

fn mean_rate(run: &Run, input: usize) -> f64 {
    let Some(last) = run.record.len().checked_sub(1) else { return 0.0 };
    let [(from, a), (to, b)] = [0, last].map(|number| {
        let end = run.record.cut(number..number + 1);
        (end.time[0], at(&end, input, 0)[0])
    });
    if to > from { (b - a) / (to - from) } else { 0.0 }
}

/// Whether an input of this unit moves in one sense in a run, and could in the other one: it is an angle
/// or a place, and does not go to and fro.
fn has_sense(run: &Run, (input, unit): (usize, &Unit)) -> bool {
    let samples = run.record.spread(SAMPLES, 1);
    let rates = (0..samples.len()).map(|sample| at(&samples, input, sample)[1]);
    let rates: Vec<f64> = rates.filter(|rate| rate.is_finite()).collect();
    let is_place = unit.is_angle() || unit.dimension == Dimension::LENGTH;
    is_place && steady_rate(&rates) != 0.0
}

fn stands_still(problem: &Problem, part: usize, input: usize) -> bool {
    let mut still = true;
    for run in &problem.parts[part].runs {
        run.record.walk(|stretch| {
            still &= stretch.each().all(|sample| {
                sample.samples.inputs[input].at(sample.at, sample.time(), 0.0, 1) == 0.0
            });
        });
    }
    still
}

/// Value, rate and acceleration of an input.
fn at(samples: &Samples, input: usize, sample: usize) -> [f64; 3] {
    [0, 1, 2].map(|order| samples.inputs[input].at(sample, samples.time[sample], 0.0, order))
}

/// A moment of a run that is there, for one that is not: states are value, rate and acceleration.
struct Moment {
    /// The state at the start of the run, and now.
    first: [f64; 3],
    now: [f64; 3],
    /// Since the start, and of the whole run (s).
    time: f64,
    duration: f64,
}

/// Lets an input move otherwise.
fn moved(samples: &mut Samples, input: usize, motion: &dyn Fn(&Moment) -> [f64; 3]) {
    let Some(last) = samples.len().checked_sub(1) else { return };
    let first = at(samples, input, 0);
    let duration = samples.time[last] - samples.time[0];
    let duration = if duration > 0.0 { duration } else { 1.0 };
    let state = |sample: usize| {
        let time = samples.time[sample] - samples.time[0];
        motion(&Moment { first, now: at(samples, input, sample), time, duration })
    };
    let states: Vec<[f64; 3]> = (0..=last).map(state).collect();
    let column = |order: usize| states.iter().map(|state| state[order]).collect();
    samples.inputs[input] =
        Track::Captured { value: column(0), rate: Some(column(1)), acceleration: Some(column(2)) };
    forget(samples);
}

/// A run that is not measured yet.
fn forget(samples: &mut Samples) {
    samples.readings.iter_mut().for_each(|column| column.fill(f64::NAN));
}

/// The point with a setup that may have been added: the instrument elsewhere, so that it sees
/// the rig from another side, farther and higher.
fn with_setups(from: &Problem, point: &Point, to: &Problem) -> Point {
    let mut made = point.carried(&from.layout, &to.layout);
    for (index, instance) in to.layout.instances.iter().enumerate() {
        let is = |name: &str| instance.of.as_deref().is_some_and(|of| of.ends_with(name));
        let turn = match (is(MOVED), is(TILTED)) {
            (true, _) => [0.0, 0.0, 0.6],
            (_, true) => [0.05, 0.1, 0.6],
            _ => continue,
        };
        let (turn, around) = (Quaternion::turn(turn), Quaternion::turn([0.0, 0.0, -0.4]));
        let instances = &from.layout.instances;
        let first = instances.iter().position(|one| one.name == instance.name);
        let Some(value) = first.map(|first| point.values[first]) else { continue };
        made.values[index] = match instance.kind {
            Kind::Rotation => {
                let q = turn * Quaternion { w: value[0], v: [value[1], value[2], value[3]] };
                [q.w, q.v[0], q.v[1], q.v[2]]
            }
            Kind::Vector => {
                let v = around.rotate([value[0], value[1], value[2]]);
                [1.3 * v[0], 1.3 * v[1], 1.3 * v[2] + 0.3, 0.0]
            }
            Kind::Scalar => value,
        };
    }
    made
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use std::path::Path;

    use super::*;
    use crate::engine::open::{Request, open};

    #[test]
    fn a_motion_to_and_fro_is_repeated_and_one_in_one_sense_reversed() {
        let words = |folder: &str| -> Vec<String> {
            let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
            let opened = open(&Request::new([folder])).unwrap();
            let point = Point::start(&opened.problem.layout);
            let fitted = design(opened.recipes, opened.problem, point);
            remedies(&fitted).into_iter().map(|(words, _)| words).collect()
        };
        assert_eq!(words("tests/cli/one_run")[0], "a run of opposite sense");
        let to_and_fro = words("examples/rail_car");
        assert_eq!(to_and_fro[0], "one more run like `out_and_back`");
        assert!(to_and_fro.iter().all(|one| one != "a run of opposite sense"));
    }
}
