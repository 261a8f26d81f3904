//! Eigenvalues and singular values of small matrices, for numbers of any size.
//!
//! The library's iterations never end, or panic, where a matrix is not finite, and sums of squares
//! of finite numbers may well overflow. Nothing else in the project decomposes a matrix by
//! iteration; triangular factors need no guard, they fail by themselves.

use nalgebra::allocator::Allocator;
use nalgebra::{
    DMatrix, DVector, DefaultAllocator, Dim, DimDiff, DimSub, OMatrix, SVD, SymmetricEigen, U1,
};

/// Most iterations for each row: a few are the rule.
const ITERATIONS: usize = 1000;

/// Eigenvalues and orthonormal eigenvectors of a symmetric n × n matrix, in no order; `None` where
/// the matrix is not finite, or empty.
pub fn symmetric<D>(matrix: OMatrix<f64, D, D>) -> Option<SymmetricEigen<f64, D>>
where
    D: Dim + DimSub<U1>,
    DefaultAllocator: Allocator<D, D> + Allocator<D> + Allocator<DimDiff<D, U1>>,
{
    let most = ITERATIONS * matrix.nrows().max(1);
    let is_finite = !matrix.is_empty() && matrix.iter().all(|value| value.is_finite());
    is_finite.then(|| SymmetricEigen::try_new(matrix, f64::EPSILON, most)).flatten()
}

/// The shortest `x` with the least `|matrix x - right|`, singular values below `least` (in the
/// matrix's units) taken for zero; `None` where numbers are not finite.
pub fn least_squares(
    matrix: DMatrix<f64>,
    right: &DVector<f64>,
    least: f64,
) -> Option<DVector<f64>> {
    let most = ITERATIONS * matrix.nrows().max(matrix.ncols()).max(1);
    let is_finite = matrix.iter().chain(right.iter()).all(|value| value.is_finite());
    if !is_finite || !least.is_finite() {
        return None;
    }
    SVD::try_new(matrix, true, true, 5.0 * f64::EPSILON, most)?.solve(right, least).ok()
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;

    use super::*;

    #[test]
    fn matrices_that_are_not_finite_have_no_eigenvalues_and_no_solution() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for size in [1, 2, 3, 7] {
                let matrix =
                    DMatrix::from_fn(size, size, |i, j| if i + j == 0 { bad } else { 1.0 });
                assert!(symmetric(matrix.clone()).is_none(), "{bad} {size}");
                assert!(least_squares(matrix, &DVector::zeros(size), 0.0).is_none());
            }
            let right = DVector::from_element(2, bad);
            assert!(least_squares(DMatrix::identity(2, 2), &right, 0.0).is_none());
            assert!(least_squares(DMatrix::identity(2, 2), &DVector::zeros(2), bad).is_none());
            assert!(symmetric(Matrix3::from_element(bad)).is_none());
            assert!(symmetric(DMatrix::zeros(0, 0)).is_none());
        }
    }

    #[test]
    fn finite_matrices_of_any_size_of_numbers_are_decomposed() {
        for scale in [f64::MIN_POSITIVE, 1e-160, 1.0, 1e150, 1e300] {
            let matrix = DMatrix::from_fn(4, 4, |i, j| scale / (1 + i + j) as f64);
            assert!(symmetric(matrix.clone()).is_some(), "{scale}");
            assert!(least_squares(matrix, &DVector::from_element(4, scale), 0.0).is_some());
        }
        assert!(symmetric(DMatrix::zeros(3, 3)).is_some());
    }

    #[test]
    fn they_are_those_of_the_matrix() {
        let matrix = DMatrix::from_row_slice(2, 2, &[2.0, 1.0, 1.0, 2.0]);
        let eigen = symmetric(matrix.clone()).unwrap_or_else(|| unreachable!());
        let mut values = eigen.eigenvalues.as_slice().to_vec();
        values.sort_by(f64::total_cmp);
        assert!((values[0] - 1.0).abs() < 1e-15 && (values[1] - 3.0).abs() < 1e-15);
        let right = DVector::from_vec(vec![3.0, 3.0]);
        let x = least_squares(matrix, &right, 1e-12).unwrap_or_else(|| unreachable!());
        assert!((x - DVector::from_vec(vec![1.0, 1.0])).amax() < 1e-14);
    }
}
