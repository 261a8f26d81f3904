//! Which unknowns there are: every parameter's instances over its scope, and their columns.
//!
//! A parameter of scope setup has one instance for each setup, and so on; campaigns that name the
//! same instrument or rig share the instances of that scope. Free instances own columns of the
//! normal equations: one for a scalar, three for a vector or a rotation (its tangent space).
//! Parameters whose values sum to zero over their scope share n - 1 columns of contrasts.

use std::collections::{BTreeSet, HashMap};

use crate::campaign::timing::enter::EFFECT;
use crate::diagnostic::Diagnostic;
use crate::engine::gram::{Columns, UNBOUNDED};
use crate::engine::shared::{Combined, Statement, combined};
use crate::graph::{Kind, Leaf, Node, NodeId, Scope};
use crate::model::Setting;
use crate::system::System;
use crate::units::Unit;

/// One value of one parameter.
#[derive(Clone, Debug)]
pub struct Instance {
    /// The parameter's full name.
    pub name: String,
    /// Scalar, vector or rotation.
    pub kind: Kind,
    /// Unit it is declared in.
    pub unit: Unit,
    /// What is known of it.
    pub setting: Setting,
    /// The setup or run it holds for; for rig and instrument the campaign where several are told
    /// apart by labels, their own name where there are several of them, else `None`.
    pub of: Option<String>,
    /// The rig or instrument that it belongs to, where that has a name.
    pub owner: Option<String>,
    /// How its tangent components follow from the columns.
    pub tangent: Tangent,
    /// Whether it acts on noise alone: then it is a level, not an unknown of least squares.
    pub noise_only: bool,
    /// Whether its start was found by a search: nobody stated it.
    pub start_found: bool,
}

impl Instance {
    /// Whether it is the delay of measurands.
    pub fn is_delay(&self) -> bool {
        self.name.ends_with(".delay")
    }

    /// Number of tangent components: 1 for a scalar, 3 for a vector or a rotation.
    pub fn dimension(&self) -> usize {
        self.kind.dimension()
    }

    /// The components that are estimated.
    fn free_components(&self) -> impl Iterator<Item = usize> {
        (0..self.dimension()).filter(|component| !self.setting.is_fixed(*component))
    }

    /// Whose it is, by any name: of its rig or instrument, else of what it holds for.
    pub fn whose(&self) -> Option<&str> {
        self.owner.as_deref().or(self.of.as_deref())
    }
}

/// How an instance follows from the columns.
#[derive(Clone, Debug, PartialEq)]
pub enum Tangent {
    /// It does not: it is fixed.
    Fixed,
    /// Component `i` is column `start + i`.
    Columns(usize),
    /// Component `i` is that column; it is fixed where there is none.
    Components([Option<usize>; 3]),
    /// Component `i` is `Σ_j coefficients[j] · column[start + j * dimension + i]`.
    Contrast {
        /// First column of the contrasts.
        start: usize,
        /// This instance's row of the contrast matrix.
        coefficients: Vec<f64>,
    },
}

/// What one campaign brings to a joint problem, as far as the layout needs it.
#[derive(Clone, Copy, Debug)]
pub struct Share<'a> {
    /// Its model with effects.
    pub system: &'a System,
    /// Name of the instrument, if stated.
    pub instrument: Option<&'a str>,
    /// Name of the rig, if stated.
    pub rig: Option<&'a str>,
    /// Its setups.
    pub setups: &'a [String],
    /// For each run, its name and its setup.
    pub runs: &'a [(String, usize)],
    /// How the campaign is called where several are used together.
    pub label: Option<&'a str>,
    /// Parameters that are held at zero in single runs: the names of the run and of the parameter.
    pub held: &'a [(String, String)],
}

