//! Whose values there are: an instance for each holder of a parameter, which campaigns may share.

use std::collections::{BTreeSet, HashMap};

use super::columns::Block;
use super::instance::{Instance, Tangent};
use super::{Layout, Share, qualified};
use crate::campaign::timing::enter::EFFECT;
use crate::engine::shared::statement::Statement;
use crate::engine::shared::{Combined, combined};
use crate::graph::{Leaf, Node, NodeId, Scope};
use crate::system::System;

/// What makes two instances the same one.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Holder {
    Named(Scope, String),
    /// Of a rig with this name, the offset of reference times of timing chains whose standard
    /// uncertainty has these bits, if it is not zero.
    Chain(Scope, String, Option<u64>),
    Campaign(Scope, usize),
    Setup(usize, usize),
    Run(usize, usize),
}

impl Layout {
    /// Lays out the unknowns of one or several campaigns.
    pub fn new(shares: &[Share<'_>]) -> Self {
        let mut layout = Self::default();
        let mut known: HashMap<(String, Holder), usize> = HashMap::new();
        let mut blocks: Vec<Block> = Vec::new();
        // What each campaign states of each instance that several may share.
        let mut statements: Vec<Vec<Statement<'_>>> = Vec::new();
        let mut first_setup = 0;
        let mut first_run = 0;
        for (number, share) in shares.iter().enumerate() {
            let noise_only = noise_only(share.system);
            layout.first_run.push(first_run);
            let mut used = Vec::with_capacity(share.runs.len());
            for (run, (run_name, setup)) in share.runs.iter().enumerate() {
                let mut row = Vec::with_capacity(share.system.settings.len());
                let parameters = &share.system.assembly.names.parameters;
                for (index, (parameter, noise_only)) in
                    parameters.iter().zip(&noise_only).enumerate()
                {
                    let setting = share.system.setting_in(index, &share.setups[*setup]);
                    let (holder, of, block) = match setting.scope {
                        Scope::Rig | Scope::Instrument => {
                            let name = if setting.scope == Scope::Rig {
                                share.rig
                            } else {
                                share.instrument
                            };
                            let holder = match name {
                                Some(name) if is_chain(share.system, index) => Holder::Chain(
                                    setting.scope,
                                    name.to_owned(),
                                    setting.sigma.as_ref().map(|sigma| sigma[0].to_bits()),
                                ),
                                Some(name) => Holder::Named(setting.scope, name.to_owned()),
                                None => Holder::Campaign(setting.scope, number),
                            };
                            let of =
                                if name.is_none() { share.label.map(str::to_owned) } else { None };
                            (holder, of, Block::Global)
                        }
                        Scope::Setup => (
                            Holder::Setup(number, *setup),
                            Some(qualified(share.label, &share.setups[*setup])),
                            Block::Setup(first_setup + setup),
                        ),
                        Scope::Run | Scope::Sample => (
                            Holder::Run(number, run),
                            Some(qualified(share.label, run_name)),
                            Block::Run(first_run + run),
                        ),
                    };
                    let owner = match &holder {
                        Holder::Named(_, name) | Holder::Chain(_, name, _) => Some(name.clone()),
                        _ => None,
                    };
                    let statement = Statement {
                        label: share.label.unwrap_or_default(),
                        system: share.system,
                        parameter: index,
                    };
                    let index =
                        *known.entry((parameter.name.clone(), holder)).or_insert_with(|| {
                            let mut setting = setting.clone();
                            let mut held = share.held.iter();
                            if held.any(|(own, name)| own == run_name && *name == parameter.name) {
                                setting.hold_at(vec![0.0; parameter.kind.dimension()]);
                            }
                            layout.instances.push(Instance {
                                name: parameter.name.clone(),
                                kind: parameter.kind,
                                unit: parameter.unit.clone(),
                                setting,
                                of,
                                owner,
                                tangent: Tangent::Fixed,
                                noise_only: *noise_only,
                                start_found: false,
                                stated_start: None,
                            });
                            blocks.push(block);
                            statements.push(Vec::new());
                            layout.instances.len() - 1
                        });
                    let stated = &mut statements[index];
                    if layout.instances[index].owner.is_some()
                        && stated.last().is_none_or(|last| !std::ptr::eq(last.system, share.system))
                    {
                        stated.push(statement);
                        layout.instances[index].noise_only &= *noise_only;
                    }
                    row.push(index);
                }
                used.push(row);
            }
            layout.used.push(used);
            layout
                .columns
                .runs
                .extend(share.runs.iter().map(|(_, setup)| (first_setup + setup, 0)));
            first_setup += share.setups.len();
            first_run += share.runs.len();
        }
        layout.combine(&statements);
        layout.name_owners();
        layout.name_chains(&statements);
        layout.columns.setups = vec![0; first_setup];
        layout.assign(&blocks);
        layout
    }

    /// Gives each instance that several campaigns share the setting that all of them state.
    fn combine(&mut self, statements: &[Vec<Statement<'_>>]) {
        let shared = self.instances.iter_mut().zip(statements).filter(|(_, list)| list.len() > 1);
        for (instance, list) in shared {
            let word = if instance.setting.scope == Scope::Rig { "rig" } else { "instrument" };
            let owner = format!("{word} `{}`", instance.owner.as_deref().unwrap_or_default());
            let Combined { kind, unit, setting, conflicts } =
                combined(&instance.name, &owner, list);
            (instance.kind, instance.unit, instance.setting) = (kind, unit, setting);
            self.conflicts.extend(conflicts);
        }
        self.conflicts.sort_by(|a, b| a.message.cmp(&b.message));
        self.conflicts.dedup();
    }

    /// Lets the offsets of different timing chains of a rig say whose they are.
    fn name_chains(&mut self, statements: &[Vec<Statement<'_>>]) {
        let alike = |a: &Instance, b: &Instance| a.name == b.name && a.owner == b.owner;
        let is_several = |one: &Instance| {
            one.owner.is_some()
                && self.instances.iter().filter(|other| alike(one, other)).count() > 1
        };
        let several: Vec<bool> = self.instances.iter().map(is_several).collect();
        for index in (0..several.len()).filter(|index| several[*index]) {
            let mut labels: Vec<&str> = statements[index].iter().map(|one| one.label).collect();
            labels.sort_unstable();
            self.instances[index].of = Some(labels.join(" + "));
        }
    }

    /// Lets parameters of several rigs or instruments say whose they are.
    fn name_owners(&mut self) {
        let mut owners: HashMap<&str, BTreeSet<&str>> = HashMap::new();
        for one in &self.instances {
            owners.entry(&one.name).or_default().extend(one.owner.as_deref());
        }
        let several: BTreeSet<String> = owners
            .into_iter()
            .filter(|(_, owners)| owners.len() > 1)
            .map(|(name, _)| name.to_owned())
            .collect();
        for one in &mut self.instances {
            if several.contains(&one.name) {
                one.of = one.of.take().or_else(|| one.owner.clone());
            }
        }
    }
}

/// Whether a parameter is the offset of reference times that `[timing]` of a campaign states. It
/// belongs to a timing chain: campaigns of one rig share it where their chains are equally good.
fn is_chain(system: &System, parameter: usize) -> bool {
    let effect = system.declared[parameter].effect;
    effect.is_some_and(|effect| system.effects[effect].effect.name == EFFECT)
}

/// For each parameter, whether it reaches a noise factor but no prediction.
fn noise_only(system: &System) -> Vec<bool> {
    let assembly = &system.assembly;
    let reached = |outputs: &[NodeId]| {
        let mut reached = vec![false; assembly.names.parameters.len()];
        for id in assembly.graph.needed_by(outputs) {
            if let Node::Leaf(Leaf::Parameter { parameter, .. }) = assembly.graph.node(id) {
                reached[parameter as usize] = true;
            }
        }
        reached
    };
    let values: Vec<NodeId> =
        assembly.measurands.iter().flat_map(|one| one.value.nodes().to_vec()).collect();
    let factors: Vec<NodeId> =
        assembly.measurands.iter().filter_map(|one| one.sigma_factor).collect();
    let (in_values, in_factors) = (reached(&values), reached(&factors));
    in_factors.iter().zip(in_values).map(|(noise, value)| *noise && !value).collect()
}
