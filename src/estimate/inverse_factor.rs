//! Normal equations, factored: `L⁻¹` of their Cholesky factor, for many products with it.
//!
//! Values that each run has for itself are eliminated apart, so that of `L⁻¹` only its blocks and the
//! rows of joint columns are held and multiplied.

use nalgebra::{DMatrix, DVector};

use self::apart::Apart;
use self::dense::inverse_factor;

mod apart;
mod dense;

/// Added to the diagonal of scaled normal equations: what the readings do not determine stays where
/// it is.
const RIDGE: f64 = 1e-10;

/// Normal equations, factored: columns scaled to unit length, `L` their Cholesky factor.
#[derive(Clone, Debug)]
pub struct Factor {
    /// The columns in the order in which they are eliminated; the joint ones last.
    order: Vec<usize>,
    /// The blocks of `L⁻¹` of the columns that are eliminated apart.
    apart: Vec<DMatrix<f64>>,
    /// Its rows of the joint columns.
    joint: DMatrix<f64>,
    /// The lengths that the columns are scaled by.
    pub length: DVector<f64>,
}

impl Factor {
    /// Of products of columns.
    pub fn of(matrix: &DMatrix<f64>) -> Self {
        let n = matrix.nrows();
        let length = matrix.diagonal().map(|square| if square > 0.0 { square.sqrt() } else { 1.0 });
        let mut ridge = RIDGE;
        // Sums that are no numbers: nothing is taken off anything.
        while ridge <= 10.0 {
            if let Some(factor) = Self::scaled(matrix, &length, ridge) {
                return factor;
            }
            ridge *= 10.0;
        }
        let (order, joint) = ((0..n).collect(), DMatrix::identity(n, n));
        Self { order, apart: Vec::new(), joint, length }
    }

    /// The same with columns scaled by given lengths and a given addition to their squares; `None` where that
    /// is not positive definite.
    pub fn scaled(matrix: &DMatrix<f64>, length: &DVector<f64>, ridge: f64) -> Option<Self> {
        let n = length.len();
        let scaled = DMatrix::from_fn(n, n, |i, j| {
            matrix[(i, j)] / (length[i] * length[j]) + f64::from(i == j) * ridge
        });
        let Apart { sets, joint: at } = Apart::of(&scaled);
        let of = |rows: &[usize], columns: &[usize]| {
            DMatrix::from_fn(rows.len(), columns.len(), |i, j| scaled[(rows[i], columns[j])])
        };
        if sets.is_empty() {
            let joint = inverse_factor(&scaled)?;
            return Some(Self { order: at, apart: Vec::new(), joint, length: length.clone() });
        }
        let order: Vec<usize> = sets.iter().flatten().chain(&at).copied().collect();
        let first = n - at.len();
        let apart: Option<Vec<_>> = sets.iter().map(|set| inverse_factor(&of(set, set))).collect();
        let apart = apart?;
        // The rows of the joint columns in `L`, and what they leave.
        let mut beside = of(&at, &order[..first]);
        for (from, block) in places(&apart).zip(&apart) {
            let own = beside.columns(from, block.nrows()) * block.transpose();
            beside.columns_mut(from, block.nrows()).copy_from(&own);
        }
        let mut rest = of(&at, &at);
        rest.gemm(-1.0, &beside, &beside.transpose(), 1.0);
        let last = inverse_factor(&rest)?;
        let mut joint = DMatrix::zeros(at.len(), n);
        let across = -(&last * beside);
        for (from, block) in places(&apart).zip(&apart) {
            let own = across.columns(from, block.nrows()) * block;
            joint.columns_mut(from, block.nrows()).copy_from(&own);
        }
        joint.columns_mut(first, at.len()).copy_from(&last);
        Some(Self { order, apart, joint, length: length.clone() })
    }

    /// `L⁻¹ b` of products of the columns with others.
    pub fn across(&self, products: &DMatrix<f64>) -> DMatrix<f64> {
        let n = self.order.len();
        let scaled = DMatrix::from_fn(n, products.ncols(), |i, j| {
            let column = self.order[i];
            products[(column, j)] / self.length[column]
        });
        if self.apart.is_empty() {
            return &self.joint * scaled;
        }
        let mut across = DMatrix::zeros(n, products.ncols());
        for (from, block) in places(&self.apart).zip(&self.apart) {
            let own = block * scaled.rows(from, block.nrows());
            across.rows_mut(from, block.nrows()).copy_from(&own);
        }
        let last = self.joint.nrows();
        across.rows_mut(n - last, last).copy_from(&(&self.joint * scaled));
        across
    }

    /// The same of products with one other.
    pub fn half(&self, score: &DVector<f64>) -> DVector<f64> {
        let half = self.across(&DMatrix::from_column_slice(score.len(), 1, score.as_slice()));
        half.column(0).into_owned()
    }

    /// The values of the columns from those.
    pub fn values(&self, half: &DVector<f64>) -> DVector<f64> {
        let values = self.back(&DMatrix::from_column_slice(half.len(), 1, half.as_slice()));
        values.column(0).into_owned()
    }

