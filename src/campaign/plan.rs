//! A run that is not measured yet: triggers and motions, made into samples without readings.
//!
//! A plan is one leg,
//! `{ trigger = "40 Hz", duration = "43.6 s", arm_angle = { start = "0 deg", rate = "-190 deg/s", acceleration = "0 deg/s^2" } }`,
//! or a list of legs. An input's motion is a table, a text where it stands still, or a list of
//! tables with a `duration` each. Value and rate that a later leg does not say go on as the leg
//! before ended; acceleration is zero unless said. A plan begins at its `start` (a time), else when
//! the run before it in its setup ended.

use std::ops::Range;

use crate::campaign::entries::{Item, Quantity, Reader, Value, get};
use crate::campaign::file::{Named, RunEntry};
use crate::campaign::loader::{self, column_count};
use crate::campaign::record::captured_with_rates;
use crate::campaign::samples::Samples;
use crate::campaign::signal::Track;
use crate::diagnostic::Span;
use crate::model::{InputDeclaration, Model};
use crate::units::{Dimension, Unit};

/// The most samples a planned run may have.
const MOST_SAMPLES: f64 = 2e7;

/// One leg of a plan.
#[derive(Clone, Debug)]
pub struct Leg {
    /// Readings a second.
    pub trigger: f64,
    /// How long it takes (s).
    pub duration: f64,
    /// Time of its first sample (s), if said; first leg only.
    pub start: Option<f64>,
    /// The inputs that move, with the pieces of their motion.
    pub motions: Vec<(Named, Vec<Piece>)>,
}

/// A stretch of constant acceleration.
#[derive(Clone, Debug)]
pub struct Piece {
    /// Value at its start.
    pub start: Option<Quantity>,
    /// Rate at its start.
    pub rate: Option<Quantity>,
    /// Acceleration.
    pub acceleration: Option<Quantity>,
    /// How long it takes (s); to the end of the leg if not said.
    pub duration: Option<f64>,
}

/// Reads `plan`.
pub(crate) fn read(reader: &mut Reader, item: &Item) -> Vec<Leg> {
    match &item.value {
        Value::List(items) => {
            if items.is_empty() {
                reader.fault(item.span, "the plan has no leg", "");
            }
            items.iter().filter_map(|item| leg(reader, item)).collect()
        }
        _ => leg(reader, item).into_iter().collect(),
    }
}

fn leg(reader: &mut Reader, item: &Item) -> Option<Leg> {
    let example =
        "plan = { trigger = \"40 Hz\", duration = \"43.6 s\", arm_angle = { rate = \"5 deg/s\" } }";
    let entries = reader.table(item, example);
    let hertz = Unit::coherent(Dimension::NONE / Dimension::TIME);
    let need = |reader: &mut Reader, key: &str, like: &Unit| match get(entries, key) {
        Some(item) => reader.positive_of(item, key, like),
        None => {
            reader.fault(item.span, format!("the plan has no `{key}`"), format!("as in {example}"));
            None
        }
    };
    let trigger = need(reader, "trigger", &hertz);
    let duration = need(reader, "duration", &Unit::second());
    let start = get(entries, "start")
        .and_then(|item| reader.quantity_of(item, "the start of a plan", &Unit::second()));
    let mut motions = Vec::new();
    for entry in entries {
        if ["trigger", "duration", "start"].contains(&entry.key.as_str()) {
            continue;
        }
        let name =
            Named { text: entry.key.clone(), span: entry.span, place: reader.place(entry.span) };
        let pieces = match &entry.item.value {
            Value::List(items) => items.iter().map(|item| piece(reader, item)).collect(),
            Value::Text(_) => vec![Piece {
                start: reader.quantity(&entry.item),
                rate: None,
                acceleration: None,
                duration: None,
            }],
            _ => vec![piece(reader, &entry.item)],
        };
        motions.push((name, pieces));
    }
    let (trigger, duration) = (trigger?, duration?);
    if trigger * duration > MOST_SAMPLES {
        let message = format!("the plan has more than {MOST_SAMPLES:.0} samples");
        reader.fault(item.span, message, "");
        return None;
    }
    Some(Leg { trigger, duration, start, motions })
}

