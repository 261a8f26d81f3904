//! A planned run made into samples without readings.

use std::ops::Range;

use crate::campaign::columns::{self, column_count};
use crate::campaign::declared::RunEntry;
use crate::campaign::loader::{InputSetting, Loader};
use crate::campaign::plan::Piece;
use crate::campaign::record::change::captured_with_rates;
use crate::campaign::record::{BLOCK, Record};
use crate::campaign::recorder::Recorder;
use crate::campaign::samples::Samples;
use crate::campaign::signal::Track;
use crate::diagnostic::Span;
use crate::document::entries::{Quantity, Reader};
use crate::model::{InputDeclaration, Model};

/// The record of a planned run; `None` after a fault.
pub(crate) fn planned(
    model: &Model,
    loader: &mut Loader<'_>,
    entry: &RunEntry,
    begin: f64,
) -> Option<Record> {
    let before = loader.reader.count();
    let plan = Planned::new(&mut loader.reader, entry, model, begin);
    let mut tracks = plan.tracks();
    for (input, track) in model.inputs.iter().zip(&mut tracks) {
        let Some((name, quantity)) = entry.inputs.iter().find(|(name, _)| name.text == input.name)
        else {
            continue;
        };
        if !matches!(track, Track::Absent) {
            loader.reader.fault(
                name.span,
                format!("run `{}` has `{}` twice", entry.name.text, input.name),
                "",
            );
        }
        loader.reader.accept(quantity, &format!("`{}`", input.name), &input.unit);
        *track = Track::Constant(quantity.value);
    }
    for name in missing(&model.inputs, &tracks, &loader.inputs) {
        let message = format!("the plan of run `{}` does not say `{name}`", entry.name.text);
        loader.reader.fault(
            entry.name.span,
            message,
            "add it to the plan, or to `inputs` where it stands still",
        );
    }
    if loader.reader.count() > before {
        return None;
    }
    let mut recorder = Recorder::new(&tracks, column_count(model));
    let mut keep = || {
        for begin in (0..plan.len()).step_by(BLOCK) {
            let samples = plan.samples(begin..plan.len().min(begin + BLOCK));
            recorder.push(loader.store, &samples)?;
        }
        Ok(())
    };
    let kept = keep().and_then(|()| recorder.finish(loader.store));
    kept.map_err(|error| loader.cannot_keep(entry, &error)).ok()
}

/// The inputs of a plan or run whose track is missing although the model needs it.
fn missing<'a>(
    inputs: &'a [InputDeclaration],
    tracks: &[Track],
    settings: &[InputSetting],
) -> Vec<&'a str> {
    inputs
        .iter()
        .zip(tracks)
        .zip(settings)
        .filter(|((_, track), setting)| setting.needed && matches!(track, Track::Absent))
        .map(|((input, _), _)| input.name.as_str())
        .collect()
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
struct Planned {
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
    fn new(reader: &mut Reader, entry: &RunEntry, model: &Model, begin: f64) -> Self {
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
    fn len(&self) -> usize {
        self.len
    }

    /// Where each input comes from; columns are empty.
    fn tracks(&self) -> Vec<Track> {
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
    fn samples(&self, range: Range<usize>) -> Samples {
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
        let like = columns::derived(&input.unit, order);
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
