//! Something that may be added to models: an effect at a head, with the members of its families, or
//! a block of unknown structure; and that something cannot be.
//!
//! It does not say which there are.

use std::sync::Arc;

use crate::engine::open::Recipe;
use crate::graph::Scope;
use crate::model::Setting;
use crate::system::{Selected, System};
use crate::units::Unit;

use super::place::Place;
use super::variant::Variant;

/// Something that may be added to the model.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// `collimation`, at a head `collimation.a`.
    pub name: String,
    /// The effect, its head and the members of its families.
    pub selected: Selected,
    /// The relaxed form that it has, if it is not the library's.
    pub variant: Option<Variant>,
    /// Where unknown structure would sit; `None` for an effect of the library.
    pub place: Option<Place>,
    /// The model with it, campaign by campaign; `None` where it does not fit.
    pub systems: Vec<Option<Arc<System>>>,
}

impl Candidate {
    /// The usual size (SI) of one of its parameters, by full name.
    pub fn typical(&self, parameter: &str) -> Option<f64> {
        self.setting(parameter)?.typical
    }

    /// What is stated of one of its parameters, by full name.
    pub fn setting(&self, parameter: &str) -> Option<&Setting> {
        self.find(parameter).map(|(system, index)| &system.settings[index])
    }

    /// The unit in which one of its parameters is declared, by full name.
    pub fn unit(&self, parameter: &str) -> Option<Unit> {
        let (system, index) = self.find(parameter)?;
        Some(system.assembly.names.parameters[index].unit.clone())
    }

    /// The measurand (by index) for which a parameter is, if there is one for each.
    pub fn measurand(&self, parameter: &str) -> Option<usize> {
        self.find(parameter).and_then(|(system, index)| system.declared[index].measurand)
    }

    /// Whether its values sum to zero over their scope.
    pub fn sums_to_zero(&self) -> bool {
        self.selected.effect.parameters.iter().any(|one| one.setting.sum_zero)
    }

    /// Whether each run has values of its own.
    pub(in crate::diagnose) fn is_of_runs(&self) -> bool {
        self.selected.effect.parameters.iter().all(|one| one.setting.scope == Scope::Run)
    }

    fn find(&self, parameter: &str) -> Option<(&System, usize)> {
        self.systems.iter().flatten().find_map(|system| {
            let names = &system.assembly.names.parameters;
            let index = names.iter().position(|one| one.name == parameter)?;
            Some((&**system, index))
        })
    }
}

/// An effect that cannot be tested here.
#[derive(Clone, Debug, PartialEq)]
pub struct NotTestable {
    /// The effect.
    pub name: String,
    /// A sentence.
    pub why: String,
    /// Whether it acts on what no campaign's model has.
    pub of_other_models: bool,
    /// The constants that a campaign need only state for it to be tested.
    pub wants: Vec<String>,
}

impl NotTestable {
    /// An effect that these models have a place for.
    pub(in crate::diagnose) fn here(name: &str, why: impl Into<String>) -> Self {
        Self { name: name.to_owned(), why: why.into(), of_other_models: false, wants: Vec::new() }
    }
}

/// Candidates that are found campaign by campaign: what is the same in several is one.
#[derive(Debug)]
pub(super) struct Joined {
    /// In the order in which they were found.
    pub(super) found: Vec<Candidate>,
    campaigns: usize,
}

impl Joined {
    /// None yet, of so many campaigns.
    pub(super) fn new(campaigns: usize) -> Self {
        Self { found: Vec::new(), campaigns }
    }

    /// Adds the system of a campaign with an effect.
    pub(super) fn add(
        &mut self,
        campaign: usize,
        selected: Selected,
        place: Option<Place>,
        system: System,
    ) {
        let name = selected.name();
        let same = |one: &Candidate| one.name == name && one.selected.member == selected.member;
        let number = self.found.iter().position(same).unwrap_or_else(|| {
            let systems = vec![None; self.campaigns];
            self.found.push(Candidate { name, selected, variant: None, place, systems });
            self.found.len() - 1
        });
        self.found[number].systems[campaign] = Some(Arc::new(system));
    }
}

/// An effect as it fits campaigns of these models; `None` where it fits none.
pub fn fitting(
    recipes: &[Recipe],
    selected: &Selected,
    place: Option<&Place>,
) -> Option<Candidate> {
    let with = |recipe: &Recipe| match place {
        Some(_) => recipe.with_first(selected),
        None => recipe.with(std::slice::from_ref(selected)),
    };
    let systems = recipes.iter().map(|recipe| with(recipe).ok().map(Arc::new)).collect();
    let (name, place, selected) = (selected.name(), place.cloned(), selected.clone());
    let fitting = Candidate { name, selected, variant: None, place, systems };
    fitting.systems.iter().any(Option::is_some).then_some(fitting)
}
