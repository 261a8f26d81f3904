//! Campaigns of the seed's rig from an independent simulator, whose true delays are known.
#![expect(clippy::print_stderr, reason = "what was measured is told")]

use std::collections::BTreeMap;
use std::path::Path;

use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::{Calibration, calibrate};

use crate::common;

fn run(folder: &Path, with: &[&str]) -> Calibration {
    let mut request = Request::new([folder]);
    request.with = with.iter().map(|name| (*name).to_owned()).collect();
    calibrate(open(&request).unwrap().problem, &Options::default()).unwrap()
}

fn truth(folder: &Path) -> BTreeMap<String, f64> {
    let text = std::fs::read_to_string(folder.join("truth.json")).unwrap();
    let value: serde_json::Value = serde_json::from_str(&text).unwrap();
    let delays = value["delays_s"].as_object().unwrap();
    delays.iter().map(|(name, value)| (name.clone(), value.as_f64().unwrap())).collect()
}

/// Each delay's error (s) and the error over its own standard uncertainty.
fn errors(result: &Calibration, folder: &Path) -> BTreeMap<String, (f64, f64)> {
    let estimates = result.estimates();
    truth(folder)
        .into_iter()
        .map(|(measurand, truth)| {
            let name = format!("{measurand}.delay");
            let found = estimates.iter().find(|one| one.name == name).unwrap();
            let error = found.value.unwrap() - truth;
            (measurand, (error, error / found.sigma.unwrap()))
        })
        .collect()
}

fn holds(campaign: &str, with: &[&str]) {
    let Some(folder) = common::shared(&format!("practice/{campaign}")) else { return };
    let result = run(&folder, with);
    assert!(result.is_sound(), "{campaign}: {} {:?}", result.fit.outcome, result.unobservable);
    for (measurand, (_, normalised)) in errors(&result, &folder) {
        assert!(normalised.abs() <= 4.0, "{campaign} {measurand}: {normalised:.2} sigma off");
    }
    let factor = result.variance_factor().unwrap();
    assert!((0.97..=1.03).contains(&factor), "{campaign}: variance factor {factor:.4}");
}

#[test]
fn clean_campaigns_give_the_true_delays() {
    for campaign in ["clean_full", "clean_two_setups", "angular_intersection"] {
        holds(campaign, &[]);
    }
}

#[test]
fn campaigns_with_an_effect_give_the_true_delays_with_that_effect() {
    holds("clock_drift", &["clock_drift"]);
    holds("tracking_reversal", &["tracking_reversal"]);
    holds("trunnion_tilt", &["trunnion_tilt"]);
    holds("encoder_eccentricity", &["encoder_eccentricity"]);
    holds("two_effects", &["centrifugal_stretch", "vertical_index"]);
    holds("timestamp_jitter", &["timestamp_jitter"]);
}

/// The bias that an effect leaves in the delays when it is not modelled.
#[test]
fn an_effect_left_out_biases_the_delays() {
    for (campaign, bias) in [("clock_drift", 32e-6), ("tracking_reversal", 7e-6)] {
        let Some(folder) = common::shared(&format!("practice/{campaign}")) else { continue };
        let result = run(&folder, &[]);
        let worst = errors(&result, &folder)
            .into_values()
            .fold(0.0_f64, |worst, (error, _)| worst.max(error.abs()));
        eprintln!("{campaign}: largest bias {:.1} µs", worst * 1e6);
        assert!((worst / bias - 1.0).abs() < 0.1, "{campaign}: {worst:e}");
    }
}

#[test]
fn one_run_at_one_rate_is_refused_in_words() {
    let Some(folder) = common::shared("practice/one_run_only") else { return };
    let result = run(&folder, &[]);
    assert!(!result.is_sound());
    let words: Vec<&str> = result.unobservable.iter().map(|one| one.words.as_str()).collect();
    let whole = words.join("; ");
    for name in ["orientation", "horizontal.delay", "vertical.delay", "distance.delay"] {
        assert!(whole.contains(name), "{name} is not named: {whole}");
    }
    for one in &result.unobservable {
        assert!(one.remedy.contains("opposite sense"), "{}", one.remedy);
    }
    let delays = result.estimates().into_iter().filter(|one| one.name.ends_with(".delay"));
    assert!(delays.into_iter().all(|one| one.value.is_none()), "an arbitrary delay was reported");
}
