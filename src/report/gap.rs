//! How far the gap closes, for programs: rms of each measurand before and after, and what held-out
//! readings bear out.

use serde_json::{Map, Value, json};

use crate::diagnose::gap::Gap;
use crate::report::json::number;

fn by_measurand(list: &[(String, f64)]) -> Map<String, Value> {
    list.iter().map(|(name, value)| (name.clone(), number(Some(*value)))).collect()
}

/// The gap before and after.
pub(crate) fn gap(one: &Gap) -> Value {
    json!({
        "held_out": one.held_out,
        "before": by_measurand(&one.before),
        "after": by_measurand(&one.after),
        "floor": by_measurand(&one.floor),
        "steps": one.steps.iter().map(|step| json!({
            "effect": step.effect,
            "rms": by_measurand(&step.rms),
            "held_out_drop": number(Some(step.held_out_drop)),
        })).collect::<Vec<_>>(),
        "noncentrality": number(Some(one.lambda)),
        "held_out_drop": number(Some(one.held_out_drop)),
        "leftover": number(Some(one.leftover)),
        "closed": one.closed,
        "closed_interval": one.closed_interval,
        "borne_out": one.is_borne_out(),
        "folds": one.folds,
        "left_out": one.left_out,
    })
}
