//! The result of `diagnose` for programs: the keys of `docs/formats.md`, section 6.

use std::collections::BTreeMap;

use serde_json::{Map, Value, json};

use crate::diagnose::Diagnosis;
use crate::diagnose::found::{Location, Noise, NoiseEffect, Ranked};
use crate::diagnose::gap::Gap;
use crate::diagnose::library::place::Of;
use crate::diagnose::library::prior::{Cause, Prior};
use crate::diagnose::search::Adopted;
use crate::diagnose::search::probability::{at_most, is_implausible};
use crate::diagnose::stage::Stage;
use crate::diagnose::verdict::answer::Verdict;
use crate::diagnose::verdict::hidden::Hidden;
use crate::diagnose::verdict::member::MemberUncertainty;
use crate::estimate::calibrate::Estimate;
use crate::report::json::{calibration, estimate, number, stated, unobservable};

/// The result of `diagnose`, at most `top` candidates.
pub fn json(diagnosis: &Diagnosis, top: Option<usize>) -> Value {
    let candidates = diagnosis.candidates.iter().take(top.unwrap_or(usize::MAX));
    let absorbed = diagnosis.absorbed.iter();
    let not_testable = diagnosis.not_testable.iter();
    let noise = diagnosis.noise.iter().map(noise_effect);
    let used = noise_in_use(diagnosis).iter().map(noise_effect);
    let effects = diagnosis.effects.iter().map(|one| effect(diagnosis, one));
    json!({
        "verdict": diagnosis.verdict.word(),
        "effects": noise.chain(effects).collect::<Vec<_>>(),
        "candidates": candidates.map(candidate).collect::<Vec<_>>(),
        "causes": diagnosis.causes.filter(|_| is_of_one_cause(diagnosis)).map(causes),
        "prior": prior(diagnosis),
        "absorbed": absorbed
            .map(|one| json!({ "name": one.name, "acts_as": one.acts_as }))
            .collect::<Vec<_>>(),
        "not_testable": not_testable
            .map(|one| json!({ "name": one.name, "why": one.why }))
            .collect::<Vec<_>>(),
        "where": diagnosis.locations.iter().map(location).collect::<Vec<_>>(),
        "nearest": diagnosis.nearest.as_ref().map(|one| json!({
            "name": one.name,
            "share": number(Some(one.share)),
        })),
        "suspected": diagnosis.suspected,
        "gap": diagnosis.gap.as_ref().map(gap),
        "unexplained": diagnosis.floor.as_ref().map(|floor| json!({
            "before": by_measurand(&diagnosis.nominal.rms),
            "floor": by_measurand(floor),
            "why": diagnosis.why.as_ref().map(|(why, _)| why.word()),
            "effects": diagnosis.why.as_ref().map(|(_, effects)| effects),
        })),
        "hidden": diagnosis.hidden.iter().map(hidden).collect::<Vec<_>>(),
        "noise": used.collect::<Vec<_>>(),
        "levels": last_noise(diagnosis).into_iter().flat_map(|noise| &noise.levels).map(|one| {
            json!({ "measurand": one.measurand, "of": one.of, "factor": number(Some(one.factor)) })
        }).collect::<Vec<_>>(),
        "run_levels": last_noise(diagnosis).into_iter().flat_map(|noise| &noise.run_levels).map(
            |(measurand, run, by)| json!({ "measurand": measurand, "run": run, "factor": number(Some(*by)) })
        ).collect::<Vec<_>>(),
        "memories": last_noise(diagnosis).into_iter().flat_map(|noise| &noise.memories).map(
            |(measurand, of, memory)| json!({
                "measurand": measurand,
                "of": of,
                "share": number(Some(memory.share)),
                "time": number(Some(memory.time)),
            })
        ).collect::<Vec<_>>(),
        "left_out": left_out(diagnosis),
        "contradicted": stated(&diagnosis.contradicted),
        "fit": calibration(&diagnosis.nominal)["fit"],
        "unobservable": unobservable(&diagnosis.nominal.unobservable),
    })
}

/// Probabilities of nothing, of an effect of the library and of unknown structure.
fn causes(of: [f64; 3]) -> Value {
    let [nothing, library, unknown] = of.map(|one| number(Some(one)));
    json!({ "nothing": nothing, "library": library, "unknown": unknown })
}

