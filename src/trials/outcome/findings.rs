//! What a diagnosis says beside its verdict and names, as plain data: the reason, the location, the
//! sizes and the readings that are left out.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::diagnose::Diagnosis;
use crate::diagnose::budget::answer::{Remainder, Row};
use crate::diagnose::found::LeftOut;
use crate::diagnose::library::place::Of;
use crate::estimate::calibrate::Estimate;

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
    let reason = found.doubtful.first().map_or("", |one| one.objection.word());
    outcome.reason = Some(reason.to_owned());
    outcome.location = Some(found.remainder.iter().take(LOCATIONS).map(location).collect());
    outcome.sizes = Some(sizes(found));
    outcome.excluded = Some(excluded(found));
}

fn location(one: &Remainder) -> Location {
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
    let named = found.rows.iter().map(|one| EffectSize {
        effect: one.name.clone(),
        role: Role::Named,
        values: estimates(one),
    });
    let noise = found.noise.iter().map(|one| EffectSize {
        effect: one.name.clone(),
        role: Role::Noise,
        values: vec![Value {
            parameter: one.parameter.clone(),
            of: None,
            value: Some(one.value),
            u: Some(one.sigma),
        }],
    });
    named.chain(noise).chain(nearest(found)).collect()
}

/// The estimates of a row.
fn estimates(row: &Row) -> Vec<Value> {
    let value = |one: &Estimate| Value {
        parameter: one.name.clone(),
        of: one.of.clone(),
        value: one.value,
        u: one.sigma,
    };
    row.values.iter().map(value).collect()
}

/// The nearest effect, as the test against the nominal model has it.
fn nearest(found: &Diagnosis) -> Option<EffectSize> {
    let nearest = found.nearest()?;
    let each = nearest.values.iter().map(|one| Value {
        parameter: format!("{}[{}]", one.parameter, one.component),
        of: one.of.clone(),
        value: Some(one.value),
        u: None,
    });
    Some(EffectSize { effect: nearest.name.clone(), role: Role::Nearest, values: each.collect() })
}

fn excluded(found: &Diagnosis) -> Vec<Excluded> {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    let LeftOut { readings, runs, stretches, lost } = &found.left_out;
    for one in readings {
        let reason = if one.instead.is_some() { "error_code" } else { "outlier" };
        *counts.entry(reason).or_default() += 1;
    }
    for (reason, all) in [("run", runs), ("part_of_run", stretches)] {
        all.iter().for_each(|one| *counts.entry(reason).or_default() += one.readings);
    }
    for one in lost {
        *counts.entry("lost_samples").or_default() += one.samples.len();
    }
    let each = counts.into_iter();
    each.map(|(reason, count)| Excluded { reason: reason.to_owned(), count }).collect()
}
