//! Quaternions over any [`Number`]: the seed's eqs. (2)-(7).
//!
//! Answers: how a point is rotated, how rotations follow one another, and how a rotation is written
//! as a rotation vector and back, with derivatives that are right at the identity too.
//! Source: Depenthal 2009, section 3.1; Kuipers 1999.
//!
//! It does not estimate rotations and does not know about frames.

use std::ops::Mul;

use crate::number::Number;

/// A quaternion `w + i x + j y + k z`, eq. (2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quaternion<N> {
    /// Scalar part.
    pub w: N,
    /// Vector part.
    pub v: [N; 3],
}

impl<N: Number> Quaternion<N> {
    /// The quaternion with these components, as they are.
    pub fn new(w: N, x: N, y: N, z: N) -> Self {
        Self { w, v: [x, y, z] }
    }

    /// No rotation.
    pub fn identity() -> Self {
        Self::constant([1.0, 0.0, 0.0, 0.0])
    }

    /// The quaternion with components `[w, x, y, z]` and no derivatives.
    pub fn constant(components: [f64; 4]) -> Self {
        Self::from_components(components.map(N::constant))
    }

    /// The quaternion with components `[w, x, y, z]`, as they are.
    pub fn from_components([w, x, y, z]: [N; 4]) -> Self {
        Self::new(w, x, y, z)
    }

    /// Components `[w, x, y, z]`.
    pub fn components(&self) -> [N; 4] {
        [self.w, self.v[0], self.v[1], self.v[2]]
    }

    /// Rotation by `angle` (rad) about `axis`, eq. (7). The axis is normalised here; about a zero
    /// axis the result is no unit quaternion.
    pub fn from_axis_angle(axis: [N; 3], angle: N) -> Self {
        let length = dot(axis, axis).sqrt();
        let half = angle * 0.5;
        let sine = half.sin();
        let unit = |a: N| {
            if length.value() == 0.0 { N::constant(0.0) } else { a / length }
        };
        Self { w: half.cos(), v: axis.map(|a| unit(a) * sine) }
    }

    /// Rotation by `angle` (rad) about the x-axis, eq. (7).
    pub fn rotation_x(angle: N) -> Self {
        let (half, zero) = (angle * 0.5, N::constant(0.0));
        Self::new(half.cos(), half.sin(), zero, zero)
    }

    /// Rotation by `angle` (rad) about the y-axis, eq. (7).
    pub fn rotation_y(angle: N) -> Self {
        let (half, zero) = (angle * 0.5, N::constant(0.0));
        Self::new(half.cos(), zero, half.sin(), zero)
    }

    /// Rotation by `angle` (rad) about the z-axis, eqs. (8) and (12).
    pub fn rotation_z(angle: N) -> Self {
        let (half, zero) = (angle * 0.5, N::constant(0.0));
        Self::new(half.cos(), zero, zero, half.sin())
    }

    /// The rotation by a rotation vector (axis times angle, rad), eq. (7) with `θ u = v`; smooth at
    /// zero, where its derivative is half the vector.
    pub fn turn(v: [N; 3]) -> Self {
        let x = dot(v, v) * 0.25;
        let s = x.stumpff(1) * 0.5;
        Self { w: x.stumpff(0), v: v.map(|a| a * s) }
    }

    /// The shortest rotation vector (rad, length at most π): the inverse of [`Quaternion::turn`].
    ///
    /// `q` and `-q` give the same vector, and so does every positive multiple of `q`. Half a turn
    /// has two shortest vectors: the one along `v` is given. With `φ = θ/2` and `n = |v|`,
    /// `tan(φ/2) = n / (|q| + w)`, and halving once more leaves `tan(φ/4) <= tan(π/8)`, where
    /// `atan(t)/t` is a short series in `t²`: no root of zero, so derivatives are right at the
    /// identity, and no branch between it and half a turn. The zero quaternion gives NaN.
    pub fn to_rotation_vector(self) -> [N; 3] {
        let (w, v) =
            if self.w.value() < 0.0 { (-self.w, self.v.map(|a| -a)) } else { (self.w, self.v) };
        let n2 = dot(v, v);
        let first = (w * w + n2).sqrt() + w;
        let second = (n2 / (first * first) + 1.0).sqrt() + 1.0;
        let t_by_n = N::constant(1.0) / (first * second);
        let u = n2 * t_by_n * t_by_n;
        // Σ (-u)^i / (2 i + 1), u <= tan²(π/8) = 0.172.
        let mut sum = N::constant(0.0);
        for i in (0..26).rev() {
            sum = -(u * sum) + 1.0 / (2.0 * f64::from(i) + 1.0);
        }
        let factor = sum * t_by_n * 8.0;
        v.map(|a| a * factor)
    }

    /// The conjugate `q*`: the opposite rotation, if `q` is a unit quaternion.
    pub fn conjugate(self) -> Self {
        Self { w: self.w, v: self.v.map(|a| -a) }
    }

    /// Square of the length.
    pub fn norm_squared(self) -> N {
        self.w * self.w + dot(self.v, self.v)
    }

    /// The unit quaternion along this one; zero with derivative zero stays zero.
    pub fn normalise(self) -> Self {
        let length = self.norm_squared().sqrt();
        if length.value() == 0.0 {
            return Self::constant([0.0; 4]);
        }
        Self { w: self.w / length, v: self.v.map(|a| a / length) }
    }

    /// The quaternion that multiplied with this one gives the identity; of zero, NaN.
    pub fn inverse(self) -> Self {
        let square = self.norm_squared();
        let conjugate = self.conjugate();
        Self { w: conjugate.w / square, v: conjugate.v.map(|a| a / square) }
    }

    /// The vector part of `q p q*`, eq. (4): the rotated vector, if `q` is a unit quaternion.
    pub fn rotate(self, p: [N; 3]) -> [N; 3] {
        // Eq. (3) applied twice: (w² - v·v) p + 2 (v·p) v + 2 w (v × p), for every q.
        let Self { w, v } = self;
        let along = w * w - dot(v, v);
        let inward = dot(v, p) * 2.0;
        let across = cross(v, p);
        let twice = w * 2.0;
        [0, 1, 2].map(|i| along * p[i] + inward * v[i] + twice * across[i])
    }

    /// The rotation matrix of a unit quaternion by rows, eq. (6).
    pub fn matrix(self) -> [[N; 3]; 3] {
        let [w, x, y, z] = self.components();
        let diagonal = |a: N| (w * w + a * a) * 2.0 - 1.0;
        let sum = |a: N, b: N, c: N| (a * b + w * c) * 2.0;
        let difference = |a: N, b: N, c: N| (a * b - w * c) * 2.0;
        [
            [diagonal(x), difference(x, y, z), sum(x, z, y)],
            [sum(x, y, z), diagonal(y), difference(y, z, x)],
            [difference(x, z, y), sum(y, z, x), diagonal(z)],
        ]
    }
}

/// Quaternion product, eq. (3): `p q` rotates by `q` first, then by `p`.
impl<N: Number> Mul for Quaternion<N> {
    type Output = Self;

    fn mul(self, q: Self) -> Self {
        let across = cross(self.v, q.v);
        Self {
            w: self.w * q.w - dot(self.v, q.v),
            v: [0, 1, 2].map(|i| self.w * q.v[i] + q.w * self.v[i] + across[i]),
        }
    }
}

/// Scalar product of two vectors.
pub fn dot<N: Number>(a: [N; 3], b: [N; 3]) -> N {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Cross product of two vectors.
pub fn cross<N: Number>(a: [N; 3], b: [N; 3]) -> [N; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
