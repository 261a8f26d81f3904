//! Unknown structure of a scale that nobody knows: waves of one order over an angle, waves over a
//! length or a count, swings over a setup, as a room's climate makes them, and exponential
//! settling after each run begins. Each is a family of blocks that is scanned like those of the library.
//!
//! Without them an encoder's error of order twelve is an oscillation at each rate, and is named as
//! one, what swings otherwise than in torsion is taken for noise, and what swings slowly for noise
//! with a memory or a walk.

use std::f64::consts::TAU;
use std::ops::RangeInclusive;

use crate::graph::MeasurandKind;
use crate::model::{InputDeclaration, MeasurandDeclaration, Model};
use crate::units::Dimension;

use super::covariate::{Covariate, FEW, RUN_TIME, Term, few_move, sense_of, wave};
use super::spread::Spread;
use super::{ORDERS, directions};
use crate::diagnose::library::place::TIME;

/// The finest waves that are looked for, in waves a turn: those of an encoder or a motor, and those of
/// the teeth of a worm or a strain wave gear.
const FINEST: usize = 36;
const FINEST_OF_TEETH: usize = 400;
/// Waves a turn of what turns at another rate: a shaft of a gearbox, a belt.
const ANY: (&str, &str) = ("0.02", "12");
/// Turns that an angle goes through at least for such waves.
const MANY_TURNS: f64 = 3.0;
/// Waves a metre over a length of some metres; longer ones over one that is at least `LONG` (m), and finer
/// ones up to so many over the whole of it.
const WAVES_A_METRE: (f64, f64) = (0.2, 200.0);
const LONG: f64 = 10.0;
const FEWEST: f64 = 1.5;
const MOST_WAVES: f64 = 1000.0;
/// Counts that an input goes through at least for waves over them.
const MANY_COUNTS: f64 = 100.0;
/// Angles, or lengths, over which waves of readings are looked for, at most.
const MOST_OVER: usize = 4;
/// What is unknown of waves a turn, and what a member is. No model names its quantities so.
const ORDER: &str = "unknown_order";
const A_TURN: &str = "{member} waves a turn";

/// A family over something: how it is called there, what a member is, its line and its terms.
fn family(
    (how, over): (&str, &str),
    member: &str,
    line: String,
    terms: impl IntoIterator<Item = Term>,
) -> Covariate {
    Covariate {
        over: over.to_owned(),
        words: format!("{over}, {member}"),
        family: line,
        ..Covariate::new(format!("{how} {over}"), terms)
    }
}

/// The line of a family from one member to another.
pub(super) fn range(name: &str, unit: &str, (from, to): (&str, &str)) -> String {
    format!("{name} = {{ unit = \"{unit}\", from = \"{from}\", to = \"{to}\" }}")
}

fn orders_of(how: &str, angle: &str, orders: impl Iterator<Item = f64>) -> Covariate {
    let members: Vec<String> = orders.map(|order| order.to_string()).collect();
    let line = format!("{ORDER} = [{}]", members.join(", "));
    family((how, angle), A_TURN, line, wave(&format!("{ORDER} * {angle}")))
}

fn whole(orders: RangeInclusive<usize>) -> impl Iterator<Item = f64> {
    orders.map(|order| order as f64)
}

/// Orders over what moves, the most probable first: of those that the readings do not tell apart the first
/// is named. At even places the waves of blocks are some of the finer ones, and over less than two turns
/// one that comes once a turn is nearly one of half an order.
fn whole_and_half() -> impl Iterator<Item = f64> {
    let halves = (0..ORDERS.0).map(|order| order as f64 + 0.5);
    whole(1..=ORDERS.0).chain(halves).chain(whole(ORDERS.0 + 1..=FINEST))
}

/// Waves over an angle, the long ones first: at even places each of them is some of the finer ones.
pub(super) fn over_circle(angle: &str) -> Covariate {
    orders_of("fine", angle, whole(1..=FINEST))
}

fn over_length(length: &str) -> Covariate {
    waves_a_metre("fine", length, WAVES_A_METRE)
}

fn waves_a_metre(how: &str, length: &str, (from, to): (f64, f64)) -> Covariate {
    let number = "unknown_waves";
    let line = range(number, "1/m", (&format!("{from} 1/m"), &format!("{to} 1/m")));
    let terms = wave(&format!("2 * pi * {number} * {length}"));
    family((how, length), "{member} waves a metre", line, terms)
}

fn is_length(input: &InputDeclaration) -> bool {
    input.unit.dimension == Dimension::LENGTH
}

