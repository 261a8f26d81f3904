//! Directions in which columns differ beyond the nominal parameters: `W` with `Wᵀ S W = 1`.
//!
//! With it a candidate's score has one number for each degree of freedom, each of unit variance
//! without the effect. Columns are cut where less than [`RANK`] of their length is left.

use nalgebra::linalg::Cholesky;
use nalgebra::{DMatrix, DVector};

use crate::estimate::eigen;

/// Share of a column's length below which nominal parameters take it up.
pub const RANK: f64 = 3e-4;

/// `W` with `Wᵀ S W = 1` and its counterpart, columns that are absorbed left out.
pub fn basis(left: &DMatrix<f64>, raw: &DVector<f64>) -> (DMatrix<f64>, DMatrix<f64>) {
    let k = left.nrows();
    let length = raw.map(|length| if length > 0.0 { length } else { 1.0 });
    let scaled = DMatrix::from_fn(k, k, |i, j| left[(i, j)] / (length[i] * length[j]));
    if let Some(found) = triangular(&scaled, &length) {
        return found;
    }
    let Some(eigen) = eigen::symmetric(scaled) else {
        return (DMatrix::zeros(k, 0), DMatrix::zeros(0, k));
    };
    let mut order: Vec<usize> = (0..k).filter(|i| eigen.eigenvalues[*i] > RANK * RANK).collect();
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    let root = |j: usize| eigen.eigenvalues[order[j]].sqrt();
    let vector = |i: usize, j: usize| eigen.eigenvectors[(i, order[j])];
    (
        DMatrix::from_fn(k, order.len(), |i, j| vector(i, j) / (length[i] * root(j))),
        DMatrix::from_fn(order.len(), k, |j, i| vector(i, j) * length[i] * root(j)),
    )
}

/// The same of columns none of which is absorbed, by far quicker: with `S = L Lᵀ` they are `L⁻ᵀ`
/// and `Lᵀ`. `None` where some eigenvalue may be below what counts as absorbed: the least is at
/// least `1 / tr S⁻¹`.
fn triangular(
    scaled: &DMatrix<f64>,
    length: &DVector<f64>,
) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
    let k = scaled.nrows();
    let lower = Cholesky::new(scaled.clone())?.unpack();
    let inverse = lower.solve_lower_triangular(&DMatrix::identity(k, k))?;
    let sound = inverse.norm_squared() * RANK * RANK < 1.0;
    sound.then(|| {
        let basis = DMatrix::from_fn(k, k, |i, j| inverse[(j, i)] / length[i]);
        let lengths = DMatrix::from_fn(k, k, |j, i| lower[(i, j)] * length[i]);
        (basis, lengths)
    })
}
