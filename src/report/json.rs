//! The keys that programs rely on (`docs/formats.md` section 6); SI units, angles in rad.

use serde_json::{Map, Value, json};

use crate::estimate::calibrate::{Calibration, Estimate};
use crate::estimate::combination::Combination;
use crate::estimate::compare::Comparison;
use crate::estimate::contradicted::{Contradicted, contradicted};
use crate::estimate::delays::Summary;
use crate::estimate::global::p_value;
use crate::estimate::linear_range::{BeyondRange, beyond_range};
use crate::estimate::words::Unobservable;
use crate::graph::Scope;
use crate::report::budget;
use crate::report::sentences::refused;

/// The word for a scope.
pub fn scope_word(scope: Scope) -> &'static str {
    match scope {
        Scope::Rig => "rig",
        Scope::Instrument => "instrument",
        Scope::Setup => "setup",
        Scope::Run => "run",
        Scope::Sample => "sample",
    }
}

/// A finite number, else null.
pub(crate) fn number(value: Option<f64>) -> Value {
    value.filter(|value| value.is_finite()).map_or(Value::Null, |value| json!(value))
}

/// One component of a parameter.
pub(crate) fn estimate(one: &Estimate) -> Value {
    let mut value = json!({
        "name": one.name,
        "scope": scope_word(one.scope),
        "of": one.of,
        "value": number(one.value),
        "sigma": number(one.sigma),
        "unit": one.unit,
        "display_unit": one.declared.symbol,
    });
    if let Some(bound) = one.bound {
        value["bound"] = json!(bound.word());
    }
    value
}

/// The result of `calibrate`.
pub fn calibration(result: &Calibration) -> Value {
    let parameters: Vec<Value> = result.estimates().iter().map(estimate).collect();
    let rms: Map<String, Value> =
        result.rms.iter().map(|(name, value)| (name.clone(), number(Some(*value)))).collect();
    json!({
        "parameters": parameters,
        "fit": {
            "readings": result.readings,
            "unknowns": result.unknowns(),
            "degrees_of_freedom": result.degrees_of_freedom(),
            "chi_squared": number(Some(result.fit.cost)),
            "variance_factor": number(result.variance_factor()),
            "p": number(p_value(result)),
            "iterations": result.fit.iterations,
            "converged": result.fit.outcome.is_result(),
            "remaining": number(Some(result.fit.remaining)),
            "rms": rms,
        },
        "unobservable": unobservable(&result.unobservable),
        "held": held(result)["held"],
        "refused": result.refused.iter().map(refused).collect::<Vec<_>>(),
        "contradicted": stated(&contradicted(result)),
        "beyond_linear_range": beyond(&beyond_range(&result.problem, &result.estimates())),
    })
}

/// The key `beyond_linear_range`.
pub(crate) fn beyond(beyond: &[BeyondRange]) -> Value {
    beyond
        .iter()
        .map(|one| {
            json!({
                "name": one.parameter,
                "of": one.of,
                "value": number(Some(one.value)),
                "linear_range": number(Some(one.range)),
                "simulate_at": number(one.simulate_at),
                "unit": one.unit.si_symbol(),
            })
        })
        .collect()
}

/// Stated values that the readings contradict.
pub(crate) fn stated(list: &[Contradicted]) -> Value {
    list.iter()
        .map(|one| {
            json!({
                "name": one.estimate.name,
                "scope": scope_word(one.estimate.scope),
                "of": one.estimate.of,
                "stated": number(Some(one.stated)),
                "sigma": number(Some(one.sigma)),
                "alone": number(Some(one.alone)),
                "deviations": number(Some(one.deviations)),
                "unit": one.estimate.unit,
            })
        })
        .collect()
}

/// Members of effects that were held.
pub fn held(result: &Calibration) -> Value {
    let each =
        result.held.iter().map(|one| json!({ "name": one.name, "of": one.of, "why": one.why }));
    json!({ "held": each.collect::<Vec<_>>() })
}

/// What cannot be determined.
pub fn unobservable(list: &[Unobservable]) -> Value {
    list.iter()
        .map(|one| {
            let direction: Map<String, Value> =
                one.direction.iter().map(|(name, weight)| (name.clone(), json!(weight))).collect();
            let determined: Vec<Value> = one.determined.iter().map(combination).collect();
            json!({
                "words": one.words,
                "direction": direction,
                "remedy": one.remedy,
                "determined": determined,
            })
        })
        .collect()
}

/// A combination of components, SI.
pub(crate) fn combination(one: &Combination) -> Value {
    let terms: Map<String, Value> =
        one.terms.iter().map(|(name, factor)| (name.clone(), number(Some(*factor)))).collect();
    let names = one.terms.iter().map(|(name, _)| name.clone());
    let factor_units: Map<String, Value> =
        names.zip(one.factor_units.iter().map(|unit| json!(unit))).collect();
    json!({
        "terms": terms,
        "factor_units": factor_units,
        "value": number(Some(one.value)),
        "sigma": number(Some(one.sigma)),
        "unit": one.declared.si_symbol(),
    })
}

/// The result of `delays`.
pub fn delays(measurands: &[Summary]) -> Value {
    let measurands: Map<String, Value> = measurands
        .iter()
        .map(|one| {
            let value = json!({
                "readings": one.readings,
                "solved": one.solved,
                "blind": one.blind,
                "failed": one.failed,
                "mean": number(one.mean),
                "sigma_of_mean": number(one.sigma_of_mean),
                "common_part": number(one.common),
                "random_part": number(one.random),
                "median_expanded_uncertainty": number(one.median_expanded_uncertainty),
                "blind_ranges": budget::blind_json(&one.blind_ranges),
            });
            (one.measurand.clone(), value)
        })
        .collect();
    json!({ "measurands": measurands })
}

/// The result of `compare`.
pub fn comparison(list: &[Comparison]) -> Value {
    let measurands: Map<String, Value> = list
        .iter()
        .map(|one| {
            let value = json!({
                "newton": number(one.newton),
                "newton_sigma": number(one.newton_sigma),
                "batch": number(one.batch),
                "batch_sigma": number(one.batch_sigma),
                "difference": number(one.difference()),
                "normalised": number(one.normalised()),
            });
            (one.measurand.clone(), value)
        })
        .collect();
    json!({ "measurands": measurands })
}
