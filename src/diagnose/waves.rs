//! Unknown structure of a scale that nobody knows: waves over an angle that are finer than blocks have
//! them, and oscillations in time. Each is a family of blocks that is scanned like those of the library.
//!
//! Without them an encoder's error of order twelve is an oscillation at each rate, and is named as one,
//! and what swings otherwise than in torsion is taken for noise.

use std::sync::Arc;

use crate::effect::Effect;
use crate::graph::MeasurandKind;
use crate::model::Model;
use crate::units::Dimension;

use super::structure::{
    CIRCLE_ORDERS, Covariate, FEW, ORDERS, OSCILLATION, Of, Place, directions, displacement,
    effect, made, turns,
};

/// The finest waves that are looked for, in waves a turn.
const FINEST: usize = 36;

/// The families of a model.
pub(super) fn families(model: &Model, all: &mut Vec<(Arc<Effect>, Place)>) {
    over_signals(model, all);
    over_circles(model, all);
    in_time(model, all);
}

/// Waves finer than so many a turn.
fn finer(angle: &str, orders: usize) -> Covariate {
    let members: Vec<String> = (orders + 1..=FINEST).map(|order| order.to_string()).collect();
    let wave = |wave: &str| (format!("{wave}(unknown_order * {angle})"), Dimension::NONE);
    Covariate {
        name: format!("fine {angle}"),
        terms: vec![wave("cos"), wave("sin")],
        scope: "instrument",
        family: format!("unknown_order = [{}]", members.join(", ")),
    }
}

/// The words for such waves.
fn in_waves(words: &str) -> String {
    format!("{words}, {{member}} waves a turn")
}

/// Displacements of the target over what turns, where few things do: a robot's joints have too many.
fn over_signals(model: &Model, all: &mut Vec<(Arc<Effect>, Place)>) {
    let signals: Vec<_> = model.inputs.iter().filter(|input| input.signal).collect();
    if signals.len() > FEW {
        return;
    }
    for signal in signals.iter().filter(|signal| turns(&signal.unit)) {
        for (channel, direction) in directions(model) {
            let place = Place {
                of: Of::Channel((*channel).to_owned()),
                words: in_waves(&displacement(channel, &signal.name)),
                covariate: signal.name.clone(),
            };
            let patch = |sum: &str| format!("target = 'target + ({sum}) * {direction}'");
            let waves = finer(&signal.name, ORDERS.0);
            all.extend(effect(&place, &waves, Dimension::LENGTH, patch));
        }
    }
}

/// Errors of circles over themselves.
fn over_circles(model: &Model, all: &mut Vec<(Arc<Effect>, Place)>) {
    for circle in &model.measurands {
        if !matches!(circle.kind, MeasurandKind::Angle { .. }) {
            continue;
        }
        let name = &circle.name;
        let place = Place {
            of: Of::Measurand(name.clone()),
            words: in_waves(&format!("an error of `{name}` over {name}")),
            covariate: name.clone(),
        };
        let patch = |sum: &str| format!("{name} = '{name} + {sum}'");
        let waves = finer(name, CIRCLE_ORDERS);
        all.extend(effect(&place, &waves, circle.unit.dimension, patch));
    }
}

/// An oscillation of all readings together, with phases and strengths of each run's own.
fn in_time(model: &Model, all: &mut Vec<(Arc<Effect>, Place)>) {
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
    all.extend(made(
        // Models with other measurands have another family.
        &format!("unknown_oscillation_{}", names.join("_")),
        &place,
        (&coefficients, "run"),
        "unknown_frequency = { unit = \"Hz\", from = \"0.5 Hz\", to = \"10 Hz\" }",
        &patches,
    ));
}
