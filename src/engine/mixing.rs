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
}

#[derive(Debug, Default)]
struct Row {
    /// The directions of the mixed row.
    directions: Vec<usize>,
    /// For each plain row that enters it, where its columns go.
    places: Vec<Vec<usize>>,
    /// The residual, then the derivatives.
    columns: Vec<Lanes>,
}

impl Mixing {
    /// Makes ready for rows that hang on these directions; not `mixed`, they stay as they are.
    pub fn prepare(&mut self, directions: &[&[usize]], mixed: bool) {
        self.rows.clear();
        for i in 0..directions.len() {
            let from = if mixed { 0 } else { i };
            let mut all: Vec<usize> =
                directions[from..=i].iter().flat_map(|one| one.iter().copied()).collect();
            all.sort_unstable();
            all.dedup();
            let place = |d: &usize| 1 + all.partition_point(|other| other < d);
            let places = directions[..=i]
                .iter()
                .map(|one| std::iter::once(0).chain(one.iter().map(place)).collect())
                .collect();
            let columns = if mixed { vec![[0.0; LANES]; all.len() + 1] } else { Vec::new() };
            self.rows.push(Row { directions: all, places, columns });
        }
    }

    /// The directions of a row.
    pub fn directions(&self, row: usize) -> &[usize] {
        &self.rows[row].directions
    }

    /// Adds a plain row to all mixed rows that it enters.
    pub fn add(&mut self, set: InstructionSet, j: usize, columns: &[&Lanes], triangles: &[Lanes]) {
        for (i, row) in self.rows.iter_mut().enumerate().skip(j) {
            let factor = &triangles[i * (i + 1) / 2 + j];
            for (column, place) in columns.iter().zip(&row.places[j]) {
                set.run(Multiplied { factor, column, sum: &mut row.columns[*place] });
            }
        }
    }

    /// Hands out a mixed row, its directions and columns, and begins it anew.
    pub fn take(&mut self, row: usize, with: impl FnOnce(&[usize], &[&Lanes])) {
        let row = &mut self.rows[row];
        with(&row.directions, &row.columns.iter().collect::<Vec<_>>());
        row.columns.iter_mut().for_each(|column| column.fill(0.0));
    }
}

struct Multiplied<'a> {
    factor: &'a Lanes,
    column: &'a Lanes,
    sum: &'a mut Lanes,
}

impl Task for Multiplied<'_> {
    type Output = ();

    #[inline(always)]
    fn run<A: Arithmetic, S: Simd>(self, _: S) {
        for lane in 0..LANES {
            self.sum[lane] = A::mul_add(self.factor[lane], self.column[lane], self.sum[lane]);
        }
    }
}
