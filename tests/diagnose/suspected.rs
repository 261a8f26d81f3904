//! A cause that a user suspects has a formula that is rounded off. An effect of the library with nearly the
//! same form, and a width that follows the readings, does not show another cause.

use std::fmt::Write as _;

use crate::found::told;
use crate::own_effects::Campaign;
use crate::stream::Stream;

const GEAR: &str = r#"
name = "gear"
title = "Output of a gear against the encoder before it"
[inputs]
motor = { unit = "rad", signal = true }
[parameters]
zero = { unit = "rad", scope = "rig" }
[quantities]
turned = 'motor / 100'
[measurands]
output = { value = 'turned + zero', kind = "angle", unit = "rad" }
"#;
const PLAY: &[(&str, &str, &str)] = &[(
    "play",
    "lash = { unit = \"rad\", typical = \"0.3 mrad\", scope = \"rig\" }",
    "turned = 'turned - 0.5 * lash * tanh(rate(motor) / (30 deg/s))'",
)];

/// The motor's angle (rad), rate and acceleration.
fn motor(time: f64) -> [f64; 3] {
    [(20.0, 0.9, 0.0), (7.0, 2.3, 0.4)].iter().fold([0.0; 3], |sum, (size, rate, phase)| {
        let (sine, cosine) = (rate * time + phase).sin_cos();
        [sum[0] + size * sine, sum[1] + size * rate * cosine, sum[2] - size * rate * rate * sine]
    })
}

#[test]
fn play_is_named_by_the_effect_of_the_user() {
    for (lash, seed) in [(5.8e-4, 3), (4.4e-4, 4)] {
        let mut stream = Stream(seed);
        let mut log = String::from(
            "time [s],motor [rad],motor_rate [rad/s],motor_acceleration [rad/s^2],output [rad]\n",
        );
        // What is driven stays until the motor has gone through the play.
        let mut driven = motor(-5.0)[0] / 100.0;
        for step in -2500..24_000 {
            let time = 0.002 * f64::from(step);
            let [angle, rate, acceleration] = motor(time);
            driven = driven.clamp(angle / 100.0 - 0.5 * lash, angle / 100.0 + 0.5 * lash);
            if step >= 0 && step % 10 == 0 {
                let read = driven + 2.5e-5 * stream.normal();
                let _ = writeln!(log, "{time:.3},{angle},{rate},{acceleration},{read}");
            }
        }
        let measurands = "output = { sigma = \"20 urad\" }";
        let campaign = Campaign { model: GEAR, effects: PLAY, measurands, log };
        let found = campaign.diagnosed();
        let row = found.rows.first().filter(|row| row.name == "play");
        let value = row.and_then(|row| row.values[0].value).unwrap_or(f64::NAN);
        assert!((value / lash - 1.0).abs() < 0.15, "{value} {}", told(&found));
        assert!(row.is_some_and(|row| row.posterior > 0.9), "{}", told(&found));
        assert!(!found.rows.iter().any(|row| row.name == "tracking_reversal"), "{}", told(&found));
        // The value allows for what the remainder has of its form.
        let sigma = row.and_then(|row| row.values[0].sigma).unwrap_or(0.0);
        assert!((value - lash).abs() < 4.0 * sigma, "{value} ± {sigma} {}", told(&found));
    }
}

/// What the library describes exactly leaves nothing; the effect that the user suspects would leave much.
#[test]
fn an_effect_of_the_library_that_leaves_nothing_is_the_cause() {
    let play = PLAY[0].2.replace("30 deg/s", "5 rad/s");
    let play = &[(PLAY[0].0, PLAY[0].1, play.as_str())];
    for (step, seed) in [(3e-4, 8), (-1e-4, 9)] {
        let mut stream = Stream(seed);
        let mut log = String::from(
            "time [s],motor [rad],motor_rate [rad/s],motor_acceleration [rad/s^2],output [rad]\n",
        );
        for sample in 0..2400 {
            let time = 0.02 * f64::from(sample);
            let [angle, rate, acceleration] = motor(time);
            let read = angle / 100.0 + step * (rate / 3.0).tanh() + 2e-5 * stream.normal();
            let _ = writeln!(log, "{time:.3},{angle},{rate},{acceleration},{read}");
        }
        let measurands = "output = { sigma = \"20 urad\" }";
        let found = Campaign { model: GEAR, effects: play, measurands, log }.diagnosed();
        let [row] = &found.rows[..] else { panic!("{}", told(&found)) };
        assert_eq!(row.name, "tracking_reversal", "{}", told(&found));
        let (value, sigma) = (row.values[0].value.unwrap(), row.values[0].sigma.unwrap());
        assert!((value - step).abs() < 4.0 * sigma, "{value} ± {sigma} {}", told(&found));
        assert!(found.remainder.is_empty(), "{}", told(&found));
    }
}

/// Noise that is autocorrelated beside the one and the other is no reason to exchange them: a width of its own,
/// found beside a wave that was not yet in the fit, gains no more than chance.
#[test]
fn an_effect_of_the_user_stays_beside_autocorrelated_noise() {
    let lines = ["cosine", "sine"].map(|name| {
        format!("{name} = {{ unit = \"rad\", typical = \"0.05 mrad\", scope = \"rig\" }}")
    });
    let wave = "turned = 'turned + cosine * cos(2 * motor) + sine * sin(2 * motor)'";
    let effects = &[PLAY[0], ("wave", &lines.join("\n"), wave)];
    for (lash, seed) in [(4e-4, 12), (-3e-4, 13), (5e-4, 14)] {
        let mut stream = Stream(seed);
        let mut log = String::from(
            "time [s],motor [rad],motor_rate [rad/s],motor_acceleration [rad/s^2],output [rad]\n",
        );
        let mut slow = 0.0;
        for sample in 0..2400 {
            let time = 0.02 * f64::from(sample);
            let [angle, rate, acceleration] = motor(time);
            slow = 0.7 * slow + 1.6e-5 * stream.normal();
            let play = 0.5 * lash * (rate / 30_f64.to_radians()).tanh();
            let read = angle / 100.0 - play + 1.3e-4 * (2.0 * angle + 0.5).cos() + slow;
            let _ = writeln!(log, "{time:.3},{angle},{rate},{acceleration},{read}");
        }
        let measurands = "output = { sigma = \"20 urad\" }";
        let found = Campaign { model: GEAR, effects, measurands, log }.diagnosed();
        let row = found.rows.iter().find(|row| row.name == "play");
        let Some(row) = row else { panic!("{}", told(&found)) };
        assert_eq!(found.rows.len(), 2, "{}", told(&found));
        assert!(!found.autocorrelation.is_empty(), "{}", told(&found));
        let (value, sigma) = (row.values[0].value.unwrap(), row.values[0].sigma.unwrap());
        assert!((value - lash).abs() < 4.0 * sigma, "{value} ± {sigma} {}", told(&found));
    }
}
