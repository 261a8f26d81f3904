//! Results in the units of the model or the campaign, and the global test of a fit.

use std::fmt::Write;
use std::path::Path;

use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::{Calibration, calibrate};
use homepoint::report::{json, text};

use crate::folder::Folder;

const MODEL: &str = r#"
name = "level"
title = "A level on a tilting table"

[inputs]
place = { unit = "mm" }

[parameters]
zero = { unit = "arcsec", scope = "instrument" }
slope = { unit = "arcsec/m", scope = "instrument" }
height = { unit = "mm", scope = "instrument" }

[measurands]
tilt = { value = 'zero + slope * place', kind = "angle", unit = "arcsec" }
gap = { value = 'height', unit = "mm" }
"#;

const EFFECT: &str = r#"
name = "ripple"
title = "A wave of the level"
acts = "instrument"

[parameters]
size = { unit = "rad", typical = "1 arcsec", scope = "instrument" }

[patch]
tilt = 'tilt + size * sin(place / 2 cm)'
"#;

/// Errors of the readings, in units of their sigma: without a sum of their own.
const ERRORS: [f64; 8] = [0.9, -1.1, 0.3, -0.4, 1.2, -0.8, -0.6, 0.5];

/// A level whose errors are `times` as large as stated.
fn level(times: f64, output: &str) -> Folder {
    let campaign = format!(
        r#"
model = "level.toml"

[parameters]
tilt.delay = {{ value = "0 ms", fixed = true }}
gap.delay = {{ value = "0 ms", fixed = true }}

[measurands]
tilt = {{ sigma = "0.1 arcsec" }}
gap = {{ sigma = "2 um" }}

{output}

[[runs]]
name = "one"
setup = "A"
data = "one.csv"
"#
    );
    let mut table = "time [s],place [mm],tilt [arcsec],gap [mm]\n".to_owned();
    for (index, error) in ERRORS.iter().enumerate() {
        let place = 50.0 * index as f64;
        let tilt = 20.0 + 0.03 * place + 5.0 * (place / 20.0).sin() + 0.1 * times * error;
        let gap = 0.2 - 0.002 * times * error;
        writeln!(table, "{index},{place},{tilt},{gap}").unwrap();
    }
    let files = [
        ("campaign.toml", campaign.as_str()),
        ("level.toml", MODEL),
        ("effects/ripple.toml", EFFECT),
        ("one.csv", table.as_str()),
    ];
    Folder::new("units", &files)
}

fn fitted(folder: &Path) -> Calibration {
    let mut request = Request::new([folder]);
    request.with = vec!["ripple".to_owned()];
    calibrate(open(&request).unwrap().problem, &Options::default()).unwrap()
}

/// The row of a parameter: its value and its uncertainty.
fn row<'a>(said: &'a str, name: &str) -> Vec<&'a str> {
    let line = said.lines().find(|line| line.starts_with(name)).unwrap();
    line.split_whitespace().skip(2).collect()
}

#[test]
fn values_are_told_in_the_unit_of_the_model() {
    let result = fitted(&level(1.0, ""));
    let said = text::calibration("A level", &result);
    for (name, unit) in
        [("zero", "arcsec"), ("slope", "arcsec/m"), ("height", "mm"), ("ripple.size", "arcsec")]
    {
        let row = row(&said, name);
        assert_eq!((row[1], row[3]), (unit, unit), "{said}");
    }
    let rms = said.lines().find(|line| line.starts_with("residual rms")).unwrap();
    assert!(rms.contains(" arcsec, gap 0.00") && rms.ends_with(" mm"), "{rms}");
    let told = json::calibration(&result);
    let size = told["parameters"].as_array().unwrap().iter().find(|one| one["name"] == "zero");
    let size = size.unwrap();
    assert_eq!(
        (size["unit"].as_str(), size["display_unit"].as_str()),
        (Some("rad"), Some("arcsec"))
    );
    let arcsec = std::f64::consts::PI / 648_000.0;
    assert!((size["value"].as_f64().unwrap() / arcsec - 20.0).abs() < 0.3);
}

#[test]
fn a_campaign_states_the_units_of_results() {
    let output = "[output]\nunits = { angle = \"mdeg\", length = \"um\", zero = \"mrad\" }";
    let said = text::calibration("A level", &fitted(&level(1.0, output)));
    for (name, unit) in [("zero", "mrad"), ("height", "um"), ("ripple.size", "mdeg")] {
        assert_eq!(row(&said, name)[1], unit, "{said}");
    }
    assert!(said.contains("tilt 0.0"), "{said}");
    let wrong = level(1.0, "[output]\nunits = { angle = \"mm\" }");
    let error = open(&Request::new([&*wrong])).unwrap_err().to_string();
    assert!(error.contains("`mm` is not a unit of `angle`"), "{error}");
}

/// Both tails of chi squared of an even number of degrees of freedom are sums of Poisson terms.
fn two_sided(chi_squared: f64, degrees: i64) -> f64 {
    let half = 0.5 * chi_squared;
    let mut term = (-half).exp();
    let (mut above, mut below) = (0.0, 0.0);
    for k in 0..400 {
        if k < degrees / 2 {
            above += term
        } else {
            below += term
        }
        term *= half / (k + 1) as f64;
    }
    2.0 * f64::min(above, below)
}

#[test]
fn the_global_test_judges_residuals_from_both_sides() {
    for (times, sentence) in [
        (0.03, Some("in another unit perhaps")),
        (0.3, Some("less than chance allows")),
        (1.3, None),
        (3.0, Some("times as large as stated: the uncertainties do not hold")),
    ] {
        let result = fitted(&level(times, ""));
        // 16 readings, four unknowns.
        assert_eq!(result.degrees_of_freedom(), 12);
        let p = homepoint::estimate::global::p_value(&result).unwrap();
        let right = two_sided(result.fit.cost, 12);
        assert!((p / right - 1.0).abs() < 1e-9, "{p} {right}");
        assert_eq!(json::calibration(&result)["fit"]["p"].as_f64(), Some(p));
        let said = text::calibration("A level", &result);
        assert!(said.contains("12 degrees of freedom, p "), "{said}");
        match sentence {
            Some(sentence) => assert!(said.contains(sentence), "{said}"),
            None => assert!(!said.contains("as large as stated"), "{said}"),
        }
    }
}
