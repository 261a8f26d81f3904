//! Columns of changes under autocorrelated noise.
//!
//! A change that acts from a sample on is whitened from there on: the filter has seen nothing of it before.
//! Let `p` be the states of the whole column as predicted for that sample. The column of the change is the
//! whole one's from there on plus `h_k = w_k eᵀ δ_k`, where `δ` begins as `p` and follows
//! `δ_{k+1} = D_{k+1} (I - K_k eᵀ) δ_k` (`D` the decays, `K` the gains, `w` the weight of a reading, `e`
//! ones). At a step that is the difference between a spike and nothing.
//!
//! [`Onsets`] sums the correction of the products of columns for all moments at once, with the adjoint of
//! the recursion, backwards over each block of the filter. Sample by sample it is
//! [`Masked`](crate::diagnose::budget::masked::Masked).

use nalgebra::DMatrix;

use crate::diagnose::budget::rows::Values;
use crate::engine::gauss_markov::{BEGIN, Gains, States};

/// A reading in a block of the filter.
struct Reading {
    bin: usize,
    gains: Gains,
    weight: f64,
    /// Of the model's columns and the residual, and of the bases.
    columns: Vec<f64>,
    bases: Vec<f64>,
}

/// For each base what beginning with a bin adds to its products with the model's columns and the
/// residual, to its squared length, and its product with what a column that began long before has there
/// in its place: of one that began while the filter remembers it the product is smaller.
pub(super) struct Onsets {
    /// Readings of the blocks in progress, by residual component.
    blocks: Vec<Vec<Reading>>,
    /// A column for each bin.
    pub(super) added: Vec<DMatrix<f64>>,
}

impl Onsets {
    /// Of models with so many columns.
    pub(super) fn new(columns: usize, bases: usize, bins: usize) -> Self {
        let added = (0..bases).map(|_| DMatrix::zeros(columns + 3, bins)).collect();
        Self { blocks: Vec::new(), added }
    }

    /// Takes a reading with its bin and weight.
    pub(super) fn see(&mut self, values: &Values<'_>, bin: usize, weight: f64) {
        let Some(gains) = values.gains.copied() else { return };
        self.blocks.resize_with(self.blocks.len().max(values.row + 1), Vec::new);
        if gains.decay == BEGIN {
            let block = std::mem::take(&mut self.blocks[values.row]);
            self.add(&block);
        }
        let columns = values.model.iter().copied().chain([values.residual]).collect();
        let bases = values.further.to_vec();
        self.blocks[values.row].push(Reading { bin, gains, weight, columns, bases });
    }

    /// Takes the last blocks.
    pub(super) fn finish(&mut self) {
        for block in std::mem::take(&mut self.blocks) {
            self.add(&block);
        }
    }

    fn add(&mut self, block: &[Reading]) {
        let Some(last) = block.last() else { return };
        // Predicted states of each base at the readings with which bins begin.
        let mut states = vec![BEGIN; last.bases.len()];
        let foreseen: Vec<Option<Vec<States>>> = (0..block.len())
            .map(|k| {
                let Reading { bin, gains, bases, .. } = &block[k];
                let faded = |state: &States| [gains.decay[0] * state[0], gains.decay[1] * state[1]];
                let begins = k > 0 && block[k - 1].bin < *bin;
                let before = begins.then(|| states.iter().map(faded).collect());
                for (state, whitened) in states.iter_mut().zip(bases) {
                    gains.undo(state, *whitened);
                }
                before
            })
            .collect();
        let mut of_columns = vec![BEGIN; last.columns.len()];
        let mut of_bases = vec![BEGIN; last.bases.len()];
        let mut square = [[0.0; 2]; 2];
        let mut decay = BEGIN;
        for (k, reading) in block.iter().enumerate().rev() {
            let Reading { bin, gains, weight, columns, bases } = reading;
            let back = |adjoint: &mut States, value: f64| {
                let faded = [decay[0] * adjoint[0], decay[1] * adjoint[1]];
                let follows = gains.gain[0] * faded[0] + gains.gain[1] * faded[1];
                *adjoint = faded.map(|one| one - follows + gains.weight * value);
            };
            of_columns.iter_mut().zip(columns).for_each(|(one, value)| back(one, *value));
            of_bases.iter_mut().zip(bases).for_each(|(one, value)| back(one, *value));
            square = squared(square, decay, gains);
            decay = gains.decay;
            let Some(foreseen) = &foreseen[k] else { continue };
            let first = block[k - 1].bin + 1;
            for ((p, of_base), added) in foreseen.iter().zip(&of_bases).zip(&mut self.added) {
                if *p == BEGIN {
                    continue;
                }
                let n = columns.len();
                let once = weight * dot(p, of_base);
                let both = weight * dot(p, &square.map(|row| dot(&row, p)));
                for bin in first..=*bin {
                    let mut column = added.column_mut(bin);
                    for (sum, adjoint) in column.iter_mut().zip(&of_columns) {
                        *sum += weight * dot(p, adjoint);
                    }
                    column[n] += 2.0 * once + both;
                    column[n + 1] += once + both;
                }
            }
        }
    }
}

