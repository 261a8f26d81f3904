//! What a model absorbs of the columns of changes, and what the model without some of its terms
//! absorbs: the model is factored once.
//!
//! With `H = L Lᵀ` the model's normal equations and `a = L⁻¹ H_Mj` of a column, the model absorbs
//! `aᵀ a` of its squared length. Without the terms `t` it absorbs less by the part of `a` within the
//! span of the columns `M_t` of `L⁻¹`: their values are `M_tᵀ a`, with the covariance `M_tᵀ M_t`.

use std::ops::Range;

use nalgebra::{DMatrix, DVector, DVectorView};

use crate::estimate::inverse_factor::Factor;

/// Columns, each the running sum of a change from a bin on, and the right side, beside a model.
pub(super) struct Across {
    /// `L⁻¹ H_Mj`.
    columns: DMatrix<f64>,
    /// `L⁻¹ b`.
    half: DVector<f64>,
    /// Of each column its squared length, and its product with the right side.
    from_each: Vec<(f64, f64)>,
}

/// Products of the columns at the ends of stretches with each other, and with the right side.
pub(super) struct EndProducts {
    products: DMatrix<f64>,
    along: DVector<f64>,
}

/// What parts of a model lack of it.
pub(super) struct Lacking {
    /// Orthonormal bases of the columns of `L⁻¹` that each lacks, side by side.
    bases: DMatrix<f64>,
    of_each: Vec<Range<usize>>,
}

impl Lacking {
    /// Of parts by the columns that each lacks.
    pub(super) fn new(factor: &Factor, parts: &[Vec<usize>]) -> Self {
        let of_part = |columns: &Vec<usize>| factor.columns(columns).qr().q();
        let bases: Vec<DMatrix<f64>> = parts.iter().map(of_part).collect();
        let ends = bases.iter().scan(0, |end, basis| {
            *end += basis.ncols();
            Some(*end - basis.ncols()..*end)
        });
        let of_each = ends.collect();
        let columns: Vec<DVector<f64>> = bases
            .iter()
            .flat_map(|basis| basis.column_iter().map(|one| one.into_owned()))
            .collect();
        let bases = match columns.is_empty() {
            true => DMatrix::zeros(factor.length.len(), 0),
            false => DMatrix::from_columns(&columns),
        };
        Self { bases, of_each }
    }
}

impl Across {
    /// Of the columns and the right side.
    pub(super) fn new(columns: DMatrix<f64>, half: DVector<f64>) -> Self {
        let of = |column: DVectorView<'_, f64>| (column.norm_squared(), column.dot(&half));
        let from_each = columns.column_iter().map(of).collect();
        Self { columns, half, from_each }
    }

    /// The squared length of the column from one bin to before another, the last of all for `None`,
    /// and its product with the right side.
    fn taken(&self, from: usize, to: Option<usize>) -> (f64, f64) {
        let Some(to) = to else { return self.from_each[from] };
        let (from, to) = (self.columns.column(from), self.columns.column(to));
        let (mut taken, mut along) = (0.0, 0.0);
        for ((from, to), half) in from.iter().zip(to.iter()).zip(self.half.iter()) {
            taken += (from - to) * (from - to);
            along += (from - to) * half;
        }
        (taken, along)
    }

    /// Of the columns at some ends; the column at `None` is zero.
    pub(super) fn ends(&self, ends: &[Option<usize>]) -> EndProducts {
        let column = |i: usize, end: usize| ends[end].map_or(0.0, |end| self.columns[(i, end)]);
        let at_ends = DMatrix::from_fn(self.half.len(), ends.len(), column);
        EndProducts { products: at_ends.transpose() * &at_ends, along: at_ends.tr_mul(&self.half) }
    }
}

impl EndProducts {
    /// Of the column between two of the ends.
    fn taken(&self, from: usize, to: usize) -> (f64, f64) {
        let of = |a, b| self.products[(a, b)];
        let squares = of(from, from) - 2.0 * of(from, to) + of(to, to);
        (squares, self.along[from] - self.along[to])
    }
}

/// What the model without some of its terms absorbs of the same columns.
pub(super) struct AbsorbedLengths<'m> {
    whole: &'m Across,
    out: Across,
}

impl<'m> AbsorbedLengths<'m> {
    /// By each of some parts of it.
    pub(super) fn by_each(whole: &'m Across, lacking: &Lacking) -> Vec<Self> {
        // A product of two matrices is blocked, `tr_mul` goes column by column.
        let bases = lacking.bases.transpose();
        let (columns, half) = (&bases * &whole.columns, bases * &whole.half);
        let of = |own: &Range<usize>| {
            let columns = columns.rows(own.start, own.len()).into_owned();
            let half = half.rows(own.start, own.len()).into_owned();
            Self { whole, out: Across::new(columns, half) }
        };
        lacking.of_each.iter().map(of).collect()
    }

    /// Whether the model is a part of the whole one.
    pub(super) fn is_of_a_part(&self) -> bool {
        !self.out.half.is_empty()
    }

    /// As [`Across::taken`]: the squared length that is absorbed, and the product with the right side.
    pub(super) fn taken(&self, from: usize, to: Option<usize>) -> (f64, f64) {
        less(self.whole.taken(from, to), self.out.taken(from, to))
    }

    /// The same between two of some ends; `whole` are the products of the whole model's columns there.
    pub(super) fn between(
        &self,
        whole: &EndProducts,
        ends: &[Option<usize>],
    ) -> impl Fn(usize, usize) -> (f64, f64) {
        let out = self.out.ends(ends);
        move |from, to| less(whole.taken(from, to), out.taken(from, to))
    }
}

fn less(whole: (f64, f64), out: (f64, f64)) -> (f64, f64) {
    (whole.0 - out.0, whole.1 - out.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Without factoring again, what is absorbed is what the model without some columns absorbs.
    #[test]
    fn what_is_taken_up_without_some_columns_is_what_the_others_take_up() {
        let value = |i: usize, j: usize| ((i * 7 + j * 13 + 1) as f64 * 0.61).sin();
        let rows = DMatrix::from_fn(12, 5, value);
        let added = DMatrix::from_fn(12, 3, |i, j| value(i + 3, j + 8));
        let right = DVector::from_fn(12, |i, _| value(i, 21));
        let beside = |kept: &[usize]| {
            let own = rows.select_columns(kept);
            let factor = Factor::of(&own.tr_mul(&own));
            let half = factor.half(&own.tr_mul(&right));
            (Across::new(factor.across(&own.tr_mul(&added)), half), factor)
        };
        let (whole, factor) = beside(&[0, 1, 2, 3, 4]);
        let (less, _) = beside(&[0, 2, 4]);
        let lacking = Lacking::new(&factor, &[Vec::new(), vec![1, 3]]);
        let all = AbsorbedLengths::by_each(&whole, &lacking);
        let [all_of_it, absorbed] = all.as_slice() else { unreachable!() };
        assert!(!all_of_it.is_of_a_part() && absorbed.is_of_a_part());
        let places = [Some(0), Some(1), Some(2), None];
        let ends = whole.ends(&places);
        let between = absorbed.between(&ends, &places);
        for (from, to) in [(0, 1), (0, 2), (1, 2), (0, 3), (2, 3)] {
            let due = less.taken(from, places[to]);
            for found in [absorbed.taken(from, places[to]), between(from, to)] {
                assert!((found.0 - due.0).abs() < 1e-8 && (found.1 - due.1).abs() < 1e-8);
            }
        }
    }
}
