//! Vectors and rotations on nodes: the seed's eqs. (2)-(7), written once for every engine.
//!
//! A rotation is a unit quaternion (w, x, y, z) and acts as `q v q⁻¹`. Where something could be
//! divided by zero, it is not: the direction of a zero vector is zero, with zero derivative.

use crate::graph::node::{Binary, Leaf, NodeId, Unary};
use crate::graph::{Graph, Kind, Value};

impl Graph {
    /// The smaller or larger, the angle of a point, and the like.
    pub fn atan2(&mut self, y: NodeId, x: NodeId) -> NodeId {
        self.binary(Binary::Atan2, y, x)
    }

    /// Inner product.
    pub fn dot(&mut self, a: [NodeId; 3], b: [NodeId; 3]) -> NodeId {
        self.sum_of_products(&[(a[0], b[0]), (a[1], b[1]), (a[2], b[2])])
    }

    /// Outer product.
    pub fn cross(&mut self, a: [NodeId; 3], b: [NodeId; 3]) -> [NodeId; 3] {
        [(1, 2), (2, 0), (0, 1)].map(|(i, j)| {
            let plus = self.multiply(a[i], b[j]);
            let minus = self.multiply(a[j], b[i]);
            self.subtract(plus, minus)
        })
    }

    /// Length of a vector, or of a quaternion; its derivative at zero counts as zero.
    pub fn norm<const N: usize>(&mut self, v: [NodeId; N]) -> NodeId {
        let squares = self.sum_of_products(&v.map(|x| (x, x)));
        self.unary(Unary::Sqrt, squares)
    }

    /// Every component times one factor.
    pub fn scaled<const N: usize>(&mut self, factor: NodeId, v: [NodeId; N]) -> [NodeId; N] {
        v.map(|x| self.multiply(factor, x))
    }

    /// Length one in the same direction; zero for zero.
    pub fn normalized<const N: usize>(&mut self, v: [NodeId; N]) -> [NodeId; N] {
        let norm = self.norm(v);
        let reciprocal = self.unary(Unary::ReciprocalOrZero, norm);
        self.scaled(reciprocal, v)
    }

    /// The rotation by an angle about an axis of length one.
    pub fn rotation_about(&mut self, axis: [NodeId; 3], angle: NodeId) -> [NodeId; 4] {
        let half = self.scale(0.5, angle);
        let w = self.unary(Unary::Cos, half);
        let sine = self.unary(Unary::Sin, half);
        let [x, y, z] = self.scaled(sine, axis);
        [w, x, y, z]
    }

    /// The rotation by an angle about the coordinate axis of this number. What it turns is turned
    /// by sine and cosine of the angle itself, eq. (8) multiplied out.
    pub fn rotation_about_coordinate(&mut self, number: usize, angle: NodeId) -> [NodeId; 4] {
        let [zero, one] = [0.0, 1.0].map(|value| self.constant(value));
        let mut axis = [zero; 3];
        axis[number] = one;
        let quaternion = self.rotation_about(axis, angle);
        let (i, j) = ((number + 1) % 3, (number + 2) % 3);
        let (cos, sin) = (self.unary(Unary::Cos, angle), self.unary(Unary::Sin, angle));
        let mut matrix = [[zero; 3]; 3];
        matrix[number][number] = one;
        (matrix[i][i], matrix[j][j]) = (cos, cos);
        (matrix[i][j], matrix[j][i]) = (self.negate(sin), sin);
        self.matrices.insert(quaternion, matrix);
        quaternion
    }

    /// The rotation by a rotation vector, smooth at zero:
    /// (c₀(|v|²/4), v/2 · c₁(|v|²/4)) with the Stumpff functions.
    pub fn turn(&mut self, v: [NodeId; 3]) -> [NodeId; 4] {
        let square = self.dot(v, v);
        let quarter = self.scale(0.25, square);
        let w = self.unary(Unary::Stumpff(0), quarter);
        let sine = self.unary(Unary::Stumpff(1), quarter);
        let factor = self.scale(0.5, sine);
        let [x, y, z] = self.scaled(factor, v);
        [w, x, y, z]
    }

    /// The quaternion product, eq. (3): first `q`, then `p`. Where the matrix of one of them is
    /// known, so is that of both: turned by nothing, a turn stays what it is, bit by bit.
    pub fn compose(&mut self, p: [NodeId; 4], q: [NodeId; 4]) -> [NodeId; 4] {
        let product = self.quaternion_product(p, q);
        if self.matrices.contains_key(&p) || self.matrices.contains_key(&q) {
            let (left, right) = (self.matrix(p), self.matrix(q));
            let matrix = left.map(|row| {
                [0, 1, 2].map(|j| self.dot(row, [right[0][j], right[1][j], right[2][j]]))
            });
            self.matrices.insert(product, matrix);
        }
        product
    }

