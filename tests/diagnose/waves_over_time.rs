//! Waves over time: of a day, which are no noise with a memory, and of no time at all, which are none.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use homepoint::diagnose::budget::answer::Verdict;

use crate::found::{names, told};
use crate::own_effects::Campaign;
use crate::stream::Stream;

/// A tilt meter on a dam, with a thermometer.
const DAM: &str = r#"
name = "dam"
title = "Tilt meter on a dam"
[inputs]
temperature = { unit = "K" }
level = { unit = "m" }
[parameters]
zero = { unit = "rad", scope = "rig" }
[quantities]
leaning = 'zero'
[measurands]
tilt = { value = 'leaning', unit = "rad" }
"#;
const PRESSED: (&str, &str, &str) = (
    "pressed",
    "by = { unit = \"rad/m\", typical = \"2 urad/m\", scope = \"rig\" }",
    "leaning = 'leaning + by * level'",
);

/// Twelve days, a reading every twenty minutes: the sun bends the dam, beside the water that leans on
/// it.
#[test]
fn a_wave_of_a_day_is_no_noise_that_remembers() {
    let mut random = Stream(97);
    let mut log = "time [s],temperature [K],level [m],tilt [rad]\n".to_owned();
    for row in 0..864 {
        let time = 1200.0 * f64::from(row);
        let level = 0.8 * (TAU * time / 4.1e5).sin() + 0.1 * random.normal();
        let day = 3e-6 * (TAU * time / 86_164.0 + 0.6).cos();
        let tilt = 2e-5 + 3e-6 * level + day + 1e-6 * random.normal();
        let temperature = 285.0 + random.normal();
        writeln!(log, "{time},{temperature:.2},{level:.4},{tilt:.9}").unwrap();
    }
    let measurands = "tilt = { sigma = \"1 urad\" }";
    let found = Campaign { model: DAM, effects: &[PRESSED], measurands, log }.diagnosed();
    assert_eq!(names(&found), ["pressed"], "{}", told(&found));
    assert_eq!(found.verdict, Verdict::PartlyExplained, "{}", told(&found));
    let words = &found.remainder[0].place.words;
    let period = words.strip_prefix("an error of `tilt` over time, a wave every ");
    let period = period.and_then(|rest| rest.strip_suffix(" s")?.parse::<f64>().ok());
    let period = period.unwrap_or_else(|| panic!("{}", told(&found)));
    assert!((period / 86_164.0 - 1.0).abs() < 0.01, "{period}");
    assert!(found.autocorrelation.is_empty(), "{}", told(&found));
}

/// A station that sees points at rest, in a table without times.
const STATION: &str = r#"
name = "station"
title = "Points seen from a station"
[inputs]
x = { unit = "m" }
y = { unit = "m" }
z = { unit = "m" }
[parameters]
zero = { unit = "rad", scope = "rig" }
position = { unit = "m", kind = "vector", scope = "rig", start = ["1 m", "1 m", "1 m"] }
[quantities]
seen = '[x, y, z] - position'
azimuth = 'atan2(seen.y, seen.x) - zero'
height = 'atan2(hypot(seen.x, seen.y), seen.z)'
[measurands]
horizontal = { value = 'azimuth', kind = "angle", unit = "rad" }
vertical = { value = 'height', kind = "angle", unit = "rad" }
distance = { value = 'norm(seen)', unit = "m" }
"#;
/// Where time stands still a wave over it is the same as a constant of each measurand, and would stand
/// for two effects at once.
#[test]
fn constants_of_two_measurands_are_no_oscillation_where_there_is_no_time() {
    let mut random = Stream(101);
    let mut log = "x [m],y [m],z [m],horizontal [rad],vertical [rad],distance [m]\n".to_owned();
    for _ in 0..45 {
        let mut along = |size: f64| size * (2.0 * random.uniform() - 1.0);
        let (x, y, z) = (along(60.0), along(60.0), along(25.0));
        let mut noise = |size: f64| size * random.normal();
        let horizontal = y.atan2(x) - 0.3 + noise(15e-6);
        let vertical = x.hypot(y).atan2(z) + 8e-5 + noise(15e-6);
        let distance = (x * x + y * y + z * z).sqrt() - 0.012 + noise(2e-3);
        writeln!(log, "{x:.4},{y:.4},{z:.4},{horizontal:.7},{vertical:.7},{distance:.4}").unwrap();
    }
    let measurands = "horizontal = { sigma = \"15 urad\" }\nvertical = { sigma = \"15 urad\" }\ndistance = { sigma = \"2 mm\" }";
    let found = Campaign { model: STATION, effects: &[], measurands, log }.diagnosed();
    let mut all = names(&found);
    all.sort_unstable();
    assert_eq!(all, ["distance_offset", "vertical_index"], "{}", told(&found));
    assert_eq!(found.verdict, Verdict::Explained, "{}", told(&found));
}