    /// The same of several at once.
    pub fn back(&self, across: &DMatrix<f64>) -> DMatrix<f64> {
        let last = self.joint.nrows();
        let first = self.order.len() - last;
        // A product of two matrices is blocked, `tr_mul` goes column by column.
        let mut values = self.joint.transpose() * across.rows(first, last);
        for (from, block) in places(&self.apart).zip(&self.apart) {
            let mut own = values.rows_mut(from, block.nrows());
            own += block.transpose() * across.rows(from, block.nrows());
        }
        self.in_columns(&values)
    }

    /// The inverse of the matrix times products of the columns with others.
    pub fn solve(&self, products: &DMatrix<f64>) -> DMatrix<f64> {
        self.back(&self.across(products))
    }

    /// The covariance of the values.
    pub fn covariance(&self) -> DMatrix<f64> {
        let mut covariance = self.joint.transpose() * &self.joint;
        for (from, block) in places(&self.apart).zip(&self.apart) {
            let k = block.nrows();
            let mut own = covariance.view_mut((from, from), (k, k));
            own += block.transpose() * block;
        }
        let values = self.in_columns(&covariance);
        self.in_columns(&values.transpose())
    }

    /// Some columns of `L⁻¹`.
    pub fn columns(&self, columns: &[usize]) -> DMatrix<f64> {
        let n = self.order.len();
        let mut unit = DMatrix::zeros(n, columns.len());
        columns
            .iter()
            .enumerate()
            .for_each(|(j, column)| unit[(*column, j)] = self.length[*column]);
        self.across(&unit)
    }

    /// Scaled values in the order of the columns, each by its length.
    fn in_columns(&self, values: &DMatrix<f64>) -> DMatrix<f64> {
        let mut ordered = DMatrix::zeros(values.nrows(), values.ncols());
        for (mut to, from) in ordered.column_iter_mut().zip(values.column_iter()) {
            for (column, value) in self.order.iter().zip(from.iter()) {
                to[*column] = value / self.length[*column];
            }
        }
        ordered
    }
}

/// Where each block begins.
fn places(blocks: &[DMatrix<f64>]) -> impl Iterator<Item = usize> {
    blocks.iter().scan(0, |end, block| {
        let from = *end;
        *end += block.nrows();
        Some(from)
    })
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a failed test should stop")]
mod tests {
    use super::*;

    /// Readings of runs: the first columns act in all of them, three columns each in one run alone, and a
    /// column in which no reading is.
    fn sums(runs: usize) -> DMatrix<f64> {
        let (common, own, rows) = (7, 3, 11);
        let value = |i: usize, j: usize| (((i * 31 + j * 17 + 1) as f64).sin() * 43_758.5).fract();
        let columns = DMatrix::from_fn(rows * runs, common + own * runs + 1, |i, j| {
            let run = i / rows;
            let is_own = (common + own * run..common + own * (run + 1)).contains(&j);
            if j < common || is_own { value(i, j) } else { 0.0 }
        });
        columns.tr_mul(&columns)
    }

    #[test]
    fn columns_of_runs_are_eliminated_apart_and_change_no_number() {
        let matrix = sums(30);
        let n = matrix.nrows();
        let found = Factor::of(&matrix);
        assert!(found.joint.nrows() == 7 && found.apart.len() > 3);
        let dense = inverse_factor(&DMatrix::from_fn(n, n, |i, j| {
            matrix[(i, j)] / (found.length[i] * found.length[j]) + f64::from(i == j) * RIDGE
        }));
        let dense = dense.unwrap();
        let scale = DMatrix::from_diagonal(&found.length.map(|length| 1.0 / length));
        let covariance = &scale * dense.transpose() * &dense * &scale;
        assert!((found.covariance() - &covariance).norm() < 1e-9 * covariance.norm());
        let products = DMatrix::from_fn(n, 4, |i, j| matrix[(i, (5 * i + j) % (n - 1))]);
        let across = found.across(&products);
        let squares = products.tr_mul(&covariance) * &products;
        assert!((across.tr_mul(&across) - &squares).norm() < 1e-9 * squares.norm());
        let solved = found.solve(&products);
        assert!((&solved - &covariance * &products).norm() < 1e-9 * solved.norm());
        let score = products.column(1).into_owned();
        let half = found.half(&score);
        assert!((&half - across.column(1)).norm() < 1e-12 * half.norm());
        assert!((found.values(&half) - solved.column(1)).norm() < 1e-12 * half.norm());
        let inverse = found.columns(&[8, 40]);
        let own = covariance.select_columns(&[8, 40]);
        let squares = DMatrix::from_fn(2, 2, |i, j| {
            own[([8, 40][i], j)] * found.length[[8, 40][i]] * found.length[[8, 40][j]]
        });
        assert!((inverse.tr_mul(&inverse) - &squares).norm() < 1e-9 * squares.norm());
    }

    #[test]
    fn sums_that_are_no_numbers_take_nothing_off() {
        let mut matrix = sums(30);
        matrix[(40, 40)] = f64::NAN;
        let found = Factor::of(&matrix);
        assert!(found.apart.is_empty() && found.joint == DMatrix::identity(98, 98));
    }
}
