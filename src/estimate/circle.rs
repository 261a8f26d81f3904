//! The circle in space nearest to some points: centre, normal and radius with their covariance.
//!
//! Answers: how far each point lies off the circle's plane (planar) and off the circle within the
//! plane (radial), as in Depenthal 2009, section 4, Figs. 5 and 6. Minimised is the sum of squared
//! distances to the circle, `Σ planar² + radial²` (geometric fit, Gauss-Newton), from the plane of
//! least scatter and Kåsa's circle in it. Planar and radial deviations have their own scatter, and
//! the covariance `A⁻¹ (s_p² J_pᵀ J_p + s_r² J_rᵀ J_r) A⁻¹` with `A = J_pᵀ J_p + J_rᵀ J_r` takes
//! each for white: where deviations follow the arm angle it is too small.

use nalgebra::{Matrix2x3, Matrix3, Matrix3x2, Matrix6, SMatrix, Vector3, Vector6};

use crate::estimate::eigen;

/// Points count as lying on a line if their spread across it is below this part of that along it.
const LINE: f64 = 1e-6;
/// Steps before giving up.
const STEPS: usize = 60;
/// A step this small against the radius ends the iteration.
const TOLERANCE: f64 = 1e-12;

/// A circle in space.
#[derive(Clone, Debug, PartialEq)]
pub struct Circle {
    /// Centre (m).
    pub centre: [f64; 3],
    /// Unit normal of its plane.
    pub normal: [f64; 3],
    /// Radius (m).
    pub radius: f64,
    /// Unit vectors in its plane; the second is the normal times the first.
    pub axes: [[f64; 3]; 2],
    /// Covariance of the centre along the axes and the normal (m), of a tilt of the normal about
    /// the axes (rad) and of the radius (m); `None` for three points, which leave no scatter.
    pub covariance: Option<Matrix6<f64>>,
    /// Standard deviation of planar and radial deviations (m), 0 for three points.
    pub scatter: [f64; 2],
    /// How many points.
    pub points: usize,
}

/// A point as the circle sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Off the plane, along the normal (m).
    pub planar: f64,
    /// Off the circle in the plane, outwards (m).
    pub radial: f64,
    /// Angle from the first axis, right-handed about the normal (rad).
    pub angle: f64,
}

/// Why points have no circle.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NoCircle {
    /// Fewer than three.
    #[error("{0} points do not make a circle: at least 3 are needed")]
    TooFew(usize),
    /// A coordinate that is no number.
    #[error("point {0} has a coordinate that is not finite")]
    NotFinite(usize),
    /// On a straight line, or all at one place.
    #[error("the points lie on a straight line, or at one place")]
    Line,
    /// So far apart that squares of their distances are not finite.
    #[error("the points are too far apart to compute with: check their unit")]
    TooFar,
    /// The arc is too short or too rough.
    #[error("no circle fits: the points show too little of their arc")]
    NotConverged,
}

impl Circle {
    /// Fits a circle; its normal points to the side of `up`.
    ///
    /// # Errors
    /// [`NoCircle`] if the points do not determine one.
    pub fn fit(points: &[[f64; 3]], up: [f64; 3]) -> Result<Self, NoCircle> {
        if let Some(bad) = points.iter().position(|p| p.iter().any(|x| !x.is_finite())) {
            return Err(NoCircle::NotFinite(bad));
        }
        if points.len() < 3 {
            return Err(NoCircle::TooFew(points.len()));
        }
        let mut circle = Self::start(points, Vector3::from(up))?;
        for _ in 0..STEPS {
            let sums = Sums::of(&circle, points);
            let Some(inverse) = sums.both().try_inverse() else { return Err(NoCircle::Line) };
            let step = -(inverse * sums.gradient);
            circle = circle.moved(&step);
            let size = circle.radius.abs().max(f64::MIN_POSITIVE);
            let (lengths, tilt) = (step.fixed_rows::<3>(0).norm(), step.fixed_rows::<2>(3).norm());
            if !step.iter().all(|x| x.is_finite()) {
                return Err(NoCircle::NotConverged);
            }
            if (lengths + step[5].abs()) / size + tilt <= TOLERANCE {
                return circle.finished(points);
            }
        }
        Err(NoCircle::NotConverged)
    }

    /// How the circle sees a point.
    pub fn sees(&self, point: [f64; 3]) -> Seen {
        let [a, b, planar] = self.components(point);
        Seen { planar, radial: a.hypot(b) - self.radius, angle: b.atan2(a) }
    }

    /// Covariance of the centre (m²) in the frame of the points.
    pub fn centre_covariance(&self) -> Option<Matrix3<f64>> {
        let frame = self.frame();
        let own = self.covariance?.fixed_view::<3, 3>(0, 0).into_owned();
        Some(frame * own * frame.transpose())
    }

    /// Covariance of the unit normal (rad²) in the frame of the points; none along itself.
    pub fn normal_covariance(&self) -> Option<Matrix3<f64>> {
        // A tilt (α, β) about the axes moves the normal by β axis_0 - α axis_1.
        let [x, y] = self.axes.map(Vector3::from);
        let moves = Matrix3x2::from_columns(&[-y, x]);
        let own = self.covariance?.fixed_view::<2, 2>(3, 3).into_owned();
        Some(moves * own * moves.transpose())
    }

    /// Standard uncertainty of the radius (m).
    pub fn radius_uncertainty(&self) -> Option<f64> {
        self.covariance.map(|covariance| covariance[(5, 5)].max(0.0).sqrt())
    }

