//! Which unknowns there are: every parameter's instances over its scope, and their columns.
//!
//! A parameter of scope setup has one instance for each setup, and so on; campaigns that name the
//! same instrument or rig share the instances of that scope. Free instances own columns of the
//! normal equations: one for a scalar, three for a vector or a rotation (its tangent space).
//! Parameters whose values sum to zero over their scope share n - 1 columns of contrasts.

mod columns;
mod holders;
mod instance;

use crate::diagnostic::Diagnostic;
use crate::engine::gram::{Columns, UNBOUNDED};
use crate::graph::Kind;
use crate::system::System;

pub use instance::{Instance, Tangent};

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

impl Layout {
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

/// A name with the label of its campaign, where there are several campaigns.
pub fn qualified(label: Option<&str>, name: &str) -> String {
    label.map_or_else(|| name.to_owned(), |label| format!("{label}/{name}"))
}
