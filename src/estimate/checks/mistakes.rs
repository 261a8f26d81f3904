//! Mistakes that would make the target's coordinates fit far better if they were undone: a swapped
//! column, a mirrored circle, an elevation read as a zenith angle, gon read as deg, mm read as m.
//!
//! Each run is aligned by itself. What does not show so, because its arc is short or because a
//! turned arm does as well, shows beside the first of the runs that share a transformation. A
//! planar target path hides a mirrored instrument and a reversed arm: both are then a turn of the
//! transformation and do no harm to the delays.

use std::f64::consts::PI;

use crate::campaign::{Role, Run, Track};
use crate::diagnostic::Diagnostic;
use crate::engine::{Part, Point, Problem};
use crate::estimate::align::{Alignment, Pair, align};
use crate::estimate::start::pairs;
use crate::graph::MeasurandKind;
use crate::units::{Dimension, decimal};

use super::{LOOK, listed};

/// Samples of a run that are looked at stand together in so many.
const STRETCH: usize = 8;

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

/// What is to be undone in some runs.
struct Mistake {
    words: String,
    runs: Vec<String>,
    /// How far they are off (m, rms), as given and with it undone, at most.
    as_given: f64,
    undone: f64,
}

/// The same of runs that share a transformation, those that rather fix it first.
fn of_sharing(problem: &Problem, p: usize, sharing: &[usize], start: &Point) -> Vec<Diagnostic> {
    let part = &problem.parts[p];
    let alternatives = candidates(part);
    let mut held: Option<(&str, Alignment)> = None;
    // By themselves, and beside the one that they are held against.
    let (mut alone, mut beside): (Vec<Mistake>, Vec<Mistake>) = (Vec::new(), Vec::new());
    for r in sharing {
        let run = &part.runs[*r];
        let looked = Looked::at(problem, (p, *r), start);
        let own = looked.best(&alternatives, None);
        if let Some(one) = &own {
            one.note(&run.name, &mut alone);
        } else if let Some((_, alignment)) = &held
            && looked.misfit(None, Some(alignment)).is_some_and(|off| off.rms >= SOUND * off.extent)
            && let Some(one) = looked.best(&alternatives, Some(alignment))
        {
            one.note(&run.name, &mut beside);
        }
        if held.is_none() {
            let alignment = match own {
                Some(one) => Some(one.alignment),
                None => looked.misfit(None, None).map(|off| off.alignment),
            };
            held = alignment.map(|alignment| (&run.name[..], alignment));
        }
    }
    let setup = &part.setups[part.runs[sharing[0]].setup];
    let alone = alone.iter().map(|one| one.alone(setup));
    let first = held.map_or("", |(name, _)| name);
    alone.chain(beside.iter().map(|one| one.beside(first))).collect()
}

/// Points of a run, as given or as they would be without a mistake.
struct Looked<'a> {
    part: &'a Part,
    parameters: Vec<[f64; 4]>,
    run: Run,
}

/// How far points are off an alignment (m, rms).
struct Off {
    rms: f64,
    extent: f64,
    alignment: Alignment,
}

/// A mistake that is likely.
struct Likely<'a> {
    words: &'a str,
    as_given: f64,
    undone: f64,
    alignment: Alignment,
}

impl<'a> Looked<'a> {
    fn at(problem: &'a Problem, (p, r): (usize, usize), start: &Point) -> Self {
        let part = &problem.parts[p];
        let run = shortened(&part.runs[r]);
        Self { part, parameters: problem.parameters(p, r, start), run }
    }

    /// Beside an alignment, or their own.
    fn misfit(&self, undo: Option<&Undo>, held: Option<&Alignment>) -> Option<Off> {
        let mut changed = None;
        if let Some(undo) = undo {
            undo(changed.insert(self.run.clone()));
        }
        let pairs = pairs(self.part, changed.as_ref().unwrap_or(&self.run), &self.parameters, 1.0);
        let alignment = match held {
            Some(held) => *held,
            None => align(&pairs, false).ok()?,
        };
        let rms = misfit(&pairs, &alignment);
        (!pairs.is_empty()).then(|| Off { rms, extent: extent(&pairs), alignment })
    }

    /// The mistake without which they fit best, if it makes them fit.
    fn best<'w>(&self, all: &'w [Alternative], held: Option<&Alignment>) -> Option<Likely<'w>> {
        let as_given = self.misfit(None, held)?.rms;
        let undone = |one: &'w Alternative| {
            let off = self.misfit(Some(&one.undo), held)?;
            let fits = off.rms < CLOSE * off.extent && FACTOR * off.rms < as_given;
            let (undone, alignment) = (off.rms, off.alignment);
            fits.then_some(Likely { words: &one.words, as_given, undone, alignment })
        };
        all.iter().filter_map(undone).min_by(|a, b| a.undone.total_cmp(&b.undone))
    }
}

impl Likely<'_> {
    /// Puts it into a list, with the runs that have the same.
    fn note(&self, run: &str, all: &mut Vec<Mistake>) {
        match all.iter_mut().find(|known| known.words == self.words) {
            Some(known) => {
                known.runs.push(run.to_owned());
                known.as_given = known.as_given.max(self.as_given);
                known.undone = known.undone.max(self.undone);
            }
            None => all.push(Mistake {
                words: self.words.to_owned(),
                runs: vec![run.to_owned()],
                as_given: self.as_given,
                undone: self.undone,
            }),
        }
    }
}

impl Mistake {
    /// Of runs that show it by themselves.
    fn alone(&self, setup: &str) -> Diagnostic {
        let Self { words, runs, .. } = self;
        let [as_given, undone] = self.millimetres();
        let (of, fit) = if runs.len() == 1 { ("run", "fit") } else { ("runs", "each fit") };
        told(format!(
            "setup `{setup}`: the coordinates of {of} {} {fit} to {as_given} as given, but to {undone} if {words}",
            listed(runs)
        ))
    }

    /// Of runs that show it where another one puts the instrument.
    fn beside(&self, first: &str) -> Diagnostic {
        let Self { words, runs, .. } = self;
        let [as_given, undone] = self.millimetres();
        let (of, its) = if runs.len() == 1 { ("run", "its") } else { ("runs", "their") };
        told(format!(
            "{of} {}: {its} coordinates are {as_given} off as given where run `{first}` puts the instrument, but {undone} if {words}",
            listed(runs)
        ))
    }

    fn millimetres(&self) -> [String; 2] {
        [self.as_given, self.undone].map(|length| format!("{} mm", decimal(length * 1e3, 3)))
    }
}

fn told(message: String) -> Diagnostic {
    Diagnostic::warning(message)
        .help("compare the columns and their units with the instrument's conventions")
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

/// Some samples of a run, spread over it.
fn shortened(run: &Run) -> Run {
    Run { record: run.record.spread(LOOK, STRETCH).into(), ..run.clone() }
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
            all.push(scaled(
                1e-3,
                format!("`{name}` were a thousandth of its reading (mm taken for m)"),
            ));
            all.push(scaled(1e3, format!("`{name}` were a thousand times its reading (or the lengths that are stated a thousandth)")));
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
