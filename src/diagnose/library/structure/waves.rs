//! Unknown structure of a scale that nobody knows: waves over an angle that are finer than blocks
//! have them, waves over a length, oscillations in time, swings over a setup, as a room's climate
//! makes them, and exponential settling after each run begins. Each is a family of blocks that is
//! scanned like those of the library.
//!
//! Without them an encoder's error of order twelve is an oscillation at each rate, and is named as
//! one, what swings otherwise than in torsion is taken for noise, and what swings slowly for noise
//! with a memory or a walk.

use crate::graph::MeasurandKind;
use crate::model::{InputDeclaration, MeasurandDeclaration, Model};
use crate::units::{Dimension, Unit};

use super::covariate::{Covariate, FEW, RUN_TIME, few_move, sense_of, wave};
use super::made::{Block, made};
use super::{ORDERS, Spread, directions, orders};
use crate::diagnose::library::place::{ALL_READINGS, OSCILLATION, Of, Place, TIME};

/// The finest waves that are looked for, in waves a turn: those of an encoder or a motor, and those of
/// the teeth of a worm or a strain wave gear.
const FINEST: usize = 36;
const FINEST_OF_TEETH: usize = 400;
/// Waves a turn of what turns at another rate: a shaft of a gearbox, a belt.
const ANY: (f64, f64) = (0.02, 12.0);
/// Turns that an angle goes through at least for such waves.
const MANY_TURNS: f64 = 3.0;
/// Angles, or lengths, over which waves of readings are looked for, at most.
const MOST_OVER: usize = 4;

/// Waves over the reading of a circle, finer than so many a turn.
pub(super) fn over_circle(angle: &str, orders: usize) -> Covariate {
    orders_of("fine", angle, finer(orders))
}

fn finer(orders: usize) -> impl Iterator<Item = f64> {
    (orders + 1..=FINEST).map(|order| order as f64)
}

fn halves() -> impl Iterator<Item = f64> {
    (0..ORDERS.0).map(|order| order as f64 + 0.5)
}

fn orders_of(how: &str, angle: &str, orders: impl Iterator<Item = f64>) -> Covariate {
    let members: Vec<String> = orders.map(|order| order.to_string()).collect();
    // No model names its quantities so.
    let order = "unknown_order";
    Covariate {
        over: angle.to_owned(),
        words: format!("{angle}, {{member}} waves a turn"),
        family: format!("{order} = [{}]", members.join(", ")),
        ..Covariate::new(format!("{how} {angle}"), wave(&format!("{order} * {angle}")))
    }
}

/// Waves over what moves, where few things do: a robot's joints are too many. Over what turns they
/// are finer than blocks have them or between theirs (a gear or a belt turns at another rate than
/// what it drives), over a length they are those of a screw, of a rack or of the bend of a rail.
pub(super) fn over_signals(model: &Model) -> Vec<Covariate> {
    if !few_move(model) {
        return Vec::new();
    }
    // A screw has its pitch whether or not what is commanded is a signal.
    let is_length = |input: &&InputDeclaration| input.unit.dimension == Dimension::LENGTH;
    let are_few = model.inputs.iter().filter(is_length).count() <= FEW;
    let signals = model.inputs.iter().filter(|input| input.signal || are_few && is_length(input));
    let over = |input: &InputDeclaration| {
        if input.unit.is_angle() {
            Some(orders_of("fine", &input.name, halves().chain(finer(ORDERS.0))))
        } else {
            (input.unit.dimension == Dimension::LENGTH).then(|| over_length(&input.name))
        }
    };
    signals.filter_map(over).collect()
}