fn piece(reader: &mut Reader, item: &Item) -> Piece {
    let entries = reader.table(item, "arm_angle = { start = \"0 deg\", rate = \"5 deg/s\" }");
    reader.only(entries, &["start", "rate", "acceleration", "duration"]);
    let quantity =
        |reader: &mut Reader, key| get(entries, key).and_then(|item| reader.quantity(item));
    Piece {
        start: quantity(reader, "start"),
        rate: quantity(reader, "rate"),
        acceleration: quantity(reader, "acceleration"),
        duration: get(entries, "duration")
            .and_then(|item| reader.positive_of(item, "duration", &Unit::second())),
    }
}

/// State of an input from a time on: value, rate, acceleration.
#[derive(Clone, Copy, Debug)]
struct State {
    from: f64,
    value: f64,
    rate: f64,
    acceleration: f64,
}

impl State {
    fn at(&self, time: f64) -> Self {
        let o = time - self.from;
        Self {
            from: time,
            value: self.value + o * (self.rate + 0.5 * o * self.acceleration),
            rate: self.rate + o * self.acceleration,
            acceleration: self.acceleration,
        }
    }
}

/// How an input moves in a planned run.
#[derive(Debug)]
enum Motion {
    Absent,
    Constant(f64),
    /// Its states, in the order of time.
    Moving(Vec<State>),
}

/// A planned run: exact values, rates and accelerations, all readings missing.
#[derive(Debug)]
pub(crate) struct Planned {
    /// Time of the first sample (s).
    begin: f64,
    /// Of each leg: its start after `begin` (s), readings a second, number of its first sample.
    legs: Vec<(f64, f64, usize)>,
    len: usize,
    motions: Vec<Motion>,
    readings: usize,
    /// Line of the run in the campaign's file.
    row: usize,
}

impl Planned {
    /// Reads the plan of a run. `begin` is the time of the first sample (s) where the plan does not
    /// say it.
    pub(crate) fn new(reader: &mut Reader, entry: &RunEntry, model: &Model, begin: f64) -> Self {
        let begin = entry.plan.first().and_then(|leg| leg.start).unwrap_or(begin);
        let mut legs = Vec::with_capacity(entry.plan.len());
        let (mut leg_begin, mut len) = (0.0, 0);
        for leg in &entry.plan {
            legs.push((leg_begin, leg.trigger, len));
            len += (leg.trigger * leg.duration - 1e-9).ceil().max(1.0) as usize;
            leg_begin += leg.duration;
        }
        let mut known: Vec<&str> = model.inputs.iter().map(|input| input.name.as_str()).collect();
        known.extend(["trigger", "duration", "start"]);
        for (name, _) in entry.plan.iter().flat_map(|leg| &leg.motions) {
            if !model.inputs.iter().any(|input| input.name == name.text) {
                reader.unknown(name.span, "input", &name.text, &known);
            }
        }
        let (readings, row) = (column_count(model), entry.name.place.line);
        let mut planned = Self { begin, legs, len, motions: Vec::new(), readings, row };
        for input in &model.inputs {
            let motion = planned.motion(reader, entry, input);
            planned.motions.push(motion);
        }
        planned
    }

    /// Number of samples.
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// Where each input comes from; columns are empty.
    pub(crate) fn tracks(&self) -> Vec<Track> {
        self.motions
            .iter()
            .map(|motion| match motion {
                Motion::Absent => Track::Absent,
                Motion::Constant(value) => Track::Constant(*value),
                Motion::Moving(_) => captured_with_rates(),
            })
            .collect()
    }