    fn frame(&self) -> Matrix3<f64> {
        let [x, y] = self.axes.map(Vector3::from);
        Matrix3::from_columns(&[x, y, Vector3::from(self.normal)])
    }

    /// A point along the axes and the normal, from the centre.
    fn components(&self, point: [f64; 3]) -> [f64; 3] {
        let from_centre = Vector3::from(point) - Vector3::from(self.centre);
        (self.frame().transpose() * from_centre).into()
    }

    /// The plane of least scatter, and in it the circle with `x² + y² = 2 u x + 2 v y + w` (Kåsa).
    fn start(points: &[[f64; 3]], up: Vector3<f64>) -> Result<Self, NoCircle> {
        let count = points.len() as f64;
        let middle = points.iter().map(|p| Vector3::from(*p)).sum::<Vector3<f64>>() / count;
        let mut scatter = Matrix3::zeros();
        for point in points {
            let from_middle = Vector3::from(*point) - middle;
            scatter += from_middle * from_middle.transpose() / count;
        }
        let eigen = eigen::symmetric(scatter).ok_or(NoCircle::TooFar)?;
        let mut order = [0, 1, 2];
        order.sort_by(|i, j| eigen.eigenvalues[*j].total_cmp(&eigen.eigenvalues[*i]));
        let spread = order.map(|i| eigen.eigenvalues[i]);
        if spread[0] <= 0.0 || spread[1] <= LINE * LINE * spread[0] {
            return Err(NoCircle::Line);
        }
        let normal = eigen.eigenvectors.column(order[2]).into_owned();
        let normal = if normal.dot(&up) < 0.0 { -normal } else { normal };
        let first = eigen.eigenvectors.column(order[0]).into_owned();
        let second = normal.cross(&first);
        let axes = Matrix2x3::from_rows(&[first.transpose(), second.transpose()]);
        let (mut left, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for point in points {
            let flat = axes * (Vector3::from(*point) - middle);
            let row = Vector3::new(2.0 * flat.x, 2.0 * flat.y, 1.0);
            left += row * row.transpose();
            right += row * flat.norm_squared();
        }
        let solved = left.cholesky().ok_or(NoCircle::Line)?.solve(&right);
        let centre = middle + axes.transpose() * solved.fixed_rows::<2>(0);
        let radius = (solved.z + solved.fixed_rows::<2>(0).norm_squared()).max(0.0).sqrt();
        Ok(Self {
            centre: centre.into(),
            normal: normal.into(),
            radius,
            axes: [first.into(), second.into()],
            covariance: None,
            scatter: [0.0; 2],
            points: points.len(),
        })
    }

    /// Moved by a step: centre along axes and normal, tilt about the axes, radius.
    fn moved(&self, step: &Vector6<f64>) -> Self {
        let frame = self.frame();
        let [x, y] = self.axes.map(Vector3::from);
        let tilt = nalgebra::Rotation3::new(x * step[3] + y * step[4]);
        let normal = (tilt * Vector3::from(self.normal)).normalize();
        let first = tilt * x;
        let first = (first - normal * normal.dot(&first)).normalize();
        Self {
            centre: (Vector3::from(self.centre) + frame * step.fixed_rows::<3>(0)).into(),
            normal: normal.into(),
            radius: self.radius + step[5],
            axes: [first.into(), normal.cross(&first).into()],
            ..self.clone()
        }
    }

    fn finished(mut self, points: &[[f64; 3]]) -> Result<Self, NoCircle> {
        let sums = Sums::of(&self, points);
        let inverse = sums.both().try_inverse().ok_or(NoCircle::Line)?;
        // Each kind of deviation determines three of the six unknowns.
        let free = points.len() - 3;
        if free > 0 {
            let variance = sums.squares.map(|sum| sum / free as f64);
            let middle = sums.planar * variance[0] + sums.radial * variance[1];
            self.covariance = Some(inverse * middle * inverse);
            self.scatter = variance.map(f64::sqrt);
        }
        Ok(self)
    }
}

/// Normal equations of both kinds of deviation.
struct Sums {
    planar: Matrix6<f64>,
    radial: Matrix6<f64>,
    gradient: Vector6<f64>,
    squares: [f64; 2],
}

impl Sums {
    fn of(circle: &Circle, points: &[[f64; 3]]) -> Self {
        let mut sums = Self {
            planar: Matrix6::zeros(),
            radial: Matrix6::zeros(),
            gradient: Vector6::zeros(),
            squares: [0.0; 2],
        };
        for point in points {
            let [a, b, planar] = circle.components(*point);
            // In the centre every direction is outwards; it moves along no one of them.
            let flat = a.hypot(b).max(f64::MIN_POSITIVE);
            let (cosine, sine, radial) = (a / flat, b / flat, flat - circle.radius);
            let of_planar = Vector6::new(0.0, 0.0, -1.0, -b, a, 0.0);
            let of_radial =
                Vector6::new(-cosine, -sine, 0.0, sine * planar, -cosine * planar, -1.0);
            sums.planar += of_planar * of_planar.transpose();
            sums.radial += of_radial * of_radial.transpose();
            sums.gradient += of_planar * planar + of_radial * radial;
            sums.squares[0] += planar * planar;
            sums.squares[1] += radial * radial;
        }
        sums
    }

    fn both(&self) -> SMatrix<f64, 6, 6> {
        self.planar + self.radial
    }
}
