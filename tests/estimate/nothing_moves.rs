//! Campaigns in which nothing moves: no times, no delays, no warnings about them.

use std::process::{Command, Output};

use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::calibrate;
use homepoint::estimate::checks::check;

use crate::folder::Folder;
use crate::problems::camera::Camera;

fn run(arguments: &[&str], folder: &Folder) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_homepoint"));
    command.args(arguments).arg(&**folder).output().unwrap()
}

#[test]
fn stops_of_a_robot_give_the_lever_and_no_delay() {
    let camera = Camera::default();
    let folder = camera.stops(18, 3);
    let opened = open(&Request::new([&*folder])).unwrap();
    assert!(opened.warnings.is_empty(), "{:?}", opened.warnings);
    assert!(check(&opened.problem).is_empty());
    let fit = calibrate(opened.problem, &Options::default()).unwrap();
    assert!(fit.is_sound());
    // Three components each of four unknowns.
    assert_eq!(fit.unknowns(), 12);
    for (axis, due) in ["x", "y", "z"].iter().zip(camera.lever) {
        let estimates = fit.estimates();
        let one = estimates.iter().find(|one| one.name == format!("camera_lever.{axis}")).unwrap();
        let off = (one.value.unwrap() - due).abs();
        assert!(off < 4.0 * one.sigma.unwrap(), "{axis}: {off}");
    }
}

#[test]
fn commands_say_once_that_nothing_moves() {
    let folder = Camera::default().stops(18, 3);
    for command in ["calibrate", "delays", "compare", "deviations"] {
        let output = run(&[command], &folder);
        assert!(output.status.success(), "{command}: {output:?}");
        assert!(output.stderr.is_empty(), "{command}: {output:?}");
        let text = String::from_utf8(output.stdout).unwrap();
        assert_eq!(text.matches("Nothing moves in these runs").count(), 1, "{command}: {text}");
        assert!(!text.contains("camera.delay"), "{command}: {text}");
        let json = run(&[command, "--format", "json"], &folder);
        assert!(json.status.success(), "{command}: {json:?}");
    }
}

/// A delay that is stated all the same stays where it is stated.
#[test]
fn a_stated_delay_changes_nothing() {
    let folder = Camera::default().stops(18, 3);
    let path = folder.join("campaign.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    let stated =
        "[parameters]\n\"camera.delay\" = { value = \"3 ms\", sigma = \"1 ms\" }\n[[runs]]";
    std::fs::write(&path, text.replace("[[runs]]", stated)).unwrap();
    let fit = calibrate(open(&Request::new([&*folder])).unwrap().problem, &Options::default());
    let fit = fit.unwrap();
    assert!(fit.is_sound());
    let estimates = fit.estimates();
    let delay = estimates.iter().find(|one| one.name == "camera.delay").unwrap();
    assert_eq!(delay.value, Some(3e-3));
    assert!((delay.sigma.unwrap() - 1e-3).abs() < 1e-9);
}
