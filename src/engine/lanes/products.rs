//! Sums of products of columns over chunks: the Gram matrix of one row of every sample.
//!
//! Tiles of 4 by 3 sums (3 by 3 without fused multiply-add) stay in registers while the chunk runs
//! through them; each sum has as many partial sums as a register holds numbers, which are added up
//! at the end. So a product costs one multiply-add, which is the least it can. Where there are so
//! many columns that partial sums would not stay in the nearest caches, they are added up chunk by
//! chunk. Columns may be in groups that want no sums with each other; what nobody wants has no
//! place in memory.

use std::ops::Range;

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
    count: usize,
    bands: Vec<Band>,
    /// For each column the band that it is a row of.
    band_of: Vec<usize>,
    set: InstructionSet,
    /// Numbers a register holds.
    width: usize,
    /// Partial sums of each sum: as many as a register holds numbers, or one.
    parts: usize,
    /// Band after band, row after row.
    sums: Vec<f64>,
}

/// Columns that follow each other and are summed with the same others: rows of one row of tiles.
#[derive(Clone, Debug)]
struct Band {
    rows: Range<usize>,
    /// The columns that they are summed with.
    with: Range<usize>,
    /// Where their sums begin, in units of sums.
    at: usize,
}

impl Products {
    /// Of every pair of this many columns; all zero.
    pub fn new(count: usize, set: InstructionSet) -> Self {
        Self::of((0..count).map(|column| column..count), set)
    }

    /// Of columns in groups, those of a group one after the other: of pairs of the same group, and
    /// of those of group 0, which is first, with all that are not.
    pub fn grouped(groups: &[usize], set: InstructionSet) -> Self {
        debug_assert!(groups.is_sorted(), "group after group, those of 0 first");
        let first = groups.partition_point(|group| *group == 0);
        let end = |column: usize| groups.partition_point(|group| *group <= groups[column]);
        let with =
            |column: usize| if column < first { first..groups.len() } else { column..end(column) };
        Self::of((0..groups.len()).map(with), set)
    }

    /// Of each column with those of a range, which ends no earlier than that of the column before
    /// it.
    fn of(with: impl ExactSizeIterator<Item = Range<usize>>, set: InstructionSet) -> Self {
        let (width, fused) = set.run(Kind);
        let (count, most) = (with.len(), if fused { ROWS } else { ROWS - 1 });
        let (mut bands, mut band_of, mut at) = (Vec::<Band>::new(), Vec::new(), 0);
        for (column, with) in with.enumerate() {
            // A row of a band is summed with those before it, too, as they begin together.
            let fits = |band: &&mut Band| band.rows.len() < most && band.with.end == with.end;
            if let Some(band) = bands.last_mut().filter(fits) {
                band.rows.end += 1;
                at += band.with.len();
            } else {
                bands.push(Band { rows: column..column + 1, with: with.clone(), at });
                at += with.len();
            }
            band_of.push(bands.len() - 1);
        }
        let parts = if count > FEW { 1 } else { width };
        Self { count, bands, band_of, set, width, parts, sums: vec![0.0; at * parts] }
    }

    /// Forgets what was added.
    pub fn clear(&mut self) {
        self.sums.fill(0.0);
    }

    /// The columns, from this one on, with which it is summed.
    pub fn with(&self, column: usize) -> Range<usize> {
        let with = &self.bands[self.band_of[column]].with;
        with.start.max(column)..with.end
    }

    /// Adds the products of a chunk; one column each.
    pub fn add(&mut self, columns: &[&Lanes]) {
        debug_assert_eq!(columns.len(), self.count);
        let Self { bands, parts, sums, set, width, .. } = self;
        let added_up = parts < width;
        for Band { rows, with, at } in bands {
            let mut j = with.start;
            while j < with.end {
                let across = COLUMNS.min(with.end - j);
                let at = (*at + j - with.start, with.len());
                let pair = (rows.start, j);
                let is_diagonal = j == rows.start && with.start == rows.start;
                let tile = Tile { columns, sums: &mut *sums, pair, at, added_up, is_diagonal };
                // A product that is not fused with its sum needs a register, too: no fourth row
                // then.
                match (rows.len(), across) {
                    (1, 1) => tile.add::<1, 1>(*set),
                    (1, 2) => tile.add::<1, 2>(*set),
                    (1, _) => tile.add::<1, 3>(*set),
                    (2, 1) => tile.add::<2, 1>(*set),
                    (2, 2) => tile.add::<2, 2>(*set),
                    (2, _) => tile.add::<2, 3>(*set),
                    (3, 1) => tile.add::<3, 1>(*set),
                    (3, 2) => tile.add::<3, 2>(*set),
                    (3, _) => tile.add::<3, 3>(*set),
                    (_, 1) => tile.add::<4, 1>(*set),
                    (_, 2) => tile.add::<4, 2>(*set),
                    (_, _) => tile.add::<4, 3>(*set),
                }
                j += across;
            }
        }
    }

