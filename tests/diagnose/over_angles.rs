//! Errors of readings over angles, in models without a target: fine waves, and values of rows beside
//! a remainder over the same angle.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use homepoint::diagnose::Diagnosis;
use homepoint::diagnose::budget::answer::Verdict;

use crate::found::{names, told};
use crate::own_effects::Campaign;
use crate::stream::Stream;

const MOTOR: &str = r#"
name = "motor"
title = "Torque of a motor"
[inputs]
rotor = { unit = "rad" }
current = { unit = "A" }
winding = { unit = "K" }
[parameters]
constant = { unit = "N m/A", scope = "rig" }
[measurands]
torque = { value = 'constant * current', unit = "N m" }
"#;

/// Torques with a wave of this order over the rotor, 1.5 times as large as the noise.
fn cogging(order: f64, seed: u64) -> Diagnosis {
    let mut stream = Stream(seed);
    let mut log = String::from("rotor [rad],current [A],winding [K],torque [N m]\n");
    for row in 0..900 {
        let (rotor, current) = (TAU * stream.uniform(), 4.0 * stream.uniform());
        let winding = 300.0 + 0.02 * f64::from(row) + stream.normal();
        let wave = 0.015 * (order * rotor + 0.4).cos();
        let torque = 0.6 * current + wave + 0.01 * stream.normal();
        let _ = writeln!(log, "{rotor},{current},{winding},{torque}");
    }
    let measurands = "torque = { sigma = \"0.01 N m\" }";
    Campaign { model: MOTOR, effects: &[], measurands, log }.diagnosed()
}

/// The poles of a motor, the teeth of a gear or a worm.
#[test]
fn fine_waves_of_a_reading_are_a_remainder_with_their_order() {
    for (seed, order) in [9.0, 24.0, 36.0, 77.0, 360.0].into_iter().enumerate() {
        let found = cogging(order, 80 + seed as u64);
        assert_eq!(found.verdict, Verdict::Unknown, "{}", told(&found));
        let words = format!("over rotor, {order} waves a turn");
        assert!(found.remainder[0].place.words.ends_with(&words), "{}", told(&found));
        let (amplitude, _) = found.remainder[0].amplitude.as_ref().unwrap();
        assert!((amplitude - 0.015).abs() < 0.003, "{order}: {amplitude}");
    }
}

const DRIVE: &str = r#"
name = "drive"
title = "A geared drive"
[inputs]
motor = { unit = "rad", signal = true }
[parameters]
zero = { unit = "rad", scope = "rig" }
[measurands]
load = { value = 'zero + motor / 7.3', unit = "rad" }
"#;

/// Times (s) and angles (rad) of a motor through some fifty turns.
fn turns() -> impl Iterator<Item = (f64, f64)> {
    (0..2000).scan(1.0, |motor, row| {
        let time = 0.02 * f64::from(row);
        *motor += 0.02 * 8.0 * (1.0 + 0.4 * (TAU * time / 11.0).sin());
        Some((time, *motor))
    })
}

/// A shaft of a gearbox turns at another rate than those that are read: its eccentricity is a wave over
/// them, of an order that is no whole number, and no noise that remembers.
#[test]
fn a_wave_of_any_order_over_many_turns_is_a_remainder_with_its_order() {
    for (seed, order, size) in [(96, 0.323, 1e-4), (97, 0.618, 4e-5), (98, 2.71, 3e-5)] {
        let mut stream = Stream(seed);
        let mut log = String::from("time [s],motor [rad],load [rad]\n");
        for (time, motor) in turns() {
            let wave = size * (order * motor + 1.1).cos();
            let load = 0.2 + motor / 7.3 + wave + 2e-5 * stream.normal();
            let _ = writeln!(log, "{time},{motor},{load}");
        }
        let measurands = "load = { sigma = \"20 urad\" }";
        let found = Campaign { model: DRIVE, effects: &[], measurands, log }.diagnosed();
        assert_eq!(found.remainder.len(), 1, "{}", told(&found));
        let words = &found.remainder[0].place.words;
        assert!(words.contains(&format!("over motor, {order}")), "{}", told(&found));
        let (amplitude, _) = found.remainder[0].amplitude.as_ref().unwrap();
        assert!((amplitude / size - 1.0).abs() < 0.1, "{order}: {amplitude}");
        assert!(found.autocorrelation.is_empty(), "{}", told(&found));
    }
}

