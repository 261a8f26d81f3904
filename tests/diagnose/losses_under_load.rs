//! What a gear loses in proportion to its load, against the sense of its motion: no library has it, and
//! without its form the friction beside it would be lost, too.

use std::fmt::Write as _;

use homepoint::diagnose::budget::answer::Verdict;

use crate::found::{names, told};
use crate::own_effects::Campaign;
use crate::stream::Stream;

/// A hoist: the force in the rope beside the torque of its motor.
const HOIST: &str = r#"
name = "hoist"
title = "Hoist"
[inputs]
torque = { unit = "N m" }
speed = { unit = "m/s" }
[parameters]
radius = { unit = "m", scope = "rig", start = "0.1 m" }
zero = { unit = "N", scope = "rig" }
[quantities]
pull = 'torque / radius + zero'
[measurands]
rope = { value = 'pull', unit = "N" }
"#;
const GREASE: (&str, &str, &str) = (
    "grease",
    "factor = { unit = \"N/(m/s)\", typical = \"100 N/(m/s)\", scope = \"rig\" }",
    "pull = 'pull - factor * speed'",
);
const SEAL: (&str, &str, &str) = (
    "seal",
    "level = { unit = \"N\", typical = \"10 N\", scope = \"rig\" }",
    "pull = 'pull - level * sign(speed)'",
);

#[test]
fn frictions_are_named_beside_a_loss_in_proportion_to_load() {
    let mut random = Stream(103);
    let mut log = "torque [Nm],speed [m/s],rope [N]\n".to_owned();
    for row in 0..700 {
        let torque = 20.0 * (0.021 * f64::from(row)).sin() + 8.0 * random.uniform();
        let up = if row / 90 % 2 == 0 { 1.0 } else { -1.0 };
        let speed = up * (0.2 + 0.5 * random.uniform());
        let own = torque / 0.12;
        let loss = 90.0 * speed + 14.0 * up + 0.05 * own.abs() * up;
        writeln!(log, "{torque:.4},{speed:.4},{:.3}", own - loss + 3.0 + 2.0 * random.normal())
            .unwrap();
    }
    let measurands = "rope = { sigma = \"2 N\" }";
    let found = Campaign { model: HOIST, effects: &[GREASE, SEAL], measurands, log }.diagnosed();
    let mut all = names(&found);
    all.sort_unstable();
    assert_eq!(all, ["grease", "seal"], "{}", told(&found));
    assert_eq!(found.verdict, Verdict::PartlyExplained, "{}", told(&found));
    for (name, due) in [("grease", 90.0), ("seal", 14.0)] {
        let row = found.rows.iter().find(|row| row.name == name).unwrap();
        let value = &row.values[0];
        let far = (value.value.unwrap() - due) / value.sigma.unwrap();
        assert!(far.abs() < 4.0, "{name}: {far}, {}", told(&found));
    }
    let words = &found.remainder[0].place.words;
    let due = "an error of `rope` over torque, direction-dependent (sign of speed)";
    assert_eq!(words, due, "{}", told(&found));
}
