//! A reading or two that are far out, among a thousand that move: no timing error of the rows about them, no
//! jitter, no noise of a run, and no reason to leave the readings behind them out.

use std::fmt::Write as _;

use homepoint::diagnose::Diagnosis;
use homepoint::diagnose::budget::answer::Verdict;

use crate::found::told;
use crate::stream::Stream;
use crate::written::diagnosed;

const RECEIVER: &str = r#"
name = "receiver"
title = "A receiver against a reference"
[inputs]
px = { unit = "m", signal = true }
py = { unit = "m", signal = true }
[parameters]
sx = { unit = "m", scope = "rig" }
sy = { unit = "m", scope = "rig" }
[measurands]
x = { value = 'px + sx', unit = "m" }
y = { value = 'py + sy', unit = "m" }
[delays]
receiver = { of = ["x", "y"] }
"#;
const RUNS: usize = 10;
const SAMPLES: usize = 90;
const INTERVAL: f64 = 0.4;
const SIGMA: f64 = 0.01;
/// Samples that are wrong, by run and row of its file: in the middle, and the first and the last of a run.
const WRONG: [Wrong; 2] = [[(2, 32), (7, 84)], [(2, 2), (7, SAMPLES + 1)]];
type Wrong = [(usize, usize); 2];

/// Noise that is autocorrelated from one reading to the next.
fn noise(by: f64, random: &mut Stream) -> Vec<f64> {
    let mut state = SIGMA * random.normal();
    let next = |_| {
        let before = state;
        state = by * state + SIGMA * (1.0 - by * by).sqrt() * random.normal();
        before
    };
    (0..SAMPLES).map(next).collect()
}

/// What is found where both coordinates of two samples are so far out.
fn found(samples: Wrong, far: f64, autocorrelated_by: f64, seed: u64) -> Diagnosis {
    let mut random = Stream(seed);
    let mut campaign = "title = \"Receiver\"\nmodel = \"receiver.toml\"\n[measurands]\nx = { sigma = \"10 mm\" }\ny = { sigma = \"10 mm\" }\n".to_owned();
    let mut files = vec![("receiver.toml".to_owned(), RECEIVER.to_owned())];
    let at: Vec<f64> = (0..4).map(|_| 6.0 * random.uniform()).collect();
    for run in 0..RUNS {
        let place = |time: f64| {
            let wave = |by: f64, rate: f64, k: usize| by * (rate * time + at[k] + run as f64).sin();
            [wave(2.2, 0.41, 0) + wave(0.5, 1.1, 1), wave(1.7, 0.35, 2) + wave(0.4, 0.93, 3)]
        };
        let start = 70.0 * run as f64;
        let (mut reference, mut log) =
            ("time [s],px [m],py [m]\n".to_owned(), "time [s],x [m],y [m]\n".to_owned());
        for number in 0..760 {
            let time = 0.05 * f64::from(number) - 1.0;
            let [x, y] = place(time);
            writeln!(reference, "{:.2},{x:.5},{y:.5}", start + time).unwrap();
        }
        let [in_x, in_y] = [0; 2].map(|_| noise(autocorrelated_by, &mut random));
        for (sample, (in_x, in_y)) in in_x.iter().zip(&in_y).enumerate() {
            let time = INTERVAL * sample as f64;
            let [x, y] = place(time - 0.03);
            let wrong = if samples.contains(&(run, sample + 2)) { far } else { 0.0 };
            let [x, y] = [x + 0.1 + in_x + wrong, y + 0.2 + in_y + wrong];
            writeln!(log, "{:.3},{x:.4},{y:.4}", start + time).unwrap();
        }
        files.push((format!("reference_{run}.csv"), reference));
        files.push((format!("receiver_{run}.csv"), log));
        write!(
            campaign,
            "[[runs]]\nname = \"{run}\"\ndata = \"receiver_{run}.csv\"\nsignals = [\"reference_{run}.csv\"]\n"
        )
        .unwrap();
    }
    files.push(("campaign.toml".to_owned(), campaign));
    diagnosed(&files)
}

/// Whether it is explained, and the readings of both wrong samples and no others are left out.
fn is_right(found: &Diagnosis, samples: Wrong) -> bool {
    let mut rows: Vec<(String, usize)> =
        found.left_out.readings.iter().map(|one| (one.run.to_string(), one.row)).collect();
    rows.dedup();
    let due: Vec<(String, usize)> =
        samples.iter().map(|(run, row)| (run.to_string(), *row)).collect();
    rows == due && found.verdict == Verdict::Explained && found.noise.is_empty()
}

#[test]
fn far_out_of_white_noise_they_are_left_out() {
    for (samples, seed) in WRONG.into_iter().zip([1, 2]) {
        for far in [0.1, 0.2] {
            let found = found(samples, far, 0.0, seed);
            assert!(is_right(&found, samples), "{samples:?}, {far}: {}", told(&found));
        }
    }
}

#[test]
fn far_out_of_autocorrelated_noise_they_are_left_out() {
    for (samples, seed) in WRONG.into_iter().zip([1, 2]) {
        for far in [0.12, 0.2] {
            let found = found(samples, far, 0.55, seed);
            assert!(!found.autocorrelation.is_empty(), "{samples:?}, {far}: {}", told(&found));
            assert!(is_right(&found, samples), "{samples:?}, {far}: {}", told(&found));
        }
    }
}
