//! Relaxed forms of effects: a value for each angle or setup.

use std::path::Path;

use homepoint::diagnose::library::variant::Variant;
use homepoint::engine::layout::Instance;

use crate::found::told;
use crate::nameless::{with_a_nameless, with_a_nameless_in};

/// Both servos of a head lag, each with its own constant; with one constant it is the effect as the
/// library has it.
#[test]
fn a_lag_whose_axes_differ_has_a_value_for_each_angle() {
    let text = "[parameters]\nown = { unit = \"s^2\", typical = \"4e-6 s^2\", scope = \"rig\", per = \"measurand\" }\n\
                [patch]\n\"each.angle\" = 'self - own * rate(rate(self))'\n";
    for (lags, seed) in [([9e-6, 3e-6], 91), ([6e-6, -6e-6], 94)] {
        let lags = [("horizontal", lags[0]), ("vertical", lags[1])];
        let lag = |one: &Instance| {
            lags.iter().find(|(name, _)| one.name.ends_with(name)).map_or(0.0, |(_, lag)| *lag)
        };
        let found = with_a_nameless(text, seed, &lag);
        let [row] = &found.rows[..] else { panic!("{}", told(&found)) };
        assert_eq!(row.name, "servo_acceleration_lag", "{}", told(&found));
        assert_eq!(row.variant, Some(Variant::EachAngle), "{}", told(&found));
        for (name, lag) in lags {
            let value = row.values.iter().find(|one| one.name.ends_with(name)).unwrap();
            let far = (value.value.unwrap() - lag).abs() / value.sigma.unwrap();
            assert!(far < 4.0, "{name}: {far} u");
        }
    }
    let found = with_a_nameless(text, 92, &|_| 6e-6);
    let [row] = &found.rows[..] else { panic!("{}", told(&found)) };
    assert_eq!((row.name.as_str(), row.variant), ("servo_acceleration_lag", None));
}

/// An instrument that is levelled anew in each setup has a tilt of its trunnion axis of its own there.
#[test]
fn an_error_that_differs_between_setups_has_a_value_for_each() {
    let text = "[parameters]\nown = { unit = \"rad\", typical = \"4 arcsec\", scope = \"setup\" }\n\
                [patch]\nhorizontal = 'horizontal + own / sin(vertical)'\n";
    let campaign = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/four_setups");
    let own = |one: &Instance| match one.of.as_deref() {
        Some("A") => 60e-6,
        Some("B") => -40e-6,
        _ => 20e-6,
    };
    let found = with_a_nameless_in(campaign, &[], text, 93, &own);
    let names: Vec<&str> = found.rows.iter().map(|row| row.name.as_str()).collect();
    assert_eq!(names, ["collimation"], "{}", told(&found));
    assert_eq!(found.rows[0].variant, Some(Variant::EachSetup), "{}", told(&found));
}
