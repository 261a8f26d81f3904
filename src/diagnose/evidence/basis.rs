//! Directions in which columns differ beyond the nominal parameters: `W` with `Wᵀ S W = 1`.
//!
//! With it a candidate's score has one number for each degree of freedom, each of unit variance
//! without the effect. Columns are cut where less than [`RANK`] of their length is left. And what
//! one such set of directions says beyond another.

use nalgebra::linalg::Cholesky;
use nalgebra::{DMatrix, DVector};

use crate::estimate::eigen;

/// Share of a column's length below which nominal parameters take it up.
pub const RANK: f64 = 3e-4;

/// `W` with `Wᵀ S W = 1` and its counterpart, columns that are taken up left out.
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

/// The same of columns none of which is taken up, by far quicker: with `S = L Lᵀ` they are `L⁻ᵀ`
/// and `Lᵀ`. `None` where some eigenvalue may be below what counts as taken up: the least is at
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

/// What directions explain beyond others, `cosines` (one row for each of the others) between them,
/// with the degrees of freedom that are left; `others` and `score` are both scores. A direction of
/// which no more than `nearly` of its square is left says nothing more: that is rounding and small
/// angles.
pub(super) fn beyond(
    cosines: &DMatrix<f64>,
    others: &DVector<f64>,
    score: &DVector<f64>,
    nearly: f64,
) -> (f64, usize) {
    let score = score - cosines.tr_mul(others);
    if others.len() < score.len() {
        // All that is not along one of the few that they have in common is left whole.
        let Some(eigen) = eigen::symmetric(cosines * cosines.transpose()) else {
            return (0.0, 0);
        };
        let along = eigen.eigenvectors.tr_mul(&(cosines * &score));
        let (mut gain, mut degrees) = (score.norm_squared(), score.len());
        for (common, along) in eigen.eigenvalues.iter().zip(along.iter()) {
            let left = 1.0 - common;
            if left > nearly {
                gain += along * along / left;
            } else {
                gain -= along * along / common;
                degrees -= 1;
            }
        }
        return (gain.max(0.0), degrees);
    }
    let left = DMatrix::identity(score.len(), score.len()) - cosines.tr_mul(cosines);
    // The least eigenvalue is at least one over the sum of their reciprocals.
    if let Some(lower) = Cholesky::new(left.clone()).map(|factor| factor.unpack())
        && let Some(inverse) =
            lower.solve_lower_triangular(&DMatrix::identity(score.len(), score.len()))
        && inverse.norm_squared() * nearly < 1.0
    {
        return ((inverse * &score).norm_squared(), score.len());
    }
    let Some(eigen) = eigen::symmetric(left) else { return (0.0, 0) };
    let (mut gain, mut degrees) = (0.0, 0);
    for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
        if *value > nearly {
            gain += vector.dot(&score).powi(2) / value;
            degrees += 1;
        }
    }
    (gain, degrees)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Few others and many, one of which is contained or none: as projections of a reading say.
    #[test]
    fn what_is_said_beyond_others_is_what_projections_differ_by() {
        let rows = 40;
        let column = |n: usize| {
            DVector::from_fn(rows, |i, _| (((i * i + 3 * i) * (n + 2) + 7 * n) % 31) as f64 - 15.0)
        };
        let span = |columns: &[DVector<f64>]| DMatrix::from_columns(columns).qr().q();
        let reading = column(17);
        for (first, second, contained) in [(2, 6, false), (6, 2, false), (3, 5, true), (5, 3, true)]
        {
            let a: Vec<DVector<f64>> = (0..first).map(column).collect();
            let own: Vec<DVector<f64>> = (first..first + second).map(column).collect();
            let all: Vec<DVector<f64>> = a.iter().chain(&own).cloned().collect();
            let explained =
                |columns: &[DVector<f64>]| span(columns).tr_mul(&reading).norm_squared();
            let known = explained(&all) - explained(&a);
            let mut b = own;
            if contained {
                b.push(&a[0] - 2.0 * &a[1] + 0.5 * &b[0]);
            }
            let (a, b) = (span(&a), span(&b));
            let (gain, degrees) =
                beyond(&a.tr_mul(&b), &a.tr_mul(&reading), &b.tr_mul(&reading), 1e-9);
            assert_eq!(degrees, second);
            assert!((gain - known).abs() < 1e-9 * known, "{first} {second}: {gain} {known}");
        }
    }
}
