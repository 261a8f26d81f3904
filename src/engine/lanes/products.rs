//! Sums of products of columns over chunks: the Gram matrix of one row of every sample.
//!
//! Tiles of 4 by 3 sums (3 by 3 without fused multiply-add) stay in registers while the chunk runs through them; each sum has as many
//! partial sums as a register holds numbers, which are added up at the end. So a product costs one
//! multiply-add, which is the least it can. Where there are so many columns that partial sums would not
//! stay in the nearest caches, they are added up chunk by chunk. Columns may be in groups that want no
//! sums with each other.

use crate::engine::lanes::dispatch::Simd;

use crate::engine::lanes::arithmetic::{Arithmetic, LANES, Lanes};
use crate::engine::lanes::dispatch::{InstructionSet, Task};

/// Rows of a tile.
const ROWS: usize = 4;
/// Columns of a tile.
const COLUMNS: usize = 3;
/// With more columns partial sums are added up after each chunk.
const FEW: usize = 96;

/// Sums of products of pairs of columns.
#[derive(Clone, Debug)]
pub struct Products {
    /// For each column the end of those from itself on with which it is summed.
    ends: Vec<usize>,
    set: InstructionSet,
    /// Partial sums of each sum: as many as a register holds numbers, or one.
    parts: usize,
    /// `[i][j][part]`; filled for `i <= j < ends[i]`.
    sums: Vec<f64>,
}

impl Products {
    /// Of every pair of this many columns; all zero.
    pub fn new(count: usize, set: InstructionSet) -> Self {
        Self::grouped(&vec![0; count], set)
    }

    /// Of columns in groups, those of a group one after the other: of pairs of the same group, and of those
    /// of group 0, which is first, with all.
    pub fn grouped(groups: &[usize], set: InstructionSet) -> Self {
        debug_assert!(groups.is_sorted(), "group after group, those of 0 first");
        let count = groups.len();
        let end = |column: usize| {
            let others = groups[column..].iter().position(|group| *group != groups[column]);
            others.filter(|_| groups[column] > 0).map_or(count, |others| column + others)
        };
        let parts = if count > FEW { 1 } else { set.run(Width) };
        let sums = vec![0.0; count * count * parts];
        Self { ends: (0..count).map(end).collect(), set, parts, sums }
    }

    /// The end of the columns, from this one on, with which it is summed.
    pub fn end(&self, column: usize) -> usize {
        self.ends[column]
    }

    /// Adds the products of a chunk; one column each.
    pub fn add(&mut self, columns: &[&Lanes]) {
        debug_assert_eq!(columns.len(), self.ends.len());
        let Self { ends, parts, sums, .. } = self;
        self.set.run(Adding { columns, ends, sums, parts: *parts });
    }

    /// The sum for a pair of columns; zero where it is not wanted.
    pub fn sum(&self, i: usize, j: usize) -> f64 {
        let at = i.min(j) * self.ends.len() + i.max(j);
        if self.parts == 1 {
            return self.sums[at];
        }
        self.sums[at * self.parts..(at + 1) * self.parts].iter().sum()
    }
}

/// How many numbers a register holds.
struct Width;

impl Task for Width {
    type Output = usize;

    #[inline(always)]
    fn run<A: Arithmetic, S: Simd>(self, _: S) -> usize {
        S::F64_LANES
    }
}

struct Adding<'a> {
    columns: &'a [&'a Lanes],
    ends: &'a [usize],
    sums: &'a mut [f64],
    parts: usize,
}