fn dot(a: &States, b: &States) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// The squared length of what states leave, one reading further back: `Fᵀ M F + w² e eᵀ`.
fn squared(later: [[f64; 2]; 2], decay: States, gains: &Gains) -> [[f64; 2]; 2] {
    let faded = |i: usize, j: usize| decay[i] * decay[j] * later[i][j];
    let m = [[faded(0, 0), faded(0, 1)], [faded(1, 0), faded(1, 1)]];
    let along = m.map(|row| dot(&row, &gains.gain));
    let whole = dot(&along, &gains.gain) + gains.weight * gains.weight;
    let own = |i: usize, j: usize| m[i][j] - along[i] - along[j] + whole;
    [[own(0, 0), own(0, 1)], [own(1, 0), own(1, 1)]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::budget::masked::Masked;
    use crate::engine::gauss_markov::{GaussMarkov, Process};

    const READINGS: usize = 60;
    /// Samples of a block of the filter, and of a bin.
    const BLOCK: usize = 35;
    const BIN: usize = 6;

    /// What is added to running sums of the whole column makes them those of the column that is whitened
    /// from the first sample of each bin on, over blocks, missing readings and unequal weights.
    #[test]
    fn sums_are_those_of_the_columns_that_begin_there() {
        let noise =
            GaussMarkov::two(Process { share: 0.3, time: 2.0 }, Process { share: 0.5, time: 15.0 });
        let value = |k: usize, phase: f64| (0.37 * k as f64 + phase).sin() + 0.4;
        let mut gains: Vec<Gains> = Vec::new();
        let mut filter = noise.filter();
        for k in 0..READINGS {
            if k == BLOCK {
                filter = noise.filter();
            }
            // A bin begins with a reading that is missing.
            gains.push(filter.next(1.3 * k as f64, k % 11 != 0 || k == 0));
        }
        let whitened = |phase: f64| -> Vec<f64> {
            let mut states = BEGIN;
            gains
                .iter()
                .enumerate()
                .map(|(k, own)| own.take(&mut states, value(k, phase)))
                .collect()
        };
        let [first, second, residual] = [0.0, 1.1, 2.3].map(whitened);
        let bases = [whitened(3.1), whitened(4.5)];
        let weight = 0.7;
        let mut onsets = Onsets::new(2, 2, READINGS.div_ceil(BIN));
        for k in (0..READINGS).filter(|k| gains[*k].weight > 0.0) {
            let values = Values {
                run: 0,
                sample: k,
                row: 0,
                measurand: 0,
                time: k as f64,
                model: &[first[k], second[k]],
                further: &[bases[0][k], bases[1][k]],
                residual: residual[k],
                gains: Some(&gains[k]),
            };
            onsets.see(&values, k / BIN, weight);
        }
        onsets.finish();
        for (base, added) in bases.iter().zip(&onsets.added) {
            for bin in 0..READINGS.div_ceil(BIN) {
                let mut masked = Masked::default();
                let (mut due, mut whole) = ([0.0; 4], [0.0; 4]);
                for k in (0..READINGS).filter(|k| gains[*k].weight > 0.0) {
                    let acts = k >= bin * BIN;
                    let own = masked.next(Some(&gains[k]), base[k], acts);
                    let columns = [first[k], second[k], residual[k]];
                    for (at, column) in columns.iter().enumerate() {
                        due[at] += weight * own * column;
                        whole[at] += if acts { weight * base[k] * column } else { 0.0 };
                    }
                    due[3] += weight * own * own;
                    whole[3] += if acts { weight * base[k] * base[k] } else { 0.0 };
                }
                for at in 0..4 {
                    let found = whole[at] + added[(at, bin)];
                    assert!((found - due[at]).abs() < 1e-10, "{bin} {at}: {found} {}", due[at]);
                }
            }
        }
    }
}
