//! Effects that show in no reading: those that nominal parameters absorb, and those that change
//! none.

use crate::campaign::Track;
use crate::diagnose::fitted::Fitted;
use crate::diagnose::library::candidate::NotTestable;
use crate::effect::Acts;
use crate::engine::open::Recipe;
use crate::graph::recognise;
use crate::system::{Selected, System};

use super::linear::Linear;
use super::selection::Selection;
use super::terms::Term;

/// An effect that nominal parameters absorb.
#[derive(Clone, Debug, PartialEq)]
pub struct Absorbed {
    /// The effect.
    pub name: String,
    /// The parameters that absorb it.
    pub acts_as: String,
}

/// Effects that show in no reading beside the nominal model. With a row in the fit the slope of
/// another effect may have a part that is the product of both: it is no evidence of that effect.
#[derive(Clone, Debug, Default)]
pub struct Unseen {
    /// Those that nominal parameters absorb.
    pub absorbed: Vec<Absorbed>,
    /// Those that change no reading, and those that cannot be tested.
    pub not_testable: Vec<NotTestable>,
}

impl Unseen {
    /// Whether an effect is one of them.
    pub(super) fn has(&self, name: &str) -> bool {
        self.absorbed.iter().any(|one| one.name == name)
            || self.not_testable.iter().any(|one| one.name == name)
    }
}

/// Share of the largest part above which a parameter is named as absorbing an effect.
const TAKES_PART: f64 = 0.05;

/// Of a fit without rows.
pub fn unseen(linear: &Linear, selection: &Selection<'_>) -> Unseen {
    let mut absorbed = Vec::new();
    let mut not_testable = linear.not_testable.clone();
    for (term, own) in linear.terms.iter().enumerate() {
        if !is_unseen(own, selection, term) {
            continue;
        }
        let square = squared_length(own, selection);
        if !square.is_finite() {
            let why = "the recordings do not hold an input that it acts on, or its slope where its parameters are zero is no number";
            not_testable.push(NotTestable::here(&own.name, why));
        } else if square <= 0.0 {
            let selected = &linear.candidates[own.candidate].selected;
            let why = why_silent(&linear.fitted, selected);
            not_testable.push(NotTestable::here(&own.name, why));
        } else {
            let acts_as = acts_as(&linear.fitted, &selection.shares_of_nominal(term));
            absorbed.push(Absorbed { name: own.name.clone(), acts_as });
        }
    }
    not_testable.sort_by(|a, b| a.name.cmp(&b.name));
    Unseen { absorbed, not_testable }
}

/// Whether an effect outside the fit, in the library's form, has no part that nominal parameters do
/// not absorb. A relaxed form is the effect by the same name.
pub(super) fn is_unseen(own: &Term, selection: &Selection<'_>, term: usize) -> bool {
    let is_listed = own.is_effect() && own.candidate != usize::MAX && own.variant.is_none();
    is_listed && selection.gain(&[], term).degrees == 0
}

/// The squared length of a term's columns; not finite where the recordings lack an input.
pub(super) fn squared_length(own: &Term, selection: &Selection<'_>) -> f64 {
    own.columns.iter().map(|column| selection.square(column)).sum()
}

/// The nominal parameters that absorb an effect, from the part that each column has in that.
pub fn acts_as(fitted: &Fitted, shares: &[(usize, f64)]) -> String {
    let layout = &fitted.problem.layout;
    let most = shares.iter().fold(0.0_f64, |most, (_, share)| most.max(*share));
    let mut names: Vec<&str> = Vec::new();
    for (column, _) in shares.iter().filter(|(_, share)| *share >= TAKES_PART * most) {
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
pub fn why_silent(fitted: &Fitted, selected: &Selected) -> String {
    let needs_motion = matches!(selected.effect.acts, Acts::Timing | Acts::Servo);
    if needs_motion && !fitted.problem.moves() {
        return "no signal moves in these runs".to_owned();
    }
    let absent: Vec<String> = fitted
        .recipes
        .iter()
        .zip(&fitted.problem.parts)
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
    let asked = |effects: &[Selected]| {
        let Recipe { model, overrides, input_sigma, .. } = recipe;
        let system = System::build(model, effects, overrides, input_sigma).ok();
        system.map(|system| recognise::accelerations(&system.assembly)).unwrap_or_default()
    };
    asked(std::slice::from_ref(selected)).difference(&asked(&[])).copied().collect()
}
