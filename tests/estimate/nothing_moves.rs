//! Campaigns in which nothing moves: no times, no delays, no warnings about them.

use std::process::{Command, Output};

use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::{Calibration, calibrate};
use homepoint::estimate::checks::check;

use crate::folder::Folder;
use crate::problems::Stream;
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
        assert_eq!(text.matches("No signal moves in these runs").count(), 1, "{command}: {text}");
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

/// A rate table at its stops: the rate of the table is an input of its own, which a file has beside
/// the angle as the rate of a signal would be. Neither is a signal.
#[test]
fn a_rate_beside_an_input_that_is_no_signal_moves_nothing() {
    let fit = table("false");
    assert!(fit.is_sound() && !fit.problem.moves());
    assert_eq!(fit.unknowns(), 2);
}

/// No signal acts on the second reading: its delay changes nothing, and the other's is estimated.
#[test]
fn a_reading_on_which_no_signal_acts_has_no_delay() {
    let fit = table("true");
    assert!(fit.is_sound() && fit.problem.moves());
    let estimates = fit.estimates();
    let of = |name: &str| estimates.iter().find(|one| one.name == name).unwrap().sigma;
    assert_eq!(fit.unknowns(), 3);
    assert!(
        of("along.delay").unwrap() > 0.0 && of("turning.delay").is_none_or(|sigma| sigma == 0.0)
    );
}

/// A turntable: gravity along an axis that turns with it, and the rate. `signal`: whether its angle
/// is one.
fn table(signal: &str) -> Calibration {
    let model = format!(
        "name = \"table\"\ntitle = \"Turntable\"\n[inputs]\nangle = {{ unit = \"rad\", signal = {signal} }}\nangle_rate = {{ unit = \"rad/s\" }}\n\
         [parameters]\nscale = {{ unit = \"1\", scope = \"rig\", start = \"1\" }}\nbias = {{ unit = \"rad/s\", scope = \"rig\" }}\n\
         [measurands]\nalong = {{ value = 'scale * sin(angle)', unit = \"1\", sigma = \"0.001\" }}\n\
         turning = {{ value = 'angle_rate + bias', unit = \"rad/s\", sigma = \"0.001 rad/s\" }}\n"
    );
    let campaign = "title = \"Turntable\"\nmodel = \"model.toml\"\n[[runs]]\nname = \"r\"\ndata = \"data.csv\"\n";
    let mut data = "time [s],angle [rad],angle_rate [rad/s],along [1],turning [rad/s]\n".to_owned();
    let mut noise = Stream(5);
    for n in 0..60 {
        let (angle, rate) = (0.7 * f64::from(n), 0.2 + 0.01 * f64::from(n % 7));
        let along = 1.02 * angle.sin() + 1e-3 * noise.normal();
        let read = rate + 0.03 + 1e-3 * noise.normal();
        data += &format!("{n},{angle},{rate},{along:.6},{read:.6}\n");
    }
    let files = [("model.toml", &*model), ("campaign.toml", campaign), ("data.csv", &*data)];
    let folder = Folder::new("table", &files);
    calibrate(open(&Request::new([&*folder])).unwrap().problem, &Options::default()).unwrap()
}

/// A signal that stands still beside one that moves: the delay of what it alone acts on does nothing.
#[test]
fn a_signal_without_a_rate_beside_one_that_moves_has_no_delay() {
    let model = "name = \"two\"\ntitle = \"Two\"\n[inputs]\nangle = { unit = \"rad\", signal = true }\ntilt = { unit = \"rad\", signal = true }\n\
         [parameters]\nbias = { unit = \"rad\", scope = \"rig\" }\n\
         [measurands]\nalong = { value = 'sin(angle)', unit = \"1\", sigma = \"0.001\" }\n\
         level = { value = 'tilt + bias', unit = \"rad\", sigma = \"0.001 rad\" }\n";
    let campaign =
        "title = \"Two\"\nmodel = \"model.toml\"\n[[runs]]\nname = \"r\"\ndata = \"data.csv\"\n";
    let mut data =
        "time [s],angle [rad],angle_rate [rad/s],tilt [rad],along [1],level [rad]\n".to_owned();
    let mut noise = Stream(6);
    for n in 0..60 {
        let (angle, tilt) = (0.7 * f64::from(n), 0.01 * f64::from(n % 9));
        let (along, level) =
            (angle.sin() + 1e-3 * noise.normal(), tilt + 0.02 + 1e-3 * noise.normal());
        data += &format!("{n},{angle},0.7,{tilt},{along:.6},{level:.6}\n");
    }
    let files = [("model.toml", model), ("campaign.toml", campaign), ("data.csv", &*data)];
    let folder = Folder::new("two", &files);
    let fit = calibrate(open(&Request::new([&*folder])).unwrap().problem, &Options::default());
    let fit = fit.unwrap();
    assert!(fit.is_sound());
    assert_eq!(fit.unknowns(), 2);
}