/// Waves over what moves, where few things do: a robot's joints are too many. Over what turns each is
/// one of those that blocks have together, finer, or between them (a gear or a belt turns at another rate
/// than what it drives), over a length they are those of a screw, of a rack or of the bend of a rail.
pub(super) fn over_signals(model: &Model) -> Vec<Covariate> {
    if !few_move(model) {
        return Vec::new();
    }
    // A screw has its pitch whether or not what is commanded is a signal.
    let are_few = model.inputs.iter().filter(|input| is_length(input)).count() <= FEW;
    let signals = model.inputs.iter().filter(|input| input.signal || are_few && is_length(input));
    let over = |input: &InputDeclaration| {
        if input.unit.is_angle() {
            Some(orders_of("fine", &input.name, whole_and_half()))
        } else {
            is_length(input).then(|| over_length(&input.name))
        }
    };
    signals.filter_map(over).collect()
}

/// Waves of a reading over inputs where a model has no target that such waves could displace. Over
/// lengths they are those of a screw, whether or not what is commanded is a signal; over angles those of
/// an eccentric disc, of the poles of a motor, of a gear, of a worm.
pub(super) fn over_inputs(model: &Model) -> Vec<Covariate> {
    let lengths = over_few(model, is_length, |one| Some(over_length(&one.name)));
    let of_teeth = |one: &InputDeclaration| {
        Some(orders_of("teeth of", &one.name, whole(FINEST + 1..=FINEST_OF_TEETH)))
    };
    let fine = |one: &InputDeclaration| Some(orders_of("fine", &one.name, whole_and_half()));
    let is_angle = |one: &InputDeclaration| one.unit.is_angle();
    let angles = over_few(model, is_angle, fine).into_iter();
    let teeth = over_few(model, is_angle, of_teeth);
    lengths.into_iter().chain(angles.zip(teeth).flat_map(|(fine, teeth)| [fine, teeth])).collect()
}

/// Families over inputs of a kind where these are few, in models without a target that they could displace.
fn over_few(
    model: &Model,
    is_own: impl Fn(&InputDeclaration) -> bool,
    over: impl Fn(&InputDeclaration) -> Option<Covariate>,
) -> Vec<Covariate> {
    let own: Vec<&InputDeclaration> = model.inputs.iter().filter(|one| is_own(one)).collect();
    let are_few = directions(model).is_empty() && own.len() <= MOST_OVER;
    own.into_iter().filter(|_| are_few).filter_map(over).collect()
}

/// Waves of any order of a reading over angles that go through many turns, in models without a target:
/// those of another shaft of a gearbox, or of a belt. Over what may be read modulo one turn each run
/// begins in a turn that is not known: its waves have phases of their own.
pub(super) fn of_any_order(model: &Model, spreads: &[Spread]) -> Vec<Covariate> {
    let turns = |input: &InputDeclaration| {
        let is_own = |one: &Spread| one.input == input.name && one.span >= MANY_TURNS * TAU;
        // Only of a signal the turns are counted on where it is read modulo one.
        let is_counted = input.signal || input.period.is_none();
        input.unit.is_angle() && is_counted && spreads.iter().any(is_own)
    };
    let over = |input: &InputDeclaration| {
        let terms = wave(&format!("{ORDER} * {}", input.name));
        let waves = family(("any order", &input.name), A_TURN, range(ORDER, "1", ANY), terms);
        Some(if input.period.is_some() { waves.per("run") } else { waves })
    };
    over_few(model, turns, over)
}

/// Waves of a reading over inputs that go over a long way, or over a short one: those of a rail that bends,
/// or of the teeth of a belt, the pitch of a fine screw, the graduation of a scale.
pub(super) fn of_any_length(model: &Model, spreads: &[Spread]) -> Vec<Covariate> {
    let (from, to) = WAVES_A_METRE;
    let over = |input: &InputDeclaration| {
        let span = spreads.iter().find(|one| one.input == input.name)?.span;
        if span >= LONG {
            return Some(waves_a_metre("long", &input.name, (FEWEST / span, from)));
        }
        // From the longest on: at even stops each of them is some of the finer ones.
        let finest = MOST_WAVES / span;
        (finest > to).then(|| waves_a_metre("finest", &input.name, (from, finest)))
    };
    over_few(model, is_length, over)
}

