//! What `plan` of a run says: triggers and motions of a run that is not measured yet.
//!
//! A plan is one leg,
//! `{ trigger = "40 Hz", duration = "43.6 s", arm_angle = { start = "0 deg", rate = "-190 deg/s", acceleration = "0 deg/s^2" } }`,
//! or a list of legs. An input's motion is a table, a text where it stands still, or a list of
//! tables with a `duration` each. Value and rate that a later leg does not say go on as the leg
//! before ended; acceleration is zero unless said. A plan begins at its `start` (a time), else when
//! the run before it in its setup ended.

use crate::document::entries::{Item, Named, Quantity, Reader, Value, get};
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
