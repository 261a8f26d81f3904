//! Errors of inputs over themselves where few things move: in several readings at once they have a form
//! that no function of one covariate has.

use std::fmt::Write as _;

use homepoint::diagnose::budget::answer::Verdict;

use crate::found::told;
use crate::own_effects::Campaign;
use crate::stream::Stream;

const HEAD: &str = r#"
name = "head"
title = "The components of a direction"
[inputs]
pan = { unit = "rad" }
tilt = { unit = "rad" }
[parameters]
gain = { unit = "1", scope = "rig", start = "1 1" }
[measurands]
x = { value = 'gain * cos(tilt) * cos(pan)', unit = "1" }
y = { value = 'gain * cos(tilt) * sin(pan)', unit = "1" }
z = { value = 'gain * sin(tilt)', unit = "1" }
"#;

/// It was a sum of products of waves in each of the readings.
#[test]
fn an_eccentric_encoder_of_a_pan_tilt_head_is_one_error_of_its_input() {
    for seed in [421, 422] {
        let mut stream = Stream(seed);
        let mut log = "pan [rad],tilt [rad],x [1],y [1],z [1]\n".to_owned();
        for _ in 0..500 {
            let (pan, tilt) = (6.0 * stream.uniform() - 3.0, 2.0 * stream.uniform() - 0.8);
            let turned = tilt + 3e-3 * (tilt + 0.5).sin();
            let all = [turned.cos() * pan.cos(), turned.cos() * pan.sin(), turned.sin()];
            let [x, y, z] = all.map(|value| value + 3e-4 * stream.normal());
            let _ = writeln!(log, "{pan:.6},{tilt:.6},{x:.6},{y:.6},{z:.6}");
        }
        let sigma = "{ sigma = \"0.0003 1\" }";
        let measurands = format!("x = {sigma}\ny = {sigma}\nz = {sigma}");
        let found =
            Campaign { model: HEAD, effects: &[], measurands: &measurands, log }.diagnosed();
        assert_eq!(found.verdict, Verdict::Unknown, "{}", told(&found));
        let [only] = &found.remainder[..] else { panic!("{}", told(&found)) };
        let due = "an error of the input `tilt` over tilt, 1 wave a turn";
        assert_eq!(only.place.words, due, "{}", told(&found));
        let (amplitude, _) = only.amplitude.as_ref().unwrap();
        assert!((amplitude - 3e-3).abs() < 3e-4, "{amplitude}");
    }
}