/// All instances, their columns, and which instance each run of each campaign uses.
#[derive(Clone, Debug, Default)]
pub struct Layout {
    /// Every value of every parameter.
    pub instances: Vec<Instance>,
    /// The blocks of unknowns.
    pub columns: Columns,
    /// `[campaign][run][parameter]`: index of the instance.
    pub used: Vec<Vec<Vec<usize>>>,
    /// `[campaign]`: index of its first run in `columns.runs`.
    pub first_run: Vec<usize>,
    /// What campaigns that share a rig or an instrument state of its parameters and does not fit
    /// together, in the order of their names.
    pub conflicts: Vec<Diagnostic>,
}

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

    /// Gives columns to the free instances: globals first, then setups, then runs.
    fn assign(&mut self, blocks: &[Block]) {
        let free = |one: &Instance| one.free_components().next().is_some() && !one.noise_only;
        for (instance, block) in self.instances.iter().zip(blocks) {
            if free(instance) && !instance.setting.sum_zero {
                let count = instance.free_components().count();
                match *block {
                    Block::Global => self.columns.global += count,
                    Block::Setup(setup) => self.columns.setups[setup] += count,
                    Block::Run(run) => self.columns.runs[run].1 += count,
                }
            }
        }
        let mut global = 0;
        let plain_globals = self.columns.global;
        // Contrasts couple all values of their scope, so they are global.
        let mut start = plain_globals;
        for members in &self.sums_to_zero() {
            let dimension = self.instances[members[0]].dimension();
            for (row, &index) in members.iter().enumerate() {
                let coefficients = contrast_row(row, members.len());
                self.instances[index].tangent = Tangent::Contrast { start, coefficients };
            }
            start += (members.len() - 1) * dimension;
        }
        self.columns.global = start;
        let mut setups: Vec<usize> =
            (0..self.columns.setups.len()).map(|setup| self.columns.setup_start(setup)).collect();
        let mut runs: Vec<usize> =
            (0..self.columns.runs.len()).map(|run| self.columns.run_start(run)).collect();
        for (instance, block) in self.instances.iter_mut().zip(blocks) {
            if !free(instance) || instance.setting.sum_zero {
                continue;
            }
            let next = match *block {
                Block::Global => &mut global,
                Block::Setup(setup) => &mut setups[setup],
                Block::Run(run) => &mut runs[run],
            };
            let count = instance.free_components().count();
            instance.tangent = if count == instance.dimension() {
                Tangent::Columns(*next)
            } else {
                let mut columns = [None; 3];
                for (place, component) in instance.free_components().enumerate() {
                    columns[component] = Some(*next + place);
                }
                Tangent::Components(columns)
            };
            *next += count;
        }
    }

    /// The free instances of each parameter whose values sum to zero over their scope.
    pub fn sums_to_zero(&self) -> Vec<Vec<usize>> {
        let mut groups: Vec<(&str, Vec<usize>)> = Vec::new();
        for (index, one) in self.instances.iter().enumerate() {
            if one.setting.fixed || one.noise_only || !one.setting.sum_zero {
                continue;
            }
            match groups.iter_mut().find(|(name, _)| *name == one.name) {
                Some((_, members)) => members.push(index),
                None => groups.push((&one.name, vec![index])),
            }
        }
        groups.into_iter().map(|(_, members)| members).collect()
    }

    /// Whether an instance acts on noise alone.
    pub fn is_noise_only(&self, instance: usize) -> bool {
        self.instances[instance].noise_only
    }

    /// The instance that a parameter (by name) has in a run of a campaign.
    pub fn instance_in(&self, campaign: usize, run: usize, parameter: usize) -> usize {
        self.used[campaign][run][parameter]
    }

    /// The columns that move an instance's tangent component, with their coefficients.
    pub fn columns_of(&self, instance: usize, component: usize) -> Vec<(usize, f64)> {
        let instance = &self.instances[instance];
        match &instance.tangent {
            Tangent::Fixed => Vec::new(),
            Tangent::Columns(start) => vec![(start + component, 1.0)],
            Tangent::Components(columns) => columns
                .get(component)
                .copied()
                .flatten()
                .map(|column| (column, 1.0))
                .into_iter()
                .collect(),
            Tangent::Contrast { start, coefficients } => coefficients
                .iter()
                .enumerate()
                .map(|(j, coefficient)| {
                    (start + j * instance.dimension() + component, *coefficient)
                })
                .collect(),
        }
    }

    /// The bounds of a component of a plain free instance (SI); infinite where there are none.
    pub fn bounds_of(&self, instance: usize, component: usize) -> (f64, f64) {
        let Instance { kind, setting, .. } = &self.instances[instance];
        let is_own = self.own_columns(instance).any(|(own, _)| own == component);
        if *kind == Kind::Rotation || !is_own {
            return UNBOUNDED;
        }
        setting.bounds_of(component)
    }

    /// The free components of a plain instance with their columns; none if it is fixed or a
    /// contrast.
    pub fn own_columns(&self, instance: usize) -> impl Iterator<Item = (usize, usize)> {
        let columns = match self.instances[instance].tangent {
            Tangent::Columns(start) => [0, 1, 2].map(|component| Some(start + component)),
            Tangent::Components(columns) => columns,
            Tangent::Fixed | Tangent::Contrast { .. } => [None; 3],
        };
        let count = self.instances[instance].dimension();
        let all = columns.into_iter().enumerate().take(count);
        all.filter_map(|(component, column)| Some((component, column?)))
    }

    /// Whether a plain instance, or a component of it, is estimated.
    pub fn is_free(&self, instance: usize) -> bool {
        self.own_columns(instance).next().is_some()
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

#[derive(Clone, Copy, Debug)]
enum Block {
    Global,
    Setup(usize),
    Run(usize),
}

/// A name with the label of its campaign, where there are several campaigns.
pub fn qualified(label: Option<&str>, name: &str) -> String {
    label.map_or_else(|| name.to_owned(), |label| format!("{label}/{name}"))
}

/// Row `row` of the orthonormal Helmert contrasts of `count` values: `count - 1` numbers, every
/// column sums to zero.
fn contrast_row(row: usize, count: usize) -> Vec<f64> {
    (1..count)
        .map(|k| {
            let scale = 1.0 / ((k * (k + 1)) as f64).sqrt();
            match row.cmp(&k) {
                std::cmp::Ordering::Less => scale,
                std::cmp::Ordering::Equal => -(k as f64) * scale,
                std::cmp::Ordering::Greater => 0.0,
            }
        })
        .collect()
}
