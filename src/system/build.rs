//! Puts a model, effects and overrides together.

use std::collections::{HashMap, HashSet};

use crate::campaign::quaternions;
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::graph::names::CoordinatesNames;
use crate::graph::resolve::assemble;
use crate::graph::{Input, Kind, Local, Measurand, Names, Parameter, Random, Scope};
use crate::library::unknown_parameter;
use crate::model::name::error_of_input;
use crate::model::{Model, Override, Setting};
use crate::system::layer::Placed;
use crate::system::needs::{delay_names, is_random, known_names};
use crate::system::place::place;
use crate::system::unknown::{Origin, Unknown};
use crate::system::{EffectInstance, OfSetup, Selected, System};
use crate::units::Unit;

impl System {
    /// A model with effects. The order of `effects` does not matter; `overrides` apply in their
    /// order, those of a general name before those of a special one. `input_sigma` are the standard
    /// uncertainties (SI) that a campaign states for the model's inputs, in the model's order;
    /// where there is none the model's own holds.
    ///
    /// Overrides of effects that are not among `effects` are passed over:
    /// [`crate::library::Library::check_overrides`] finds those that mean nothing at all.
    ///
    /// # Errors
    /// An effect that does not fit the model, an override of something that is not there or of the
    /// wrong dimension, a fixed parameter without value, every fault of the formulas.
    pub fn build(
        model: &Model,
        effects: &[Selected],
        overrides: &[Override],
        input_sigma: &[Option<f64>],
    ) -> Result<Self, Diagnostics> {
        let placed = place(model, effects, overrides)?;
        let mut builder = Builder { model, placed, unknowns: Vec::new(), owned: Vec::new() };
        builder.declare(input_sigma);
        Diagnostics(builder.faults_of_names()).into_result(())?;
        builder.override_all(overrides)?;
        let faults = builder.unknowns.iter().filter_map(Unknown::fault).take(50).collect();
        Diagnostics(faults).into_result(())?;
        builder.finish()
    }
}

/// A name of an effect's own.
struct Own {
    name: String,
    /// Its unknowns.
    unknowns: Vec<usize>,
    /// With `per = "measurand"`, the measurands for which they are.
    measurands: Option<Vec<usize>>,
}

struct Builder<'m> {
    model: &'m Model,
    placed: Vec<Placed>,
    unknowns: Vec<Unknown>,
    /// For each placed effect its own names.
    owned: Vec<Vec<Own>>,
}

