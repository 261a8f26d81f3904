//! Inverse of the Cholesky factor of a symmetric matrix of some hundred columns, by halves: nearly all
//! of the work is products of matrices, which are quicker than columns.

use nalgebra::{DMatrix, DMatrixView};

/// Up to this size column by column.
const SMALL: usize = 24;

/// `L⁻¹` with `L Lᵀ = matrix`; only the lower triangle is read. `None` where the matrix is not positive
/// definite.
pub(super) fn inverse_factor(matrix: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    of(matrix.as_view())
}

fn of(matrix: DMatrixView<'_, f64>) -> Option<DMatrix<f64>> {
    let n = matrix.nrows();
    if n <= SMALL {
        return small(matrix);
    }
    let (a, b) = (n / 2, n - n / 2);
    let upper = of(matrix.view((0, 0), (a, a)))?;
    let beside = matrix.view((a, 0), (b, a)) * upper.transpose();
    let mut rest = matrix.view((a, a), (b, b)).into_owned();
    rest.gemm(-1.0, &beside, &beside.transpose(), 1.0);
    let lower = of(rest.as_view())?;
    let mut inverse = DMatrix::zeros(n, n);
    inverse.view_mut((a, 0), (b, a)).copy_from(&(-(&lower * &beside) * &upper));
    inverse.view_mut((0, 0), (a, a)).copy_from(&upper);
    inverse.view_mut((a, a), (b, b)).copy_from(&lower);
    Some(inverse)
}

fn small(matrix: DMatrixView<'_, f64>) -> Option<DMatrix<f64>> {
    let n = matrix.nrows();
    let mut factor = DMatrix::zeros(n, n);
    let mut inverse = DMatrix::zeros(n, n);
    for j in 0..n {
        let taken: f64 = (0..j).map(|k| factor[(j, k)] * factor[(j, k)]).sum();
        let pivot: f64 = matrix[(j, j)] - taken;
        if !(pivot > 0.0 && pivot.is_finite()) {
            return None;
        }
        let root = pivot.sqrt();
        factor[(j, j)] = root;
        for i in j + 1..n {
            let taken: f64 = (0..j).map(|k| factor[(i, k)] * factor[(j, k)]).sum();
            factor[(i, j)] = (matrix[(i, j)] - taken) / root;
        }
        inverse[(j, j)] = 1.0 / root;
        for i in 0..j {
            let sum: f64 = (i..j).map(|k| factor[(j, k)] * inverse[(k, i)]).sum();
            inverse[(j, i)] = -sum / root;
        }
    }
    Some(inverse)
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a failed test should stop")]
mod tests {
    use super::*;

    #[test]
    fn it_makes_the_matrix_the_identity_at_any_size() {
        for n in [1, 5, SMALL, SMALL + 1, 70, 133] {
            let any = |i: usize, j: usize| ((i * 31 + j * 17) as f64).sin();
            let half = DMatrix::from_fn(n, n, any);
            let matrix = &half * half.transpose() + DMatrix::identity(n, n);
            let inverse = inverse_factor(&matrix).unwrap();
            let one = &inverse * &matrix * inverse.transpose();
            assert!((one - DMatrix::identity(n, n)).norm() < 1e-9);
            assert_eq!(inverse.lower_triangle(), inverse);
        }
    }

    #[test]
    fn a_matrix_that_is_not_positive_definite_has_none() {
        let mut matrix = DMatrix::identity(40, 40);
        matrix[(35, 35)] = -1.0;
        assert!(inverse_factor(&matrix).is_none());
        matrix[(35, 35)] = f64::NAN;
        assert!(inverse_factor(&matrix).is_none());
    }
}
