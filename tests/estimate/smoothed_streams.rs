//! The error of a smoothed stream's curve in the weights: a gyro against the rate of an angle that
//! is logged with noise.

use std::fmt::Write;

use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::{Calibration, calibrate};
use homepoint::estimate::stream_bias::{Cause, stream_biases};

use crate::folder::Folder;
use crate::problems::Stream;

const MODEL: &str = "name = \"gyro\"\n[inputs]\nangle = { unit = \"rad\", signal = true, smooth = \"0.4 s\" }\n\
    [parameters]\nbias = { unit = \"rad/s\", scope = \"rig\" }\ngain = { unit = \"1\", scope = \"rig\", start = \"1\" }\n\
    [measurands]\nw = { value = 'gain * rate(angle) + bias', unit = \"rad/s\" }\n\
    q = { value = 'angle', unit = \"rad\" }\n";
/// Standard deviations of the gyro (rad/s), the other reading (rad), and the logged angle (rad).
const GYRO: f64 = 2e-3;
const OTHER: f64 = 0.05;

fn angle(t: f64) -> (f64, f64) {
    let (a, b) = (0.8, 1.1);
    ((a * t).sin() + 0.3 * (b * t).cos(), a * (a * t).cos() - 0.3 * b * (b * t).sin())
}

fn fit(noise: f64, input: &str, seed: u64) -> Calibration {
    fit_of_clocks(noise, input, seed, 0.0)
}

/// The same where the clock of the logged angle is ahead by this (s).
fn fit_of_clocks(noise: f64, input: &str, seed: u64, ahead: f64) -> Calibration {
    fit_of_model(MODEL, noise, input, seed, ahead)
}

fn fit_of_model(model: &str, noise: f64, input: &str, seed: u64, ahead: f64) -> Calibration {
    let mut stream = Stream(seed);
    let mut logged = String::from("time [s],angle [rad]\n");
    for n in 0..6001 {
        let t = -5.0 + 0.01 * f64::from(n);
        writeln!(logged, "{},{}", t + ahead, angle(t).0 + noise * stream.normal()).unwrap();
    }
    let mut read = String::from("time [s],w [rad/s],q [rad]\n");
    for n in 0..1000 {
        let t = 0.05 * f64::from(n);
        let (value, rate) = angle(t);
        let (w, q) = (rate + 0.01 + GYRO * stream.normal(), value + OTHER * stream.normal());
        writeln!(read, "{t},{w},{q}").unwrap();
    }
    let campaign = format!(
        "title = \"Gyro\"\nmodel = \"gyro.toml\"\ndelay_range = [\"{} s\", \"{} s\"]\n\
         parameters.\"w.delay\".start = \"{ahead} s\"\nparameters.\"q.delay\".start = \"{ahead} s\"\n{input}\n[measurands]\nw = {{ sigma = \"{GYRO} rad/s\" }}\nq = {{ sigma = \"{OTHER} rad\" }}\n\
         [[runs]]\nname = \"run\"\ndata = \"read.csv\"\nsignals = [\"logged.csv\"]\n",
        ahead - 0.5,
        ahead + 0.5
    );
    let files = [
        ("campaign.toml", &*campaign),
        ("gyro.toml", model),
        ("logged.csv", &*logged),
        ("read.csv", &*read),
    ];
    let folder = Folder::new("gyro", &files);
    calibrate(open(&Request::new([&*folder])).unwrap().problem, &Options::default()).unwrap()
}

fn added(fit: &Calibration) -> Vec<f64> {
    fit.problem.parts[0].smoothing_sigma.first().cloned().unwrap_or_default()
}

#[test]
fn noise_of_a_smoothed_stream_is_in_the_weights() {
    let noise = 2e-3;
    let found = fit(noise, "", 5);
    // The filter 1 / (1 + (ω s)⁴): the variance of its rate is σ² Δ / s³ times (1/2π) ∫ u² / (1 + u⁴)² du.
    let s: f64 = 0.4 / std::f64::consts::TAU;
    let integral = std::f64::consts::PI / (4.0 * 2.0_f64.sqrt());
    let due = noise * (0.01 / s.powi(3) * integral / std::f64::consts::TAU).sqrt();
    let found_w = added(&found)[0];
    assert!((found_w / due - 1.0).abs() < 0.15, "{found_w} for {due}");
    // The value of the curve moves the other reading by far less than it scatters.
    assert_eq!(added(&found)[1], 0.0);
    let factor = found.variance_factor().unwrap();
    assert!((factor - 1.0).abs() < 0.12, "{factor}");
    // Without the curve's noise residuals would be twice as large as stated.
    assert!(due > 1.5 * GYRO);
    // What is stated of the input says nothing of its rate.
    let stated = fit(noise, "[inputs]\nangle = { sigma = \"2 mrad\" }", 5);
    assert!((added(&stated)[0] / due - 1.0).abs() < 0.15, "{:?}", added(&stated));
}

