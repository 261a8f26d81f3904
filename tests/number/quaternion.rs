//! Quaternions: two routes to every rotation, against nalgebra, and derivatives at the identity.

use std::f64::consts::PI;

use homepoint::number::{
    Gradient, Number, derivative, derivatives2, partial, partials, variable, variable2,
};
use homepoint::quaternion::{Quaternion, cross};
use nalgebra::{UnitQuaternion, Vector3};
use proptest::prelude::*;

/// Compares lists of numbers to an absolute tolerance.
#[track_caller]
fn close<const N: usize>(found: [f64; N], expected: [f64; N], tolerance: f64) {
    for i in 0..N {
        let fits = (found[i] - expected[i]).abs() <= tolerance;
        assert!(fits, "component {i}: found {found:?}, expected {expected:?}");
    }
}

fn apply<N: Number>(m: [[N; 3]; 3], p: [N; 3]) -> [N; 3] {
    m.map(|row| row[0] * p[0] + row[1] * p[1] + row[2] * p[2])
}

/// Eq. (4) as written: two products with pure quaternions.
fn triple_product<N: Number>(q: Quaternion<N>, p: [N; 3]) -> Quaternion<N> {
    q * Quaternion { w: N::constant(0.0), v: p } * q.conjugate()
}

fn by_nalgebra(v: [f64; 3]) -> UnitQuaternion<f64> {
    UnitQuaternion::from_scaled_axis(Vector3::from(v))
}

fn vector() -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(-3.0..3.0)
}

/// Three variables at `v`, with their partial derivatives.
fn variables(v: [f64; 3]) -> [Gradient<3>; 3] {
    [0, 1, 2].map(|i| partial(v[i], i))
}

fn values<const N: usize>(v: [Gradient<N>; 3]) -> [f64; 3] {
    v.map(|a| a.value())
}

proptest! {
    #[test]
    fn rotates_as_nalgebra_does(v in vector(), u in vector(), p in vector()) {
        let (q, r) = (Quaternion::turn(v), Quaternion::turn(u));
        let (a, b) = (by_nalgebra(v), by_nalgebra(u));
        close(q.components(), [a.w, a.i, a.j, a.k], 1e-15);
        close(q.rotate(p), (a * Vector3::from(p)).into(), 1e-14);
        let product = a * b;
        close((q * r).components(), [product.w, product.i, product.j, product.k], 1e-15);
        close((q * r).rotate(p), q.rotate(r.rotate(p)), 1e-14);
        let matrix = a.to_rotation_matrix();
        for (i, row) in q.matrix().into_iter().enumerate() {
            close(row, [matrix[(i, 0)], matrix[(i, 1)], matrix[(i, 2)]], 1e-14);
        }
        let angle = v[0].hypot(v[1]).hypot(v[2]);
        close(Quaternion::from_axis_angle(v, angle).components(), q.components(), 1e-15);
        let back = by_nalgebra(v).scaled_axis();
        close(q.to_rotation_vector(), back.into(), 1e-14);
    }

    #[test]
    fn matrix_and_triple_product_are_one(v in vector(), p in vector()) {
        let q = Quaternion::turn(variables(v));
        let point = p.map(Gradient::<3>::constant);
        let (a, b, c) = (q.rotate(point), apply(q.matrix(), point), triple_product(q, point));
        prop_assert!(c.w.value().abs() < 1e-14);
        close(values(a), values(b), 1e-14);
        close(values(a), values(c.v), 1e-14);
        for i in 0..3 {
            close(partials(&a[i]), partials(&b[i]), 1e-13);
            close(partials(&a[i]), partials(&c.v[i]), 1e-13);
        }
    }

    #[test]
    fn rotation_vector_and_back(v in vector(), size in 0.0..1.0_f64) {
        // Lengths from 0 to just under half a turn.
        let length = v[0].hypot(v[1]).hypot(v[2]);
        prop_assume!(length > 1e-3);
        let v = v.map(|a| a / length * (PI - 1e-9) * size);
        let back = Quaternion::turn(variables(v)).to_rotation_vector();
        close(values(back), v, 1e-14);
        for i in 0..3 {
            let mut row = [0.0; 3];
            row[i] = 1.0;
            close(partials(&back[i]), row, 1e-13);
        }
    }

    #[test]
    fn derivative_of_a_turn_agrees_with_differences(v in vector(), p in vector()) {
        let found = Quaternion::turn(variables(v)).rotate(p.map(Gradient::<3>::constant));
        let step = 1e-5;
        for j in 0..3 {
            let mut sides = [v, v];
            sides[0][j] += step;
            sides[1][j] -= step;
            let [up, down] = sides.map(|side| Quaternion::turn(side).rotate(p));
            for i in 0..3 {
                let difference = (up[i] - down[i]) / (2.0 * step);
                prop_assert!((partials(&found[i])[j] - difference).abs() < 1e-8);
            }
        }
    }

    #[test]
    fn inverse_and_normalise(v in vector(), factor in 0.1..10.0_f64) {
        let q = Quaternion::turn(v);
        let long = Quaternion::from_components(q.components().map(|a| a * factor));
        close(long.normalise().components(), q.components(), 1e-15);
        close((long * long.inverse()).components(), [1.0, 0.0, 0.0, 0.0], 1e-15);
        close(q.inverse().components(), q.conjugate().components(), 1e-15);
        close(long.to_rotation_vector(), q.to_rotation_vector(), 1e-14);
        prop_assert!((long.norm_squared() - factor * factor).abs() < 1e-13 * factor * factor);
    }
}

