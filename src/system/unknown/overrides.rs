//! What campaigns and the command line state of an unknown, laid over what is declared.

use super::{Origin, Unknown};
use crate::diagnostic::Diagnostic;
use crate::graph::{Kind, Scope};
use crate::model::parameter::component_count;
use crate::model::{Override, Process};

impl Unknown {
    /// Lays an override over it, and over what was said of it in single setups; `is_stated` if a
    /// campaign or the command line states it.
    pub(in crate::system) fn apply(
        &mut self,
        said: &Override,
        is_stated: bool,
    ) -> Result<(), Box<Diagnostic>> {
        if is_stated {
            self.note(said);
        }
        let Some(setup) = &said.setup else {
            self.of_setups.iter_mut().try_for_each(|(_, own)| own.apply_here(said))?;
            return self.apply_here(said);
        };
        if let Some((_, own)) = self.of_setups.iter_mut().find(|(known, _)| known == setup) {
            return own.apply_here(said);
        }
        let mut own = Self { of_setups: Vec::new(), ..self.clone() };
        own.apply_here(said)?;
        self.of_setups.push((setup.clone(), own));
        Ok(())
    }

    /// Notes which keys a campaign or the command line states of it in all setups.
    fn note(&mut self, said: &Override) {
        if said.setup.is_none() {
            let place = |key| (key, said.place.clone());
            self.declared.stated.extend(said.keys().map(place));
        }
    }

    fn apply_here(&mut self, said: &Override) -> Result<(), Box<Diagnostic>> {
        let at = |error: Diagnostic| Box::new(error.at_maybe(said.place.as_ref()));
        let component = self.component_of(said).map_err(at)?;
        let count = component.map_or(component_count(self.kind), |_| 1);
        if let Some((message, help)) = said.check(count, &self.unit) {
            let error = Diagnostic::error(message);
            return Err(at(if help.is_empty() { error } else { error.help(help) }));
        }
        if let Some(component) = component {
            said.apply_to_component(component, &mut self.setting);
            if said.place.is_some() {
                self.place.clone_from(&said.place);
            }
            return Ok(());
        }
        let (from, fixed) = (self.setting.scope, self.setting.fixed);
        said.apply(&mut self.setting);
        if self.origin == Origin::InputError {
            // Its `sigma` is what is known of it, not a prior that sets it free.
            self.setting.fixed = said.fixed.unwrap_or(fixed);
        }
        if said.place.is_some() {
            self.place.clone_from(&said.place);
        }
        let name = &self.name;
        let to = self.setting.scope;
        let message = match self.origin {
            Origin::InputError if to != Scope::Sample => {
                format!(
                    "`{name}` is an input's error, new in every sample: its scope cannot change"
                )
            }
            Origin::Delay if to == Scope::Sample => {
                format!(
                    "the delay `{name}` cannot be random; the effect `timestamp_jitter` is what you want"
                )
            }
            _ if from != to && self.process != Process::White => {
                format!("`{name}` is a process in time: its scope cannot change")
            }
            _ => return Ok(()),
        };
        Err(at(Diagnostic::error(message)))
    }

    /// Whether an override means it, or one of its components.
    pub(in crate::system) fn is_meant_by(&self, said: &Override) -> bool {
        self.name == said.name || self.has_component(said, &self.name)
    }

    /// Whether an override means a component of it by this name.
    pub(in crate::system) fn has_component(&self, said: &Override, name: &str) -> bool {
        self.kind != Kind::Scalar && said.component().is_some_and(|(vector, _)| vector == name)
    }

    /// The component that an override means, if it does not mean all of it.
    fn component_of(&self, said: &Override) -> Result<Option<usize>, Diagnostic> {
        let is_component = |name: &str| self.has_component(said, name);
        if self.name == said.name || !(is_component(&self.name) || is_component(&self.general)) {
            return Ok(None);
        }
        let Some((vector, component)) = said.component() else { return Ok(None) };
        if self.kind == Kind::Rotation {
            let message = format!("`{}`: a rotation is stated as a whole", said.name);
            let help = format!("state `{vector}` with its three components, a rotation vector");
            return Err(Diagnostic::error(message).help(help));
        }
        let whole = [
            ("scope", said.scope.is_some()),
            ("sum", said.sum_zero.is_some()),
            ("plausible", said.plausible.is_some()),
            ("linear_range", said.linear_range.is_some()),
            ("simulated_at", said.simulated_at.is_some()),
            ("degrees_of_freedom", said.degrees_of_freedom.is_some()),
        ];
        if let Some((key, _)) = whole.into_iter().find(|(_, is_said)| *is_said) {
            let message = format!("`{key}` of `{}` holds for all components", said.name);
            return Err(Diagnostic::error(message).help(format!("state it of `{vector}`")));
        }
        Ok(Some(component))
    }
}