/// Waves of a reading over lengths where a model has no target that such waves could displace: those
/// of a screw, whether or not what is commanded is a signal.
pub(super) fn over_lengths(model: &Model) -> impl Iterator<Item = Covariate> {
    let is_length = |input: &&InputDeclaration| input.unit.dimension == Dimension::LENGTH;
    let is_wanted =
        directions(model).is_empty() && model.inputs.iter().filter(is_length).count() <= MOST_OVER;
    let lengths = model.inputs.iter().filter(move |input| is_wanted && is_length(input));
    lengths.map(|input| over_length(&input.name))
}

/// Waves of a reading over angles, finer than blocks have them or between theirs, where a model has no
/// target that such waves could displace: those of the poles of a motor, of a gear, of a worm.
pub(super) fn over_angles(model: &Model) -> impl Iterator<Item = Covariate> {
    let is_angle = |input: &&InputDeclaration| input.unit.is_angle();
    let is_wanted =
        directions(model).is_empty() && model.inputs.iter().filter(is_angle).count() <= MOST_OVER;
    let angles = model.inputs.iter().filter(move |input| is_wanted && is_angle(input));
    angles.flat_map(|input| {
        let fine = halves().chain(finer(orders(model)));
        let of_teeth = (FINEST + 1..=FINEST_OF_TEETH).map(|order| order as f64);
        [orders_of("fine", &input.name, fine), orders_of("teeth of", &input.name, of_teeth)]
    })
}

/// Waves of any order of a reading over angles that go through many turns, in models without a target:
/// those of another shaft of a gearbox, or of a belt. Over what may be read modulo one turn each run
/// begins in a turn that is not known: its waves have phases of their own.
pub(super) fn of_any_order(model: &Model, spreads: &[Spread]) -> Vec<Covariate> {
    let turns = |input: &&InputDeclaration| {
        let is_own = |one: &&Spread| one.input == input.name && one.turns >= MANY_TURNS;
        spreads.iter().any(|one| is_own(&one))
    };
    let over = |input: &InputDeclaration| {
        let waves = any_order_over(&input.name);
        if input.period.is_some() { waves.per("run") } else { waves }
    };
    let angles: Vec<Covariate> = model.inputs.iter().filter(turns).map(over).collect();
    if directions(model).is_empty() && angles.len() <= MOST_OVER { angles } else { Vec::new() }
}

fn any_order_over(angle: &str) -> Covariate {
    let order = "unknown_order";
    Covariate {
        over: angle.to_owned(),
        words: format!("{angle}, {{member}} waves a turn"),
        family: format!("{order} = {{ unit = \"1\", from = {}, to = {} }}", ANY.0, ANY.1),
        ..Covariate::new(format!("any order {angle}"), wave(&format!("{order} * {angle}")))
    }
}

/// Waves of an error of an angle over itself, finer than so many a turn; none over anything else.
pub(super) fn over_input(input: &InputDeclaration, orders: usize) -> Option<Covariate> {
    input.unit.is_angle().then(|| orders_of("fine", &input.name, finer(orders)))
}

/// Waves of a reading over itself, each by itself: over a shaft that is counted on over turns, and over
/// a length where a model has no target. A scale, a rack and a phase meter err so, each drive of a
/// machine with several by itself.
pub(super) fn over_itself(model: &Model, measurand: &MeasurandDeclaration) -> Option<Covariate> {
    let name = measurand.name.as_str();
    if measurand.kind == MeasurandKind::Plain && measurand.unit.is_angle() {
        return Some(over_circle(name, 0));
    }
    let is_length = measurand.unit.dimension == Dimension::LENGTH;
    (is_length && directions(model).is_empty()).then(|| over_length(name))
}

fn over_length(length: &str) -> Covariate {
    let number = "unknown_waves";
    Covariate {
        over: length.to_owned(),
        words: format!("{length}, {{member}} waves a metre"),
        family: format!("{number} = {{ unit = \"1/m\", from = \"0.2 1/m\", to = \"200 1/m\" }}"),
        ..Covariate::new(format!("fine {length}"), wave(&format!("2 * pi * {number} * {length}")))
    }
}

