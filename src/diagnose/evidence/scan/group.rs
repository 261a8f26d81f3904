//! What members of a family do together over a campaign, a setup or a run, and what each takes off
//! the sum of squares. Which members are tried is not its business.

use indexmap::IndexMap;
use nalgebra::linalg::Cholesky;
use nalgebra::{DMatrix, DVector};

use crate::diagnose::evidence::basis::RANK;
use crate::engine::passes::Passes;
use crate::graph::Scope;

use super::{OF_RUN, Scan, TOGETHER};

/// Sums of `TOGETHER` members' columns that hold together: with those of the same member, or of all; with
/// the nominal columns; with what is left.
pub(super) struct Group {
    pub(super) own: DMatrix<f64>,
    pub(super) across: DMatrix<f64>,
    pub(super) score: DVector<f64>,
}

impl Scan<'_> {
    /// Sums over runs of columns that hold together: over a campaign, a setup or a run.
    pub(super) fn groups(
        &self,
        passes: &Passes<'_>,
        members: &[f64],
    ) -> IndexMap<(usize, usize), Group> {
        let problem = &self.fitted.problem;
        let (part, columns) = (passes.signatures().part(), &passes.signatures().columns);
        let n = self.nominal.score.len();
        let k = columns.len();
        let mut groups = IndexMap::new();
        for (run, sums) in passes.sums(members).iter().enumerate() {
            let touched = problem.layout.columns.touched_by(problem.run_index(part, run));
            let scope = columns.first().map(|one| one.scope);
            let key = match scope.map(|own| if self.is_by_runs { Scope::Run } else { own }) {
                Some(Scope::Run) => (OF_RUN, problem.run_index(part, run)),
                Some(Scope::Setup) => (1, problem.parts[part].runs[run].setup),
                _ => (0, 0),
            };
            let rows = if k > 0 { sums.own(0).len() } else { 0 };
            let group = groups.entry(key).or_insert_with(|| Group {
                own: DMatrix::zeros(rows, k),
                across: DMatrix::zeros(n, k),
                score: DVector::zeros(k),
            });
            for j in 0..k {
                group.score[j] += sums.residual(j);
                for (sum, more) in group.own.column_mut(j).iter_mut().zip(sums.own(j)) {
                    *sum += more;
                }
                for (column, sum) in touched.iter().zip(sums.nominal(j)) {
                    group.across[(*column, j)] += sum;
                }
            }
        }
        groups
    }
}

impl Group {
    /// What a member takes off the sum of squares, without what others absorb: `taken` are nominal
    /// columns' products with the columns and with what is left, halfway to their product.
    pub(super) fn gain(&self, member: usize, taken: Option<&(DMatrix<f64>, &DVector<f64>)>) -> f64 {
        let k = self.score.len() / TOGETHER;
        let first = member * k;
        let mut left = self.own.view((0, first), (k, k)).into_owned();
        let mut score = self.score.rows(first, k).into_owned();
        if let Some((half, known)) = taken {
            let half = half.columns(first, k);
            left -= half.tr_mul(&half);
            score -= half.tr_mul(known);
        }
        gained(left, |i| self.own[(i, first + i)], &score)
    }

    /// The squared cosines between the first member and another, added up, and those of the first
    /// with itself: as many as it has directions. `None` where they have none.
    pub(super) fn cosines(&self, other: usize) -> Option<(f64, f64)> {
        let k = self.score.len() / TOGETHER;
        let block = |i: usize, j: usize| self.own.view((i * k, j * k), (k, k)).into_owned();
        let factor = |mut own: DMatrix<f64>| {
            (0..k).for_each(|i| own[(i, i)] = raised(own[(i, i)], own[(i, i)]));
            Cholesky::new(own)
        };
        let (left, right) = (factor(block(0, 0))?, factor(block(other, other))?);
        let cosines = |right: &Factor, products: DMatrix<f64>| {
            let half = left.l().solve_lower_triangular(&products)?;
            Some(right.l().solve_lower_triangular(&half.transpose())?.norm_squared())
        };
        Some((cosines(&right, block(0, other))?, cosines(&left, block(0, 0))?))
    }
}

type Factor = Cholesky<f64, nalgebra::Dyn>;

/// What is left of a column's squared length, a little more. What others absorb is nothing: the
/// nominal parameters, or another of the columns, as where all runs turn in the same sense; so is a
/// column of zeros, as where a signal stands still.
fn raised(left: f64, own: f64) -> f64 {
    if own > 0.0 { left + RANK.powi(2) * own } else { 1.0 }
}

/// What columns take off the sum of squares: `left` are the products of what is left of them, `own`
/// their squared lengths, `score` their products with what is left of the residual.
fn gained(mut left: DMatrix<f64>, own: impl Fn(usize) -> f64, score: &DVector<f64>) -> f64 {
    (0..score.len()).for_each(|i| left[(i, i)] = raised(left[(i, i)], own(i)));
    let half = Cholesky::new(left).and_then(|left| left.l_dirty().solve_lower_triangular(score));
    half.map_or(0.0, |half| half.norm_squared())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A signal that stands still has a column of zeros, and one that always turns in one sense two
    /// that are the same; what the others do is seen all the same.
    #[test]
    fn columns_of_zeros_and_the_same_ones_take_nothing() {
        let own = DMatrix::from_row_slice(3, 3, &[4.0, 4.0, 0.0, 4.0, 4.0, 0.0, 0.0, 0.0, 0.0]);
        let score = DVector::from_row_slice(&[6.0, 6.0, 0.0]);
        let gain = gained(own.clone(), |i| own[(i, i)], &score);
        assert!((gain - 9.0).abs() < 1e-3, "{gain}");
    }
}
