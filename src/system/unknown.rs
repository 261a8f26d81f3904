//! One line for every parameter and random quantity, before it is settled which of the two it is.

mod faults;
mod overrides;

use crate::diagnostic::Place;
use crate::graph::{Kind, Scope};
use crate::model::{ParameterDeclaration, Process, Setting, Shape};
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
