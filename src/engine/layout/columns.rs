//! Columns of the normal equations for the free instances: globals first, then setups, then runs.

use super::Layout;
use super::instance::{Instance, Tangent};

/// The unknowns among which an instance has its columns: of all campaigns, of a setup, of a run.
#[derive(Clone, Copy, Debug)]
pub(super) enum Block {
    Global,
    Setup(usize),
    Run(usize),
}

impl Layout {
    /// Gives columns to the free instances: globals first, then setups, then runs.
    pub(super) fn assign(&mut self, blocks: &[Block]) {
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
