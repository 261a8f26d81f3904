//! Standard uncertainties of readings as formulas and as columns: weighted means by hand.

use std::fmt::Write as _;
use std::process::{Command, Output};

use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::calibrate;

use crate::folder::Folder;
use crate::problems::Stream;

const ARCSEC: f64 = std::f64::consts::TAU / 1_296_000.0;

const MODEL: &str = r#"
name = "telescope"
title = "Altitude-azimuth mount"
[inputs]
star_azimuth   = { unit = "deg" }
star_elevation = { unit = "deg" }
[parameters]
azimuth_zero   = { unit = "arcsec" }
elevation_zero = { unit = "arcsec" }
[measurands]
azimuth   = { value = 'star_azimuth + azimuth_zero', kind = "angle", unit = "deg", period = "360 deg" }
elevation = { value = 'star_elevation + elevation_zero', kind = "angle", unit = "deg" }
"#;

/// A star: elevation (rad), error of its azimuth over the zero (rad).
fn stars() -> Vec<[f64; 2]> {
    let mut stream = Stream(5);
    let star = |_| {
        let elevation = 0.2 + 1.2 * stream.uniform();
        [elevation, 3.0 * ARCSEC * stream.normal() / elevation.cos()]
    };
    (0..40).map(star).collect()
}

/// A campaign of these stars; `sigma` is what is stated of azimuths.
fn campaign(sigma: &str, own: impl Fn(usize, f64) -> String) -> Folder {
    let mut table = "azimuth [deg],elevation [deg],star_azimuth [deg],star_elevation [deg],azimuth_sigma [arcsec]\n".to_owned();
    for (number, [elevation, error]) in stars().into_iter().enumerate() {
        let azimuth = (0.3 + 20.0 * ARCSEC + error).to_degrees();
        let star = 0.3_f64.to_degrees();
        let up = elevation.to_degrees();
        let _ = writeln!(table, "{azimuth},{up},{star},{up},{}", own(number, elevation));
    }
    let campaign = format!(
        "title = \"Stars\"\nmodel = \"model.toml\"\n[measurands]\nazimuth = {{ {sigma} }}\n\
         elevation = {{ sigma = \"3 arcsec\" }}\n[[runs]]\nname = \"night\"\ndata = \"stars.csv\"\n"
    );
    let files = [("model.toml", MODEL), ("campaign.toml", &campaign), ("stars.csv", &table)];
    Folder::new("sigmas", &files)
}

/// The zero of azimuths and its standard uncertainty, with weights by hand.
fn by_hand() -> [f64; 2] {
    let weights = |elevation: f64| (elevation.cos() / (3.0 * ARCSEC)).powi(2);
    let all: f64 = stars().iter().map(|[elevation, _]| weights(*elevation)).sum();
    let sum: f64 = stars().iter().map(|[elevation, error]| weights(*elevation) * error).sum();
    [20.0 * ARCSEC + sum / all, all.sqrt().recip()]
}

fn estimated(folder: &Folder) -> [f64; 2] {
    let opened = open(&Request::new([&**folder])).unwrap();
    let fit = calibrate(opened.problem, &Options::default()).unwrap();
    let estimates = fit.estimates();
    let one = estimates.iter().find(|one| one.name == "azimuth_zero").unwrap();
    [one.value.unwrap(), one.sigma.unwrap()]
}

fn near(found: [f64; 2], due: [f64; 2]) {
    for (found, due) in found.iter().zip(due) {
        assert!((found - due).abs() < 1e-7 * due.abs(), "{found} for {due}");
    }
}

#[test]
fn a_formula_weighs_each_reading() {
    let folder = campaign("sigma = \"3 arcsec / cos(elevation)\"", |_, _| String::new());
    near(estimated(&folder), by_hand());
}

#[test]
fn a_column_has_the_sigma_of_each_reading() {
    let own = |_: usize, elevation: f64| format!("{}", 3.0 / elevation.cos());
    near(estimated(&campaign("sigma = \"azimuth_sigma\"", own)), by_hand());
}

#[test]
fn a_quantity_of_the_campaign_comes_before_a_formula_of_the_model() {
    let folder = campaign("sigma = \"3 arcsec\"", |_, _| String::new());
    let due = estimated(&folder);
    let model = MODEL.replace("period =", "sigma = '9 arcsec / cos(elevation)', period =");
    std::fs::write(folder.join("model.toml"), model).unwrap();
    near(estimated(&folder), due);
    let sigma = 3.0 * ARCSEC / 40_f64.sqrt();
    assert!((due[1] - sigma).abs() < 1e-9 * sigma);
}

fn check(folder: &Folder) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_homepoint"));
    command.arg("calibrate").arg(&**folder).output().unwrap()
}

#[test]
fn what_is_no_standard_uncertainty_is_refused_with_its_place() {
    let good = |_: usize, _: f64| "2".to_owned();
    let zero = |number: usize, _: f64| if number == 6 { "0" } else { "2" }.to_owned();
    let negative = |number: usize, _: f64| if number == 6 { "-1" } else { "2" }.to_owned();
    let column = "sigma = \"azimuth_sigma\"";
    let cases: [(Folder, &[&str]); 7] = [
        (campaign(column, zero), &["`azimuth` is 0 deg", "row 8", "sigma = \"azimuth_sigma\""]),
        (campaign(column, negative), &["`azimuth` is -", "row 8"]),
        // Above zero at the start, below it at the estimate.
        (campaign("sigma = \"1 arcsec - 0.1 * azimuth_zero\"", good), &["`azimuth` is -", "row 2"]),
        (campaign("sigma = \"1 / cos(elevation)\"", good), &["no unit of angles"]),
        (campaign("sigma = \"no_such_column\"", good), &["no_such_column"]),
        (campaign("sigma = \"2 mm / cos(elevation)\"", good), &["no unit of angles"]),
        (campaign("sigma = \"azimuth_sigma\", k = 2", good), &["`k` stands beside"]),
    ];
    for (folder, says) in &cases {
        let output = check(folder);
        assert_eq!(output.status.code(), Some(2), "{says:?}: {output:?}");
        let text = String::from_utf8(output.stderr).unwrap();
        for says in *says {
            assert!(text.contains(says), "{says}: {text}");
        }
    }
}