/// Waves of a reading over inputs that count: steps of a motor, lines of an encoder on a belt or a screw.
pub(super) fn over_counts(model: &Model, spreads: &[Spread]) -> Vec<Covariate> {
    let is_count = |input: &InputDeclaration| {
        let unit = &input.unit;
        unit.dimension == Dimension::NONE && !unit.is_angle() && unit.factor == 1.0
    };
    let over = |input: &InputDeclaration| {
        let span = spreads.iter().find(|one| one.input == input.name)?.span;
        let period = "unknown_count";
        let terms = wave(&format!("2 * pi * {} / {period}", input.name));
        let ends = [span / MOST_WAVES, span / FEWEST].map(|end| end.to_string());
        let line = range(period, "1", (&ends[0], &ends[1]));
        let words = "a wave every {member}";
        (span >= MANY_COUNTS).then(|| family(("waves over", &input.name), words, line, terms))
    };
    over_few(model, is_count, over)
}

/// Waves of a reading over itself, each by itself: over a shaft that is counted on over turns, and over
/// a length where a model has no target. A scale, a rack and a phase meter err so, each drive of a
/// machine with several by itself.
pub(super) fn over_itself(model: &Model, measurand: &MeasurandDeclaration) -> Option<Covariate> {
    let name = measurand.name.as_str();
    if measurand.kind == MeasurandKind::Plain && measurand.unit.is_angle() {
        return Some(over_circle(name));
    }
    let is_length = measurand.unit.dimension == Dimension::LENGTH;
    (is_length && directions(model).is_empty()).then(|| over_length(name))
}

/// Waves over a setup: from those that a run just sees to an hour, and from there to a month, as day
/// and night and the tides make them.
pub(super) fn slow() -> [Covariate; 2] {
    let period = "unknown_period";
    [("slow", ("10 s", "1 h")), ("slowest", ("1 h", "720 h"))].map(|(how, ends)| {
        let terms = wave(&format!("2 * pi * setup_time / {period}"));
        let line = range(period, "s", ends);
        family((how, TIME), "a wave every {member} s", line, terms).per("setup")
    })
}

/// Exponential settling after each run begins, in the same way or by the sense in which a signal moves,
/// where few do: a servo, a bearing, what was touched to start it.
pub(super) fn settling(model: &Model) -> Covariate {
    let time = "unknown_time";
    let rest = (format!("exp(-(run_time / {time}))"), Dimension::NONE);
    let signals = model.inputs.iter().filter(|input| input.signal && few_move(model));
    let by_sense = signals.map(|signal| {
        let (sense, of) = sense_of(&signal.name);
        (format!("{sense} * {}", rest.0), of)
    });
    let terms = std::iter::once(rest.clone()).chain(by_sense);
    let line = range(time, "s", ("0.2 s", "100 s"));
    family(("rest in", RUN_TIME), "exponential settling in {member} s", line, terms)
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use super::*;
    use crate::diagnostic::Source;

    #[test]
    fn waves_over_counts_are_those_of_what_counts() {
        let inputs = "inputs.lines = { unit = \"count\" }\ninputs.load = { unit = \"%\" }\ninputs.turns = { unit = \"rad\" }\n";
        let read = "measurands.read = { value = '1e-3 * lines', unit = \"1\" }\n";
        let text = format!("name = \"belt\"\ntitle = \"Belt\"\n{inputs}{read}");
        let model = Model::parse(Source::new("belt.toml", text)).unwrap();
        let waves = |span: f64| {
            let all = ["lines", "load", "turns"];
            let spreads = all.map(|name| Spread::of_knots(name.to_owned(), Vec::new(), span));
            over_counts(&model, &spreads)
        };
        let found = waves(3e4);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].words, "lines, a wave every {member}");
        assert!(found[0].family.contains("from = \"30\", to = \"20000\""));
        assert!(waves(12.0).is_empty());
    }

    /// Over a rail of 60 m waves may be longer, over 0.2 mm of a scale shorter than those over a metre or two.
    #[test]
    fn long_ways_have_longer_waves_and_short_ones_shorter() {
        let inputs = "inputs.place = { unit = \"m\" }\n";
        let read = "measurands.read = { value = 'place', unit = \"m\" }\n";
        let text = format!("name = \"axis\"\ntitle = \"Axis\"\n{inputs}{read}");
        let model = Model::parse(Source::new("axis.toml", text)).unwrap();
        let waves = |span: f64| -> Vec<String> {
            let spread = Spread::of_knots("place".to_owned(), Vec::new(), span);
            of_any_length(&model, &[spread]).into_iter().map(|one| one.family).collect()
        };
        assert!(waves(60.0).concat().contains("from = \"0.025 1/m\", to = \"0.2 1/m\""));
        assert!(waves(2e-4).concat().contains("from = \"0.2 1/m\", to = \"5000000 1/m\""));
        assert_eq!(
            waves(0.8),
            ["unknown_waves = { unit = \"1/m\", from = \"0.2 1/m\", to = \"1250 1/m\" }"]
        );
        assert!(waves(7.0).is_empty());
    }
}
