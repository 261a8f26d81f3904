//! The seed's models written by hand: a second route to what the model files say.
//!
//! Depenthal 2009, eqs. (8)-(16), over any [`Number`], so a delay's derivative comes from an arm
//! angle that moves ([`at_delay`]). Rotations are matrices by eq. (6) only; nothing is shared with
//! the crate but the numbers. Orientations are unit quaternions `[w, x, y, z]`, lengths in m,
//! angles in rad, and the vertical angle is the zenith angle.
//!
//! Include it with `#[path = "problems/seed.rs"] mod seed;`. Its own tests come along: they use
//! every function, so none counts as dead code.

use homepoint::number::Number;

/// An angle that turns at a constant `rate` (rad/s), `delay` (s) after its reference time.
pub(crate) fn at_delay<N: Number>(angle: f64, rate: f64, delay: N) -> N {
    delay * rate + angle
}

/// The matrix Q of a unit quaternion, eq. (6), by rows.
pub(crate) fn matrix<N: Number>([w, x, y, z]: [N; 4]) -> [[N; 3]; 3] {
    [
        [w * w * 2.0 - 1.0 + x * x * 2.0, x * y * 2.0 - w * z * 2.0, x * z * 2.0 + w * y * 2.0],
        [x * y * 2.0 + w * z * 2.0, w * w * 2.0 - 1.0 + y * y * 2.0, y * z * 2.0 - w * x * 2.0],
        [x * z * 2.0 - w * y * 2.0, y * z * 2.0 + w * x * 2.0, w * w * 2.0 - 1.0 + z * z * 2.0],
    ]
}

/// `Q p`, eq. (5).
pub(crate) fn apply<N: Number>(q: [[N; 3]; 3], p: [N; 3]) -> [N; 3] {
    q.map(|row| row[0] * p[0] + row[1] * p[1] + row[2] * p[2])
}

/// The quaternion about the z-axis, eqs. (8) and (12).
pub(crate) fn about_z<N: Number>(angle: N) -> [N; 4] {
    let (half, zero) = (angle * 0.5, N::constant(0.0));
    [half.cos(), zero, zero, half.sin()]
}

/// The target in the frame of the instrument, one rotation: eq. (10) by matrices.
pub(crate) fn point_one_rotation<N: Number>(
    arm_angle: N,
    radius: N,
    orientation: [N; 4],
    position: [N; 3],
) -> [N; 3] {
    let homepoint = [radius, N::constant(0.0), N::constant(0.0)];
    let target = apply(matrix(about_z(arm_angle)), homepoint);
    let turned = apply(matrix(orientation), target);
    [0, 1, 2].map(|i| turned[i] + position[i])
}

/// The target in the frame of the turning instrument, two rotations: eqs. (13) and (14). The
/// platform turns points by `platform_angle` about the instrument's z-axis, the position included.
pub(crate) fn point_two_rotations<N: Number>(
    arm_angle: N,
    platform_angle: N,
    radius: N,
    orientation: [N; 4],
    position: [N; 3],
) -> [N; 3] {
    let before = point_one_rotation(arm_angle, radius, orientation, position);
    apply(matrix(about_z(platform_angle)), before)
}

/// Horizontal angle, vertical angle (from the zenith) and distance of a point.
pub(crate) fn polar<N: Number>([x, y, z]: [N; 3]) -> [N; 3] {
    [y.atan2(x), x.hypot(y).atan2(z), (x * x + y * y + z * z).sqrt()]
}

/// Horizontal angle, vertical angle and distance that follow one rotation, section 3.2.1.
pub(crate) fn polar_one_rotation<N: Number>(
    arm_angle: N,
    radius: N,
    orientation: [N; 4],
    position: [N; 3],
) -> [N; 3] {
    polar(point_one_rotation(arm_angle, radius, orientation, position))
}