impl Builder<'_> {
    /// Everything that is declared, in the order in which it is numbered: the errors of inputs,
    /// the model's parameters, its delays, the effects' parameters.
    fn declare(&mut self, input_sigma: &[Option<f64>]) {
        let model = self.model;
        for (index, input) in model.inputs.iter().enumerate() {
            let stated = input_sigma.get(index).copied().flatten().or(input.sigma);
            let Some(sigma) = stated else { continue };
            let mut setting = Setting::new(Scope::Sample);
            setting.fixed = true;
            setting.sigma = Some(vec![sigma]);
            let name = error_of_input(&input.name);
            let width = input.unit.of_differences();
            self.unknowns.push(Unknown::implied(name, width, setting, Origin::InputError));
        }
        for parameter in &model.parameters {
            let place = model.source.place(parameter.span);
            let name = parameter.name.clone();
            self.unknowns.push(Unknown::of(parameter, name.clone(), name, place));
        }
        let second = Unit::coherent(crate::units::Dimension::TIME);
        for name in delay_names(model) {
            let group = model.delays.iter().find(|group| format!("{}.delay", group.name) == name);
            let setting = group.map_or_else(Setting::of_delay, |group| group.setting.clone());
            let of = |index: &usize| {
                let measurand = &model.measurands[*index].name;
                match group {
                    Some(group) => group.of.contains(measurand),
                    None => name.strip_suffix(".delay") == Some(measurand),
                }
            };
            let delay_of = (0..model.measurands.len()).filter(of).collect();
            let mut unknown = Unknown::implied(name, second.clone(), setting, Origin::Delay);
            unknown.declared.delay_of = delay_of;
            unknown.place = group.map(|group| model.source.place(group.span));
            self.unknowns.push(unknown);
        }
        for (number, placed) in self.placed.iter().enumerate() {
            let mut owned = Vec::new();
            for parameter in &placed.effect.parameters {
                let place = placed.effect.source.place(parameter.span);
                let general = format!("{}.{}", placed.effect.name, parameter.name);
                let name = format!("{}.{}", placed.name, parameter.name);
                let per = parameter.per_measurand.then(|| placed.measurands_of(model, parameter));
                let first = self.unknowns.len();
                let each: Vec<Option<usize>> = match &per {
                    Some(per) => per.iter().copied().map(Some).collect(),
                    None => vec![None],
                };
                for measurand in each {
                    let name = match measurand {
                        Some(index) => format!("{name}.{}", model.measurands[index].name),
                        None => name.clone(),
                    };
                    let mut unknown = Unknown::of(parameter, name, general.clone(), place.clone());
                    unknown.declared.effect = Some(number);
                    unknown.declared.measurand = measurand;
                    unknown.memory = unknown.memory.or(placed.member.get("memory").copied());
                    self.unknowns.push(unknown);
                }
                owned.push(Own {
                    name: parameter.name.clone(),
                    unknowns: (first..self.unknowns.len()).collect(),
                    measurands: per,
                });
            }
            self.owned.push(owned);
        }
    }

    /// Two unknowns of one name: an effect called like an input or a measurand.
    fn faults_of_names(&self) -> Vec<Diagnostic> {
        let mut seen = HashSet::new();
        let twice = self.unknowns.iter().filter(|unknown| !seen.insert(unknown.name.as_str()));
        let say = |unknown: &Unknown| {
            let error = Diagnostic::error(format!("there are two parameters `{}`", unknown.name));
            error
                .at_maybe(unknown.place.as_ref())
                .help("choose another name for this effect or parameter")
        };
        twice.map(say).take(50).collect()
    }

    fn override_all(&mut self, overrides: &[Override]) -> Result<(), Diagnostics> {
        let mut faults = Vec::new();
        let (mut general, mut special) = (Vec::new(), Vec::new());
        let own = self.model.overrides.iter().map(|said| (said, false));
        for (said, is_stated) in own.chain(overrides.iter().map(|said| (said, true))) {
            let exact = self.unknowns.iter().any(|unknown| unknown.is_meant_by(said));
            let some = exact || self.unknowns.iter().any(|unknown| matches_general(unknown, said));
            match (exact, some) {
                (true, _) => special.push((said, is_stated)),
                (false, true) => general.push((said, is_stated)),
                (false, false) if self.is_passed_over(said) => {}
                _ => {
                    let effects = self.placed.iter().map(|placed| &placed.effect);
                    faults.push(unknown_parameter(said, &known_names(self.model, effects)));
                }
            }
        }
        general.sort_by_key(|(said, _)| said.name.matches('.').count());
        for (said, is_stated) in general {
            for unknown in self.unknowns.iter_mut().filter(|one| matches_general(one, said)) {
                faults.extend(unknown.apply(said, is_stated).err().map(|fault| *fault));
            }
        }
        // What is said of a component counts over what the same file, or the command line, says of
        // all of the vector.
        let is_vector = |said: &Override| {
            self.unknowns.iter().any(|one| one.kind == Kind::Vector && one.is_meant_by(said))
        };
        special.sort_by_cached_key(|(said, _)| {
            let is_of_component = self.unknowns.iter().all(|one| one.name != said.name);
            if is_vector(said) { (said.place.is_none(), is_of_component) } else { (false, false) }
        });
        for (said, is_stated) in special {
            for unknown in self.unknowns.iter_mut().filter(|unknown| unknown.is_meant_by(said)) {
                faults.extend(unknown.apply(said, is_stated).err().map(|fault| *fault));
            }
        }
        faults.dedup();
        faults.truncate(50);
        Diagnostics(faults).into_result(())
    }

    /// Whether an override means a family, an effect that is not applied, or an input whose error
    /// nobody stated.
    fn is_passed_over(&self, said: &Override) -> bool {
        let Some((owner, rest)) = said.name.split_once('.') else { return false };
        let model = self.model;
        if let Some(placed) = self.placed.iter().find(|placed| placed.effect.name == owner) {
            let last = rest.rsplit('.').next().unwrap_or(rest);
            return placed.effect.shape.contains_key(last);
        }
        let own = model.measurands.iter().any(|one| one.name == owner)
            || model.delays.iter().any(|one| one.name == owner)
            || model.inputs.iter().any(|one| one.name == owner)
            || model.parameters.iter().any(|one| one.name == owner);
        !own && rest != "delay"
    }

    fn finish(self) -> Result<System, Diagnostics> {
        let Self { model, placed, unknowns, owned } = self;
        let mut names = Names { quantities: model.quantities.clone(), ..Names::default() };
        let (mut settings, mut declared, mut randoms) = (Vec::new(), Vec::new(), Vec::new());
        let mut of_setups = Vec::new();
        // Where each unknown went: random or parameter, by index.
        let mut places: Vec<(bool, usize)> = Vec::with_capacity(unknowns.len());
        for unknown in &unknowns {
            let random = is_random(unknown.setting.scope);
            places
                .push((random, if random { names.randoms.len() } else { names.parameters.len() }));
            if random {
                let dimension = unknown.dimension_of_draw();
                names.randoms.push(Random { name: unknown.name.clone(), dimension });
                let effect = unknown.declared.effect.map(|number| placed[number].name.clone());
                randoms.push(unknown.random(effect));
            } else {
                let (name, unit) = (unknown.name.clone(), unknown.unit.clone());
                names.parameters.push(Parameter { name, kind: unknown.kind, unit });
                of_setups.extend(unknown.of_setups.iter().map(|(setup, own)| OfSetup {
                    setup: setup.clone(),
                    parameter: settings.len(),
                    setting: own.setting.clone(),
                }));
                settings.push(unknown.setting.clone());
                declared.push(unknown.declared.clone());
            }
        }
        for input in &model.inputs {
            let error = error_of_input(&input.name);
            names.inputs.push(Input {
                name: input.name.clone(),
                unit: input.unit.clone(),
                signal: input.signal,
                error: names.randoms.iter().position(|random| random.name == error),
            });
        }
        for (index, measurand) in model.measurands.iter().enumerate() {
            let delay = declared.iter().position(|declared| declared.delay_of.contains(&index));
            names.measurands.push(Measurand {
                name: measurand.name.clone(),
                formula: measurand.formula.clone(),
                kind: measurand.kind,
                unit: measurand.unit.clone(),
                sigma: measurand.sigma_formula.clone(),
                delay: delay.unwrap_or(0),
            });
        }
        let mut effects = Vec::with_capacity(placed.len());
        let mut faults = Vec::new();
        for (placed, owned) in placed.iter().zip(&owned) {
            let mut locals = HashMap::new();
            let mut instance = EffectInstance {
                name: placed.name.clone(),
                effect: placed.effect.clone(),
                head: placed.head.clone(),
                member: placed.member.clone(),
                parameters: Vec::new(),
                randoms: Vec::new(),
            };
            for Own { name: local, unknowns: indices, measurands: per } in owned {
                let went: Vec<(bool, usize)> = indices.iter().map(|index| places[*index]).collect();
                for (random, index) in &went {
                    if *random {
                        instance.randoms.push(*index)
                    } else {
                        instance.parameters.push(*index)
                    }
                }
                match local_of(&went, per.as_deref(), model.measurands.len()) {
                    Some(meaning) => {
                        locals.insert(local.clone(), meaning);
                    }
                    None if went.is_empty() => {}
                    None => faults.push(Diagnostic::error(format!(
                        "`{}.{local}` must be random for all measurands or for none",
                        placed.name
                    ))),
                }
            }
            match placed.layer(model, locals) {
                Ok(layer) => names.layers.push(layer),
                Err(fault) => faults.extend(fault.0),
            }
            effects.push(instance);
        }
        if let Some(declared) = &model.coordinates {
            let index =
                |name: &str| names.parameters.iter().position(|parameter| parameter.name == name);
            if let (Some(rotation), Some(translation)) =
                (index(&declared.rotation), index(&declared.translation))
            {
                names.coordinates = Some(CoordinatesNames {
                    from: declared.from.clone(),
                    measured: declared.measured.clone(),
                    gap: declared.gap.clone(),
                    helpers: declared.helpers.clone(),
                    rotation,
                    translation,
                });
            }
        }
        Diagnostics(faults).into_result(())?;
        let (assembly, roles) = (assemble(names)?, model.roles.clone());
        let place = |name: String| model.inputs.iter().position(|input| input.name == name);
        let quadruple = |names: [String; 4]| {
            let [w, x, y, z] = names.map(place);
            Some([w?, x?, y?, z?])
        };
        let attitudes = quaternions(model).into_iter().filter_map(quadruple).collect();
        Ok(System { assembly, settings, of_setups, declared, randoms, effects, roles, attitudes })
    }
}

/// Whether `EFFECT.NAME` or `EFFECT.HEAD.NAME` means this unknown, or a component of it, among
/// others.
fn matches_general(unknown: &Unknown, said: &Override) -> bool {
    if unknown.declared.effect.is_none() {
        return false;
    }
    let name = &said.name;
    unknown.general == *name
        || unknown.has_component(said, &unknown.general)
        || (unknown.declared.measurand.is_some()
            && unknown.name.rsplit_once('.').is_some_and(|(owner, _)| owner == *name))
}

/// What an effect's own name stands for. A measurand on which it does not act takes the first
/// one's: no formula asks for it.
fn local_of(went: &[(bool, usize)], per: Option<&[usize]>, measurands: usize) -> Option<Local> {
    let (random, first) = *went.first()?;
    let Some(per) = per else {
        return Some(if random { Local::Random(first) } else { Local::Parameter(first) });
    };
    if went.iter().any(|(other, _)| *other != random) {
        return None;
    }
    let mut table = vec![first; measurands];
    for (measurand, (_, index)) in per.iter().zip(went) {
        if let Some(place) = table.get_mut(*measurand) {
            *place = *index;
        }
    }
    Some(if random { Local::RandomPerMeasurand(table) } else { Local::PerMeasurand(table) })
}