/// The same before the readings, and how many times as probable as others effects are; null where
/// there was no search.
fn prior(diagnosis: &Diagnosis) -> Value {
    let Some(prior) = stated_prior(diagnosis) else { return Value::Null };
    let mut value =
        causes([Cause::Nothing, Cause::Library, Cause::Unknown].map(|one| prior.of(one)));
    let times = prior.unequal().map(|(name, times)| (name.to_owned(), number(Some(times))));
    value["times"] = Value::Object(times.collect());
    value
}

/// The prior that probabilities are made from.
pub(crate) fn stated_prior(diagnosis: &Diagnosis) -> Option<&Prior> {
    Some(&diagnosis.search.as_ref()?.stages.first()?.prior)
}

/// One row a candidate, best first: its test and its probability.
pub fn table(diagnosis: &Diagnosis) -> String {
    let mut text = String::from("name,ln_p,lambda,probability,share\n");
    for one in &diagnosis.candidates {
        text.push_str(&format!(
            "{},{:.6e},{:.6e},{:.6e},{:.6e}\n",
            one.name,
            one.score.ln_p,
            one.score.lambda(),
            one.probability,
            one.share
        ));
    }
    text
}

/// What is left out, single readings by row, and the delays with and without it.
fn left_out(diagnosis: &Diagnosis) -> Value {
    let out = last_noise(diagnosis).map(|noise| &noise.left_out);
    let readings = out.into_iter().flat_map(|out| &out.readings).map(|one| {
        json!({
            "run": &*one.run,
            "row": one.row,
            "measurand": &*one.measurand,
            "deviations": number(Some(one.deviations)),
            "code": number(one.code),
        })
    });
    let stretches = out.into_iter().flat_map(|out| out.runs.iter().chain(&out.stretches));
    let runs = stretches.map(|one| {
        json!({
            "run": one.run,
            "measurand": one.measurand,
            "readings": one.readings,
            "first_row": one.rows.0,
            "last_row": one.rows.1,
            "deviations": number(Some(one.deviations)),
        })
    });
    let lost = diagnosis.lost.iter().map(|one| {
        json!({
            "run": one.name,
            "first_row": one.rows.0,
            "last_row": one.rows.1,
            "periods": one.periods,
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

/// The effects on the noise of which the fit takes account, also where something beside them is
/// unknown; none where a walk stands for displacements.
pub(crate) fn noise_in_use(diagnosis: &Diagnosis) -> &[NoiseEffect] {
    match last_noise(diagnosis) {
        Some(noise) if diagnosis.verdict == Verdict::Unknown && noise.displaced.is_none() => {
            &noise.effects
        }
        _ => &diagnosis.noise,
    }
}

/// The noise with the named effects in the model.
pub(crate) fn last_noise(diagnosis: &Diagnosis) -> Option<&Noise> {
    last_stage(diagnosis).map(|stage| &stage.noise_found)
}

/// The stage with the named effects in the model.
pub(crate) fn last_stage(diagnosis: &Diagnosis) -> Option<&Stage> {
    diagnosis.search.as_ref()?.stages.get(diagnosis.effects.len())
}

/// The estimates that belong to an effect; their uncertainties count how well the members of its
/// families are known.
pub(crate) fn estimates_of(diagnosis: &Diagnosis, adopted: &Adopted) -> Vec<Estimate> {
    let prefix = format!("{}.", adopted.candidate.name);
    let all = diagnosis.explained.iter().flat_map(|one| one.estimates());
    let mut all: Vec<Estimate> = all.filter(|one| one.name.starts_with(&prefix)).collect();
    let shares = members_of(diagnosis, adopted).flat_map(|one| &one.shares);
    for (instance, share) in shares {
        let own = all.iter_mut().filter(|one| one.instance == Some(*instance));
        own.for_each(|one| one.sigma = one.sigma.map(|sigma| sigma.hypot(*share)));
    }
    all
}

/// How well the members of its families are known.
pub(crate) fn members_of<'a>(
    diagnosis: &'a Diagnosis,
    adopted: &'a Adopted,
) -> impl Iterator<Item = &'a MemberUncertainty> {
    diagnosis.members.iter().filter(|one| one.effect == adopted.candidate.name)
}

/// How many times as large as usual an effect is, by the largest of its values; `None` where it has
/// no usual size.
pub(crate) fn times_usual(diagnosis: &Diagnosis, adopted: &Adopted) -> Option<f64> {
    let explained = diagnosis.explained.as_ref()?;
    let times = |one: Estimate| {
        let typical = explained.problem.layout.instances[one.instance?].setting.typical?;
        Some(one.value?.abs() / typical)
    };
    estimates_of(diagnosis, adopted).into_iter().filter_map(times).reduce(f64::max)
}

/// The member of each family; null without any.
fn member(of: &BTreeMap<String, f64>) -> Value {
    let all = of.iter().map(|(family, value)| (family.clone(), json!(value)));
    if of.is_empty() { Value::Null } else { Value::Object(all.collect()) }
}

fn effect(diagnosis: &Diagnosis, adopted: &Adopted) -> Value {
    let known = members_of(diagnosis, adopted).map(|one| (one.family.clone(), one.sigma)).collect();
    json!({
        "name": adopted.candidate.name,
        "member": member(&adopted.candidate.selected.member),
        "member_sigma": member(&known),
        "probability": number(Some(adopted.probability)),
        "aliases": adopted.aliases,
        "evidence": adopted.evidence(),
        "times_usual": number(times_usual(diagnosis, adopted)),
        "implausible": times_usual(diagnosis, adopted).is_some_and(is_implausible),
        "parameters": estimates_of(diagnosis, adopted).iter().map(estimate).collect::<Vec<_>>(),
    })
}

fn noise_effect(one: &NoiseEffect) -> Value {
    let parameters = std::iter::once(&one.parameter).chain(&one.also).map(|name| {
        json!({
            "name": name,
            "scope": "sample",
            "of": one.of,
            "value": number(Some(one.value)),
            "sigma": number(Some(one.sigma)),
            "unit": one.unit.si_symbol(),
        })
    });
    json!({
        "name": one.name,
        "member": one.memory.map(|memory| json!({ "memory": memory })),
        "probability": number(Some(at_most(one.ln_p))),
        "aliases": one.aliases,
        "evidence": "data",
        "times_usual": Value::Null,
        "implausible": false,
        "parameters": parameters.collect::<Vec<_>>(),
    })
}

fn candidate(one: &Ranked) -> Value {
    json!({
        "name": one.name,
        "member": member(&one.member),
        "p": one.score.ln_p.exp(),
        "ln_p": number(Some(one.score.ln_p)),
        "lambda": number(Some(one.score.lambda())),
        "probability": number(Some(one.probability)),
        "share": number(Some(one.share)),
    })
}

fn location(one: &Location) -> Value {
    let (key, of) = match &one.place.of {
        Of::Measurand(name) => ("measurand", name),
        Of::Channel(name) => ("channel", name),
    };
    json!({
        key: of,
        "covariate": one.place.covariate,
        "share": number(Some(one.share)),
        "run": one.place.run,
        "rows": one.place.rows.map(|(first, last)| [Some(first), last]),
        "words": one.place.words,
    })
}

fn by_measurand(list: &[(String, f64)]) -> Map<String, Value> {
    list.iter().map(|(name, value)| (name.clone(), number(Some(*value)))).collect()
}

/// Whether probabilities of single causes say something: not where several were found, or one is
/// not all.
pub(super) fn is_of_one_cause(diagnosis: &Diagnosis) -> bool {
    diagnosis.effects.len() < 2 && diagnosis.verdict != Verdict::ShapeDiffers
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
        "lambda": number(Some(one.lambda)),
        "held_out_drop": number(Some(one.held_out_drop)),
        "leftover": number(Some(one.leftover)),
        "closed": number(one.closed),
        "closed_interval": one.closed_interval,
        "borne_out": one.is_borne_out(),
        "folds": one.folds,
        "left_out": one.left_out,
    })
}

fn hidden(one: &Hidden) -> Value {
    json!({
        "name": one.name,
        "delay": one.delay,
        "bias": number(Some(one.bias)),
        "times_usual": number(one.times_usual),
    })
}