/// Whichever way the smoothing was chosen, what it leaves of the noise is counted.
#[test]
fn noise_of_a_stream_without_stated_smoothing_is_in_the_weights() {
    let model = MODEL.replace(", smooth = \"0.4 s\"", "");
    for input in ["", "[inputs]\nangle = { sigma = \"5 mrad\" }"] {
        let found = fit_of_model(&model, 5e-3, input, 6, 0.0);
        assert!(added(&found)[0] > 0.5 * GYRO, "{input}: {:?}", added(&found));
        let factor = found.variance_factor().unwrap();
        assert!((factor - 1.0).abs() < 0.12, "{input}: {factor}");
    }
}

/// A gain of a noisy rate is too small by the variance of the noise over that of the rate.
#[test]
fn a_gain_that_the_noise_of_a_rate_attenuates_is_named_with_its_bias() {
    let found = fit(0.05, "", 7);
    let gain = found.estimates().into_iter().find(|one| one.name == "gain").unwrap();
    let off = gain.value.unwrap() - 1.0;
    let biases = stream_biases(&found);
    let [one] = &biases[..] else { panic!("{biases:?}") };
    assert_eq!((one.estimate.name.as_str(), one.by), ("gain", Cause::Noise));
    assert!(off < -0.015 && (one.bias / off - 1.0).abs() < 0.4, "{} for {off}", one.bias);
}

/// Smoothing over half a period of the motion takes some of it off: the gain is too large.
#[test]
fn a_gain_of_a_motion_that_is_smoothed_away_is_named_with_its_bias() {
    let found = fit(1e-4, "[inputs]\nangle = { smooth = \"3 s\" }", 8);
    let gain = found.estimates().into_iter().find(|one| one.name == "gain").unwrap();
    let off = gain.value.unwrap() - 1.0;
    let biases = stream_biases(&found);
    let one = biases.iter().find(|one| one.estimate.name == "gain").unwrap();
    assert_eq!(one.by, Cause::Smoothing);
    assert!(off > 0.01 && (one.bias / off - 1.0).abs() < 0.3, "{} for {off}", one.bias);
    assert!(stream_biases(&fit(1e-6, "", 8)).is_empty());
}

#[test]
fn a_stream_without_noise_changes_nothing() {
    assert!(added(&fit(1e-6, "", 5)).is_empty());
}

/// Stamps of one file that are all off by a time zone are a delay, and nothing else: the noise of the
/// stream is there at the moments that are looked at.
#[test]
fn clocks_far_apart_hide_no_noise_of_a_stream() {
    let [near, far] = [0.0, 3600.0].map(|ahead| fit_of_clocks(2e-3, "", 1, ahead));
    let alike = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-3, "{a} {b}");
    assert!(added(&near)[0] > GYRO, "{:?}", added(&near));
    alike(added(&far)[0], added(&near)[0]);
    alike(far.variance_factor().unwrap(), near.variance_factor().unwrap());
    for (one, other) in near.estimates().iter().zip(far.estimates()) {
        alike(other.sigma.unwrap(), one.sigma.unwrap());
    }
}

/// Without a run the others keep their own uncertainties of smoothing.
#[test]
fn runs_that_stay_keep_what_is_known_of_their_streams() {
    let fitted = fit(1e-3, "", 5);
    let mut part = fitted.problem.parts[0].clone();
    let own = part.smoothing_sigma[0].clone();
    assert!(own.iter().any(|sigma| *sigma > 0.0));
    let other: Vec<f64> = own.iter().map(|sigma| 2.0 * sigma).collect();
    part.runs.push(part.runs[0].clone());
    part.smoothing_sigma.push(other.clone());
    let both = fitted.problem.with_parts(vec![part]);
    let last = both.without_runs(|_, run| run == 0).unwrap();
    assert_eq!(last.parts[0].smoothing_sigma, [other]);
}
