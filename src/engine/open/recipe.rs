//! A campaign's model with effects, put together again and again with other effects.

use crate::diagnostic::{Diagnostic, Diagnostics, Severity};
use crate::engine::switched_off::remains;
use crate::library::Library;
use crate::model::{Model, Override};
use crate::system::{Selected, System, candidates, stand_ins};

/// From what a model with effects was put together, so that it can be done again with other
/// effects.
#[derive(Clone, Debug)]
pub struct Recipe {
    /// The effects that can be named here.
    pub library: Library,
    /// The model.
    pub model: Model,
    /// The effects that are in use.
    pub effects: Vec<Selected>,
    /// What the campaign and the user state of parameters.
    pub overrides: Vec<Override>,
    /// What the campaign states of the inputs.
    pub input_sigma: Vec<Option<f64>>,
    /// Delays that are held at zero, because they act on no reading and nothing is stated of them.
    pub held_delays: Vec<String>,
}

impl Recipe {
    /// The model with the effects in use and some more.
    ///
    /// # Errors
    /// As [`System::build`].
    pub fn with(&self, more: &[Selected]) -> Result<System, Diagnostics> {
        let all: Vec<Selected> = self.effects.iter().chain(more).cloned().collect();
        System::build(&self.model, &all, &self.overrides, &self.input_sigma)
    }

    /// The model with an effect before those in use: it acts on what the model says without them.
    ///
    /// # Errors
    /// As [`System::build`].
    pub fn with_first(&self, first: &Selected) -> Result<System, Diagnostics> {
        let all: Vec<Selected> = std::iter::once(first).chain(&self.effects).cloned().collect();
        System::build(&self.model, &all, &self.overrides, &self.input_sigma)
    }

    /// Why an effect that is not in use cannot be tested here: it is there although its parameters
    /// are zero.
    pub fn remains(&self, selected: &Selected, overrides: &[Override]) -> Option<Diagnostic> {
        if self.effects.iter().any(|one| one.effect.name == selected.effect.name) {
            return None;
        }
        let beside = (&self.model, self.effects.as_slice());
        remains(beside, selected, overrides, &self.input_sigma).ok().flatten()
    }

    /// What is wrong with effects of the user's own that do not fit the model, each with the
    /// effect's name. A constant that is not stated is no misfit.
    pub fn own_that_do_not_fit(&self) -> Vec<(String, Diagnostic)> {
        let mut told = Vec::new();
        for effect in self.library.own_effects() {
            let stated: Vec<Override> =
                self.overrides.iter().cloned().chain(stand_ins(effect)).collect();
            let faults = match candidates(&self.model, effect, &stated) {
                Err(faults) => faults,
                Ok(ways) => {
                    Diagnostics(ways.iter().filter_map(|way| self.remains(way, &stated)).collect())
                }
            };
            told.extend(faults.0.into_iter().map(|fault| {
                let (name, model) = (&effect.name, &self.model.name);
                let message = format!(
                    "the effect `{name}` does not fit the model `{model}`: {}",
                    fault.message
                );
                (name.clone(), Diagnostic { severity: Severity::Warning, message, ..fault })
            }));
        }
        told
    }
}