    /// Some of the samples; clocks are not filled.
    pub(crate) fn samples(&self, range: Range<usize>) -> Samples {
        let times: Vec<f64> = range.map(|sample| self.run_time(sample)).collect();
        let mut inputs = self.tracks();
        for (track, motion) in inputs.iter_mut().zip(&self.motions) {
            let Motion::Moving(states) = motion else { continue };
            let at: Vec<State> = times.iter().map(|time| state_at(states, *time)).collect();
            *track = Track::Captured {
                value: at.iter().map(|state| state.value).collect(),
                rate: Some(at.iter().map(|state| state.rate).collect()),
                acceleration: Some(at.iter().map(|state| state.acceleration).collect()),
            };
        }
        Samples {
            readings: vec![vec![f64::NAN; times.len()]; self.readings],
            rows: vec![self.row; times.len()],
            time: times.iter().map(|time| time + self.begin).collect(),
            inputs,
            ..Samples::default()
        }
    }

    /// Time of a sample since the first one (s).
    fn run_time(&self, sample: usize) -> f64 {
        let leg = self.legs.partition_point(|(_, _, first)| *first <= sample);
        let leg = self.legs.get(leg.saturating_sub(1));
        leg.map_or(0.0, |(begin, trigger, first)| begin + (sample - first) as f64 / trigger)
    }

    /// The motion of one input over all legs.
    fn motion(&self, reader: &mut Reader, entry: &RunEntry, input: &InputDeclaration) -> Motion {
        let mut states: Vec<State> = Vec::new();
        let mut named = false;
        for (leg, (begin, _, _)) in entry.plan.iter().zip(&self.legs) {
            let motion = leg.motions.iter().find(|(name, _)| name.text == input.name);
            let Some((name, pieces)) = motion else {
                if let Some(last) = states.last() {
                    let goes_on = State { acceleration: 0.0, ..last.at(*begin) };
                    states.push(goes_on);
                }
                continue;
            };
            named = true;
            let mut from = *begin;
            for piece in pieces {
                if let Some(state) = next(reader, input, name.span, piece, from, states.last()) {
                    states.push(state);
                }
                from += piece.duration.unwrap_or((begin + leg.duration - from).max(0.0));
            }
            if from > begin + leg.duration * (1.0 + 1e-9) {
                let message = format!("the motion of `{}` is longer than its leg", name.text);
                reader.fault(name.span, message, "");
            }
        }
        let Some(first) = states.first().copied() else {
            return if named { Motion::Constant(f64::NAN) } else { Motion::Absent };
        };
        let stands = |state: &State| state.rate == 0.0 && state.value == first.value;
        let mut at = (0..self.len).map(|sample| state_at(&states, self.run_time(sample)));
        if !input.signal && at.all(|state| stands(&state)) {
            return Motion::Constant(first.value);
        }
        Motion::Moving(states)
    }
}

/// The state at a time since the run's first sample (s): that of the last piece begun, or the
/// first.
fn state_at(states: &[State], time: f64) -> State {
    let begun = states.partition_point(|state| state.from <= time + 1e-9);
    let still = State { from: time, value: f64::NAN, rate: f64::NAN, acceleration: f64::NAN };
    states.get(begun.saturating_sub(1)).map_or(still, |state| state.at(time))
}

fn next(
    reader: &mut Reader,
    input: &InputDeclaration,
    span: Span,
    piece: &Piece,
    from: f64,
    last: Option<&State>,
) -> Option<State> {
    let before = last.map(|state| state.at(from));
    let mut take = |quantity: &Option<Quantity>, order: u8| {
        let quantity = quantity.as_ref()?;
        let of = ["", "the rate of ", "the acceleration of "][usize::from(order)];
        let like = loader::derived(&input.unit, order);
        reader.accept(quantity, &format!("{of}`{}`", input.name), &like);
        Some(quantity.value)
    };
    let value = take(&piece.start, 0).or(before.map(|state| state.value));
    let rate = take(&piece.rate, 1).or(before.map(|state| state.rate));
    let acceleration = take(&piece.acceleration, 2);
    let Some(value) = value else {
        let message = format!("the plan does not say where `{}` starts", input.name);
        reader.fault(span, message, "write start = \"0 deg\"");
        return None;
    };
    let (rate, acceleration) = (rate.unwrap_or(0.0), acceleration.unwrap_or(0.0));
    Some(State { from, value, rate, acceleration })
}
