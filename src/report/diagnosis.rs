//! The result of `diagnose` for programs: the keys of `docs/formats.md`, section 6.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use crate::diagnose::Diagnosis;
use crate::diagnose::budget::answer::{Doubtful, Ranked, Remainder, Row, Size, StepChange};
use crate::diagnose::budget::stamp_jumps::Side;
use crate::diagnose::found::{NoReading, NoiseEffect, Wrong};
use crate::diagnose::library::place::Of;
use crate::diagnose::library::variant::Variant;
use crate::report::gap::gap;
use crate::report::json::{beyond, calibration, estimate, number, stated, unobservable};
use crate::report::noise::process_json;

/// The result of `diagnose`, at most `top` candidates.
pub fn json(diagnosis: &Diagnosis, top: Option<usize>) -> Value {
    let candidates = diagnosis.candidates.iter().take(top.unwrap_or(usize::MAX));
    let noise = diagnosis.noise.iter().map(noise_effect);
    let effects = diagnosis.rows.iter().map(row);
    json!({
        "verdict": diagnosis.verdict.word(),
        "effects": effects.chain(noise).collect::<Vec<_>>(),
        "where": diagnosis.remainder.iter().map(remainder).collect::<Vec<_>>(),
        "doubtful": diagnosis.doubtful.iter().map(doubtful).collect::<Vec<_>>(),
        "candidates": candidates.map(candidate).collect::<Vec<_>>(),
        "causes": diagnosis.causes.map(|[nothing, library, unknown]| json!({
            "nothing": number(Some(nothing)),
            "library": number(Some(library)),
            "unmodelled": number(Some(unknown)),
        })),
        "nearest": diagnosis.nearest().map(candidate),
        "absorbed": diagnosis.absorbed.iter()
            .map(|one| json!({ "name": one.name, "acts_as": one.acts_as }))
            .collect::<Vec<_>>(),
        "not_testable": diagnosis.not_testable.iter()
            .map(|one| json!({ "name": one.name, "why": one.why }))
            .collect::<Vec<_>>(),
        "gap": diagnosis.gap.as_ref().map(gap),
        "noise_scale": diagnosis.levels.iter().map(|one| {
            json!({
                "measurand": one.measurand,
                "of": one.of,
                "run": one.run,
                "factor": number(Some(one.factor)),
            })
        }).collect::<Vec<_>>(),
        "autocorrelation": autocorrelation(diagnosis),
        "left_out": left_out(diagnosis),
        "contradicted": stated(&diagnosis.contradicted),
        "set_free": diagnosis.set_free,
        "beyond_linear_range": beyond(&diagnosis.beyond_range),
        "search": diagnosis.log,
        "fit": calibration(&diagnosis.nominal)["fit"],
        "unobservable": unobservable(&diagnosis.nominal.unobservable),
    })
}

/// One row a candidate, best first.
pub fn table(diagnosis: &Diagnosis) -> String {
    let mut text = String::from("name,ln_bayes_factor,noncentrality,share\n");
    for one in &diagnosis.candidates {
        text.push_str(&format!(
            "{},{:.6e},{:.6e},{:.6e}\n",
            one.name,
            one.ln_bayes,
            one.gain.noncentrality(),
            one.share
        ));
    }
    text
}

fn row(one: &Row) -> Value {
    let confounded = one.confounded.iter();
    json!({
        "name": one.name,
        "member": member(&one.member),
        "variant": one.variant.map(Variant::word),
        "member_sigma": member(&one.member_sigma),
        "posterior": number(Some(one.posterior)),
        "ln_bayes_factor": number(Some(one.ln_bayes)),
        "noncentrality": number(Some(one.gain.noncentrality())),
        "closes": number(Some(one.closes)),
        "alone": number(Some(one.alone)),
        "predictive_gain": number(Some(one.predictive_gain)),
        "aliases": one.aliases,
        "unmodelled_alias": one.unmodelled_alias,
        "confounded": confounded
            .map(|other| json!({
                "with": other.name,
                "is_row": other.is_row,
                "correlation": number(Some(other.correlation)),
                "factor": number(other.factor),
                "joint": other.joint.iter().map(|(size, sigma)| json!({
                    "parameter": size.parameter,
                    "component": size.component,
                    "of": size.of,
                    "value": number(Some(size.value)),
                    "sigma": number(Some(*sigma)),
                    "unit": size.unit.si_symbol(),
                })).collect::<Vec<_>>(),
            }))
            .collect::<Vec<_>>(),
        "well_determined": one.well_determined.as_ref().map(|found| json!({
            "terms": found.terms.iter().map(|(factor, size)| json!({
                "factor": number(Some(*factor)),
                "parameter": size.parameter,
                "component": size.component,
                "of": size.of,
                "unit": size.unit.si_symbol(),
            })).collect::<Vec<_>>(),
            "value": number(Some(found.value)),
            "sigma": number(Some(found.sigma)),
        })),
        "stamp_jumps": one.stamp_jumps.iter().map(|jump| json!({
            "run": jump.run,
            "row": jump.row,
            "size": number(Some(jump.size)),
            "right": jump.right.map(Side::word),
        })).collect::<Vec<_>>(),
        "ratio_to_typical": number(one.ratio_to_typical),
        "parameters": one.values.iter().map(estimate).collect::<Vec<_>>(),
    })
}