/// The same over an encoder that is read modulo one turn: its turns are counted on.
#[test]
fn a_wave_of_any_order_over_an_angle_with_a_period_has_its_order() {
    let model = DRIVE.replace("signal = true", "signal = true, period = \"360 deg\"");
    let model = model.replace("zero + motor / 7.3", "zero + motor");
    for (seed, order) in [(101, 0.42), (102, 1.37)] {
        let mut stream = Stream(seed);
        let mut log = String::from("time [s],motor [rad],load [rad]\n");
        for (time, motor) in turns() {
            let wave = 5e-5 * (order * motor + 1.1).cos();
            let load = 0.2 + motor.rem_euclid(TAU) + wave + 2e-5 * stream.normal();
            let _ = writeln!(log, "{time},{},{load}", motor.rem_euclid(TAU));
        }
        let model = model
            .replace("load = { value", "load = { kind = \"angle\", period = \"360 deg\", value");
        let measurands = "load = { sigma = \"20 urad\" }";
        let found = Campaign { model: &model, effects: &[], measurands, log }.diagnosed();
        assert_eq!(found.verdict, Verdict::Unknown, "{}", told(&found));
        let words = &found.remainder[0].place.words;
        let number = words.split("over motor, ").nth(1).and_then(|one| one.split(' ').next());
        let found_order: f64 = number.unwrap_or_else(|| panic!("{words}")).parse().unwrap();
        assert!((found_order - order).abs() < 0.01, "{words}");
    }
}

const COMPASS: &str = r#"
name = "compass"
title = "A compass against a heading"
[inputs]
heading = { unit = "rad", period = "360 deg" }
speed = { unit = "m/s" }
[parameters]
mount = { unit = "rad", scope = "rig" }
[measurands]
compass = { value = 'heading + mount', kind = "angle", unit = "rad", period = "360 deg" }
"#;
const IRON: (&str, &str, &str) = (
    "hard_iron",
    "b = { unit = \"rad\", typical = \"2 deg\", scope = \"rig\" }\nc = { unit = \"rad\", typical = \"2 deg\", scope = \"rig\" }",
    "compass = 'compass + b * sin(heading) + c * cos(heading)'",
);
const CURRENT: (&str, &str, &str) = (
    "log_current",
    "k = { unit = \"rad s/m\", typical = \"0.1 deg s/m\", scope = \"rig\" }",
    "compass = 'compass + k * (speed - 3 m/s)'",
);

/// Headings that are seldom south, a wave of the first order that has a file, and others that have none:
/// of the second order, and of a third one of this size.
fn iron(effects: &[(&str, &str, &str)], third: f64, seed: u64) -> Diagnosis {
    let mut stream = Stream(seed);
    let mut log = String::from("heading [rad],speed [m/s],compass [rad]\n");
    for _ in 0..900 {
        let heading = loop {
            let tried = TAU * stream.uniform();
            if stream.uniform() < 0.55 + 0.4 * tried.cos() {
                break tried;
            }
        };
        let speed = 3.0 + 0.3 * heading.sin() + 0.1 * stream.normal();
        let first = 0.037 * heading.sin() - 0.059 * heading.cos();
        let second = 0.016 * (2.0 * heading).sin() + 0.009 * (2.0 * heading).cos();
        let third = third * (3.0 * heading + 0.7).cos();
        let compass = heading - 0.02 + first + second + third + 0.0026 * stream.normal();
        let _ = writeln!(log, "{heading},{speed},{}", compass.rem_euclid(TAU));
    }
    let measurands = "compass = { sigma = \"2.6 mrad\" }";
    Campaign { model: COMPASS, effects, measurands, log }.diagnosed()
}

