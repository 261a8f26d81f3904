//! One line for every parameter and random quantity, before it is settled which of the two it is.

use crate::diagnostic::{Diagnostic, Place};
use crate::graph::{Kind, Scope};
use crate::model::component::AXES;
use crate::model::parameter::component_count;
use crate::model::{Component, Override, ParameterDeclaration, Process, Setting, Shape};
use crate::system::needs::is_random;
use crate::system::{Declared, RandomSetting};
use crate::units::{Dimension, Exponent, Unit};

/// What kind of line it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Origin {
    /// Declared in `[parameters]` of the model or an effect.
    Declared,
    /// A delay.
    Delay,
    /// The error of an input.
    InputError,
}

/// A parameter or a random quantity.
#[derive(Clone, Debug)]
pub(super) struct Unknown {
    pub(super) name: String,
    /// `EFFECT.NAME`, by which an override means it at all heads and for all measurands.
    pub(super) general: String,
    pub(super) kind: Kind,
    pub(super) unit: Unit,
    pub(super) setting: Setting,
    /// What is said of it in single setups, with the setup's name.
    pub(super) of_setups: Vec<(String, Unknown)>,
    pub(super) origin: Origin,
    pub(super) declared: Declared,
    pub(super) process: Process,
    pub(super) shape: Shape,
    pub(super) memory: Option<f64>,
    /// Where it is declared or was last overridden.
    pub(super) place: Option<Place>,
}

impl Unknown {
    /// A line of `[parameters]`; `name` and `general` are full names.
    pub(super) fn of(
        declaration: &ParameterDeclaration,
        name: String,
        general: String,
        place: Place,
    ) -> Self {
        Self {
            name,
            general,
            kind: declaration.kind,
            unit: declaration.unit.clone(),
            setting: declaration.setting.clone(),
            of_setups: Vec::new(),
            origin: Origin::Declared,
            declared: Declared {
                local: declaration.name.clone(),
                about: declaration.about.clone(),
                ..Declared::default()
            },
            process: declaration.process,
            shape: declaration.shape,
            memory: declaration.memory,
            place: Some(place),
        }
    }

    /// A scalar that no file declares.
    pub(super) fn implied(name: String, unit: Unit, setting: Setting, origin: Origin) -> Self {
        Self {
            general: name.clone(),
            declared: Declared { local: name.clone(), ..Declared::default() },
            name,
            kind: Kind::Scalar,
            unit,
            setting,
            of_setups: Vec::new(),
            origin,
            process: Process::White,
            shape: Shape::Normal,
            memory: None,
            place: None,
        }
    }

