//! Oscillations faster than a grid of frequencies goes, such as the hum of the mains and the vibration of
//! an arm: they are structure, not noise that is larger than stated or autocorrelated.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use homepoint::diagnose::Diagnosis;
use homepoint::diagnose::budget::answer::Verdict;

use crate::found::told;
use crate::own_effects::Campaign;
use crate::stream::Stream;

const PROBE: &str = r#"
name = "probe"
title = "A probe against a stage"
[inputs]
stage = { unit = "mm" }
[parameters]
gain = { unit = "1", start = "1", scope = "rig" }
zero = { unit = "mm", scope = "rig" }
[quantities]
reading = 'gain * stage + zero'
[measurands]
probe = { value = 'reading', unit = "mm" }
"#;

/// The diagnosis of readings at times, with white noise of 10 µm as stated and what is added to it (mm).
pub(crate) fn diagnosed(
    times: impl Iterator<Item = f64>,
    seed: u64,
    added: impl Fn(f64) -> f64,
) -> Diagnosis {
    let mut stream = Stream(seed);
    let mut log = String::from("time [s],stage [mm],probe [mm]\n");
    for time in times {
        let stage = 40.0 * (0.7 * time).sin() + 3.0 * (0.19 * time).cos();
        let probe = 1.002 * stage + 0.4 + 0.01 * stream.normal() + added(time);
        let _ = writeln!(log, "{time:.5},{stage:.4},{probe:.5}");
    }
    let measurands = "probe = { sigma = \"10 um\" }";
    Campaign { model: PROBE, effects: &[], measurands, log }.diagnosed()
}

/// Samples so many times a second, for 20 s.
pub(crate) fn even(rate: u32) -> impl Iterator<Item = f64> {
    (0..20 * rate).map(move |row| f64::from(row) / f64::from(rate))
}

fn oscillation(found: &Diagnosis, amplitude: f64, frequency: &str) {
    assert_eq!(found.verdict, Verdict::Unknown, "{}", told(found));
    let first = &found.remainder[0];
    assert!(first.place.is_oscillation(), "{}", told(found));
    assert!(first.place.words.ends_with(&format!(" at {frequency} Hz")), "{}", told(found));
    let (size, _) = first.amplitude.as_ref().unwrap();
    assert!((size / amplitude - 1.0).abs() < 0.1, "{size} {}", told(found));
}

#[test]
fn hum_and_vibration_are_oscillations() {
    let wave =
        |frequency: f64, size: f64| move |time: f64| size * (TAU * frequency * time + 0.8).sin();
    oscillation(&diagnosed(even(200), 3, wave(50.0, 0.012)), 12e-6, "50");
    // Neighbours of a slower one look alike: that is no autocorrelated noise.
    oscillation(&diagnosed(even(125), 4, wave(16.4, 0.02)), 20e-6, "16.4");
    // Beyond half the rate it is read as one below it.
    oscillation(&diagnosed(even(100), 5, wave(60.3, 0.02)), 20e-6, "39.7");
}

/// Times that scatter by a third of an interval about an even grid.
#[test]
fn times_may_be_uneven() {
    let mut stream = Stream(11);
    let times: Vec<f64> = even(125).map(|time| time + 0.0027 * stream.uniform()).collect();
    let wave = |time: f64| 0.015 * (TAU * 23.7 * time).sin();
    oscillation(&diagnosed(times.into_iter(), 6, wave), 15e-6, "23.7");
}

#[test]
fn white_noise_has_no_oscillation() {
    for seed in [21, 22, 23] {
        let found = diagnosed(even(200), seed, |_| 0.0);
        assert_eq!(found.verdict, Verdict::Adequate, "{}", told(&found));
    }
}