    /// The sum for a pair of columns; zero where it is not wanted.
    pub fn sum(&self, i: usize, j: usize) -> f64 {
        let (i, j) = (i.min(j), i.max(j));
        let with = self.with(i);
        if with.contains(&j) { self.added_up(self.at(i) + j - with.start) } else { 0.0 }
    }

    /// The sums of a column and each of those with which it is summed.
    pub fn row(&self, column: usize, sums: &mut Vec<f64>) {
        let (first, count) = (self.at(column), self.with(column).len());
        sums.clear();
        if self.parts == 1 {
            sums.extend_from_slice(&self.sums[first..first + count]);
        } else {
            sums.extend((first..first + count).map(|at| self.added_up(at)));
        }
    }

    /// Where the sums of a column begin that are wanted, in units of sums.
    fn at(&self, column: usize) -> usize {
        let Band { rows, with, at } = &self.bands[self.band_of[column]];
        at + (column - rows.start) * with.len() + self.with(column).start - with.start
    }

    fn added_up(&self, at: usize) -> f64 {
        self.sums[at * self.parts..(at + 1) * self.parts].iter().sum()
    }
}

/// How many numbers a register holds, and whether a product is fused with its sum.
struct Kind;

impl Task for Kind {
    type Output = (usize, bool);

    #[inline(always)]
    fn run<A: Arithmetic, S: Simd>(self, _: S) -> (usize, bool) {
        (S::F64_LANES, A::FUSED)
    }
}

/// Products of some rows and columns.
struct Tile<'a> {
    columns: &'a [&'a Lanes],
    sums: &'a mut [f64],
    /// First row and column.
    pair: (usize, usize),
    /// Where the first sum is, and how many there are from row to row.
    at: (usize, usize),
    added_up: bool,
    /// Whether rows and columns begin together: what is below the diagonal is above it, too.
    is_diagonal: bool,
}

impl Tile<'_> {
    fn add<const R: usize, const C: usize>(self, set: InstructionSet) {
        if R > 1 && self.is_diagonal {
            set.run(Counted::<R, C, true>(self));
        } else {
            set.run(Counted::<R, C, false>(self));
        }
    }
}

/// A tile whose rows and columns are counted when it is compiled, and whether what is below the
/// diagonal is left out.
struct Counted<'a, const R: usize, const C: usize, const DIAGONAL: bool>(Tile<'a>);

impl<const R: usize, const C: usize, const DIAGONAL: bool> Task for Counted<'_, R, C, DIAGONAL> {
    type Output = ();

    #[expect(clippy::needless_range_loop, reason = "indices say which pair is meant")]
    #[inline(always)]
    fn run<A: Arithmetic, S: Simd>(self, simd: S) {
        let Tile { columns, sums, pair: (i, j), at: (at, stride), added_up, .. } = self.0;
        let is_wanted = |r: usize, c: usize| !DIAGONAL || r <= c;
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
                    if is_wanted(r, c) {
                        let right = across[c][step];
                        tile[r][c] = if A::FUSED {
                            simd.mul_add_f64s(left, right, tile[r][c])
                        } else {
                            simd.add_f64s(simd.mul_f64s(left, right), tile[r][c])
                        };
                    }
                }
            }
        }
        for r in 0..R {
            for c in 0..C {
                if !is_wanted(r, c) {
                    continue;
                }
                let at = at + r * stride + c;
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
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_summed_with_themselves_and_the_first_with_all_others() {
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
                let wanted = (groups[i] == 0) != (groups[i] == groups[j]);
                assert_eq!(some.with(i).contains(&j), wanted, "{i} {j}");
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
