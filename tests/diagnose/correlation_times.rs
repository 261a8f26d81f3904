//! Noise that is correlated over several times, as that of receivers and gyroscopes is: it is noise, and
//! a step beside it is none.

use std::fmt::Write as _;

use homepoint::diagnose::Diagnosis;
use homepoint::diagnose::budget::answer::Verdict;

use crate::found::told;
use crate::own_effects::Campaign;
use crate::stream::Stream;

/// A receiver on a table that moves to and fro.
const RECEIVER: &str = r#"
name = "receiver"
title = "Receiver"
[inputs]
stroke = { unit = "m" }
[parameters]
zero = { unit = "m", scope = "rig" }
[measurands]
north = { value = 'stroke + zero', unit = "m" }
"#;

/// Correlation times (s) and standard deviations (m) of its noise beside 2 mm that are white.
const PROCESSES: [(f64, f64); 3] = [(1.0, 2e-3), (14.0, 2e-3), (160.0, 3e-3)];

/// Ten minutes at 5 Hz, with a step in the middle.
fn diagnosed(seed: u64, step: f64) -> Diagnosis {
    logged(seed, step).diagnosed()
}

fn logged(seed: u64, step: f64) -> Campaign<'static> {
    let mut random = Stream(seed);
    let mut states = PROCESSES.map(|(_, deviation)| deviation * random.normal());
    let mut log = "time [s],stroke [m],north [m]\n".to_owned();
    for row in 0..3000 {
        let time = 0.2 * f64::from(row);
        for (state, (memory, deviation)) in states.iter_mut().zip(PROCESSES) {
            let keep = f64::exp(-0.2 / memory);
            *state = keep * *state + (1.0 - keep * keep).sqrt() * deviation * random.normal();
        }
        let stroke = 0.1 * (0.6 * time).sin();
        let shift = if row < 1500 { 0.0 } else { step };
        let noise = states.iter().sum::<f64>() + 2e-3 * random.normal();
        writeln!(log, "{time:.1},{stroke:.6},{:.6}", stroke + 0.3 + shift + noise).unwrap();
    }
    let measurands = "north = { sigma = \"4 mm\" }";
    Campaign { model: RECEIVER, effects: &[], measurands, log }
}

#[test]
fn noise_that_is_correlated_over_three_times_is_noise() {
    for seed in 1..9 {
        let found = diagnosed(seed, 0.0);
        assert_eq!(found.verdict, Verdict::Explained, "{seed}: {}", told(&found));
        assert_eq!(found.autocorrelation.len(), 1);
        let noise = found.autocorrelation[0].noise;
        assert!(noise.processes().count() > 1, "{seed}: {noise:?}");
    }
}

/// Whitened from its first sample on: of the whole column from there on the spike at the step would be
/// missing, and two opposite steps of three times the size make one.
#[test]
fn a_step_beside_it_is_one_step_of_its_size() {
    for seed in 1..7 {
        let found = diagnosed(seed, 0.03);
        assert_eq!(found.verdict, Verdict::Unknown, "{seed}: {}", told(&found));
        let steps = found.remainder.iter().filter_map(|one| Some((one, one.change.as_ref()?)));
        let steps: Vec<_> = steps.collect();
        let [(part, step)] = steps[..] else { panic!("{seed}: {}", told(&found)) };
        let (row, _) = part.place.rows.unwrap();
        assert!((1497..1506).contains(&row), "{seed}: {row}");
        let far = (step.value - 0.03) / step.sigma;
        assert!(far.abs() < 4.0 && step.sigma < 4e-3, "{seed}: {step:?}");
    }
}

/// Without times, noise is correlated over rows: over as many as there are in its times.
#[test]
fn without_times_it_is_correlated_over_rows() {
    let mut untimed = logged(1, 0.0);
    let timed = logged(1, 0.0).diagnosed();
    let without = |line: &str| line.split_once(',').unwrap().1.to_owned() + "\n";
    untimed.log = untimed.log.lines().map(without).collect();
    let untimed = untimed.diagnosed();
    assert_eq!(untimed.verdict, Verdict::Explained, "{}", told(&untimed));
    let ([over_time], [over_rows]) = (&timed.autocorrelation[..], &untimed.autocorrelation[..])
    else {
        panic!("{}", told(&untimed))
    };
    assert!(over_rows.is_over_rows && !over_time.is_over_rows);
    let pairs = over_time.noise.processes().zip(over_rows.noise.processes());
    for (over_time, over_rows) in pairs {
        assert!((over_rows.share - over_time.share).abs() < 0.01, "{over_rows:?} {over_time:?}");
        let ratio = over_rows.time * 0.2 / over_time.time;
        assert!((ratio - 1.0).abs() < 0.02, "{over_rows:?} {over_time:?}");
    }
    assert!(!untimed.not_testable.iter().any(|one| !one.wants.is_empty()));
}