/// Horizontal angle, vertical angle and distance that follow two rotations, section 3.2.2.
pub(crate) fn polar_two_rotations<N: Number>(
    arm_angle: N,
    platform_angle: N,
    radius: N,
    orientation: [N; 4],
    position: [N; 3],
) -> [N; 3] {
    polar(point_two_rotations(arm_angle, platform_angle, radius, orientation, position))
}

/// Horizontal and vertical angle at the first station, then at the second, which stands at
/// `(base_length, 0, base_height)` in the frame of the first: section 3.3, eqs. (15) and (16).
pub(crate) fn angular_intersection<N: Number>(
    arm_angle: N,
    radius: N,
    orientation: [N; 4],
    position: [N; 3],
    base_length: N,
    base_height: N,
) -> [N; 4] {
    let point = point_one_rotation(arm_angle, radius, orientation, position);
    let [horizontal_a, vertical_a, _] = polar(point);
    let from_b = [point[0] - base_length, point[1], point[2] - base_height];
    let [horizontal_b, vertical_b, _] = polar(from_b);
    [horizontal_a, vertical_a, horizontal_b, vertical_b]
}

/// Eq. (11), the point of one rotation written out. The seed prints the first row as
/// `2 s² - 1 + x²`; by eq. (6) it must be `2 s² - 1 + 2 x²`: `factor` is what stands before x².
pub(crate) fn point_written_out<N: Number>(
    factor: f64,
    arm_angle: N,
    radius: N,
    orientation: [N; 4],
    position: [N; 3],
) -> [N; 3] {
    let [q0, _, _, qz] = about_z(arm_angle);
    let [r0, rx, ry, rz] = orientation;
    let (s, x) = (r0 * q0 - rz * qz, rx * q0 + ry * qz);
    let (y, z) = (ry * q0 - rx * qz, rz * q0 + r0 * qz);
    [
        (s * s * 2.0 - 1.0 + x * x * factor) * radius + position[0],
        (x * y * 2.0 + s * z * 2.0) * radius + position[1],
        (x * z * 2.0 - s * y * 2.0) * radius + position[2],
    ]
}

mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use homepoint::number::{Dual, Number, derivative, variable};
    use homepoint::quaternion::Quaternion;
    use proptest::prelude::*;

    use super::*;

    const RATE: f64 = 3.3;
    /// A few units of rounding of the target's speed, 2 m times `RATE`.
    const ROUNDING: f64 = 1e-14;

    #[track_caller]
    fn close<const N: usize>(found: [Dual; N], expected: [Dual; N], tolerance: f64) {
        for i in 0..N {
            let (a, b) = (found[i], expected[i]);
            let (value, rate) = (a.value() - b.value(), derivative(a) - derivative(b));
            let fits = value.abs() <= tolerance && rate.abs() <= tolerance;
            assert!(fits, "component {i}: found {a:?}, expected {b:?}");
        }
    }

    /// A pose as the functions want it, and its quaternion.
    fn pose(turn: [f64; 3], position: [f64; 3]) -> (Quaternion<Dual>, [Dual; 4], [Dual; 3]) {
        let orientation = Quaternion::turn(turn.map(Dual::constant));
        (orientation, orientation.components(), position.map(Dual::constant))
    }

    proptest! {
        #[test]
        fn every_model_agrees_with_the_quaternion_route(
            turn in prop::array::uniform3(-2.0..2.0),
            position in prop::array::uniform3(-3.0..3.0),
            (angle, platform, radius) in (-7.0..7.0, -7.0..7.0, 0.2..2.0),
            (length, height) in (1.0..5.0, -1.0..1.0),
        ) {
            let (q_r, orientation, p_tr) = pose(turn, position);
            let delay = variable(0.002);
            let (arm, table) = (at_delay(angle, RATE, delay), at_delay(platform, -1.7, delay));
            let radius = Dual::constant(radius);
            let zero = Dual::constant(0.0);
            // Eq. (10) by q_R q_1, eq. (13) by q_2 q_R q_1 and q_2.
            let (q_1, q_2) = (Quaternion::rotation_z(arm), Quaternion::rotation_z(table));
            let add = |a: [Dual; 3], b: [Dual; 3]| [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
            let home = [radius, zero, zero];
            let p_2 = add((q_r * q_1).rotate(home), p_tr);
            let p_3 = add((q_2 * q_r * q_1).rotate(home), q_2.rotate(p_tr));
            close(point_one_rotation(arm, radius, orientation, p_tr), p_2, 1e-13);
            close(point_two_rotations(arm, table, radius, orientation, p_tr), p_3, 1e-13);
            // The measurands give the points back: no inverse function is shared with `polar`.
            let back = |h: Dual, v: Dual, d: Dual| {
                [d * v.sin() * h.cos(), d * v.sin() * h.sin(), d * v.cos()]
            };
            // Near the pole rounding of x and y turns the direction by one over their distance from
            // it.
            let near = |p: [Dual; 3]| (1.0 / p[0].value().hypot(p[1].value())).max(1.0);
            let [h, v, d] = polar_one_rotation(arm, radius, orientation, p_tr);
            close(back(h, v, d), p_2, 1e-13 * near(p_2));
            let [h, v, d] = polar_two_rotations(arm, table, radius, orientation, p_tr);
            close(back(h, v, d), p_3, 1e-13 * near(p_3));
            // Seen from the second station, along the two angles at the true distance.
            let (s, e) = (Dual::constant(length), Dual::constant(height));
            let [h_a, v_a, h_b, v_b] =
                angular_intersection(arm, radius, orientation, p_tr, s, e);
            let from_b = [p_2[0] - s, p_2[1], p_2[2] - e];
            let d_b = (from_b[0] * from_b[0] + from_b[1] * from_b[1] + from_b[2] * from_b[2]).sqrt();
            close(back(h_b, v_b, d_b), from_b, 1e-12 * near(from_b));
            let [h, v, _] = polar_one_rotation(arm, radius, orientation, p_tr);
            close([h_a, v_a], [h, v], 0.0);
        }

        #[test]
        fn the_corrected_equation_11_is_equation_10_and_the_printed_one_is_not(
            turn in prop::array::uniform3(-2.0..2.0),
            position in prop::array::uniform3(-3.0..3.0),
            angle in -7.0..7.0,
        ) {
            let (_, orientation, p_tr) = pose(turn, position);
            let arm = at_delay(angle, RATE, variable(0.0));
            let radius = Dual::constant(1.146);
            let by_matrices = point_one_rotation(arm, radius, orientation, p_tr);
            close(point_written_out(2.0, arm, radius, orientation, p_tr), by_matrices, 1e-13);
            // The printed row falls short by r x², with x the quaternion's component (q_R q_1)_x.
            let printed = point_written_out(1.0, arm, radius, orientation, p_tr);
            let x = turn_component(orientation, angle);
            let short = by_matrices[0].value() - printed[0].value();
            prop_assert!((short - 1.146 * x * x).abs() < 1e-13);
            prop_assume!(x.abs() > 1e-3);
            prop_assert!(short > 1e-6);
        }
    }

    /// x-component of `q_R q_1` by eq. (3).
    fn turn_component(orientation: [Dual; 4], angle: f64) -> f64 {
        let [_, x, y, _] = orientation.map(|a| a.value());
        x * (angle / 2.0).cos() + y * (angle / 2.0).sin()
    }

    #[test]
    fn the_printed_equation_11_does_not_keep_the_radius() {
        // Half a turn about x: the homepoint stays at (r, 0, 0); printed, it comes to the origin.
        let half_turn = [0.0, 1.0, 0.0, 0.0];
        assert_eq!(point_one_rotation(0.0, 1.0, half_turn, [0.0; 3]), [1.0, 0.0, 0.0]);
        assert_eq!(point_written_out(2.0, 0.0, 1.0, half_turn, [0.0; 3]), [1.0, 0.0, 0.0]);
        assert_eq!(point_written_out(1.0, 0.0, 1.0, half_turn, [0.0; 3]), [0.0, 0.0, 0.0]);
    }

    #[test]
    fn on_the_axes_the_measurands_are_plain() {
        // No rotation, instrument in the centre: the horizontal angle is the arm angle.
        let unit = [1.0, 0.0, 0.0, 0.0].map(Dual::constant);
        let centre = [0.0; 3].map(Dual::constant);
        let radius = Dual::constant(2.0);
        for quarter in -1..=2 {
            let arm = at_delay(f64::from(quarter) * FRAC_PI_2, RATE, variable(0.0));
            let expected = [arm, Dual::constant(FRAC_PI_2), radius];
            close(polar_one_rotation(arm, radius, unit, centre), expected, ROUNDING);
        }
        // Arm and platform turn against each other: the target stands still.
        let arm = at_delay(0.4, RATE, variable(0.0));
        let expected = [Dual::constant(0.0), Dual::constant(FRAC_PI_2), radius];
        close(polar_two_rotations(arm, -arm, radius, unit, centre), expected, ROUNDING);
        // Above the instrument by the radius: 45 degrees; below: 135 degrees.
        for (height, zenith) in [(2.0, 0.25 * PI), (-2.0, 0.75 * PI), (0.0, FRAC_PI_2)] {
            let above = [0.0, 0.0, height].map(Dual::constant);
            let [_, vertical, _] = polar_one_rotation(arm, radius, unit, above);
            close([vertical], [Dual::constant(zenith)], ROUNDING);
        }
        // Straight overhead, where the horizontal angle is singular: all stays finite.
        let overhead = polar([0.0, 0.0, 3.0].map(Dual::constant));
        close(overhead, [0.0, 0.0, 3.0].map(Dual::constant), 0.0);
    }

    #[test]
    fn the_second_station_sees_the_target_from_the_end_of_the_base() {
        // Target at (2, 0, 0), second station at (2, 0, -2): straight overhead.
        let unit = [1.0, 0.0, 0.0, 0.0];
        let seen = angular_intersection(0.0, 2.0, unit, [0.0; 3], 2.0, -2.0);
        assert_eq!(seen, [0.0, FRAC_PI_2, 0.0, 0.0]);
        // Second station at (4, 0, 0): it looks back along -x.
        let seen = angular_intersection(0.0, 2.0, unit, [0.0; 3], 4.0, 0.0);
        assert_eq!(seen, [0.0, FRAC_PI_2, PI, FRAC_PI_2]);
    }

    #[test]
    fn a_tracker_on_the_axis_turns_at_the_rates_of_the_seed() {
        // Section 4: vertical arm, tracker on the axis 1.4 m before the arm plane, 190 degrees/s,
        // 3.8 m/s at the target: the horizontal angle turns at r ω / 1.4 m = 2.7 rad/s at most.
        let rate = 190.0_f64.to_radians();
        let radius = 3.8 / rate;
        // The arm's z-axis points along the instrument's -x, the arm plane stands upright.
        let orientation = Quaternion::rotation_y(Dual::constant(-FRAC_PI_2)).components();
        let position = [1.4, 0.0, 0.0].map(Dual::constant);
        let mut largest = 0.0_f64;
        for degree in 0..360 {
            let arm = at_delay(f64::from(degree).to_radians(), rate, variable(0.0));
            let [h, _, d] = polar_one_rotation(arm, Dual::constant(radius), orientation, position);
            largest = largest.max(derivative(h).abs());
            assert!(
                (d.value() - 1.4_f64.hypot(radius)).abs() < 1e-14 && derivative(d).abs() < 1e-14
            );
        }
        assert!((largest - 3.8 / 1.4).abs() < 1e-12, "{largest}");
    }
}
