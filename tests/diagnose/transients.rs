//! Transients: a reading leaves the model once, in a form of its own, and comes back.

use std::fmt::Write as _;

use homepoint::diagnose::Diagnosis;
use homepoint::diagnose::budget::answer::Verdict;

use crate::found::told;
use crate::own_effects::Campaign;
use crate::stream::Stream;

const CART: &str = r#"
name = "cart"
title = "Speed of a cart from its wheel"
[inputs]
wheel = { unit = "rad/s" }
torque = { unit = "N m" }
[parameters]
radius = { unit = "m", value = "0.1 m", fixed = true }
[quantities]
rim = 'wheel * radius'
[measurands]
speed = { value = 'rim', unit = "m/s" }
"#;
const EFFECTS: &[(&str, &str, &str)] = &[
    ("wear", "by = { unit = \"1\", typical = \"1 %\", scope = \"rig\" }", "rim = 'rim * (1 + by)'"),
    (
        "creep",
        "by = { unit = \"1/(N m)\", typical = \"1e-4 1/(N m)\", scope = \"rig\" }",
        "rim = 'rim * (1 - by * torque)'",
    ),
];
const WEAR: f64 = -0.01;
const CREEP: f64 = 1.5e-4;

/// Of a ride in which the wheel spins between two rows for so much of its rate.
fn ride((first, last): (usize, usize), spin: f64, seed: u64) -> Diagnosis {
    let mut stream = Stream(seed);
    let mut log = String::from("time [s],wheel [rad/s],torque [N m],speed [m/s]\n");
    for row in 0..2000 {
        let time = 0.1 * row as f64;
        let rate = 20.0 + 3.0 * (0.11 * time).sin() + 2.0 * (0.043 * time).cos();
        let torque = 20.0 * (0.11 * time).cos() + 10.0 * (0.27 * time).sin();
        let phase = (row as f64 - first as f64) / (last - first) as f64;
        let is_in = (0.0..1.0).contains(&phase);
        let bump = if is_in { spin * (std::f64::consts::PI * phase).sin().powi(2) } else { 0.0 };
        let speed = 0.1 * rate * (1.0 + WEAR) * (1.0 - CREEP * torque) + 3e-3 * stream.normal();
        let _ = writeln!(log, "{time:.1},{},{torque},{speed}", rate + bump);
    }
    Campaign { model: CART, effects: EFFECTS, measurands: "speed = { sigma = \"3 mm/s\" }", log }
        .diagnosed()
}

/// What it would bias, or hide, has its value; the place is a part of the remainder.
#[test]
fn causes_are_named_beside_a_transient() {
    for (rows, spin, seed) in [((700, 760), 1.0, 5), ((1300, 1420), 0.6, 6), ((0, 1), 0.0, 7)] {
        let found = ride(rows, spin, seed);
        for (name, right) in [("wear", WEAR), ("creep", CREEP)] {
            let row = found.rows.iter().find(|row| row.name == name);
            let Some(row) = row else { panic!("{name}: {}", told(&found)) };
            let far = (row.values[0].value.unwrap() - right) / row.values[0].sigma.unwrap();
            assert!(far.abs() < 4.0, "{name}: {far} u, {}", told(&found));
        }
        if spin == 0.0 {
            assert_eq!(found.verdict, Verdict::Explained, "{}", told(&found));
            continue;
        }
        assert_eq!(found.verdict, Verdict::PartlyExplained, "{}", told(&found));
        let Some((first, Some(last))) = found.remainder[0].place.rows else {
            panic!("{}", told(&found))
        };
        // A row of the file has a header before it.
        let (due_first, due_last) = (rows.0 + 2, rows.1 + 2);
        let length = rows.1 - rows.0;
        assert!(first >= due_first && first < due_first + length / 3, "{first} {}", told(&found));
        assert!(last <= due_last + 5 && last > due_last - length / 3, "{last} {}", told(&found));
    }
}
