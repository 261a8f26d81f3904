//! What is judged beside something else that was found: effects beside a wrong stated value and a
//! large change, readings that are far out beside effects.

use std::fmt::Write as _;

use homepoint::diagnose::Diagnosis;
use homepoint::diagnose::budget::answer::Verdict;

use crate::found::{names, told};
use crate::own_effects::Campaign;
use crate::stream::Stream;

/// A gear of a stated ratio, with lost motion and a wave.
const GEAR: &str = r#"
name = "gear"
title = "Gear"
[inputs]
motor = { unit = "rad" }
side = { unit = "1" }
[parameters]
ratio = { unit = "1", scope = "rig", value = "30", fixed = true }
zero = { unit = "rad", scope = "rig" }
[quantities]
angle = 'motor / ratio + zero'
[measurands]
out = { value = 'angle', unit = "rad" }
"#;
const LASH: (&str, &str, &str) = (
    "lash",
    "size = { unit = \"rad\", typical = \"200 urad\", scope = \"rig\" }",
    "angle = 'angle - 0.5 * size * side'",
);
const WAVE: (&str, &str, &str) = (
    "wave",
    "c = { unit = \"rad\", typical = \"100 urad\", scope = \"rig\" }\ns = { unit = \"rad\", typical = \"100 urad\", scope = \"rig\" }",
    "angle = 'angle + c * cos(motor) + s * sin(motor)'",
);
const RATIO: (&str, &str, &str) = (
    "ratio_error",
    "part = { unit = \"1\", typical = \"1000 ppm\", scope = \"rig\" }",
    "angle = 'angle + part * motor / ratio'",
);

/// A gear whose ratio is 31.
fn gear(effects: &[(&str, &str, &str)]) -> Diagnosis {
    let mut random = Stream(41);
    let mut log = "motor [rad],side [1],out [rad]\n".to_owned();
    for row in 0..600 {
        let side = if row % 200 < 100 { 1.0 } else { -1.0 };
        let place = if side > 0.0 { row % 100 } else { 99 - row % 100 };
        let motor = 0.9 * f64::from(place);
        let out =
            motor / 31.0 + 0.02 - 0.5 * 4e-4 * side + 1.5e-4 * motor.cos() + 5e-5 * random.normal();
        writeln!(log, "{motor},{side},{out:.8}").unwrap();
    }
    Campaign { model: GEAR, effects, measurands: "out = { sigma = \"50 urad\" }", log }.diagnosed()
}

#[test]
fn effects_are_named_beside_a_wrong_stated_value() {
    let found = gear(&[LASH, WAVE]);
    assert_eq!(found.verdict, Verdict::PartlyExplained, "{}", told(&found));
    assert_eq!(found.set_free.as_deref(), Some("ratio"));
    assert_eq!(found.remainder[0].place.words, "a wrong stated value of `ratio`");
    assert!((found.contradicted[0].alone - 31.0).abs() < 1e-3, "{:?}", found.contradicted);
    let mut all = names(&found);
    all.sort_unstable();
    assert_eq!(all, ["lash", "wave"], "{}", told(&found));
    let lash = found.rows.iter().find(|row| row.name == "lash").unwrap();
    let far = (lash.values[0].value.unwrap() - 4e-4) / lash.values[0].sigma.unwrap();
    assert!(far.abs() < 4.0, "{far}");
}

/// Whoever describes an effect that does what the wrong value does asks for it.
#[test]
fn an_effect_of_ones_own_is_named_in_place_of_a_wrong_stated_value() {
    let found = gear(&[LASH, WAVE, RATIO]);
    assert_eq!((found.verdict, &found.set_free), (Verdict::Explained, &None), "{}", told(&found));
    let row = found.rows.iter().find(|row| row.name == "ratio_error").unwrap();
    let far = (row.values[0].value.unwrap() - (30.0 / 31.0 - 1.0)) / row.values[0].sigma.unwrap();
    assert!(far.abs() < 4.0, "{far}, {}", told(&found));
}

/// A carriage on rails.
pub(crate) const RAIL: &str = r#"
name = "rail"
title = "Rail"
[inputs]
sent = { unit = "m" }
[parameters]
zero = { unit = "m", scope = "rig" }
[quantities]
place = 'sent'
[measurands]
read = { value = 'place + zero', unit = "m" }
"#;
pub(crate) const SCALE: (&str, &str, &str) = (
    "scale",
    "k = { unit = \"1\", typical = \"500 ppm\", scope = \"rig\" }",
    "place = 'place + k * sent'",
);
/// An error that grows so fast that few readings have most of it.
const BOW: (&str, &str, &str) = (
    "bow",
    "size = { unit = \"m\", typical = \"10 mm\", scope = \"rig\" }",
    "place = 'place + size * (sent / 10 m)^8'",
);

fn rail(effects: &[(&str, &str, &str)], error: impl Fn(usize, f64) -> f64) -> Diagnosis {
    let mut random = Stream(43);
    let mut log = "sent [m],read [m]\n".to_owned();
    for row in 0..900 {
        let sent = 10.0 * random.uniform().powi(2);
        let read = sent + 0.3 + error(row, sent) + 3e-3 * random.normal();
        writeln!(log, "{sent:.5},{read:.6}").unwrap();
    }
    Campaign { model: RAIL, effects, measurands: "read = { sigma = \"3 mm\" }", log }.diagnosed()
}

/// A step of 300 mm leaves nothing that a scale of noncentrality 30 could imitate.
#[test]
fn a_small_effect_is_named_beside_a_large_change() {
    let found = rail(&[SCALE], |row, sent| 1.2e-3 * sent + if row >= 610 { 0.3 } else { 0.0 });
    assert_eq!(names(&found), ["scale"], "{}", told(&found));
    assert_eq!(found.verdict, Verdict::PartlyExplained, "{}", told(&found));
    let far =
        (found.rows[0].values[0].value.unwrap() - 1.2e-3) / found.rows[0].values[0].sigma.unwrap();
    assert!(far.abs() < 4.0, "{far}, {}", told(&found));
    assert!(found.gap.as_ref().unwrap().is_borne_out() == Some(true), "{:?}", found.gap);
    let change = found.remainder[0].change.as_ref().unwrap();
    assert!((change.value.abs() - 0.3).abs() < 5.0 * change.sigma, "{change:?}");
}

/// Readings that an effect makes are right, and come back; bursts that an effect hides are left out.
#[test]
fn readings_that_are_far_out_are_judged_beside_effects() {
    let found = rail(&[BOW], |_, sent| 0.15 * (sent / 10.0).powi(8));
    assert_eq!(
        (found.verdict, names(&found)),
        (Verdict::Explained, vec!["bow"]),
        "{}",
        told(&found)
    );
    assert!(found.left_out.is_empty(), "{:?}", found.left_out);
    let bursts = [100..118, 300..320, 640..655];
    let found = rail(&[SCALE], |row, sent| {
        8e-3 * sent + if bursts.iter().any(|one| one.contains(&row)) { 0.03 } else { 0.0 }
    });
    assert_eq!(names(&found), ["scale"], "{}", told(&found));
    let rows: Vec<(usize, usize)> = found.left_out.stretches.iter().map(|one| one.rows).collect();
    assert_eq!(rows, [(102, 119), (302, 321), (642, 656)], "{}", told(&found));
}
