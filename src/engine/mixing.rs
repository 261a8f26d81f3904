//! Rows of a chunk whitened where readings of a sample are correlated: `row_i' = Σ_j L⁻¹_ij row_j`.
//!
//! A row hangs on few directions; a mixed one on those of all rows that enter it.

use crate::engine::lanes::dispatch::Simd;

use crate::engine::lanes::arithmetic::{Arithmetic, LANES, Lanes};
use crate::engine::lanes::dispatch::{InstructionSet, Task};

/// The mixed rows of a chunk, as they grow.
#[derive(Debug, Default)]
pub struct Mixing {
    rows: Vec<Row>,
    mixed: bool,
}

#[derive(Debug, Default)]
struct Row {
    /// The directions of the mixed row.
    directions: Vec<usize>,
    /// For each plain row that enters it, where its columns go, and whether another went there
    /// before.
    places: Vec<Vec<(usize, bool)>>,
    /// The residual, then the derivatives.
    columns: Vec<Lanes>,
}

impl Mixing {
    /// Makes ready for rows that hang on these directions, the same each time; not `mixed`, they
    /// stay as they are.
    pub fn prepare<'a>(
        &mut self,
        directions: impl ExactSizeIterator<Item = &'a [usize]>,
        mixed: bool,
    ) {
        if self.rows.len() == directions.len() && self.mixed == mixed {
            return;
        }
        let directions: Vec<&[usize]> = directions.collect();
        self.mixed = mixed;
        self.rows.clear();
        for i in 0..directions.len() {
            let from = if mixed { 0 } else { i };
            let mut all: Vec<usize> =
                directions[from..=i].iter().flat_map(|one| one.iter().copied()).collect();
            all.sort_unstable();
            all.dedup();
            let place = |d: &usize| 1 + all.partition_point(|other| other < d);
            let mut filled = vec![false; all.len() + 1];
            let mut placed = |place: usize| (place, std::mem::replace(&mut filled[place], true));
            let places = directions[from..=i]
                .iter()
                .map(|one| {
                    std::iter::once(0).chain(one.iter().map(place)).map(&mut placed).collect()
                })
                .collect();
            let columns = if mixed { vec![[0.0; LANES]; all.len() + 1] } else { Vec::new() };
            self.rows.push(Row { directions: all, places, columns });
        }
    }

    /// The directions of a row.
    pub fn directions(&self, row: usize) -> &[usize] {
        &self.rows[row].directions
    }

    /// Adds a plain row to all mixed rows that it enters: row after row, from the first on.
    pub fn add(&mut self, set: InstructionSet, j: usize, columns: &[&Lanes], triangles: &[Lanes]) {
        for (i, row) in self.rows.iter_mut().enumerate().skip(j) {
            let factor = &triangles[i * (i + 1) / 2 + j];
            let places = &row.places[j];
            set.run(Multiplied { factor, columns, places, sums: &mut row.columns });
        }
    }

    /// A mixed row: its directions and columns.
    pub fn row(&self, row: usize) -> (&[usize], Vec<&Lanes>) {
        let Row { directions, columns, .. } = &self.rows[row];
        (directions, columns.iter().collect())
    }
}

struct Multiplied<'a> {
    factor: &'a Lanes,
    columns: &'a [&'a Lanes],
    places: &'a [(usize, bool)],
    sums: &'a mut [Lanes],
}

impl Task for Multiplied<'_> {
    type Output = ();

    #[inline(always)]
    fn run<A: Arithmetic, S: Simd>(self, simd: S) {
        let Self { factor, columns, places, sums } = self;
        let (factor, _) = S::as_simd_f64s(&factor[..]);
        for (column, (place, again)) in columns.iter().zip(places) {
            let (column, _) = S::as_simd_f64s(&column[..]);
            let (sum, _) = S::as_mut_simd_f64s(&mut sums[*place][..]);
            for ((sum, factor), value) in sum.iter_mut().zip(factor).zip(column) {
                *sum = match (again, A::FUSED) {
                    (false, _) => simd.mul_f64s(*factor, *value),
                    (true, true) => simd.mul_add_f64s(*factor, *value, *sum),
                    (true, false) => simd.add_f64s(simd.mul_f64s(*factor, *value), *sum),
                };
            }
        }
    }
}
