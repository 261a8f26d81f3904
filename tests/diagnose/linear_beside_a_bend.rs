//! A small effect of one input beside a large unmodelled one of another input: what would take its place
//! has its form.

use std::fmt::Write as _;

use homepoint::diagnose::budget::answer::Verdict;

use crate::found::{names, told};
use crate::own_effects::Campaign;
use crate::stream::Stream;

const BAROMETER: &str = r#"
name = "barometer"
title = "Barometer of a drone"
[inputs]
throttle = { unit = "1" }
board = { unit = "K" }
height = { unit = "m" }
[parameters]
ground = { unit = "Pa", scope = "rig", start = "1010 hPa" }
density = { unit = "kg/m^3", scope = "rig", start = "1.2 kg/m^3" }
[quantities]
air = 'ground - density * 9.81 m/s^2 * height'
[measurands]
pressure = { value = 'air', unit = "Pa" }
"#;
const EFFECTS: &[(&str, &str, &str)] = &[(
    "board_warms",
    "part = { unit = \"Pa/K\", typical = \"1 Pa/K\", scope = \"rig\" }",
    "air = 'air + part * (board - 303.15 K)'",
)];
const DUE: f64 = -0.5;

#[test]
fn a_small_linear_effect_is_named_beside_a_large_remainder() {
    for seed in [1, 2, 3] {
        let mut random = Stream(seed);
        let mut log = String::from("time [s],throttle [1],board [K],height [m],pressure [Pa]\n");
        for row in 0..3000 {
            let t = 0.2 * f64::from(row);
            let throttle =
                0.5 + 0.2 * (t / 7.0).sin() + 0.1 * (t / 2.3).sin() + 0.02 * random.normal();
            let board = 305.0 + 5.0 * (t / 190.0).sin() + 0.5 * (t / 31.0).cos();
            let height = 30.0 + 20.0 * (t / 47.0).sin();
            let pressure = 101_000.0 - 1.2 * 9.81 * height - 60.0 * throttle * throttle
                + DUE * (board - 303.15)
                + 3.0 * random.normal();
            writeln!(log, "{t:.1},{throttle:.4},{board:.3},{height:.3},{pressure:.2}").unwrap();
        }
        let measurands = "pressure = { sigma = \"3 Pa\" }";
        let found = Campaign { model: BAROMETER, effects: EFFECTS, measurands, log }.diagnosed();
        assert_eq!(found.verdict, Verdict::PartlyExplained, "{seed}: {}", told(&found));
        assert_eq!(names(&found), ["board_warms"], "{seed}: {}", told(&found));
        let value = &found.rows[0].values[0];
        let far = (value.value.unwrap() - DUE) / value.sigma.unwrap();
        assert!(far.abs() < 4.0, "{seed}: {far}");
        assert!(found.remainder[0].place.words.contains("throttle"), "{seed}: {}", told(&found));
    }
}
