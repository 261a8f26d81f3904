//! A model with effects and with what a campaign says of their parameters: names settled, graph
//! assembled, what is known of every unknown.
//!
//! Answers: which parameters and random quantities there are, over which scope, with which prior
//! knowledge, and to which effect each belongs. It does not know the data.
//!
//! | file | answers |
//! |---|---|
//! | [`needs`] | whether an effect can be applied to a model, and at which heads |
//! | [`mod@build`] | a model and effects as one symbol table |
//! | `place` | effects at heads, with members, in order of application |
//! | `layer` | one effect as one layer of patches |
//! | `testable` | which effects of a library can be tested on a model |
//! | `unknown` | one line for every parameter and random before scopes are settled |
//!
//! Names of parameters: `NAME` of the model, `NAME.delay`, `EFFECT.NAME`, at a head
//! `EFFECT.HEAD.NAME`, one for each measurand `EFFECT.NAME.MEASURAND`. An override of `EFFECT.NAME`
//! holds for all heads and measurands for which nothing more is said.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::diagnostic::Place;
use crate::effect::Effect;
use crate::graph::{Assembly, Scope};
use crate::model::{Process, Roles, Setting, Shape};
use crate::units::Unit;

pub mod build;
mod layer;
pub mod needs;
mod place;
mod testable;
mod unknown;

pub(crate) use needs::delay_names;
pub use needs::{candidates, known_names, lacks, missing_names, stand_ins, wanted_constants};
pub use testable::{Lacking, Testable, testable};

/// An effect that is to be applied, at one head or all, with the chosen members of its families.
#[derive(Clone, Debug)]
pub struct Selected {
    /// The effect.
    pub effect: Arc<Effect>,
    /// One of the model's heads; `None`: at every head that the effect fits.
    pub head: Option<String>,
    /// Chosen members (SI) by family; the rest are as overrides say, else the family's default.
    pub member: BTreeMap<String, f64>,
}

impl Selected {
    /// The name of the effect with its head.
    pub fn name(&self) -> String {
        match &self.head {
            Some(head) => format!("{}.{head}", self.effect.name),
            None => self.effect.name.clone(),
        }
    }
}

/// A model with its effects, ready for an engine.
#[derive(Clone, Debug)]
pub struct System {
    /// Graph and names.
    pub assembly: Assembly,
    /// What is known of each of `assembly.names.parameters`, overrides applied; never of scope
    /// sample.
    pub settings: Vec<Setting>,
    /// What is known of a parameter in one setup, where that is more than in all.
    pub of_setups: Vec<OfSetup>,
    /// More on each of `assembly.names.parameters`.
    pub declared: Vec<Declared>,
    /// What is known of each of `assembly.names.randoms`.
    pub randoms: Vec<RandomSetting>,
    /// The effects in order of application.
    pub effects: Vec<EffectInstance>,
    /// Which names of the model stand for those of the library.
    pub roles: Roles,
    /// Inputs (of `assembly.names.inputs`) that are the components of one attitude, w first.
    pub attitudes: Vec<[usize; 4]>,
}

/// What is known of a parameter in one setup.
#[derive(Clone, Debug)]
pub struct OfSetup {
    /// Name of the setup.
    pub setup: String,
    /// The parameter, by its index.
    pub parameter: usize,
    /// What is known of it there.
    pub setting: Setting,
}

impl System {
    /// The input that the library calls so, or that stands for it.
    pub fn input(&self, name: &str) -> Option<usize> {
        let called = self.roles.get(name).map_or(name, |role| role.owner.as_str());
        self.assembly.names.inputs.iter().position(|input| input.name == called)
    }

    /// What is known of a parameter in a setup.
    pub fn setting_in(&self, parameter: usize, setup: &str) -> &Setting {
        let own = |one: &&OfSetup| one.parameter == parameter && one.setup == setup;
        self.of_setups.iter().find(own).map_or(&self.settings[parameter], |one| &one.setting)
    }

    /// What is known of a parameter, everywhere and in single setups, to be changed.
    pub fn settings_mut(&mut self, parameter: usize) -> impl Iterator<Item = &mut Setting> {
        let own = self.of_setups.iter_mut().filter(move |one| one.parameter == parameter);
        self.settings.get_mut(parameter).into_iter().chain(own.map(|one| &mut one.setting))
    }
}

/// Where a parameter comes from.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Declared {
    /// Index in [`System::effects`]; `None` for the model's own.
    pub effect: Option<usize>,
    /// Its name in its file.
    pub local: String,
    /// Measurands (by index) whose delay it is.
    pub delay_of: Vec<usize>,
    /// The measurand (by index) for which it is, of an effect's parameter with `per = "measurand"`.
    pub measurand: Option<usize>,
    /// In words.
    pub about: String,
    /// The keys (`value`, `sigma`, ...) that a campaign or the command line states of it, over its
    /// declaration, each with its place if that is a file.
    pub stated: BTreeMap<&'static str, Option<Place>>,
}

/// What is known of a random quantity. Its mean is zero; estimated is its standard deviation.
#[derive(Clone, Debug)]
pub struct RandomSetting {
    /// `arm_angle.error`, `timestamp_jitter.jitter`.
    pub name: String,
    /// Unit of its standard deviation (of a walk: per square root of time).
    pub unit: Unit,
    /// Stated standard deviation (SI).
    pub sigma: Option<f64>,
    /// Magnitude such rigs show (SI).
    pub typical: Option<f64>,
    /// Correlation from sample to sample.
    pub process: Process,
    /// Distribution.
    pub shape: Shape,
    /// Memory time (s) of [`Process::Memory`].
    pub memory: Option<f64>,
    /// The effect (as in [`EffectInstance::name`]) to which it belongs; `None` for the model's own.
    pub effect: Option<String>,
    /// The standard deviation is not estimated.
    pub fixed: bool,
    /// Always [`Scope::Sample`]: one draw a sample.
    pub scope: Scope,
    /// In words.
    pub about: String,
}

/// An effect as it is applied.
#[derive(Clone, Debug)]
pub struct EffectInstance {
    /// `collimation`, at a head `collimation.a`; where a family is there more than once
    /// `encoder_high_harmonic[order=5]`.
    pub name: String,
    /// The effect.
    pub effect: Arc<Effect>,
    /// The head.
    pub head: Option<String>,
    /// Members in use (SI) by family.
    pub member: BTreeMap<String, f64>,
    /// Its parameters, by index.
    pub parameters: Vec<usize>,
    /// Its randoms, by index.
    pub randoms: Vec<usize>,
}
