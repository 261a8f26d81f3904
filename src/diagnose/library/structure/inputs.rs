//! Errors of inputs over themselves, where there are many: what a joint of an arm does wrong is
//! another displacement of its tool in each pose, which no function of one covariate is.

use std::sync::Arc;

use crate::diagnose::library::place::{Of, Place};
use crate::effect::Effect;
use crate::model::Model;

use super::covariate::{FEW, of_itself};
use super::effect;

/// Waves of an error over an input that turns.
const ORDERS: usize = 3;

/// Those of a model.
pub(super) fn errors_of_inputs(model: &Model, all: &mut Vec<(Arc<Effect>, Place)>) {
    if model.inputs.len() <= FEW {
        return;
    }
    for input in &model.inputs {
        let (name, covariate) = (&input.name, of_itself(input, ORDERS));
        let words = format!("an error of the input `{name}` over {}", covariate.words);
        let place = Place::new(Of::Channel(format!("input {name}")), &covariate.over, words);
        let patch = |sum: &str| format!("{name} = '{name} + {sum}'");
        all.extend(effect(&place, &covariate, input.unit.dimension, patch));
    }
}
