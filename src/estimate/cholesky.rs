//! Cholesky factor of a small symmetric matrix, which says *which* column is dependent when there
//! is none.

use nalgebra::{DMatrix, DVector};

/// Lower factor `L` with `L Lᵀ = matrix`; only the lower triangle is read.
///
/// The matrix must have been scaled to a unit diagonal (or be a Schur complement of such a one): a
/// pivot is then the squared share of a column that the columns before it do not explain, and
/// `floor` is the least share that counts.
///
/// # Errors
/// The first column whose pivot does not exceed `floor` (or is not a number).
pub(crate) fn factor(mut matrix: DMatrix<f64>, floor: f64) -> Result<DMatrix<f64>, usize> {
    let n = matrix.nrows();
    for j in 0..n {
        let pivot = matrix[(j, j)];
        if !(pivot > floor && pivot.is_finite()) {
            return Err(j);
        }
        let root = pivot.sqrt();
        matrix[(j, j)] = root;
        for i in j + 1..n {
            matrix[(i, j)] /= root;
        }
        for k in j + 1..n {
            let factor = matrix[(k, j)];
            if factor == 0.0 {
                continue;
            }
            for i in k..n {
                let product = matrix[(i, j)] * factor;
                matrix[(i, k)] -= product;
            }
        }
        for i in 0..j {
            matrix[(i, j)] = 0.0;
        }
    }
    Ok(matrix)
}

/// `L⁻¹ right`, column by column in place.
pub(crate) fn forward(lower: &DMatrix<f64>, right: &mut DMatrix<f64>) {
    let n = lower.nrows();
    for mut column in right.column_iter_mut() {
        for j in 0..n {
            let value = column[j] / lower[(j, j)];
            column[j] = value;
            for i in j + 1..n {
                column[i] -= lower[(i, j)] * value;
            }
        }
    }
}

/// `(L Lᵀ)⁻¹ right`.
pub(crate) fn solve(lower: &DMatrix<f64>, right: &DVector<f64>) -> DVector<f64> {
    let n = lower.nrows();
    let mut x = right.clone();
    for j in 0..n {
        x[j] /= lower[(j, j)];
        for i in j + 1..n {
            let product = lower[(i, j)] * x[j];
            x[i] -= product;
        }
    }
    for j in (0..n).rev() {
        for i in j + 1..n {
            let product = lower[(i, j)] * x[i];
            x[j] -= product;
        }
        x[j] /= lower[(j, j)];
    }
    x
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a failed test should stop")]
mod tests {
    use super::*;

    #[test]
    fn the_factor_solves_and_names_a_dependent_column() {
        let m = DMatrix::from_row_slice(3, 3, &[1.0, 0.5, 0.2, 0.5, 1.0, 0.3, 0.2, 0.3, 1.0]);
        let l = factor(m.clone(), 1e-14).unwrap();
        let right = DVector::from_vec(vec![1.0, -2.0, 0.5]);
        assert!((&m * solve(&l, &right) - &right).norm() < 1e-14);
        let mut half = DMatrix::from_columns(std::slice::from_ref(&right));
        forward(&l, &mut half);
        assert!((&l * half - DMatrix::from_columns(&[right])).norm() < 1e-14);
        let twice = DMatrix::from_row_slice(3, 3, &[1.0, 0.5, 1.0, 0.5, 1.0, 0.5, 1.0, 0.5, 1.0]);
        assert_eq!(factor(twice, 1e-14).unwrap_err(), 2);
    }
}