impl Task for Adding<'_> {
    type Output = ();

    #[inline(always)]
    fn run<A: Arithmetic, S: Simd>(self, simd: S) {
        let Self { columns, ends, sums, parts } = self;
        let count = columns.len();
        let added_up = parts < S::F64_LANES;
        let mut i = 0;
        while i < count {
            // A product that is not fused with its sum needs a register, too.
            let most = if A::FUSED { ROWS } else { ROWS - 1 };
            let end = ends[i];
            let alike = ends[i..].iter().take(most).take_while(|other| **other == end);
            let rows = alike.count();
            let mut j = i;
            while j < end {
                let across = COLUMNS.min(end - j);
                let at = (i, j, count, added_up);
                match (rows, across) {
                    (1, 1) => tile::<A, S, 1, 1>(simd, columns, sums, at),
                    (1, 2) => tile::<A, S, 1, 2>(simd, columns, sums, at),
                    (1, _) => tile::<A, S, 1, 3>(simd, columns, sums, at),
                    (2, 1) => tile::<A, S, 2, 1>(simd, columns, sums, at),
                    (2, 2) => tile::<A, S, 2, 2>(simd, columns, sums, at),
                    (2, _) => tile::<A, S, 2, 3>(simd, columns, sums, at),
                    (3, 1) => tile::<A, S, 3, 1>(simd, columns, sums, at),
                    (3, 2) => tile::<A, S, 3, 2>(simd, columns, sums, at),
                    (3, _) => tile::<A, S, 3, 3>(simd, columns, sums, at),
                    (_, 1) => tile::<A, S, 4, 1>(simd, columns, sums, at),
                    (_, 2) => tile::<A, S, 4, 2>(simd, columns, sums, at),
                    (_, _) => tile::<A, S, 4, 3>(simd, columns, sums, at),
                }
                j += across;
            }
            i += rows;
        }
    }
}

/// Adds `R` times `C` products from row `i` and column `j`.
#[expect(clippy::needless_range_loop, reason = "indices say which pair is meant")]
#[inline(always)]
fn tile<A: Arithmetic, S: Simd, const R: usize, const C: usize>(
    simd: S,
    columns: &[&Lanes],
    sums: &mut [f64],
    (i, j, count, added_up): (usize, usize, usize, bool),
) {
    let steps = LANES / S::F64_LANES;
    let registers = |column: usize| &S::as_simd_f64s(&columns[column][..]).0[..steps];
    let (mut down, mut across) = ([registers(i); R], [registers(j); C]);
    (1..R).for_each(|r| down[r] = registers(i + r));
    (1..C).for_each(|c| across[c] = registers(j + c));
    let mut tile = [[simd.splat_f64s(0.0); C]; R];
    for step in 0..steps {
        for r in 0..R {
            let left = down[r][step];
            for c in 0..C {
                let right = across[c][step];
                tile[r][c] = if A::FUSED {
                    simd.mul_add_f64s(left, right, tile[r][c])
                } else {
                    simd.add_f64s(simd.mul_f64s(left, right), tile[r][c])
                };
            }
        }
    }
    for r in 0..R {
        for c in 0..C {
            let at = (i + r) * count + j + c;
            if added_up {
                sums[at] += simd.reduce_sum_f64s(tile[r][c]);
                continue;
            }
            let (sum, _) =
                S::as_mut_simd_f64s(&mut sums[at * S::F64_LANES..(at + 1) * S::F64_LANES]);
            sum[0] = simd.add_f64s(sum[0], tile[r][c]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_summed_with_themselves_and_with_the_first() {
        let groups = [0, 0, 1, 1, 1, 1, 1, 2, 3, 3];
        let columns: Vec<Lanes> = (0..groups.len())
            .map(|c| std::array::from_fn(|i| ((i * 7 + c * 31) % 23) as f64 - 11.0))
            .collect();
        let borrowed: Vec<&Lanes> = columns.iter().collect();
        for set in InstructionSet::available() {
            let (mut some, mut all) =
                (Products::grouped(&groups, set), Products::new(groups.len(), set));
            some.add(&borrowed);
            all.add(&borrowed);
            for (i, j) in (0..groups.len()).flat_map(|i| (i..groups.len()).map(move |j| (i, j))) {
                let wanted = groups[i] == 0 || groups[i] == groups[j];
                assert_eq!(j < some.end(i), wanted, "{i} {j}");
                let sum = if wanted { all.sum(i, j) } else { 0.0 };
                assert_eq!(some.sum(i, j), sum, "{} {i} {j}", set.name());
            }
        }
    }

    #[test]
    fn every_pair_is_summed_on_every_instruction_set() {
        for count in (1..14).chain([FEW, FEW + 1, FEW + 5]) {
            let columns: Vec<Lanes> = (0..count)
                .map(|c| std::array::from_fn(|i| ((i * 7 + c * 31) % 23) as f64 - 11.0))
                .collect();
            let borrowed: Vec<&Lanes> = columns.iter().collect();
            for set in InstructionSet::available() {
                let mut products = Products::new(count, set);
                products.add(&borrowed);
                products.add(&borrowed);
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
