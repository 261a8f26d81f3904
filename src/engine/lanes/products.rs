//! Sums of products of columns over chunks: the Gram matrix of one row of every sample.
//!
//! Tiles of 4 by 3 sums stay in registers while the chunk runs through them; each sum has as many
//! partial sums as a register holds numbers, which are added up at the end. So a product costs one
//! multiply-add, which is the least it can.

use crate::engine::lanes::arithmetic::{Arithmetic, LANES, Lanes};
use crate::engine::lanes::dispatch::{InstructionSet, Task};

/// Rows of a tile.
const ROWS: usize = 4;
/// Columns of a tile.
const COLUMNS: usize = 3;
/// Partial sums kept of each sum: as many numbers as the widest register holds.
const PARTS: usize = 8;

/// Sums of products of every pair of `count` columns.
#[derive(Clone, Debug)]
pub struct Products {
    count: usize,
    /// `[i][j][part]`; filled for `i <= j`.
    sums: Vec<f64>,
}

impl Products {
    /// Of this many columns; all zero.
    pub fn new(count: usize) -> Self {
        Self { count, sums: vec![0.0; count * count * PARTS] }
    }

    /// Number of columns.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Adds the products of a chunk; one column each.
    pub fn add(&mut self, set: InstructionSet, columns: &[&Lanes]) {
        debug_assert_eq!(columns.len(), self.count);
        set.run(Adding { columns, sums: &mut self.sums });
    }

    /// The sum for a pair of columns.
    pub fn sum(&self, i: usize, j: usize) -> f64 {
        let at = (i.min(j) * self.count + i.max(j)) * PARTS;
        self.sums[at..at + PARTS].iter().sum()
    }

    /// Forgets what was added.
    pub fn clear(&mut self) {
        self.sums.fill(0.0);
    }
}

struct Adding<'a> {
    columns: &'a [&'a Lanes],
    sums: &'a mut [f64],
}

impl Task for Adding<'_> {
    type Output = ();

    #[inline(always)]
    fn run<A: Arithmetic, const WIDTH: usize>(self) {
        let Self { columns, sums } = self;
        let count = columns.len();
        let mut i = 0;
        while i < count {
            let rows = ROWS.min(count - i);
            let mut j = i;
            while j < count {
                let across = COLUMNS.min(count - j);
                let at = (i, j, count);
                match (rows, across) {
                    (1, 1) => tile::<A, WIDTH, 1, 1>(columns, sums, at),
                    (1, 2) => tile::<A, WIDTH, 1, 2>(columns, sums, at),
                    (1, _) => tile::<A, WIDTH, 1, 3>(columns, sums, at),
                    (2, 1) => tile::<A, WIDTH, 2, 1>(columns, sums, at),
                    (2, 2) => tile::<A, WIDTH, 2, 2>(columns, sums, at),
                    (2, _) => tile::<A, WIDTH, 2, 3>(columns, sums, at),
                    (3, 1) => tile::<A, WIDTH, 3, 1>(columns, sums, at),
                    (3, 2) => tile::<A, WIDTH, 3, 2>(columns, sums, at),
                    (3, _) => tile::<A, WIDTH, 3, 3>(columns, sums, at),
                    (_, 1) => tile::<A, WIDTH, 4, 1>(columns, sums, at),
                    (_, 2) => tile::<A, WIDTH, 4, 2>(columns, sums, at),
                    (_, _) => tile::<A, WIDTH, 4, 3>(columns, sums, at),
                }
                j += across;
            }
            i += rows;
        }
    }
}

#[expect(clippy::needless_range_loop, reason = "indices say which pair is meant")]
/// Adds `R` times `C` products from row `i` and column `j`.
#[inline(always)]
fn tile<A: Arithmetic, const WIDTH: usize, const R: usize, const C: usize>(
    columns: &[&Lanes],
    sums: &mut [f64],
    (i, j, count): (usize, usize, usize),
) {
    let down: [&[[f64; WIDTH]]; R] = std::array::from_fn(|r| columns[i + r].as_chunks().0);
    let across: [&[[f64; WIDTH]]; C] = std::array::from_fn(|c| columns[j + c].as_chunks().0);
    let mut tile = [[[0.0; WIDTH]; C]; R];
    for r in 0..R {
        for c in 0..C {
            let at = ((i + r) * count + j + c) * PARTS;
            tile[r][c].copy_from_slice(&sums[at..at + WIDTH]);
        }
    }
    for step in 0..LANES / WIDTH {
        for r in 0..R {
            let left = &down[r][step];
            for c in 0..C {
                let right = &across[c][step];
                for w in 0..WIDTH {
                    tile[r][c][w] = A::mul_add(left[w], right[w], tile[r][c][w]);
                }
            }
        }
    }
    for r in 0..R {
        for c in 0..C {
            let at = ((i + r) * count + j + c) * PARTS;
            sums[at..at + WIDTH].copy_from_slice(&tile[r][c]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pair_is_summed_on_every_instruction_set() {
        for count in 1..14 {
            let columns: Vec<Lanes> = (0..count)
                .map(|c| std::array::from_fn(|i| ((i * 7 + c * 31) % 23) as f64 - 11.0))
                .collect();
            let borrowed: Vec<&Lanes> = columns.iter().collect();
            for set in InstructionSet::available() {
                let mut products = Products::new(count);
                products.add(set, &borrowed);
                products.add(set, &borrowed);
                for i in 0..count {
                    for j in 0..count {
                        // Whole numbers: exact in any order.
                        let sum: f64 = (0..LANES).map(|l| columns[i][l] * columns[j][l]).sum();
                        assert_eq!(products.sum(i, j), 2.0 * sum, "{} {i} {j}", set.name());
                    }
                }
            }
        }
    }
}