fn noise_effect(one: &NoiseEffect) -> Value {
    json!({
        "name": one.name,
        "acts_on": "noise",
        "parameters": [{
            "name": one.parameter,
            "scope": "sample",
            "of": null,
            "value": number(Some(one.value)),
            "sigma": number(Some(one.sigma)),
            "unit": one.unit.si_symbol(),
        }],
        "ln_p": number(Some(one.ln_p)),
    })
}

fn step_change(step: &StepChange) -> Value {
    json!({ "value": number(Some(step.value)), "sigma": number(Some(step.sigma)) })
}

fn remainder(one: &Remainder) -> Value {
    let (key, of) = match &one.place.of {
        Of::Measurand(name) => ("measurand", name),
        Of::Channel(name) => ("channel", name),
    };
    json!({
        key: of,
        "covariate": one.place.covariate,
        "share": number(Some(one.share)),
        "noncentrality": number(Some(one.gain.noncentrality())),
        "rms": number(one.rms.as_ref().map(|(rms, _)| *rms)),
        "rms_of": one.rms.as_ref().map(|(_, name)| name),
        "amplitude": number(one.amplitude.as_ref().map(|(size, _)| *size)),
        "orders": one.orders.iter().map(|(order, size)| json!({
            "order": order,
            "amplitude": number(Some(*size)),
        })).collect::<Vec<_>>(),
        "change": one.change.as_ref().map(step_change),
        "turn": one.turn.as_ref().map(step_change),
        "nearest": one.nearest.as_ref().map(|(name, share)| json!({
            "name": name,
            "share": number(Some(*share)),
        })),
        "run": one.place.run,
        "rows": one.place.rows.map(|(first, last)| [Some(first), last]),
        "words": one.place.words,
    })
}

fn doubtful(one: &Doubtful) -> Value {
    json!({
        "name": one.name,
        "noncentrality": number(Some(one.gain.noncentrality())),
        "objection": one.objection.word(),
        "values": values(&one.values),
    })
}

fn candidate(one: &Ranked) -> Value {
    json!({
        "name": one.name,
        "member": member(&one.member),
        "ln_bayes_factor": number(Some(one.ln_bayes)),
        "noncentrality": number(Some(one.gain.noncentrality())),
        "share": number(Some(one.share)),
        "probability": number(Some(one.probability)),
        "values": values(&one.values),
    })
}

fn values(all: &[Size]) -> Value {
    let one = |one: &Size| {
        json!({
            "parameter": one.parameter,
            "component": one.component,
            "of": one.of,
            "size": number(Some(one.value)),
            "unit": one.unit.si_symbol(),
        })
    };
    all.iter().map(one).collect()
}

/// The member of each family; null without any.
fn member(of: &BTreeMap<String, f64>) -> Value {
    let all = of.iter().map(|(family, value)| (family.clone(), json!(value)));
    if of.is_empty() { Value::Null } else { Value::Object(all.collect()) }
}

/// What is left out, single readings by row, and the delays with and without it.
fn left_out(diagnosis: &Diagnosis) -> Value {
    let out = &diagnosis.left_out;
    let readings = out.readings.iter().map(|one| {
        json!({
            "run": &*one.run,
            "row": one.row,
            "measurand": &*one.measurand,
            "deviations": number(Some(one.deviations)),
            "code": number(one.instead.and_then(NoReading::code)),
            "limit": number(one.instead.and_then(NoReading::limit)),
        })
    });
    let runs = out.runs.iter().chain(&out.stretches).map(|one| {
        json!({
            "run": one.run,
            "measurand": one.measurand,
            "readings": one.readings,
            "first_row": one.rows.0,
            "last_row": one.rows.1,
            "deviations": number(Some(one.deviations)),
            "repeats": one.how == Wrong::Repeated,
            "unresponsive": one.how == Wrong::Unresponsive,
        })
    });
    let lost = out.lost.iter().map(|one| {
        json!({
            "run": one.name,
            "first_row": one.rows.0,
            "last_row": one.rows.1,
            "periods": one.periods,
            "seconds": number(Some(one.seconds)),
            "whole_run": one.is_whole_run,
            "ln_p": number(Some(one.ln_p)),
        })
    });
    let delays = diagnosis.delays.iter().map(|one| {
        json!({
            "name": one.name,
            "of": one.of,
            "with": number(Some(one.with)),
            "without": number(Some(one.without)),
            "sigma": number(one.sigma),
        })
    });
    json!({
        "readings": readings.collect::<Vec<_>>(),
        "runs": runs.collect::<Vec<_>>(),
        "lost": lost.collect::<Vec<_>>(),
        "delays": delays.collect::<Vec<_>>(),
    })
}

/// Gauss-Markov processes in the noise, one after the other.
fn autocorrelation(diagnosis: &Diagnosis) -> Vec<Value> {
    let each = diagnosis.autocorrelation.iter().flat_map(|found| {
        found.noise.processes().map(move |one| {
            let mut process = process_json(one, found.is_over_rows);
            process["measurand"] = json!(found.measurand);
            process["of"] = json!(found.of);
            process
        })
    });
    each.collect()
}
