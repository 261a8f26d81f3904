//! Relaxed forms of effects: a value for each angle or setup where the library has one for all.
//!
//! It says which forms there are. Whether one is needed the search finds out. A value for each run is
//! no form: so many values follow slow noise and random walks.

use std::sync::Arc;

use crate::effect::{Effect, Target};
use crate::graph::Scope;
use crate::model::ParameterDeclaration;
use crate::system::Selected;

/// A relaxed form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variant {
    /// A value for each angle that the effect acts on.
    EachAngle,
    /// A value for each setup.
    EachSetup,
}

impl Variant {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::EachAngle, Self::EachSetup];

    /// Its key.
    pub fn word(self) -> &'static str {
        match self {
            Self::EachAngle => "each_angle",
            Self::EachSetup => "each_setup",
        }
    }

    /// What it is.
    pub fn words(self) -> &'static str {
        match self {
            Self::EachAngle => "a value for each angle",
            Self::EachSetup => "a value for each setup",
        }
    }

    /// Those that an effect may take.
    pub fn of_all(effect: &Effect) -> Vec<Self> {
        Self::ALL.into_iter().filter(|form| form.of(effect).is_some()).collect()
    }

    /// An effect as it is part of a model, in this form; `None` where it cannot have it.
    pub fn selected(self, plain: &Selected) -> Option<Selected> {
        let effect = Arc::new(self.of(&plain.effect)?);
        Some(Selected { effect, ..plain.clone() })
    }

    /// An effect in this form; `None` where it has that form or has no such values.
    pub fn of(self, effect: &Effect) -> Option<Effect> {
        let mut relaxed = effect.clone();
        let mut changed = false;
        for parameter in &mut relaxed.parameters {
            let acts_on_angles = effect.patches.iter().any(|line| {
                let mut names = line.formula.root.names().into_iter();
                line.target == Target::EachAngle && names.any(|(name, _)| *name == parameter.name)
            });
            let setting = &mut parameter.setting;
            let is_value = !setting.fixed && !setting.sum_zero && setting.value.is_none();
            match (self, setting.scope) {
                (Self::EachAngle, _) if is_value && acts_on_angles && !parameter.per_measurand => {
                    parameter.per_measurand = true;
                }
                (Self::EachSetup, Scope::Rig | Scope::Instrument) if is_value => {
                    setting.scope = Scope::Setup;
                }
                _ => continue,
            }
            changed = true;
        }
        changed.then_some(relaxed)
    }
}

/// What the signatures of an effect depend on beside its text and its member.
pub fn scopes_of(effect: &Effect) -> String {
    let of = |one: &ParameterDeclaration| (one.per_measurand, one.setting.scope);
    format!("{:?}", effect.parameters.iter().map(of).collect::<Vec<_>>())
}
