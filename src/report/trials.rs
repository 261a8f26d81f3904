//! The score of trials for programs: the keys of `docs/formats.md`, section 6.

use serde_json::{Map, Value, json};

use crate::report::json::number;
use crate::trials::bound::Count;
use crate::trials::tally::mixtures::Mixtures;
use crate::trials::tally::{Cell, Tally};

/// The score.
pub fn json(tally: &Tally, seed: u64) -> Value {
    let noise: Map<String, Value> = tally
        .noise_alarms
        .iter()
        .map(|(name, count)| (name.clone(), with_bound(*count, count.upper())))
        .collect();
    json!({
        "trials": tally.trials,
        "seed": seed,
        "failed": tally.failed,
        "overall": {
            "false_alarms": number(tally.false_alarms.rate()),
            "false_alarms_upper": number(Some(tally.false_alarms.upper())),
            "false_alarms_trials": tally.false_alarms.trials,
            "noise_alarms": noise,
            "brier": number(tally.brier),
            "calibration_error": number(tally.calibration_error),
            "shrinkage_error": number(tally.shrinkage_error),
            "shrinkage_trials": tally.shrinkages,
        },
        "cells": tally.cells.iter().map(cell).collect::<Vec<_>>(),
        "confusion": tally
            .confusion
            .iter()
            .map(|one| json!({ "truth": one.truth, "said": one.said, "trials": one.trials }))
            .collect::<Vec<_>>(),
        "mixtures": tally.mixtures.map(mixtures),
    })
}

/// What was identified in mixtures, each rate with what it exceeds at 95 %.
fn mixtures(score: Mixtures) -> Value {
    let rate = |count: Count| {
        json!({
            "rate": number(count.rate()),
            "lower": number(Some(count.lower())),
            "trials": count.trials,
        })
    };
    json!({
        "effects": rate(score.effects),
        "large_effects": rate(score.large),
        "names_right": rate(score.names),
        "remainder": rate(score.remainder),
        "false_remainder": with_bound(score.false_remainder, score.false_remainder.upper()),
    })
}

fn with_bound(count: Count, upper: f64) -> Value {
    json!({
        "rate": number(count.rate()),
        "upper": number(Some(upper)),
        "trials": count.trials,
    })
}

/// Rates between 0 and 1; beside each what it exceeds at 95 %.
fn cell(cell: &Cell) -> Value {
    let rates = [
        ("detected", cell.detected),
        ("declared", cell.declared),
        ("top1", cell.top1),
        ("top3", cell.top3),
        ("unknown", cell.unknown),
        ("exact", cell.exact),
    ];
    let mut value = json!({
        "kind": cell.kind,
        "own_form": cell.own_form,
        "effect": cell.effect,
        "lambda": number(Some(cell.lambda)),
        "band": cell.band.map(|(from, to)| [from, to]),
        "trials": cell.exact.trials,
    });
    if let Value::Object(map) = &mut value {
        for (name, count) in rates {
            map.insert(name.to_owned(), number(count.rate()));
        }
        let lower = rates.map(|(name, count)| (name.to_owned(), json!(count.lower())));
        map.insert("lower".to_owned(), Value::Object(lower.into_iter().collect()));
    }
    value
}