#[test]
fn a_small_turn_moves_a_point_by_the_cross_product() {
    let q = Quaternion::turn(variables([0.0; 3]));
    close(q.components().map(|a| a.value()), [1.0, 0.0, 0.0, 0.0], 0.0);
    assert_eq!(partials(&q.w), [0.0; 3]);
    let p = [0.3, -1.2, 2.0];
    let moved = q.rotate(p.map(Gradient::<3>::constant));
    close(values(moved), p, 0.0);
    for j in 0..3 {
        let mut axis = [0.0; 3];
        axis[j] = 1.0;
        close(moved.map(|a| partials(&a)[j]), cross(axis, p), 1e-15);
    }
}

#[test]
fn second_derivative_of_a_turn_at_zero_points_to_the_axis() {
    // d²/dε² of rotate(turn(ε u), p) is u × (u × p).
    let (u, p) = ([0.6, 0.0, 0.8], [1.0, -2.0, 0.5]);
    let e = variable2(0.0);
    let moved = Quaternion::turn(u.map(|a| e * a)).rotate(p.map(Number::constant));
    close(moved.map(|a| derivatives2(a)[0]), cross(u, p), 1e-15);
    close(moved.map(|a| derivatives2(a)[1]), cross(u, cross(u, p)), 1e-15);
    let back = Quaternion::turn(u.map(|a| e * a)).to_rotation_vector();
    close(back.map(|a| derivatives2(a)[0]), u, 1e-15);
    close(back.map(|a| derivatives2(a)[1]), [0.0; 3], 1e-15);
}

#[test]
fn the_rotation_vector_of_the_identity_has_derivative_two() {
    for sign in [1.0, -1.0] {
        let q = Quaternion::from_components([
            partial::<4>(sign, 0),
            partial(0.0, 1),
            partial(0.0, 2),
            partial(0.0, 3),
        ]);
        let v = q.to_rotation_vector();
        close(values(v), [0.0; 3], 0.0);
        for i in 0..3 {
            let mut row = [0.0; 4];
            row[i + 1] = 2.0 * sign;
            close(partials(&v[i]), row, 1e-15);
        }
    }
}

#[test]
fn the_shortest_rotation_vector_is_given() {
    for angle in [3.5, 2.0 * PI - 1e-6, -4.0, 9.0] {
        let v = Quaternion::rotation_z(angle).to_rotation_vector();
        let shortest = angle - (angle / (2.0 * PI)).round() * 2.0 * PI;
        close(v, [0.0, 0.0, shortest], 1e-14);
    }
    // Half a turn, with either sign of the quaternion; the derivative is that of the angle.
    for sign in [1.0, -1.0] {
        let v = Quaternion::constant([0.0, 0.0, sign, 0.0]).to_rotation_vector();
        close(v, [0.0, sign * PI, 0.0], 1e-15);
    }
    for gap in [1e-3, 1e-9, 1e-12] {
        let v = Quaternion::rotation_x(variable(PI - gap)).to_rotation_vector();
        close(v.map(|a| a.value()), [PI - gap, 0.0, 0.0], 1e-15);
        close(v.map(derivative), [1.0, 0.0, 0.0], 1e-14);
    }
}

#[test]
fn turns_about_the_axes_follow_the_right_hand() {
    let quarter = variable(PI / 2.0);
    let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let cases = [
        (Quaternion::rotation_x(quarter), y, z, [0.0, -1.0, 0.0]),
        (Quaternion::rotation_y(quarter), z, x, [0.0, 0.0, -1.0]),
        (Quaternion::rotation_z(quarter), x, y, [-1.0, 0.0, 0.0]),
    ];
    for (i, (q, from, to, rate)) in cases.into_iter().enumerate() {
        let moved = q.rotate(from.map(Number::constant));
        close(moved.map(|a| a.value()), to, 1e-15);
        close(moved.map(derivative), rate, 1e-15);
        let axis = [x, y, z][i].map(Number::constant);
        let same = Quaternion::from_axis_angle(axis, quarter);
        close(same.components().map(|a| a.value()), q.components().map(|a| a.value()), 1e-15);
        close(same.components().map(derivative), q.components().map(derivative), 1e-15);
    }
}

#[test]
fn normalising_differentiates_along_the_sphere() {
    // At the identity the scalar part cannot change and has second derivative -1 across.
    let [w, across] = [variable2(0.0) + 1.0, variable2(0.0)];
    let zero = Number::constant(0.0);
    let along = Quaternion::new(w, zero, zero, zero).normalise();
    close(derivatives2(along.w), [0.0, 0.0], 1e-15);
    let tilted = Quaternion::new(Number::constant(1.0), zero, across, zero).normalise();
    close(derivatives2(tilted.w), [0.0, -1.0], 1e-15);
    close(derivatives2(tilted.v[1]), [1.0, 0.0], 1e-15);
    let nothing = Quaternion::new(zero, across, zero, zero).normalise();
    for a in nothing.components() {
        assert_eq!((a.value(), derivatives2(a)), (0.0, [0.0, 0.0]));
    }
    close(Quaternion::<f64>::identity().rotate([1.0, 2.0, 3.0]), [1.0, 2.0, 3.0], 0.0);
}
