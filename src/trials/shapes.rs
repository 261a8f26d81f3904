//! Effects that no library holds: known causes in another form, and causes that nobody named.
//!
//! A diagnosis that is only tried on effects exactly as its library writes them is never surprised.
//! Here backlash is a step that is not the library's, servo loops have two poles, drifts level off,
//! waves have harmonics and frequencies between those that are scanned; and some effects have no
//! counterpart at all. Those that do not fit a model are passed over.

use std::sync::Arc;

use crate::diagnostic::Source;
use crate::effect::Effect;

/// A form that the library lacks.
#[derive(Clone, Debug)]
pub struct Shape {
    /// The effect.
    pub effect: Arc<Effect>,
    /// The library's names for its cause; none where it has no counterpart.
    pub names: &'static [&'static str],
}

/// Name, names of the library, parameters, patches.
type Written = (&'static str, &'static [&'static str], &'static str, &'static str);

/// Known causes in another form.
const FORMS: &[Written] = &[
    (
        "reversal_algebraic",
        &["tracking_reversal"],
        r#"step = { unit = "rad", typical = "1.6 arcsec", scope = "instrument" }"#,
        r#""each.angle" = 'self + step * rate(self) / sqrt(rate(self)^2 + (0.03 rad / 1 s)^2)'"#,
    ),
    (
        "reversal_sharp",
        &["tracking_reversal"],
        r#"step = { unit = "rad", typical = "1.6 arcsec", scope = "instrument" }"#,
        r#""each.angle" = 'self + step * sign(rate(self))'"#,
    ),
    (
        "two_pole_loop",
        &["servo_acceleration_lag", "first_order_lowpass"],
        r#"lag = { unit = "s^2", typical = "4e-6 s^2", scope = "instrument" }"#,
        r#""each.angle" = 'self - lag * (rate(rate(self)) - 10 ms * rate(rate(rate(self))))'"#,
    ),
    (
        "stribeck_windup",
        &["arm_windup"],
        r#"windup = { unit = "m", typical = "8 um", scope = "rig" }"#,
        r#"target = 'target - windup * tanh(rate(arm_angle) * 1 s / 6 deg) * rotate(arm_turn, [0, 1, 0])'"#,
    ),
    (
        "drag_of_less_than_square",
        &["air_drag"],
        r#"drag = { unit = "m", typical = "2 um", scope = "rig" }"#,
        r#"target = 'target - drag * sign(rate(arm_angle)) * abs(rate(arm_angle) * 1 s / 1 rad)^1.85 * rotate(arm_turn, [0, 1, 0])'"#,
    ),
    (
        "stretch_that_stiffens",
        &["centrifugal_stretch", "support_sway"],
        r#"stretch = { unit = "m/(rad/s)^2", typical = "0.5 um/(rad/s)^2", scope = "rig" }"#,
        r#"radius = 'radius + stretch * rate(arm_angle)^2 / (1 + (rate(arm_angle) * 1 s / 8 rad)^2)'"#,
    ),
    (
        "triangular_encoder_error",
        &["encoder_high_harmonic"],
        r#"cosine = { unit = "rad", typical = "1.3 arcsec", scope = "rig" }
sine = { unit = "rad", typical = "1.3 arcsec", scope = "rig" }"#,
        r#"arm_angle = 'arm_angle + cosine * asin(0.95 * cos(4 * arm_angle)) + sine * asin(0.95 * sin(4 * arm_angle))'"#,
    ),
    (
        "clock_warming_up",
        &["clock_drift", "sample_clock_rate"],
        r#"rate_error = { unit = "1", typical = "5 ppm", scope = "instrument" }"#,
        r#"t = 't + rate_error * 200 s * (1 - exp(-run_time / 200 s))'"#,
    ),
    (
        "arm_growth_levelling_off",
        &["arm_thermal_growth"],
        r#"growth = { unit = "m/s", typical = "10 um/h", scope = "rig" }"#,
        r#"radius = 'radius + growth * 1.5 h * (1 - exp(-time / 1.5 h))'"#,
    ),
    (
        "station_settling",
        &["station_drift"],
        r#"velocity = { kind = "vector", unit = "m/s", typical = "40 um/h", scope = "setup" }"#,
        r#"position = 'position + velocity * 30 min * (1 - exp(-setup_time / 30 min))'"#,
    ),
    (
        "cyclic_with_overtone",
        &["distance_cyclic"],
        r#"cosine = { unit = "m", typical = "8 um", scope = "instrument" }
sine = { unit = "m", typical = "8 um", scope = "instrument" }"#,
        r#"distance = 'distance + cosine * (cos(2 * pi * distance / 0.61 m) + 0.1 * cos(4 * pi * distance / 0.61 m)) + sine * (sin(2 * pi * distance / 0.61 m) + 0.1 * sin(4 * pi * distance / 0.61 m))'"#,
    ),
    (
        "torsion_dying_away",
        &["arm_torsion_oscillation"],
        r#"cosine = { unit = "m", typical = "15 um", scope = "run" }
sine = { unit = "m", typical = "15 um", scope = "run" }"#,
        r#"target = 'target + exp(-run_time / 60 s) * (cosine * cos(2 * pi * 3.71 Hz * run_time) + sine * sin(2 * pi * 3.71 Hz * run_time)) * rotate(arm_turn, [0, 1, 0])'"#,
    ),
];

/// Causes without a name.
const NAMELESS: &[Written] = &[
    (
        "cable_over_platform",
        &[],
        r#"cosine = { unit = "rad", typical = "2 arcsec", scope = "rig" }
sine = { unit = "rad", typical = "2 arcsec", scope = "rig" }"#,
        r#"vertical = 'vertical + cosine * cos(2 * platform_angle) + sine * sin(2 * platform_angle)'"#,
    ),
    (
        "third_harmonic_of_the_circle",
        &[],
        r#"cosine = { unit = "rad", typical = "2 arcsec", scope = "instrument" }
sine = { unit = "rad", typical = "2 arcsec", scope = "instrument" }"#,
        r#"horizontal = 'horizontal + cosine * cos(3 * horizontal) + sine * sin(3 * horizontal)'"#,
    ),
    (
        "vertical_over_arm_angle",
        &[],
        r#"cosine = { unit = "rad", typical = "2 arcsec", scope = "instrument" }
sine = { unit = "rad", typical = "2 arcsec", scope = "instrument" }"#,
        r#"vertical = 'vertical + cosine * cos(3 * arm_angle) + sine * sin(3 * arm_angle)'"#,
    ),
    (
        "bump_on_the_arm",
        &[],
        r#"bump = { unit = "m", typical = "20 um", scope = "rig" }"#,
        r#"target = 'target + bump * exp(6 * (cos(arm_angle - 1) - 1)) * rotate(arm_turn, [1, 0, 0])'"#,
    ),
    (
        "step_of_the_distance",
        &[],
        r#"step = { unit = "m", typical = "20 um", scope = "instrument" }"#,
        r#"distance = 'distance + step * tanh((time - 15 min) / 1 min)'"#,
    ),
    (
        "third_radial_runout",
        &[],
        r#"cosine = { unit = "m", typical = "5 um", scope = "rig" }
sine = { unit = "m", typical = "5 um", scope = "rig" }"#,
        r#"target = 'target + (cosine * cos(3 * arm_angle) + sine * sin(3 * arm_angle)) * rotate(arm_turn, [1, 0, 0])'"#,
    ),
    (
        "vertical_late_over_arm_angle",
        &[],
        r#"cosine = { unit = "s", typical = "10 us", scope = "instrument" }
sine = { unit = "s", typical = "10 us", scope = "instrument" }"#,
        r#""vertical.t" = 't + cosine * cos(2 * arm_angle) + sine * sin(2 * arm_angle)'"#,
    ),
    (
        "distance_over_the_circle",
        &[],
        r#"cosine = { unit = "m", typical = "8 um", scope = "instrument" }
sine = { unit = "m", typical = "8 um", scope = "instrument" }"#,
        r#"distance = 'distance + cosine * cos(2 * horizontal) + sine * sin(2 * horizontal)'"#,
    ),
];

/// All shapes.
pub fn shapes() -> Vec<Shape> {
    FORMS.iter().chain(NAMELESS).filter_map(made).collect()
}

fn made((name, names, parameters, patch): &Written) -> Option<Shape> {
    let text = format!(
        "name = \"{name}\"\ntitle = \"{name}\"\nacts = \"noise\"\n[parameters]\n{parameters}\n[patch]\n{patch}\n"
    );
    let effect = Arc::new(Effect::parse(Source::new(*name, text)).ok()?);
    Some(Shape { effect, names })
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use std::path::Path;

    use super::*;
    use crate::library::Library;
    use crate::system::{Selected, System};

    #[test]
    fn every_shape_can_be_read() {
        assert_eq!(shapes().len(), FORMS.len() + NAMELESS.len());
    }

    /// A form that no model takes is never drawn, and no score says so.
    #[test]
    fn every_shape_fits_a_model() {
        let library = Library::builtin().unwrap();
        let model = library.model("polar_two_rotations", Path::new(".")).unwrap();
        for shape in shapes() {
            let (effect, member) = (shape.effect.clone(), Default::default());
            let selected = Selected { effect, head: None, member };
            let built = System::build(&model, &[selected], &[], &vec![None; model.inputs.len()]);
            assert!(built.is_ok(), "{}: {:?}", shape.effect.name, built.err());
        }
    }
}