/// Waves over a setup: from those that a run just sees to an hour, and from there to a month, as day
/// and night and the tides make them.
pub(super) fn slow() -> [Covariate; 2] {
    let period = "unknown_period";
    [("slow", "10 s", "1 h"), ("slowest", "1 h", "720 h")].map(|(how, from, to)| {
        let terms = wave(&format!("2 * pi * setup_time / {period}"));
        Covariate {
            over: TIME.to_owned(),
            words: format!("{TIME}, a wave every {{member}} s"),
            family: format!("{period} = {{ unit = \"s\", from = \"{from}\", to = \"{to}\" }}"),
            ..Covariate::new(format!("{how} {TIME}"), terms).per("setup")
        }
    })
}

/// Exponential settling after each run begins, in the same way or by the sense in which a signal moves,
/// where few do: a servo, a bearing, what was touched to start it.
pub(super) fn settling(model: &Model) -> Covariate {
    let time = "unknown_time";
    let rest = format!("exp(-(run_time / {time}))");
    let signals = model.inputs.iter().filter(|input| input.signal && few_move(model));
    let by_sense = signals.map(|signal| {
        let (sense, of) = sense_of(&signal.name);
        (format!("{sense} * {rest}"), of)
    });
    let terms = std::iter::once((rest.clone(), Dimension::NONE)).chain(by_sense);
    Covariate {
        over: RUN_TIME.to_owned(),
        words: format!("{RUN_TIME}, exponential settling in {{member}} s"),
        family: format!("{time} = {{ unit = \"s\", from = \"0.2 s\", to = \"100 s\" }}"),
        ..Covariate::new(format!("rest in {RUN_TIME}"), terms)
    }
}

/// An oscillation of all readings together, with phases and strengths of each run's own, from where
/// slow waves end.
pub(super) fn in_time(model: &Model) -> Vec<Block> {
    let all = &model.measurands;
    let (of, what) = match all.as_slice() {
        [one] => (Of::Measurand(one.name.clone()), format!("`{}`", one.name)),
        _ => (Of::Channel(ALL_READINGS.to_owned()), "the readings".to_owned()),
    };
    let place = Place::new(of, OSCILLATION, format!("an oscillation of {what} at {{member}} Hz"));
    // Models with other measurands have another family.
    let names: Vec<&str> = all.iter().map(|one| one.name.as_str()).collect();
    oscillation(&names.join("_"), &place, all).into_iter().collect()
}

/// What a wave along each axis is multiplied by.
const AXES: &[&str] = &[" * [1, 0, 0]", " * [0, 1, 0]", " * [0, 0, 1]"];

fn oscillation(name: &str, place: &Place, of: &[MeasurandDeclaration]) -> Option<Block> {
    let (mut coefficients, mut patches) = (Vec::new(), String::new());
    for (number, measurand) in of.iter().enumerate() {
        let name = measurand.name.as_str();
        let axes = if measurand.kind == MeasurandKind::Rotation { AXES } else { &[""] };
        let mut wave = Vec::new();
        for (axis, along) in axes.iter().enumerate() {
            for phase in ["cos", "sin"] {
                let coefficient = format!("unknown_{phase}_{number}_{axis}");
                wave.push(format!(
                    "{coefficient} * {phase}(2 * pi * unknown_frequency * run_time){along}"
                ));
                coefficients.push((coefficient, Unit::coherent(measurand.unit.dimension)));
            }
        }
        let sum = wave.join(" + ");
        patches.push_str(&match measurand.kind {
            MeasurandKind::Rotation => format!("{name} = '{name} * turn({sum})'\n"),
            _ => format!("{name} = '{name} + {sum}'\n"),
        });
    }
    made(
        &format!("unknown_oscillation_{name}"),
        place,
        (&coefficients, "run"),
        "unknown_frequency = { unit = \"Hz\", from = \"0.1 Hz\", to = \"10 Hz\" }",
        &patches,
    )
}
