//! The covariance of an estimate: of the problem at a point, without damping or column scaling.

use nalgebra::{DMatrix, DVector};

use crate::engine::gram::Normal;
use crate::estimate::arrow::{covariance, normal_matrix};
use crate::estimate::eigen;
use crate::estimate::observability::{Direction, Kind};

/// Covariance of all columns; where directions are not determined at all, that of what is left when
/// they are held (their own entries then mean nothing and are not to be shown). NaN where even that
/// does not exist.
pub fn of_determined(normal: &Normal, directions: &[Direction]) -> DMatrix<f64> {
    let n = normal.columns.len();
    if directions.iter().all(|direction| direction.kind == Kind::UpToNoise)
        && let Ok(whole) = covariance(normal)
    {
        return whole;
    }
    held(normal, directions).unwrap_or_else(|| DMatrix::from_element(n, n, f64::NAN))
}

/// Variance of a sum of columns, each with its factor.
pub fn of_combination(covariance: &DMatrix<f64>, factors: &[(usize, f64)]) -> f64 {
    let pairs = factors.iter().flat_map(|one| factors.iter().map(move |other| (one, other)));
    pairs.map(|((i, a), (j, b))| a * b * covariance[(*i, *j)]).sum()
}

/// The pseudo-inverse over what is determined, through columns of unit length.
fn held(normal: &Normal, directions: &[Direction]) -> Option<DMatrix<f64>> {
    let (hessian, _) = normal_matrix(normal).ok()?;
    let n = hessian.nrows();
    if hessian.iter().any(|value| !value.is_finite()) {
        return None;
    }
    let length = DVector::from_fn(n, |i, _| {
        let square: f64 = hessian[(i, i)];
        if square > 0.0 { square.sqrt() } else { 1.0 }
    });
    let scaled = DMatrix::from_fn(n, n, |i, j| hessian[(i, j)] / (length[i] * length[j]));
    let eigen = eigen::symmetric(scaled)?;
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
    let exact = directions.iter().filter(|direction| direction.kind == Kind::Exact).count();
    let mut result = DMatrix::zeros(n, n);
    for k in order.into_iter().skip(exact) {
        let vector = eigen.eigenvectors.column(k);
        result += vector * vector.transpose() / eigen.eigenvalues[k];
    }
    Some(DMatrix::from_fn(n, n, |i, j| result[(i, j)] / (length[i] * length[j])))
}
