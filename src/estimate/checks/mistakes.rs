//! Mistakes that would make the target's coordinates fit far better if they were undone: a swapped column, a
//! mirrored circle, an elevation read as a zenith angle, gon read as deg, mm read as m.
//!
//! Of the runs that share a transformation the first one is aligned by itself, the others are held against it: what
//! one run alone was recorded with shows there. A planar target path hides a mirrored instrument and a
//! reversed arm: both are then a turn of the transformation and do no harm to the delays.

use std::f64::consts::PI;

use crate::campaign::{Role, Run, Track};
use crate::diagnostic::Diagnostic;
use crate::engine::{Part, Point, Problem};
use crate::estimate::align::{Alignment, Pair, align};
use crate::estimate::start::pairs;
use crate::graph::MeasurandKind;
use crate::units::Dimension;

use super::{LOOK, listed};

/// An alternative must fit this many times better to be mentioned.
const FACTOR: f64 = 5.0;
/// And that well, beside the extent of the motion: what shrinks everything shrinks the misfit, too.
const CLOSE: f64 = 0.1;
/// A run that is no farther off, beside the extent of the motion, shows no mistake of this kind.
const SOUND: f64 = 0.01;

/// One mistake that may have been made, undone.
struct Alternative {
    words: String,
    undo: Undo,
}

/// Changes a run's readings or inputs.
type Undo = Box<dyn Fn(&mut Run)>;

/// The mistakes that runs of a campaign look like.
pub(super) fn mistakes(problem: &Problem, p: usize, start: &Point) -> Vec<Diagnostic> {
    let part = &problem.parts[p];
    let Some(coordinates) = &part.system.assembly.coordinates else { return Vec::new() };
    let key = |r: usize| {
        [coordinates.rotation, coordinates.translation]
            .map(|of| problem.layout.instance_in(p, r, of))
    };
    let mut found = Vec::new();
    let mut looked_at = Vec::new();
    for r in 0..part.runs.len() {
        if looked_at.contains(&key(r)) {
            continue;
        }
        looked_at.push(key(r));
        let mut sharing: Vec<usize> = (r..part.runs.len()).filter(|o| key(*o) == key(r)).collect();
        sharing.sort_by_key(|o| part.runs[*o].role != Role::Reference);
        found.extend(of_sharing(problem, p, &sharing, start));
    }
    found
}

/// The same of runs that share a transformation, those that rather fix it first.
fn of_sharing(problem: &Problem, p: usize, sharing: &[usize], start: &Point) -> Vec<Diagnostic> {
    let part = &problem.parts[p];
    let alternatives = candidates(part);
    let mut held: Option<(usize, Alignment)> = None;
    let mut first: Option<(String, Diagnostic)> = None;
    // What is to be done to runs beside the one that the others are held against, and how far they were off.
    let mut others: Vec<(String, Vec<&str>, f64, f64)> = Vec::new();
    for r in sharing {
        let parameters = problem.parameters::<f64>(p, *r, start);
        let short = shortened(&part.runs[*r]);
        let fit = |run: &Run| {
            let pairs = pairs(part, run, &parameters, 1.0);
            let alignment = match &held {
                Some((_, held)) => *held,
                None => align(&pairs, false).ok()?,
            };
            (!pairs.is_empty()).then(|| (misfit(&pairs, &alignment), extent(&pairs), alignment))
        };
        let Some((as_given, reach, alignment)) = fit(&short) else { continue };
        let mut best: Option<(f64, &str, Alignment)> = None;
        let is_sound = held.is_some() && as_given < SOUND * reach;
        for alternative in alternatives.iter().filter(|_| !is_sound) {
            let mut changed = short.clone();
            (alternative.undo)(&mut changed);
            if let Some((rms, extent, alignment)) = fit(&changed)
                && rms < CLOSE * extent
                && FACTOR * rms < as_given
                && best.as_ref().is_none_or(|(known, ..)| rms < *known)
            {
                best = Some((rms, &alternative.words, alignment));
            }
        }
        let name = part.runs[*r].name.as_str();
        if held.is_none() {
            let told = |(rms, words, _): &(f64, &str, Alignment)| {
                ((*words).to_owned(), alone(part, *r, as_given, *rms, words))
            };
            first = best.as_ref().map(told);
            held = Some((*r, best.map_or(alignment, |(_, _, alignment)| alignment)));
        } else if let Some((rms, words, _)) = best {
            match others.iter_mut().find(|(known, ..)| known == words) {
                Some((_, names, most, left)) => {
                    names.push(name);
                    (*most, *left) = (most.max(as_given), left.max(rms));
                }
                None => others.push((words.to_owned(), vec![name], as_given, rms)),
            }
        }
    }
    let mut found = Vec::new();
    for (words, names, as_given, rms) in others {
        match (&mut first, held) {
            (Some((same, told)), _) if *same == words => {
                told.help.push(format!("so do those of {}", listed(&names)));
            }
            (_, Some((r, _))) => {
                found.push(beside(&part.runs[r].name, &names, as_given, rms, &words));
            }
            (_, None) => {}
        }
    }
    first.into_iter().map(|(_, told)| told).chain(found).collect()
}

const HELP: &str = "compare the columns and their units with the instrument's conventions";

fn alone(part: &Part, r: usize, as_given: f64, rms: f64, words: &str) -> Diagnostic {
    let run = &part.runs[r];
    let (setup, as_given, rms) = (&part.setups[run.setup], as_given * 1e3, rms * 1e3);
    let message = format!(
        "setup `{setup}`: the coordinates of run `{}` fit to {as_given:.3} mm as given, but to {rms:.3} mm if {words}",
        run.name
    );
    Diagnostic::warning(message).help(HELP)
}

fn beside(first: &str, names: &[&str], as_given: f64, rms: f64, words: &str) -> Diagnostic {
    let (runs, its) = if names.len() == 1 { ("run", "its") } else { ("runs", "their") };
    let (as_given, rms) = (as_given * 1e3, rms * 1e3);
    let message = format!(
        "{runs} {}: where run `{first}` puts the instrument {its} coordinates are {as_given:.3} mm off as given, but {rms:.3} mm if {words}",
        listed(names)
    );
    Diagnostic::warning(message).help(HELP)
}

/// Distance of points of the model from those measured (rms, m), as aligned.
fn misfit(pairs: &[Pair], alignment: &Alignment) -> f64 {
    let off = |pair: &Pair| -> f64 {
        let turned = alignment.rotation.rotate(pair.source);
        let there = |axis: usize| turned[axis] + alignment.translation[axis];
        (0..3).map(|axis| (pair.target[axis] - there(axis)).powi(2)).sum()
    };
    (pairs.iter().map(off).sum::<f64>() / pairs.len().max(1) as f64).sqrt()
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