/// However unevenly headings were visited, and whatever files there are that do nothing.
#[test]
fn a_row_keeps_its_value_beside_a_remainder_over_the_same_angle() {
    // Of several orders what the remainder may have of the first one, by what it has of others; one order
    // has none of it.
    for (seed, third, sigmas) in [(91, 0.006, 0.001..0.01), (92, 0.0, 1e-4..3e-4)] {
        let [with, alone] =
            [&[IRON, CURRENT][..], &[IRON]].map(|effects| iron(effects, third, seed));
        for found in [&with, &alone] {
            assert_eq!(names(found), ["hard_iron"], "{}", told(found));
            assert_eq!(found.verdict, Verdict::PartlyExplained, "{}", told(found));
            // Of one row the part that it closes is what the verdict says.
            let closed = found.gap.as_ref().unwrap().closed;
            assert!((found.rows[0].closes - closed).abs() < 1e-9, "{}", told(found));
            for (value, truth) in found.rows[0].values.iter().zip([0.037, -0.059]) {
                let (value, sigma) = (value.value.unwrap(), value.sigma.unwrap());
                assert!((value - truth).abs() < 0.001, "{value} for {truth}, {}", told(found));
                assert!((value - truth).abs() < 4.0 * sigma, "{value} for {truth}: {sigma}");
                assert!(sigmas.contains(&sigma), "{sigma} {}", told(found));
            }
        }
        for (one, other) in with.rows[0].values.iter().zip(&alone.rows[0].values) {
            assert!((one.value.unwrap() - other.value.unwrap()).abs() < 2e-4);
        }
    }
}

/// Angles every 10 degrees: waves of 24 a turn are those of 12, and the lower order is named.
#[test]
fn of_waves_that_few_angles_do_not_tell_apart_the_lowest_is_named() {
    let mut stream = Stream(95);
    let mut log = String::from("rotor [rad],current [A],winding [K],torque [N m]\n");
    for row in 0..720 {
        let (rotor, current) = (TAU * f64::from(row % 36) / 36.0, 4.0 * stream.uniform());
        let wave = 0.02 * (24.0 * rotor + 0.4).cos();
        let torque = 0.6 * current + wave + 0.01 * stream.normal();
        let _ = writeln!(log, "{rotor},{current},300,{torque}");
    }
    let measurands = "torque = { sigma = \"0.01 N m\" }";
    let found = Campaign { model: MOTOR, effects: &[], measurands, log }.diagnosed();
    let words = &found.remainder[0].place.words;
    assert!(words.ends_with("over rotor, 12 waves a turn"), "{}", told(&found));
}

/// Places every 15 degrees, or nearly so: a wave of a low order is one of the finer ones there, and the
/// order of the cause is named, with its own amplitude.
#[test]
fn a_low_order_at_even_places_is_no_finer_one() {
    let cases = [(1, 0.0), (2, 0.0), (2, 1e-5), (3, 1e-3), (2, 5e-3), (1, 1e-2)];
    for (seed, (order, off)) in (131..).zip(cases) {
        let mut stream = Stream(seed);
        let mut log = String::from("rotor [rad],current [A],winding [K],torque [N m]\n");
        for row in 0..240 {
            let rotor = TAU * f64::from(row % 24) / 24.0 + off * stream.normal();
            let current = 4.0 * stream.uniform();
            let wave = 0.01 * (f64::from(order) * rotor + 0.4).cos();
            let torque = 0.6 * current + wave + 0.01 * stream.normal();
            let _ = writeln!(log, "{rotor:.6},{current},300,{torque}");
        }
        let measurands = "torque = { sigma = \"0.01 N m\" }";
        let found = Campaign { model: MOTOR, effects: &[], measurands, log }.diagnosed();
        let words = match order {
            1 => "over rotor, 1 wave a turn".to_owned(),
            _ => format!("over rotor, {order} waves a turn"),
        };
        assert!(found.remainder[0].place.words.ends_with(&words), "{off}: {}", told(&found));
        let (amplitude, _) = found.remainder[0].amplitude.as_ref().unwrap();
        assert!((amplitude - 0.01).abs() < 0.003, "{order}: {amplitude}");
    }
}
