//! One effect as one layer of patches: heads, members of families and measurands settled.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::Arc;

use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::effect::{Effect, PatchLine, Target};
use crate::formula::Formula;
use crate::graph::{Local, MeasurandKind, Patch, PatchLayer, PatchTarget};
use crate::model::{Model, ParameterDeclaration, Roles};
use crate::system::needs::roles_at;

/// One effect at one head with its members.
#[derive(Clone, Debug)]
pub(super) struct Placed {
    pub(super) effect: Arc<Effect>,
    pub(super) head: Option<String>,
    pub(super) member: BTreeMap<String, f64>,
    pub(super) name: String,
}

impl Placed {
    fn roles(&self, model: &Model) -> Roles {
        roles_at(model, self.head.as_deref())
    }

    /// Index of the measurand that a patch calls `name`.
    fn measurand(&self, model: &Model, name: &str) -> Option<usize> {
        let roles = self.roles(model);
        let name = roles.get(name).map_or(name, |role| role.owner.as_str());
        model.measurands.iter().position(|measurand| measurand.name == name)
    }

    /// The measurands that this head reads; all without heads.
    fn own_measurands(&self, model: &Model) -> Vec<usize> {
        let all = 0..model.measurands.len();
        match self.head.as_ref().and_then(|head| model.heads.get(head)) {
            None => all.collect(),
            Some(roles) => {
                let named = |index: &usize| {
                    roles.values().any(|role| role.owner == model.measurands[*index].name)
                };
                all.filter(named).collect()
            }
        }
    }

    fn own_angles(&self, model: &Model) -> Vec<usize> {
        let mut angles = self.own_measurands(model);
        angles.retain(|index| matches!(model.measurands[*index].kind, MeasurandKind::Angle { .. }));
        angles
    }

    /// What a line of `[patch]` acts on in this model.
    fn targets(&self, model: &Model, line: &PatchLine) -> Vec<PatchTarget> {
        let name = |index: &usize| PatchTarget::Name(model.measurands[*index].name.clone());
        match &line.target {
            Target::AllTimes if self.head.is_none() => vec![PatchTarget::AllTimes],
            Target::AllTimes => {
                self.own_measurands(model).into_iter().map(PatchTarget::Time).collect()
            }
            Target::Time(name) => {
                self.measurand(model, name).map(PatchTarget::Time).into_iter().collect()
            }
            Target::Sigma(name) => {
                self.measurand(model, name).map(PatchTarget::Sigma).into_iter().collect()
            }
            Target::EachAngle => self.own_angles(model).iter().map(name).collect(),
            Target::EachAngleSigma => {
                self.own_angles(model).into_iter().map(PatchTarget::Sigma).collect()
            }
            Target::Name(name) => {
                let roles = self.roles(model);
                let name = roles.get(name).map_or(name, |role| &role.value);
                vec![PatchTarget::Name(name.clone())]
            }
        }
    }

    /// The measurands for which a `per = "measurand"` parameter acts.
    pub(super) fn measurands_of(
        &self,
        model: &Model,
        parameter: &ParameterDeclaration,
    ) -> Vec<usize> {
        let mut touched = HashSet::new();
        for line in &self.effect.patches {
            if !line.formula.root.names().iter().any(|(name, _)| *name == parameter.name) {
                continue;
            }
            for target in self.targets(model, line) {
                match target {
                    PatchTarget::AllTimes => touched.extend(0..model.measurands.len()),
                    PatchTarget::Time(index) | PatchTarget::Sigma(index) => {
                        touched.insert(index);
                    }
                    PatchTarget::Name(name) => {
                        match model.measurands.iter().position(|m| m.name == name) {
                            Some(index) => {
                                touched.insert(index);
                            }
                            None => touched.extend(0..model.measurands.len()),
                        }
                    }
                }
            }
        }
        let mut touched: Vec<usize> = touched.into_iter().collect();
        touched.sort_unstable();
        touched
    }

    /// The layer; `parameters` are the effect's own names.
    pub(super) fn layer(
        &self,
        model: &Model,
        parameters: HashMap<String, Local>,
    ) -> Result<PatchLayer, Diagnostics> {
        let mut locals: HashMap<String, Local> = HashMap::new();
        for (role, means) in self.roles(model) {
            let delay = |of: &str| format!("{of}.delay");
            locals.insert(delay(&role), Local::Name(delay(&means.owner)));
            locals.insert(role, Local::Name(means.value));
        }
        for (family, declared) in &self.effect.shape {
            let value = self.member.get(family).copied().unwrap_or(0.0);
            locals.insert(family.clone(), Local::Constant(value, declared.unit.dimension));
        }
        locals.extend(parameters);
        let mut patches: Vec<Patch> = Vec::new();
        for line in &self.effect.patches {
            for target in self.targets(model, line) {
                if patches.iter().any(|patch| overlap(&patch.target, &target)) {
                    let message = format!("`{}` is patched twice by the same effect", line.name);
                    let place = self.effect.source.place(line.span);
                    return Err(Diagnostic::error(message).at(place).into());
                }
                let formula: Formula = line.formula.clone();
                patches.push(Patch { target, formula });
            }
        }
        Ok(PatchLayer { effect: self.name.clone(), locals, patches })
    }
}

/// Whether two patches of one effect would act on the same thing.
fn overlap(a: &PatchTarget, b: &PatchTarget) -> bool {
    let time =
        |target: &PatchTarget| matches!(target, PatchTarget::AllTimes | PatchTarget::Time(_));
    a == b || (time(a) && time(b) && (*a == PatchTarget::AllTimes || *b == PatchTarget::AllTimes))
}
