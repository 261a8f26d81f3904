//! What a column without a unit measures, as its name says: a rate is no position.

use crate::campaign::begin::candidate::base;

/// Parts of names without their axis, and the usual unit of what is called so. The first that fits
/// counts; one letter without an axis says nothing (`bus_v` is a voltage).
const KINDS: [(&str, &str); 18] = [
    ("angular_velocity", "rad/s"),
    ("angular", "rad/s"),
    ("gyro", "rad/s"),
    ("g", "rad/s"),
    ("omega", "rad/s"),
    ("w", "rad/s"),
    ("linear_acceleration", "m/s^2"),
    ("acceleration", "m/s^2"),
    ("accel", "m/s^2"),
    ("acc", "m/s^2"),
    ("a", "m/s^2"),
    ("linear_velocity", "m/s"),
    ("linear", "m/s"),
    ("velocity", "m/s"),
    ("vel", "m/s"),
    ("speed", "m/s"),
    ("v", "m/s"),
    ("twist", "m/s"),
];
/// What parts a name.
const PARTS: [char; 3] = ['_', '.', '/'];

/// The usual unit of a rate or an acceleration, by the name of its column.
pub(super) fn rate(name: &str) -> Option<&'static str> {
    let base = base(name).0;
    let axis = base.strip_suffix(['x', 'y', 'z']);
    let stem = axis.unwrap_or(&base).trim_end_matches(PARTS);
    let is_called = |(kind, _): &&(&str, &str)| {
        let before = stem.strip_suffix(kind).filter(|_| kind.len() > 1 || axis.is_some());
        before.is_some_and(|before| before.is_empty() || before.ends_with(PARTS))
    };
    KINDS.iter().find(is_called).map(|(_, unit)| *unit)
}

#[cfg(test)]
mod tests {
    use super::rate;

    #[test]
    fn rates_are_known_by_their_names_without_axis() {
        for (name, unit) in [
            ("gx", Some("rad/s")),
            ("imu.angular_velocity.z", Some("rad/s")),
            ("linear_acceleration.x", Some("m/s^2")),
            ("vx", Some("m/s")),
            ("speed", Some("m/s")),
            ("v_x", Some("m/s")),
            ("base_vx", Some("m/s")),
            ("v", None),
            ("a", None),
            ("w", None),
            ("g", None),
            ("bus_v", None),
            ("supply_a", None),
            ("axyz", None),
            ("x", None),
            ("px", None),
            ("tracker_x", None),
            ("e", None),
            ("angle", None),
        ] {
            assert_eq!(rate(name), unit, "{name}");
        }
    }
}
