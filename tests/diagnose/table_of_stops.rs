//! A table of stops: where a stage goes on by equal steps, a stroke that is displaced by an effect looks
//! like lost samples.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use homepoint::diagnose::Diagnosis;
use homepoint::diagnose::budget::answer::Verdict;

use crate::found::{names, told};
use crate::own_effects::Campaign;
use crate::stream::Stream;

const STAGE: &str = r#"
name = "stage"
title = "A stage against a laser"
[inputs]
position = { unit = "m" }
temperature = { unit = "K" }
[parameters]
zero = { unit = "m", scope = "rig" }
[quantities]
place = 'position'
[measurands]
laser = { value = 'place + zero', unit = "m" }
"#;
const SHIFT: (&str, &str, &str) = (
    "warmth",
    "size = { unit = \"m/K\", typical = \"1 um/K\", scope = \"rig\" }",
    "place = 'place + size * (temperature - 293.15 * 1 K)'",
);
const EXPANSION: (&str, &str, &str) = (
    "warmth",
    "size = { unit = \"1/K\", typical = \"0.01 1/K\", scope = \"rig\" }",
    "place = 'place * (1 + size * (temperature - 293.15 * 1 K))'",
);

/// A table of these stops, each with how much warmer it was and its reading without noise.
fn table(
    effect: (&str, &str, &str),
    stops: &[(f64, f64)],
    sigma: f64,
    read: impl Fn(usize) -> f64,
) -> Diagnosis {
    let mut stream = Stream(5);
    let (mut log, mut time) = ("time [s],position [m],temperature [K],laser [m]\n".to_owned(), 0.0);
    for (row, (position, warmer)) in stops.iter().enumerate() {
        time += 2.0 + 0.2 * stream.uniform();
        let laser = read(row) + sigma * stream.normal();
        let _ = writeln!(log, "{time:.2},{position:.9},{:.4},{laser:.10}", 293.15 + warmer);
    }
    let measurands = format!("laser = {{ sigma = \"{} nm\" }}", 1e9 * sigma);
    Campaign { model: STAGE, effects: &[effect], measurands: &measurands, log }.diagnosed()
}

/// Six strokes of 80 stops: where each is, and how much warmer the strokes were.
fn strokes(stop: impl Fn(i32) -> f64, warmer: [f64; 6]) -> Vec<(f64, f64)> {
    let mut stream = Stream(6);
    let mut all = Vec::new();
    for warmer in warmer {
        all.extend((0..80).map(|k| (stop(k), warmer + 0.02 * stream.normal())));
    }
    all
}

fn assert_warmth(found: &Diagnosis, size: f64) {
    assert_eq!(names(found), ["warmth"], "{}", told(found));
    assert_eq!(found.verdict, Verdict::Explained, "{}", told(found));
    let value = &found.rows[0].values[0];
    let far = (value.value.unwrap() - size) / value.sigma.unwrap();
    assert!(far.abs() < 4.0, "{far} u, {}", told(found));
}

/// A shift by two equal steps is an offset: nothing says that samples were lost.
#[test]
fn a_stroke_that_is_displaced_by_two_equal_steps_has_lost_no_samples() {
    let stops = strokes(|k| 0.03 + 0.7e-6 * f64::from(k), [0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    let read = |row: usize| stops[row].0 + 1e-6 + 1.4e-6 * stops[row].1;
    let found = table(SHIFT, &stops, 4e-8, read);
    assert!(found.left_out.is_empty(), "{:?}", found.left_out);
    assert_warmth(&found, 1.4e-6);
}

/// Of steps that grow by 1 % a shift by two is no offset but an expansion by 2 %, which the other strokes
/// show in small.
#[test]
fn a_stroke_that_expands_by_two_growing_steps_has_lost_no_samples() {
    let stops = strokes(|k| 0.1 * 1.01_f64.powi(k), [-0.2, -0.1, 0.0, 2.0, 0.1, 0.2]);
    let read = |row: usize| stops[row].0 * (1.0 + 0.010_05 * stops[row].1) + 1e-6;
    let found = table(EXPANSION, &stops, 1e-4, read);
    assert!(found.left_out.is_empty(), "{:?}", found.left_out);
    assert_warmth(&found, 0.010_05);
}

/// Steps that differ tell samples that were lost from a displacement.
#[test]
fn samples_that_were_lost_are_left_out_beside_an_effect() {
    let stop = |row: usize| {
        let turn = row as f64 / 48.0 * TAU;
        (0.03 + 2e-5 * turn.sin() + 6e-6 * (3.1 * turn + 1.0).sin(), 0.5 * (0.16 * turn).sin())
    };
    let stops: Vec<(f64, f64)> = (0..480).map(stop).collect();
    let read = |row: usize| {
        let (position, warmer) = stop(if row < 300 { row } else { row + 2 });
        position + 1e-6 + 1.4e-6 * warmer
    };
    let found = table(SHIFT, &stops, 4e-8, read);
    let [lost] = &found.left_out.lost[..] else { panic!("{:?}", found.left_out) };
    assert_eq!((lost.periods, lost.samples.end), (2, 480), "{lost:?}");
    assert!(lost.samples.start.abs_diff(300) <= 1, "{lost:?}");
    assert_warmth(&found, 1.4e-6);
}
