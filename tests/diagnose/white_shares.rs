//! Shares of the gap under autocorrelated noise: parts of squared residuals, as the rms shows them.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use crate::found::{names, told};
use crate::own_effects::Campaign;
use crate::stream::Stream;

const STAGE: &str = r#"
name = "stage"
title = "A stage against a laser"
[inputs]
place = { unit = "m" }
warmth = { unit = "K" }
[parameters]
zero = { unit = "m", scope = "rig" }
[quantities]
at = 'place'
[measurands]
laser = { value = 'at + zero', unit = "m" }
"#;
const EXPANSION: (&str, &str, &str) = (
    "expansion",
    "size = { unit = \"1/K\", typical = \"1e-5 1/K\", scope = \"rig\" }",
    "at = 'at * (1 + size * warmth)'",
);

/// The weights of correlated noise are those of differences of readings: an error that varies slowly is
/// small by them, beside one that is fine.
#[test]
fn a_slow_effect_beside_fine_waves_closes_what_the_rms_shows() {
    let (mut stream, mut slow) = (Stream(411), 0.0);
    let kept = (-1.0_f64 / 60.0).exp();
    let mut log = "time [s],place [m],warmth [K],laser [m]\n".to_owned();
    for row in 0..4000 {
        let time = 0.1 * f64::from(row);
        let place = 0.45 - 0.4 * (TAU * time / 44.0).cos();
        let warmth = 1.5 * (1.0 - (-time / 150.0).exp());
        slow = kept * slow + (1.0_f64 - kept * kept).sqrt() * stream.normal();
        let wave = 0.6 * (TAU * place / 0.01).sin();
        let error = 5.0 * warmth * place + wave + 0.5 * (slow + stream.normal());
        let _ = writeln!(log, "{time:.1},{place:.9},{warmth:.6},{:.10}", place + 1e-6 * error);
    }
    let measurands = "laser = { sigma = \"0.5 um\" }";
    let found = Campaign { model: STAGE, effects: &[EXPANSION], measurands, log }.diagnosed();
    assert_eq!(names(&found), ["expansion"], "{}", told(&found));
    assert!(!found.autocorrelation.is_empty(), "{}", told(&found));
    let gap = found.gap.as_ref().unwrap();
    let square = |rms: &[(String, f64)]| rms[0].1.powi(2);
    let (before, after, noise) = (square(&gap.before), square(&gap.after), square(&gap.floor));
    let shown = (before - after) / (before - noise);
    assert!((gap.closed - shown).abs() < 0.03, "{} of {shown}: {}", gap.closed, told(&found));
    // The row and the wave share the gap.
    let wave = found.remainder.iter().map(|one| one.share).sum::<f64>();
    assert!((found.rows[0].closes + wave - 1.0).abs() < 0.05, "{wave}: {}", told(&found));
}
