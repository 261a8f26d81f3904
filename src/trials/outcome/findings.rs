//! What a diagnosis says beside its verdict and names, as plain data: the reason, the location, the
//! sizes and the readings that are left out.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::diagnose::Diagnosis;
use crate::diagnose::found::{self, LeftOut};
use crate::diagnose::library::place::Of;
use crate::diagnose::search::Adopted;

use super::Outcome;

/// Locations that are recorded.
const LOCATIONS: usize = 3;

/// Where something without a name sits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Location {
    /// The measurand or the channel.
    pub of: String,
    /// What it is a function of.
    pub covariate: String,
    /// The run, where it is in one.
    pub run: Option<String>,
    /// Rows of that run's file: the first, and the last unless it goes on to the end.
    pub rows: Option<(usize, Option<usize>)>,
    /// Share of the largest location's gain.
    pub share: f64,
}

/// Why the values of an effect are recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// It is named.
    Named,
    /// It is an effect on the noise that is named.
    Noise,
    /// It is nearest to what has no name; values are those of the linear test.
    Nearest,
}

/// The values of an effect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EffectSize {
    /// The effect.
    pub effect: String,
    /// Why it is here.
    pub role: Role,
    /// Its values.
    pub values: Vec<Value>,
}

/// A value with its standard uncertainty (SI).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Value {
    /// The parameter, with its component.
    pub parameter: String,
    /// The setup, run, rig or instrument that it holds for.
    pub of: Option<String>,
    /// The value; `None` where the data do not determine it.
    pub value: Option<f64>,
    /// Its standard uncertainty.
    pub u: Option<f64>,
}

/// Readings that are left out.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Excluded {
    /// Why: `outlier`, `error_code`, `run`, `part_of_run` or `lost_samples`.
    pub reason: String,
    /// How many readings; of lost samples how many samples.
    pub count: usize,
}

/// Writes it into an outcome.
pub(super) fn write(outcome: &mut Outcome, found: &Diagnosis) {
    let reason = found.why.as_ref().map_or("", |(why, _)| why.word());
    outcome.reason = Some(reason.to_owned());
    outcome.location = Some(found.locations.iter().take(LOCATIONS).map(location).collect());
    outcome.sizes = Some(sizes(found));
    outcome.excluded = Some(excluded(found));
}

fn location(one: &found::Location) -> Location {
    let (Of::Measurand(of) | Of::Channel(of)) = &one.place.of;
    Location {
        of: of.clone(),
        covariate: one.place.covariate.clone(),
        run: one.place.run.clone(),
        rows: one.place.rows,
        share: one.share,
    }
}

fn sizes(found: &Diagnosis) -> Vec<EffectSize> {
    let named = found.effects.iter().map(|one| EffectSize {
        effect: one.candidate.name.clone(),
        role: Role::Named,
        values: estimates(found, one),
    });
    let noise = found.noise.iter().map(|one| EffectSize {
        effect: one.name.clone(),
        role: Role::Noise,
        values: vec![Value {
            parameter: one.parameter.clone(),
            of: one.of.clone(),
            value: Some(one.value),
            u: Some(one.sigma),
        }],
    });
    named.chain(noise).chain(nearest(found)).collect()
}

/// The estimates of a named effect; their uncertainties count how well the members of its families
/// are known.
fn estimates(found: &Diagnosis, adopted: &Adopted) -> Vec<Value> {
    let name = &adopted.candidate.name;
    let prefix = format!("{name}.");
    let members = || found.members.iter().filter(|one| one.effect == *name);
    let all = found.explained.iter().flat_map(|one| one.estimates());
    let own = all.filter(|one| one.name.starts_with(&prefix)).map(|one| {
        let shares = members().flat_map(|member| &member.shares);
        let own = shares.filter(|(instance, _)| one.instance == Some(*instance));
        let u = one.sigma.map(|sigma| own.fold(sigma, |u, (_, share)| u.hypot(*share)));
        Value { parameter: one.name, of: one.of, value: one.value, u }
    });
    own.collect()
}

/// The nearest effect, as the test against the nominal model has it.
fn nearest(found: &Diagnosis) -> Option<EffectSize> {
    let nearest = found.nearest.as_ref()?;
    let stage = found.search.as_ref().and_then(|search| search.stages.first());
    let values = stage.and_then(|stage| {
        let of = |name: &str| stage.candidates.iter().position(|one| one.name == name);
        let entry = stage.entry(of(&nearest.name)?);
        let own = entry.values();
        let each = entry.owners.iter().zip(&own).zip(entry.basis.row_iter());
        let each = each.map(|((owner, value), row)| Value {
            parameter: format!("{}[{}]", owner.parameter, owner.component),
            of: owner.of.clone(),
            value: Some(*value),
            u: Some(row.norm()),
        });
        Some(each.collect::<Vec<_>>())
    });
    Some(EffectSize {
        effect: nearest.name.clone(),
        role: Role::Nearest,
        values: values.unwrap_or_default(),
    })
}

fn excluded(found: &Diagnosis) -> Vec<Excluded> {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    let stage = found.search.as_ref().and_then(|search| search.stages.get(found.effects.len()));
    if let Some(LeftOut { readings, runs, stretches }) = stage.map(|one| &one.noise_found.left_out)
    {
        for one in readings {
            let reason = if one.code.is_some() { "error_code" } else { "outlier" };
            *counts.entry(reason).or_default() += 1;
        }
        for (reason, all) in [("run", runs), ("part_of_run", stretches)] {
            all.iter().for_each(|one| *counts.entry(reason).or_default() += one.readings);
        }
    }
    for one in &found.lost {
        *counts.entry("lost_samples").or_default() += one.samples.len();
    }
    let each = counts.into_iter();
    each.map(|(reason, count)| Excluded { reason: reason.to_owned(), count }).collect()
}