    fn quaternion_product(&mut self, p: [NodeId; 4], q: [NodeId; 4]) -> [NodeId; 4] {
        let ([pw, pv @ ..], [qw, qv @ ..]) = (p, q);
        let dot = self.dot(pv, qv);
        let ww = self.multiply(pw, qw);
        let w = self.subtract(ww, dot);
        let cross = self.cross(pv, qv);
        let [x, y, z] = [0, 1, 2].map(|i| {
            let sum = self.sum_of_products(&[(pw, qv[i]), (qw, pv[i])]);
            self.add(sum, cross[i])
        });
        [w, x, y, z]
    }

    /// The inverse of a rotation.
    pub fn inverse(&mut self, q: [NodeId; 4]) -> [NodeId; 4] {
        let [w, x, y, z] = q;
        let inverse = [w, self.negate(x), self.negate(y), self.negate(z)];
        if let Some(matrix) = self.matrices.get(&q).copied() {
            let transposed = [0, 1, 2].map(|i| matrix.map(|row| row[i]));
            self.matrices.insert(inverse, transposed);
        }
        inverse
    }

    /// A vector turned, `q v q⁻¹` for unit q, by the rotation's matrix: where the rotation stands
    /// still, the matrix is made once for all samples.
    pub fn rotate(&mut self, q: [NodeId; 4], v: [NodeId; 3]) -> [NodeId; 3] {
        self.matrix(q).map(|row| self.dot(row, v))
    }

    /// The matrix of a rotation, row by row, eq. (6).
    pub fn matrix(&mut self, q: [NodeId; 4]) -> [[NodeId; 3]; 3] {
        if let Some(known) = self.matrices.get(&q) {
            return *known;
        }
        let [w, u @ ..] = q;
        let one = self.constant(1.0);
        [0, 1, 2].map(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let mut row = [one; 3];
            let squares = self.sum_of_products(&[(u[j], u[j]), (u[k], u[k])]);
            let twice = self.scale(2.0, squares);
            row[i] = self.subtract(one, twice);
            let (ij, wk) = (self.multiply(u[i], u[j]), self.multiply(w, u[k]));
            let minus = self.subtract(ij, wk);
            row[j] = self.scale(2.0, minus);
            let (ik, wj) = (self.multiply(u[i], u[k]), self.multiply(w, u[j]));
            let plus = self.add(ik, wj);
            row[k] = self.scale(2.0, plus);
            row
        })
    }

    /// The rotation vector of a unit quaternion, of length at most π; smooth at the identity. The
    /// operations are those of [`crate::quaternion::Quaternion::to_rotation_vector`].
    pub fn rotation_vector(&mut self, [w, v @ ..]: [NodeId; 4]) -> [NodeId; 3] {
        let (zero, one) = (self.constant(0.0), self.constant(1.0));
        // 1 where w >= 0, else -1.
        let half = self.constant(0.5);
        let side = self.unary(Unary::Sign, w);
        let side = self.add(side, half);
        let side = self.unary(Unary::Sign, side);
        let w = self.multiply(side, w);
        let v = self.scaled(side, v);
        let n2 = self.dot(v, v);
        let square = self.multiply(w, w);
        let length = self.add(square, n2);
        let length = self.unary(Unary::Sqrt, length);
        let first = self.add(length, w);
        let first_square = self.multiply(first, first);
        let ratio = self.divide(n2, first_square);
        let second = self.add(ratio, one);
        let second = self.unary(Unary::Sqrt, second);
        let second = self.add(second, one);
        let product = self.multiply(first, second);
        let tangent_by_n = self.divide(one, product);
        let tangent_square = self.multiply(tangent_by_n, tangent_by_n);
        let u = self.multiply(n2, tangent_square);
        // Σ (-u)^i / (2 i + 1), u <= tan²(π/8) = 0.172.
        let mut sum = zero;
        for i in (0..26).rev() {
            let term = self.constant(1.0 / (2.0 * f64::from(i) + 1.0));
            let before = self.multiply(u, sum);
            sum = self.subtract(term, before);
        }
        let factor = self.multiply(sum, tangent_by_n);
        let factor = self.scale(8.0, factor);
        self.scaled(factor, v)
    }

    /// A value whose components are leaves.
    pub fn leaves(&mut self, kind: Kind, leaf: impl Fn(u8) -> Leaf) -> Value {
        match kind {
            Kind::Scalar => Value::Scalar(self.leaf(leaf(0))),
            Kind::Vector => Value::Vector([0, 1, 2].map(|i| self.leaf(leaf(i)))),
            Kind::Rotation => Value::Rotation([0, 1, 2, 3].map(|i| self.leaf(leaf(i)))),
        }
    }
}