    /// Lays an override over it, and over what was said of it in single setups; `is_stated` if a
    /// campaign or the command line states it.
    pub(super) fn apply(
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
    pub(super) fn is_meant_by(&self, said: &Override) -> bool {
        self.name == said.name || self.has_component(said, &self.name)
    }

    /// Whether an override means a component of it by this name.
    pub(super) fn has_component(&self, said: &Override, name: &str) -> bool {
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

    /// What is wrong with it, or with what is said of it in single setups, now that everything is
    /// said.
    pub(super) fn fault(&self) -> Option<Diagnostic> {
        let is_constant = self.setting.fixed && self.declared.effect.is_some();
        if let Some((_, own)) = self.of_setups.first().filter(|_| is_constant) {
            let message =
                format!("`{}` is a constant of an effect, the same in all setups", self.name);
            let error = Diagnostic::error(message).help("state it in [parameters]");
            return Some(error.at_maybe(own.place.as_ref()));
        }
        if let Some((_, own)) = self.of_setups.first().filter(|_| self.setting.sum_zero) {
            let message = format!("the values of `{}` sum to zero over the setups", self.name);
            let help = "none of them can be stated alone";
            return Some(Diagnostic::error(message).help(help).at_maybe(own.place.as_ref()));
        }
        if let (Some((_, own)), false) =
            (self.of_setups.first(), self.setting.scope == Scope::Setup)
        {
            let message = format!("`{}` has no value of its own in each setup", self.name);
            let help = "state it in [parameters]; there scope = \"setup\" gives it one in each";
            return Some(Diagnostic::error(message).help(help).at_maybe(own.place.as_ref()));
        }
        self.fault_here().or_else(|| self.of_setups.iter().find_map(|(_, own)| own.fault_here()))
    }

    fn fault_here(&self) -> Option<Diagnostic> {
        let (name, setting) = (&self.name, &self.setting);
        let error = |message: String, help: &str| {
            let error = Diagnostic::error(message);
            let error = if help.is_empty() { error } else { error.help(help) };
            Some(error.at_maybe(self.place.as_ref()))
        };
        if setting.linear_range.or(setting.simulated_at).is_some()
            && (self.origin != Origin::Declared || self.kind != Kind::Scalar)
        {
            return error(
                format!(
                    "`{name}` has `linear_range` or `simulated_at` and is no scalar that is declared"
                ),
                "they belong to parameters of which streams were computed, such as a simulator's",
            );
        }
        if is_random(setting.scope) {
            if self.kind != Kind::Scalar {
                return error(
                    format!("`{name}` is random (scope = \"sample\") and not a scalar"),
                    "only scalars can be random",
                );
            }
            if setting.sum_zero {
                return error(
                    format!("`{name}` is random: its mean is zero anyway"),
                    "leave out `sum`",
                );
            }
            if self.origin != Origin::InputError
                && setting.value.is_some()
                && setting.sigma.is_some()
            {
                return error(
                    format!(
                        "`{name}` is random and has one standard deviation, not `value` and `sigma`"
                    ),
                    "give its standard deviation as `value`",
                );
            }
            if self.standard_deviation().is_some_and(|sigma| sigma < 0.0) {
                return error(format!("`{name}`: a standard deviation cannot be negative"), "");
            }
            return None;
        }
        if let Some(fault) = self.fault_of_components() {
            return Some(fault.at_maybe(self.place.as_ref()));
        }
        if setting.fixed && setting.value.is_none() {
            let unit = if self.unit.symbol == "1" { "" } else { self.unit.symbol.as_str() };
            let quantity = |number: u8| format!("\"{}\"", format!("{number} {unit}").trim_end());
            let example = match self.kind {
                Kind::Scalar => quantity(1),
                _ => format!("[{0}, {0}, {0}]", quantity(0)),
            };
            let help = format!("\"{name}\" = {{ value = {example}, fixed = true }}");
            return error(
                format!("`{name}` is fixed, but nobody says at what: state its value"),
                &help,
            );
        }
        if setting.sigma.is_some() && setting.value.is_none() {
            return error(
                format!("`{name}` has a standard uncertainty, but no value"),
                "`sigma` is the standard uncertainty of `value`",
            );
        }
        if let (Some(lower), Some(upper)) = (&setting.lower, &setting.upper)
            && lower.iter().zip(upper).any(|(lower, upper)| lower >= upper)
        {
            return error(format!("`{name}`: `lower` must be below `upper`"), "");
        }
        None
    }

    /// What is wrong with what is said of single components.
    fn fault_of_components(&self) -> Option<Diagnostic> {
        let setting = &self.setting;
        let all = setting.components.as_ref()?;
        if setting.sum_zero {
            let message = format!("the values of `{}` sum to zero over their scope", self.name);
            return Some(Diagnostic::error(message).help("no component can be stated by itself"));
        }
        let fault = |(component, own): (usize, &Component)| {
            let name = format!("{}.{}", self.name, AXES[component]);
            let (lower, upper) = setting.bounds_of(component);
            if own.fixed == Some(true) && setting.value_of(component).is_none() {
                let help = format!(
                    "\"{name}\" = {{ value = \"{}\", fixed = true }}",
                    format!("0 {}", self.unit.symbol).trim_end_matches(" 1")
                );
                let message =
                    format!("`{name}` is fixed, but nobody says at what: state its value");
                Some(Diagnostic::error(message).help(help))
            } else if own.sigma.is_some() && setting.value_of(component).is_none() {
                let message = format!("`{name}` has a standard uncertainty, but no value");
                Some(
                    Diagnostic::error(message)
                        .help("`sigma` is the standard uncertainty of `value`"),
                )
            } else if lower >= upper {
                Some(Diagnostic::error(format!("`{name}`: `lower` must be below `upper`")))
            } else {
                None
            }
        };
        all.iter().enumerate().find_map(fault)
    }

    fn standard_deviation(&self) -> Option<f64> {
        let said = self.setting.value.as_ref().or(self.setting.sigma.as_ref());
        said.and_then(|said| said.first()).copied()
    }

    /// The dimension of one draw: a walk's unit has a root of time in its denominator.
    pub(super) fn dimension_of_draw(&self) -> Dimension {
        match (self.process, Exponent::new(1, 2)) {
            (Process::Walk, Some(half)) => self.unit.dimension * Dimension::TIME.pow(half),
            _ => self.unit.dimension,
        }
    }

    /// As a random quantity of an effect.
    pub(super) fn random(&self, effect: Option<String>) -> RandomSetting {
        RandomSetting {
            name: self.name.clone(),
            unit: self.unit.of_differences(),
            sigma: self.standard_deviation(),
            typical: self.setting.typical,
            process: self.process,
            shape: self.shape,
            memory: self.memory,
            effect,
            fixed: self.setting.fixed,
            scope: Scope::Sample,
            about: self.declared.about.clone(),
        }
    }
}
