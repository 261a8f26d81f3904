//! Why a fit that settled is no result: a smaller model fits better, or a delay ends outside the range
//! that is stated for it, or where most readings lie outside their streams. Beyond its ends a stream is
//! extrapolated.

use crate::campaign::signal::{Track, moving_signals};
use crate::campaign::spline::Spline;
use crate::engine::{Point, Problem};

/// Why a fit that settled is no result.
#[derive(Clone, Debug, PartialEq)]
pub enum Refused {
    /// A smaller model fits better.
    Worse {
        /// Effects that were put in.
        effects: Vec<String>,
        /// chi squared with them and without.
        chi_squared: [f64; 2],
    },
    /// A delay is farther than the stated `delay_range`.
    OutsideRange {
        /// Name of the delay.
        delay: String,
        /// Its value (s).
        value: f64,
        /// The least and the greatest in the range (s).
        range: [f64; 2],
    },
    /// At a delay most readings lie outside their streams.
    OutsideStreams(Outside),
}

/// A delay at which readings lie outside their streams, or in gaps of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Outside {
    /// Its name.
    pub delay: String,
    /// The setup or run, where it has several values.
    pub of: Option<String>,
    /// Its value (s).
    pub value: f64,
    /// Readings outside, and all that it acts on.
    pub counts: [usize; 2],
}

impl Outside {
    /// Whether most are.
    pub fn is_most(&self) -> bool {
        2 * self.counts[0] > self.counts[1]
    }
}

/// Delays that are farther than the range that is stated for them.
pub(super) fn outside_range(problem: &Problem, point: &Point) -> Vec<Refused> {
    let layout = &problem.layout;
    let mut found: Vec<Refused> = Vec::new();
    for (p, part) in problem.parts.iter().enumerate() {
        for index in layout.used[p].iter().flatten() {
            let instance = &layout.instances[*index];
            if !instance.is_delay() || !layout.is_free(*index) {
                continue;
            }
            let Some(range) = part.delay_range.stated(&instance.name) else { continue };
            let value = point.values[*index][0];
            let one = Refused::OutsideRange { delay: instance.name.clone(), value, range };
            if !(range[0]..=range[1]).contains(&value) && !found.contains(&one) {
                found.push(one);
            }
        }
    }
    found
}

/// Delays at which some readings lie outside their streams. Within their ranges none does: such samples
/// are left out when a campaign is read.
pub fn outside_streams(problem: &Problem, point: &Point) -> Vec<Outside> {
    let layout = &problem.layout;
    let mut counts = vec![[0; 2]; layout.instances.len()];
    for (p, part) in problem.parts.iter().enumerate() {
        let names = &part.system.assembly.names;
        for (r, run) in part.runs.iter().enumerate() {
            // The instance, its delay and the columns of each measurand.
            let each = names.measurands.iter().zip(part.slots()).map(|(one, slot)| {
                let index = layout.instance_in(p, r, one.delay);
                (index, point.values[index][0], slot.columns())
            });
            let each: Vec<_> = each.collect();
            let is_within = |(index, value, _): &(usize, f64, _)| {
                let [low, high] = part.delay_range.of_delay(&layout.instances[*index].name);
                (low..=high).contains(value)
            };
            if each.iter().all(is_within) {
                continue;
            }
            run.record.walk(|stretch| {
                let samples = stretch.samples;
                let moving = moving_signals(&names.inputs, &samples.inputs);
                let streams = samples.inputs.iter().zip(moving);
                let streams: Vec<&Spline> = streams.filter_map(logged).collect();
                for sample in stretch.each() {
                    for (index, value, columns) in &each {
                        if samples.readings[columns.start][sample.at].is_nan() {
                            continue;
                        }
                        let moment = samples.time[sample.at] + value;
                        let is_out = streams.iter().any(|one| !one.covers(moment, moment));
                        counts[*index][0] += usize::from(is_out);
                        counts[*index][1] += 1;
                    }
                }
            });
        }
    }
    let found = counts.into_iter().zip(&layout.instances).zip(&point.values);
    let found = found.filter(|((counts, _), _)| counts[0] > 0);
    let outside = found.map(|((counts, instance), value)| Outside {
        delay: instance.name.clone(),
        of: instance.of.clone(),
        value: value[0],
        counts,
    });
    outside.collect()
}

/// The stream of a signal that moves.
fn logged((track, moves): (&Track, bool)) -> Option<&Spline> {
    match track {
        Track::Logged(spline) if moves => Some(spline.as_ref()),
        _ => None,
    }
}
