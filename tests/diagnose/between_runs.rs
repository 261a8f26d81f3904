//! What differs from one run to the next, and readings of which other noise is stated.

use std::fmt::Write as _;

use homepoint::diagnose::budget::answer::Verdict;
use homepoint::diagnose::{Diagnosis, judge};
use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::Options;

use crate::found::told;
use crate::own_effects::Campaign;
use crate::stream::Stream;
use crate::written::diagnosed;

const SLIDE: &str = r#"
name = "slide"
title = "A slide"
[inputs]
place = { unit = "m", signal = true }
[parameters]
zero = { unit = "m", scope = "rig" }
[measurands]
reading = { value = 'place + zero', unit = "m" }
"#;

/// Three runs in one course; the slide stands still for a while at the end of the second, and in the
/// third the stamps of the readings are off.
fn stamps_of_the_last_run_are_off(seed: u64) -> Diagnosis {
    let mut stream = Stream(seed);
    let place = |run: u32, t: f64| {
        let moved = f64::from(run) + (0.9 * t.min(8.0)).sin();
        if run == 1 { moved } else { moved + 0.4 * (1.7 * t).cos() }
    };
    let mut files = vec![("model.toml".to_owned(), SLIDE.to_owned())];
    let mut campaign = String::from(
        "title = \"Slide\"\nmodel = \"model.toml\"\n[measurands]\nreading = { sigma = \"1 mm\" }\n",
    );
    for run in 0..3_u32 {
        let late = if run == 2 { 0.12 } else { 0.0 };
        let mut read = String::from("time [s],reading [m]\n");
        let mut logged = String::from("time [s],place [m]\n");
        for n in 0..600 {
            let t = 0.02 * f64::from(n);
            let stamp = 20.0 * f64::from(run) + t;
            if (25..575).contains(&n) {
                let reading = place(run, t - late) + 0.05 + 1e-3 * stream.normal();
                let _ = writeln!(read, "{stamp},{reading}");
            }
            let _ = writeln!(logged, "{stamp},{}", place(run, t) + 1e-5 * stream.normal());
        }
        let _ = write!(
            campaign,
            "[[runs]]\nname = \"run{run}\"\nsetup = \"A\"\ndata = \"read{run}.csv\"\nsignals = [\"log{run}.csv\"]\n"
        );
        files.push((format!("read{run}.csv"), read));
        files.push((format!("log{run}.csv"), logged));
    }
    files.push(("campaign.toml".to_owned(), campaign));
    diagnosed(&files)
}

/// Where nothing moves before it, the change would fit as well within the run before.
#[test]
fn what_changes_between_runs_is_placed_there() {
    for seed in 1..=4 {
        let found = stamps_of_the_last_run_are_off(seed);
        assert_eq!(found.verdict, Verdict::Unknown, "{}", told(&found));
        let place = &found.remainder[0].place;
        assert!(place.words.starts_with("a timing error"), "{}", told(&found));
        assert_eq!((place.run.as_deref(), place.rows), (Some("run2"), None), "{}", told(&found));
    }
}

const GAUGE: &str = r#"
name = "gauge"
title = "A gauge beside another"
[inputs]
other = { unit = "mm" }
wind = { unit = "m/s" }
[parameters]
gain = { unit = "1", scope = "rig", start = "1" }
[measurands]
rain = { value = 'gain * other', unit = "mm" }
"#;
const LOSS: (&str, &str, &str) = (
    "loss",
    "k = { unit = \"s/m\", typical = \"0.02 s/m\", scope = \"rig\" }",
    "rain = 'rain * (1 - k * wind)'",
);

/// Large readings are stated to be noisier: no burst is left out where it rains most.
#[test]
fn readings_that_are_stated_to_be_noisier_are_not_farther_out() {
    for seed in 1..=6 {
        let mut stream = Stream(seed);
        let mut log = String::from("other [mm],wind [m/s],rain [mm]\n");
        for row in 0..400 {
            let heavy = (-0.5 * ((f64::from(row) - 150.0) / 2.5).powi(2)).exp();
            let (other, wind) =
                (2.0 + 2.0 * stream.uniform() + 90.0 * heavy, 8.0 * stream.uniform());
            let due = other * (1.0 - 0.02 * wind);
            let rain = due + (0.1 + 0.04 * due) * stream.normal();
            let _ = writeln!(log, "{other},{wind},{rain}");
        }
        let measurands = "rain = { sigma = \"0.1 mm + 0.04 * rain\" }";
        let found = Campaign { model: GAUGE, effects: &[LOSS], measurands, log }.diagnosed();
        assert!(found.left_out.is_empty(), "{seed}: {}", told(&found));
        assert_eq!(found.rows.len(), 1, "{seed}: {}", told(&found));
    }
}

/// A campaign that was held out is as noisy as the one that was fitted, and states the same: what
/// remains in it is noise.
#[test]
fn a_held_out_campaign_has_the_noise_that_was_found() {
    let of = |seed: u64| {
        let mut stream = Stream(seed);
        let mut log = String::from("other [mm],wind [m/s],rain [mm]\n");
        for _ in 0..600 {
            let (other, wind) = (10.0 + 20.0 * stream.uniform(), 8.0 * stream.uniform());
            let rain = other * (1.0 - 0.02 * wind) + 0.3 * stream.normal();
            let _ = writeln!(log, "{other},{wind},{rain}");
        }
        let measurands = "rain = { sigma = \"0.2 mm\" }";
        Campaign { model: GAUGE, effects: &[LOSS], measurands, log }
    };
    let mut found = of(11).diagnosed();
    assert_eq!(found.rows.len(), 1, "{}", told(&found));
    let folder = tempfile::tempdir().unwrap();
    of(12).write_to(folder.path());
    let held_out = open(&Request::new([folder.path()])).unwrap();
    judge(&mut found, &held_out, &Options::default()).unwrap();
    let gap = found.gap.unwrap();
    assert!(gap.closed > 0.99, "{} {:?}", gap.closed, gap.closed_interval);
    let (_, floor) = &gap.floor[0];
    assert!((floor / 0.3e-3 - 1.0).abs() < 0.1, "{floor}");
}
