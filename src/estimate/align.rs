//! Alignment of two sets of points: rotation, translation and, if wanted, scale in closed form.
//!
//! Horn 1987, *Closed-form solution of absolute orientation using unit quaternions*: the rotation
//! is the eigenvector to the largest eigenvalue of a symmetric 4 × 4 matrix (section 4.A), so it is
//! never a reflection; the translation joins the centroids; the scale is the least-squares one for
//! exact source points. Gives start values: it weighs points, not coordinates, and has no
//! uncertainties. Points on a line are refused in words.

use nalgebra::{Matrix3, Matrix4, Vector3};

use crate::estimate::eigen;
use crate::quaternion::Quaternion;

/// Points count as lying on a line if their spread across it is below this part of that along it.
const LINE: f64 = 1e-6;
/// The two best rotations count as equally good below this relative distance.
const AMBIGUOUS: f64 = 1e-10;

/// A pair of the same point in both frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// In the frame to be moved, m.
    pub source: [f64; 3],
    /// In the other frame, m.
    pub target: [f64; 3],
    /// Weight, not negative (1 / variance).
    pub weight: f64,
}

/// `target ≈ scale · rotate(rotation, source) + translation`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alignment {
    /// Unit quaternion with `w ≥ 0`.
    pub rotation: Quaternion<f64>,
    /// In the target frame, m.
    pub translation: [f64; 3],
    /// 1 unless it was asked for.
    pub scale: f64,
    /// Weighted root mean square of the distances left over, m.
    pub rms: f64,
}

/// Why points do not fix an alignment.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Degenerate {
    /// Fewer than three points.
    #[error("{0} points with weight do not fix an alignment: at least 3 are needed, not on a line")]
    TooFew(usize),
    /// A coordinate or weight is not a number, or a weight is negative.
    #[error("point {0} has a coordinate or weight that is not finite, or a negative weight")]
    NotFinite(usize),
    /// So far apart that squares of their distances are not finite.
    #[error("the points are too far apart to compute with: check their unit")]
    TooFar,
    /// All at one place.
    #[error("all points lie at one place: the rotation is open")]
    Coincident,
    /// On a straight line.
    #[error("the points lie on a straight line: the rotation about it is open; add points off it")]
    Collinear,
    /// The sets do not match, two rotations are equally good.
    #[error("two rotations fit equally well: the point sets look like mirror images of each other")]
    Ambiguous,
}

/// Aligns weighted pairs of points, in closed form.
///
/// # Errors
/// [`Degenerate`] if the points do not fix the rotation.
pub fn align(pairs: &[Pair], with_scale: bool) -> Result<Alignment, Degenerate> {
    if let Some(bad) = pairs.iter().position(|p| {
        !(p.source.iter().chain(&p.target).all(|x| x.is_finite())
            && p.weight.is_finite()
            && p.weight >= 0.0)
    }) {
        return Err(Degenerate::NotFinite(bad));
    }
    let points: Vec<_> = pairs
        .iter()
        .filter(|p| p.weight > 0.0)
        .map(|p| (Vector3::from(p.source), Vector3::from(p.target), p.weight))
        .collect();
    if points.len() < 3 {
        return Err(Degenerate::TooFew(points.len()));
    }
    let total: f64 = points.iter().map(|p| p.2).sum();
    let zero = (Vector3::zeros(), Vector3::zeros());
    let (from, to) = points.iter().fold(zero, |(from, to): (Vector3<f64>, Vector3<f64>), p| {
        (from + p.0 * (p.2 / total), to + p.1 * (p.2 / total))
    });
    let (mut source, mut target, mut cross) =
        (Matrix3::zeros(), Matrix3::zeros(), Matrix3::zeros());
    for (a, b, weight) in &points {
        let (a, b, weight) = (a - from, b - to, weight / total);
        source += a * a.transpose() * weight;
        target += b * b.transpose() * weight;
        cross += a * b.transpose() * weight;
    }
    check_spread(&source)?;
    check_spread(&target)?;
    let rotation = best_rotation(&(cross / (source.trace() * target.trace()).sqrt()))?;
    let turned = |v: Vector3<f64>| turn(&rotation, v);
    let scale = if with_scale {
        // Σ b · R a, with the sum over the cross products of coordinates.
        let matched: f64 =
            (0..3).map(|i| turned(Vector3::ith(i, 1.0)).dot(&cross.row(i).transpose())).sum();
        matched / source.trace()
    } else {
        1.0
    };
    let translation = to - turned(from) * scale;
    let squares: f64 = points
        .iter()
        .map(|(a, b, w)| (b - to - turned(a - from) * scale).norm_squared() * w / total)
        .sum();
    Ok(Alignment { rotation, translation: translation.into(), scale, rms: squares.sqrt() })
}

/// Whether points with this scatter span a plane at least.
fn check_spread(scatter: &Matrix3<f64>) -> Result<(), Degenerate> {
    let mut spread = eigen::symmetric(*scatter).ok_or(Degenerate::TooFar)?.eigenvalues;
    spread.as_mut_slice().sort_by(|a, b| b.total_cmp(a));
    if spread[0] <= 0.0 || spread[0].is_nan() {
        return Err(Degenerate::Coincident);
    }
    if spread[1] <= LINE * LINE * spread[0] { Err(Degenerate::Collinear) } else { Ok(()) }
}

/// Horn's matrix `N` and its eigenvector; `s[(i, j)]` sums source coordinate i × target j.
fn best_rotation(s: &Matrix3<f64>) -> Result<Quaternion<f64>, Degenerate> {
    let (xx, yy, zz) = (s[(0, 0)], s[(1, 1)], s[(2, 2)]);
    let (a, b, c) = (s[(1, 2)] - s[(2, 1)], s[(2, 0)] - s[(0, 2)], s[(0, 1)] - s[(1, 0)]);
    let (d, e, f) = (s[(0, 1)] + s[(1, 0)], s[(2, 0)] + s[(0, 2)], s[(1, 2)] + s[(2, 1)]);
    #[rustfmt::skip]
    let n = Matrix4::new(
        xx + yy + zz, a, b, c,
        a, xx - yy - zz, d, e,
        b, d, yy - xx - zz, f,
        c, e, f, zz - xx - yy,
    );
    let eigen = eigen::symmetric(n).ok_or(Degenerate::TooFar)?;
    let best = eigen.eigenvalues.imax();
    let value = eigen.eigenvalues[best];
    let second =
        (0..4).filter(|&i| i != best).map(|i| eigen.eigenvalues[i]).fold(f64::MIN, f64::max);
    if value - second <= AMBIGUOUS * eigen.eigenvalues.amax() {
        return Err(Degenerate::Ambiguous);
    }
    let q = eigen.eigenvectors.column(best).normalize();
    let q = if q[0] < 0.0 { -q } else { q };
    Ok(Quaternion { w: q[0], v: [q[1], q[2], q[3]] })
}

/// `v` rotated: `v + 2 w (q × v) + 2 q × (q × v)`.
fn turn(q: &Quaternion<f64>, v: Vector3<f64>) -> Vector3<f64> {
    let axis = Vector3::from(q.v);
    let cross = axis.cross(&v);
    v + cross * (2.0 * q.w) + axis.cross(&cross) * 2.0
}
