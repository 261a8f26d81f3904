//! Backlash as a play: an effect of the user's own that is right but for the moments of reversal is
//! named beside what remains there.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use crate::found::{names, told};
use crate::own_effects::Campaign;
use crate::stream::Stream;

const GEAR: &str = r#"
name = "gear"
title = "Encoders before and behind a gear"
[inputs]
motor = { unit = "rad", signal = true }
current = { unit = "A" }
[parameters]
zero = { unit = "rad", scope = "rig" }
[quantities]
shaft = 'motor / 50'
[measurands]
load = { value = 'shaft + zero', unit = "rad" }
"#;
const EFFECTS: &[(&str, &str, &str)] = &[
    (
        "lash",
        "gap = { unit = \"rad\", typical = \"1 mrad\", scope = \"rig\" }",
        "shaft = 'shaft - 0.5 * gap * tanh(rate(motor) / 1 rad/s)'",
    ),
    (
        "torsion",
        "by = { unit = \"rad/A\", typical = \"0.3 mrad/A\", scope = \"rig\" }",
        "shaft = 'shaft - by * current'",
    ),
    (
        "runout",
        "cosine = { unit = \"rad\", typical = \"0.5 mrad\", scope = \"rig\" }\nsine = { unit = \"rad\", typical = \"0.5 mrad\", scope = \"rig\" }",
        "load = 'load + cosine * cos(load) + sine * sin(load)'",
    ),
];
/// The play of the gear (rad).
const GAP: f64 = 1.4e-3;

/// The motor's angle (rad), rate and acceleration.
fn motor(t: f64) -> [f64; 3] {
    let waves = [(18.0, 16.0, 0.0), (7.0, 5.3, 1.0), (4.0, 2.9, 0.3)];
    waves.iter().fold([0.0; 3], |sum, (turns, period, phase)| {
        let (size, rate) = (TAU * turns, TAU / period);
        let (sine, cosine) = (rate * t + phase).sin_cos();
        [sum[0] + size * sine, sum[1] + size * rate * cosine, sum[2] - size * rate * rate * sine]
    })
}

#[test]
fn a_play_is_named_beside_what_it_does_at_reversals() {
    for seed in [21, 22, 23] {
        let mut random = Stream(seed);
        let mut log = String::from(
            "time [s],motor [rad],motor_rate [rad/s],motor_acceleration [rad/s^2],current [A],load [rad]\n",
        );
        let mut shaft = motor(-1.0)[0] / 50.0;
        for step in -10_000..800_000 {
            // The shaft stays until the motor has gone through the play.
            let t = 1e-4 * f64::from(step);
            let [angle, rate, acceleration] = motor(t);
            let driven = angle / 50.0;
            shaft = shaft.clamp(driven - 0.5 * GAP, driven + 0.5 * GAP);
            if step >= 0 && step % 200 == 0 {
                let current =
                    1.2 * (rate / 19.0).tanh() + 0.1 * random.normal() + 3e-3 * acceleration;
                let load = shaft + 9e-4 * shaft.cos() - 5e-4 * shaft.sin() + 0.3;
                let read = load + 1.5e-4 * random.normal();
                writeln!(
                    log,
                    "{t:.2},{angle:.7},{rate:.6},{acceleration:.6},{current:.4},{read:.7}"
                )
                .unwrap();
            }
        }
        let measurands = "load = { sigma = \"0.15 mrad\" }";
        let found = Campaign { model: GEAR, effects: EFFECTS, measurands, log }.diagnosed();
        let mut named = names(&found);
        named.sort_unstable();
        assert_eq!(named, ["lash", "runout"], "{}", told(&found));
        let lash = found.rows.iter().find(|row| row.name == "lash").unwrap();
        let gap = lash.values[0].value.unwrap();
        assert!((gap - GAP).abs() < 0.1 * GAP, "{gap}, {}", told(&found));
    }
}

/// A formula that is rounded off at reversals is not exact there; a free function of the sense of motion
/// would be better, but is no other cause.
#[test]
fn a_play_whose_formula_is_rounded_off_keeps_its_name() {
    for seed in [31, 32] {
        let mut random = Stream(seed);
        let mut log =
            String::from("time [s],motor [rad],motor_rate [rad/s],current [A],load [rad]\n");
        for step in 0..3000 {
            let t = 0.02 * f64::from(step);
            let [angle, rate, _] = motor(t);
            let current = 1.2 * (rate / 19.0).tanh() + 0.3 * random.normal();
            let shaft = angle / 50.0 - 0.5 * GAP * rate.signum() - 3e-4 * current;
            let read = shaft + 0.3 + 2e-5 * random.normal();
            writeln!(log, "{t:.2},{angle:.7},{rate:.6},{current:.4},{read:.7}").unwrap();
        }
        let measurands = "load = { sigma = \"20 urad\" }";
        let found = Campaign { model: GEAR, effects: EFFECTS, measurands, log }.diagnosed();
        let mut named = names(&found);
        named.sort_unstable();
        assert_eq!(named, ["lash", "torsion"], "{}", told(&found));
        let lash = found.rows.iter().find(|row| row.name == "lash").unwrap();
        let gap = lash.values[0].value.unwrap();
        assert!((gap - GAP).abs() < 0.02 * GAP, "{gap}, {}", told(&found));
        assert!(lash.posterior > 0.9, "{}", lash.posterior);
    }
}
