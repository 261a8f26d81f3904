//! Unknown structure of a scale that nobody knows: waves over an angle that are finer than blocks have
//! them, and oscillations in time. Each is a family of blocks that is scanned like those of the library.
//!
//! Without them an encoder's error of order twelve is an oscillation at each rate, and is named as one,
//! and what swings otherwise than in torsion is taken for noise.

use std::sync::Arc;

use crate::effect::Effect;
use crate::graph::MeasurandKind;
use crate::model::Model;

use super::structure::{Covariate, FEW, ORDERS, OSCILLATION, Of, Place, made, turns};

/// The finest waves that are looked for, in waves a turn.
const FINEST: usize = 36;

/// Waves finer than so many a turn.
pub(super) fn finer(angle: &str, orders: usize) -> Covariate {
    let members: Vec<String> = (orders + 1..=FINEST).map(|order| order.to_string()).collect();
    // No model names its quantities so.
    let order = "unknown_order";
    Covariate::family(angle, order, format!("{order} = [{}]", members.join(", ")))
}

/// Waves over what turns, where few things do: a robot's joints are too many.
pub(super) fn over_signals(model: &Model) -> Vec<Covariate> {
    let signals: Vec<_> = model.inputs.iter().filter(|input| input.signal).collect();
    if signals.len() > FEW {
        return Vec::new();
    }
    let angles = signals.iter().filter(|signal| turns(&signal.unit));
    angles.map(|signal| finer(&signal.name, ORDERS.0)).collect()
}

/// An oscillation of all readings together, with phases and strengths of each run's own.
pub(super) fn in_time(model: &Model) -> Option<(Arc<Effect>, Place)> {
    let (mut coefficients, mut patches, mut names) = (Vec::new(), String::new(), Vec::new());
    let numbers =
        model.measurands.iter().filter(|measurand| measurand.kind != MeasurandKind::Rotation);
    for (number, measurand) in numbers.enumerate() {
        let name = measurand.name.as_str();
        names.push(name);
        let [cosine, sine] = ["cosine", "sine"].map(|wave| format!("unknown_{wave}_{number}"));
        patches.push_str(&format!(
            "{name} = '{name} + {cosine} * cos(2 * pi * unknown_frequency * run_time) + {sine} * sin(2 * pi * unknown_frequency * run_time)'\n"
        ));
        coefficients.extend([cosine, sine].map(|one| (one, measurand.unit.dimension)));
    }
    let place = Place {
        of: Of::Channel("all readings".to_owned()),
        words: "an oscillation of the readings at {member} Hz".to_owned(),
        covariate: OSCILLATION.to_owned(),
    };
    made(
        // Models with other measurands have another family.
        &format!("unknown_oscillation_{}", names.join("_")),
        &place,
        (&coefficients, "run"),
        "unknown_frequency = { unit = \"Hz\", from = \"0.5 Hz\", to = \"10 Hz\" }",
        &patches,
    )
}
