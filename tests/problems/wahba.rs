//! Wahba's problem: the rotation that turns one set of directions into another, on its manifold.

use homepoint::engine::gram::{Columns, LeastSquares, Normal, RunGram};
use homepoint::number::{Gradient, Number, partial, partials};
use homepoint::quaternion::Quaternion;
use nalgebra::DMatrix;

use super::Stream;

/// Directions before and after the rotation.
pub(crate) struct Wahba {
    columns: Columns,
    pub(crate) pairs: Vec<([f64; 3], [f64; 3])>,
}

/// Product of rotations: `b` first, then `a`.
pub(crate) fn product<T: Number>(a: Quaternion<T>, b: Quaternion<T>) -> Quaternion<T> {
    let ([ax, ay, az], [bx, by, bz]) = (a.v, b.v);
    Quaternion {
        w: a.w * b.w - ax * bx - ay * by - az * bz,
        v: [
            a.w * bx + b.w * ax + ay * bz - az * by,
            a.w * by + b.w * ay + az * bx - ax * bz,
            a.w * bz + b.w * az + ax * by - ay * bx,
        ],
    }
}

/// A vector turned: `q v q*`.
pub(crate) fn turned<T: Number>(q: Quaternion<T>, v: [T; 3]) -> [T; 3] {
    let pure = Quaternion { w: T::constant(0.0), v };
    let back = Quaternion { w: q.w, v: q.v.map(|x| -x) };
    product(product(q, pure), back).v
}

impl Wahba {
    /// `count` directions turned by `rotation`, with reading errors of up to `error`.
    pub(crate) fn new(rotation: [f64; 3], count: usize, error: f64) -> Self {
        let mut stream = Stream(11);
        let q = Quaternion::turn(rotation);
        let pairs = (0..count)
            .map(|_| {
                let a = [(); 3].map(|()| stream.next());
                (a, turned(q, a).map(|x| x + error * stream.next()))
            })
            .collect();
        Self { columns: Columns { global: 3, setups: vec![0], runs: vec![(0, 0)] }, pairs }
    }

    fn residuals<T: Number>(&self, q: Quaternion<T>) -> Vec<T> {
        let one = |(a, b): &([f64; 3], [f64; 3])| {
            let p = turned(q, a.map(T::constant));
            [0, 1, 2].map(|i| (-p[i] + b[i]) * 1e4)
        };
        self.pairs.iter().flat_map(one).collect()
    }
}

impl LeastSquares for Wahba {
    type Point = Quaternion<f64>;

    fn columns(&self) -> &Columns {
        &self.columns
    }

    fn reweight(&mut self, _: &Quaternion<f64>) {}

    fn weights_move(&self) -> bool {
        false
    }

    fn cost(&self, point: &Quaternion<f64>) -> f64 {
        self.residuals(*point).iter().map(|r| r * r).sum()
    }

    fn normal(&self, point: &Quaternion<f64>) -> Normal {
        let fixed = Quaternion {
            w: Gradient::<3>::constant(point.w),
            v: point.v.map(Gradient::<3>::constant),
        };
        let step = Quaternion::turn([0, 1, 2].map(|i| partial::<3>(0.0, i)));
        let residuals = self.residuals(product(fixed, step));
        let rows = DMatrix::from_row_iterator(
            residuals.len(),
            4,
            residuals.iter().flat_map(|r| partials(r).map(|d| -d).into_iter().chain([r.value()])),
        );
        let sums = RunGram { gram: rows.tr_mul(&rows), readings: residuals.len() };
        Normal { columns: self.columns.clone(), runs: vec![sums], priors: vec![] }
    }

    fn moved(&self, point: &Quaternion<f64>, step: &[f64]) -> Quaternion<f64> {
        let q = product(*point, Quaternion::turn([step[0], step[1], step[2]]));
        let length = (q.w * q.w + q.v.iter().map(|x| x * x).sum::<f64>()).sqrt();
        Quaternion { w: q.w / length, v: q.v.map(|x| x / length) }
    }
}
