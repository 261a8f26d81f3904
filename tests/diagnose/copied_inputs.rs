//! Inputs that were taken from a reading, such as the row of an image in which a point was seen: they
//! have the reading's own noise, and are no covariate of it.

use std::fmt::Write as _;

use homepoint::diagnose::budget::answer::Verdict;

use crate::found::{names, told};
use crate::own_effects::Campaign;
use crate::stream::Stream;

const CAMERA: &str = r#"
name = "camera"
title = "Camera on a head"
[inputs]
tilt = { unit = "rad" }
row = { unit = "1" }
[parameters]
focal = { unit = "1", scope = "rig", start = "1000" }
zero = { unit = "rad", scope = "rig" }
[quantities]
down = 'tan(tilt - zero)'
[measurands]
v = { value = '500 + focal * down', unit = "1" }
"#;
const LENS: (&str, &str, &str) = (
    "lens",
    "k = { unit = \"1\", typical = \"0.02\", scope = \"rig\" }",
    "down = 'down * (1 + k * down^2)'",
);

#[test]
fn a_lens_is_named_beside_the_row_that_was_rounded_from_the_reading() {
    for seed in 31..=33 {
        let mut random = Stream(seed);
        let mut log = "tilt [rad],row [1],v [1]\n".to_owned();
        for step in 0..300 {
            let tilt = 0.4 * (f64::from(step) * 0.37).sin();
            let down = (tilt - 0.01_f64).tan();
            let v = 500.0 + 990.0 * down * (1.0 - 0.03 * down * down) + 0.6 * random.normal();
            writeln!(log, "{tilt:.6},{},{v:.3}", v.round()).unwrap();
        }
        let measurands = "v = { sigma = \"0.5\" }";
        let found = Campaign { model: CAMERA, effects: &[LENS], measurands, log }.diagnosed();
        assert_eq!(found.verdict, Verdict::Explained, "{seed}: {}", told(&found));
        assert_eq!(names(&found), ["lens"], "{seed}: {}", told(&found));
        let value = &found.rows[0].values[0];
        let far = (value.value.unwrap() + 0.03) / value.sigma.unwrap();
        assert!(far.abs() < 4.0, "{seed}: {far}");
    }
}
