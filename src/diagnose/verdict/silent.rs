//! Effects that show in no reading: those that nominal parameters take up, and those that change
//! none.

use crate::campaign::Track;
use crate::diagnose::library::candidate::{NotTestable, with_only};
use crate::diagnose::stage::Stage;
use crate::engine::open::Recipe;
use crate::graph::recognise;
use crate::system::Selected;

/// An effect that nominal parameters take up.
#[derive(Clone, Debug, PartialEq)]
pub struct Absorbed {
    /// The effect.
    pub name: String,
    /// The parameters that take it up.
    pub acts_as: String,
}

/// Effects that nominal parameters take up, and effects that change no reading here.
pub fn silent(stage: &Stage) -> (Vec<Absorbed>, Vec<NotTestable>) {
    let mut absorbed = Vec::new();
    let mut not_testable = stage.not_testable.clone();
    for number in (0..stage.effects).filter(|n| stage.entry(*n).degrees() == 0) {
        let name = stage.candidates[number].name.clone();
        let entry = stage.entry(number);
        if !entry.finite {
            let why = "the recordings do not hold an input that it acts on, or its slope where its parameters are zero is no number";
            not_testable.push(NotTestable::here(&name, why));
        } else if !entry.acts() {
            not_testable.push(NotTestable::here(&name, why_silent(stage, number)));
        } else {
            absorbed.push(Absorbed { name, acts_as: acts_as(stage, number) });
        }
    }
    not_testable.sort_by(|a, b| a.name.cmp(&b.name));
    (absorbed, not_testable)
}

/// Share of an effect's length above which a parameter is named as taking it up.
const TAKES_PART: f64 = 0.05;

/// The nominal parameters that take an effect up.
pub(in crate::diagnose) fn acts_as(stage: &Stage, number: usize) -> String {
    let layout = &stage.fitted.problem.layout;
    let takers = stage.evidence.takers(stage.entry(number));
    let most = takers.first().map_or(0.0, |(_, share)| *share);
    let mut names: Vec<&str> = Vec::new();
    for (column, _) in takers.iter().filter(|(_, share)| *share >= TAKES_PART * most) {
        let owner = layout.instances.iter().enumerate().find(|(index, instance)| {
            (0..instance.dimension())
                .any(|k| layout.columns_of(*index, k).iter().any(|(c, _)| c == column))
        });
        if let Some((_, instance)) = owner
            && !names.contains(&instance.name.as_str())
        {
            names.push(&instance.name);
        }
    }
    names.join(", ")
}

/// Why an effect changes no reading here.
pub(in crate::diagnose) fn why_silent(stage: &Stage, number: usize) -> String {
    let selected = &stage.candidates[number].selected;
    let absent: Vec<String> = stage
        .fitted
        .recipes
        .iter()
        .zip(&stage.fitted.problem.parts)
        .flat_map(|(recipe, part)| {
            let is_absent = |input: &u32| {
                let lacks =
                    |track: &Track| matches!(track, Track::Captured { acceleration: None, .. });
                part.runs.iter().any(|run| lacks(&run.record.inputs()[*input as usize]))
            };
            let asked = accelerations(recipe, selected).into_iter().filter(is_absent);
            asked
                .map(|input| format!("`{}_acceleration`", recipe.model.inputs[input as usize].name))
        })
        .collect();
    if absent.is_empty() {
        "it changes no reading in these runs by an amount that could be seen, or only by powers of its parameters: an effect must have a slope where they are zero".to_owned()
    } else {
        let columns = absent.join(" or ");
        format!(
            "there is no column {columns}: rates count as constant, and then it changes no reading"
        )
    }
}

/// The inputs, by index, whose accelerations an effect brings into a model's readings.
fn accelerations(recipe: &Recipe, selected: &Selected) -> Vec<u32> {
    let asked = |effect| with_only(recipe, effect).map(|it| recognise::accelerations(&it.assembly));
    let nominal = asked(None).unwrap_or_default();
    let with = asked(Some(selected)).unwrap_or_default();
    with.difference(&nominal).copied().collect()
}
