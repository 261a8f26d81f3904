//! A log in local time beside one in UTC: what moves slowly fits as well, an hour late.

use std::fmt::Write as _;
use std::process::Command;

use tempfile::tempdir;

/// What is told beside the fit of readings that are late by so many seconds.
fn told(late: f64) -> String {
    let folder = tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let elevation = |t: f64| 0.9 * (std::f64::consts::TAU * t / 86_400.0).sin();
    let mut stream = "time [s],sun [rad]\n".to_owned();
    for minute in 0..720 {
        let t = 60.0 * f64::from(minute);
        writeln!(stream, "{t},{:.9}", elevation(t)).unwrap();
    }
    let mut readings = "time [s],tracker [rad]\n".to_owned();
    for row in 0..300 {
        let t = 8_000.0 + 80.0 * f64::from(row);
        let noise = 1e-4 * (12.9 * f64::from(row)).sin();
        writeln!(readings, "{},{:.9}", t + late, elevation(t) + noise).unwrap();
    }
    write("stream.csv", &stream);
    write("readings.csv", &readings);
    write(
        "model.toml",
        "name = \"sun\"\ntitle = \"Sun\"\n[inputs]\nsun = { unit = \"rad\", signal = true }\n\
         [measurands]\ntracker = { value = 'sun', unit = \"rad\" }\n",
    );
    write(
        "campaign.toml",
        "title = \"Day\"\nmodel = \"model.toml\"\n[measurands]\ntracker = { sigma = \"0.1 mrad\" }\n\
         [[runs]]\nname = \"day\"\ndata = \"readings.csv\"\nsignals = [\"stream.csv\"]\n",
    );
    let mut command = Command::new(env!("CARGO_BIN_EXE_homepoint"));
    let output = command.arg("calibrate").arg(folder.path()).output().unwrap();
    String::from_utf8(output.stderr).unwrap()
}

#[test]
fn a_delay_near_whole_half_hours_is_asked_for() {
    let hour = told(3_614.0);
    assert!(hour.contains("near -1.0 h") && hour.contains("time zones"), "{hour}");
    for late in [14.0, 2_700.0] {
        let other = told(late);
        assert!(!other.contains("time zones"), "{late}: {other}");
    }
}
