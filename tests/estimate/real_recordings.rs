//! Real recordings with known results: a robot arm under a laser tracker. They do not ship; tests
//! say so and pass where they are absent.
#![expect(clippy::print_stderr, reason = "what was measured is told")]

use std::path::Path;

use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::{Calibration, calibrate};

use crate::common;
use crate::folder::Folder;

fn run(folder: &Path, with: &[&str], set: &[&str]) -> Calibration {
    let mut request = Request::new([folder]);
    request.with = with.iter().map(|name| (*name).to_owned()).collect();
    request.set = set.iter().map(|text| (*text).to_owned()).collect();
    calibrate(open(&request).unwrap().problem, &Options::default()).unwrap()
}

/// rms of the distance between read and predicted point (mm).
fn rms_3d(result: &Calibration) -> f64 {
    result.rms.iter().map(|(_, rms)| rms * rms).sum::<f64>().sqrt() * 1e3
}

fn value(result: &Calibration, name: &str) -> (f64, f64) {
    let found = result.estimates().into_iter().find(|one| one.name == name).unwrap();
    (found.value.unwrap(), found.sigma.unwrap())
}

#[test]
fn arrival_times_explain_most_of_the_gap_of_the_swinging_arm() {
    let Some(folder) = common::shared("ur5_lasertracker/lan10") else { return };
    let constant = run(&folder, &[], &[]);
    let rms = rms_3d(&constant);
    eprintln!("constant delay: {rms:.2} mm");
    assert!((60.0..75.0).contains(&rms), "{rms}");
    let clocks = run(&folder, &["arrival_stamps", "sample_clock_rate"], &[]);
    let rms = rms_3d(&clocks);
    eprintln!("arrival stamps and sample clock: {rms:.3} mm");
    assert!(rms <= 0.28, "{rms}");
    let lag = run(&folder, &["arrival_stamps", "sample_clock_rate", "acceleration_lag"], &[]);
    let rms = rms_3d(&lag);
    let (c, u) = value(&lag, "acceleration_lag.lag");
    eprintln!("acceleration lag, too: {rms:.3} mm, {c:e} ± {u:e} s²");
    assert!(rms <= 0.21, "{rms}");
    assert!((-2e-4..-0.5e-4).contains(&c), "{c:e}");
}

/// The published adjustment: lever (mm) and translation (m), with standard deviations (mm).
const LEVER: [(f64, f64); 3] = [(-26.556, 0.064), (-114.059, 0.129), (86.778, 0.056)];
const TRANSLATION: [(f64, f64); 3] = [(-5.053469, 0.127), (-1.639007, 0.071), (-0.618820, 0.062)];

#[test]
fn static_poses_reproduce_the_published_adjustment() {
    let Some(source) = common::shared("ur5_lasertracker/static_poses") else { return };
    let folder = Folder::new("static_poses", &[]);
    std::fs::copy(source.join("poses.csv"), folder.join("poses.csv")).unwrap();
    let text = r#"
title = "static poses"
model = "tool_pose_laser_tracker"
[parameters]
"tracker.delay" = { value = "0 s", fixed = true }
[measurands]
x = { sigma = "0.3 mm" }
y = { sigma = "0.3 mm" }
z = { sigma = "0.3 mm" }
[[runs]]
name = "static_poses"
role = "reference"
data = "poses.csv"
"#;
    std::fs::write(folder.join("campaign.toml"), text).unwrap();
    let result = run(&folder, &[], &[]);
    let scaled = run(&folder, &["kinematic_scale"], &[]);
    assert!(result.is_sound(), "{:?}", result.unobservable);
    for (axis, (published, deviation)) in ["x", "y", "z"].iter().zip(LEVER) {
        let (found, _) = value(&result, &format!("lever.{axis}"));
        let off = (found * 1e3 - published).abs() / deviation;
        assert!(off <= 1.0, "lever.{axis}: {off:.2} standard deviations");
    }
    for (axis, (published, deviation)) in ["x", "y", "z"].iter().zip(TRANSLATION) {
        let (found, _) = value(&result, &format!("position.{axis}"));
        let off = (found - published).abs() * 1e3 / deviation;
        assert!(off <= 1.0, "position.{axis}: {off:.2} standard deviations");
    }
    let rms = rms_3d(&result);
    assert!((rms - 0.498).abs() < 0.005, "{rms}");
    let rms = rms_3d(&scaled);
    assert!((rms - 0.372).abs() < 0.005, "{rms}");
    let (scale, _) = value(&scaled, "kinematic_scale.scale");
    assert!((scale.abs() * 1e6 - 443.0).abs() < 10.0, "{scale:e}");
}
