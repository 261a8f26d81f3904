//! Is a certificate read as it is written, and an encoder corrected by it?

use std::convert::Infallible;
use std::f64::consts::PI;
use std::fmt::Write as _;
use std::fs;

use homepoint::campaign::write::write_campaign;
use homepoint::engine::open::{Opened, Request, open};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::calibrate;
use homepoint::estimate::systematic::Widening;
use homepoint::estimate::transformation::Transformation;

use crate::folder::Folder;
use crate::seed;

const ARCSEC: f64 = PI / 180.0 / 3600.0;
const RATE: f64 = 50.0 * PI / 180.0;
const DELAY: f64 = 0.3e-3;

struct Campaign(Folder);

impl Campaign {
    fn new(name: &str, parameters: &str, inputs: &str, measurand: &str) -> Self {
        let campaign = format!(
            "model = \"polar_one_rotation\"\n[parameters]\n{parameters}\n\
             orientation = {{ value = [\"0 rad\", \"0 rad\", \"0 rad\"], fixed = true }}\n\
             position = {{ value = [\"0.4 m\", \"0.1 m\", \"1.4 m\"], fixed = true }}\n\
             [inputs]\n{inputs}\n[measurands]\nhorizontal = {{ {measurand} }}\n\
             [[runs]]\nname = \"fast\"\ndata = \"fast.csv\"\n"
        );
        // The encoder reads too little by 20 arcsec times the sine of twice its reading.
        let mut data =
            "time [s],arm_angle [rad],arm_angle_rate [rad/s],horizontal [rad]\n".to_owned();
        for k in 0..400 {
            let time = 0.02 * f64::from(k);
            let reading = RATE * time;
            // The arm moves at another rate than the encoder's reading of it.
            let rate = RATE * (1.0 + 40.0 * ARCSEC * (2.0 * reading).cos());
            let arm = reading + error(reading) + rate * DELAY;
            let read = seed::polar_one_rotation(arm, 1.146, [1.0, 0.0, 0.0, 0.0], [0.4, 0.1, 1.4]);
            writeln!(data, "{time:?},{reading:?},{RATE:?},{:?}", read[0]).unwrap();
        }
        Self(Folder::new(name, &[("campaign.toml", &campaign), ("fast.csv", &data)]))
    }

    fn with_corrections(self, rows: &str) -> Self {
        fs::write(self.0.join("encoder.csv"), rows).unwrap();
        self
    }

    fn open(&self) -> Opened {
        open(&Request::new([&self.0])).unwrap()
    }

    #[track_caller]
    fn fault(&self) -> String {
        let Err(faults) = open(&Request::new([&self.0])) else { panic!("nothing is wrong") };
        let first = &faults.0[0];
        let place = first.place.as_ref().map_or_else(String::new, |place| {
            let file = place.file.rsplit('/').next().unwrap();
            format!("{file}:{}:{} ", place.line, place.column)
        });
        format!("{place}{} | {}", first.message, first.help.join("; "))
    }
}

fn error(reading: f64) -> f64 {
    20.0 * ARCSEC * (2.0 * reading).sin()
}

/// The certificate of that encoder, a row every degree.
fn certificate() -> String {
    let mut rows = "arm_angle [deg],correction [arcsec]\n".to_owned();
    for degree in 0..=360 {
        let correction = error(f64::from(degree).to_radians()) / ARCSEC;
        writeln!(rows, "{degree},{correction:?}").unwrap();
    }
    rows
}

const RADIUS: &str = "radius = { value = \"1.146 m\", fixed = true }";
const SIGMA: &str = "sigma = \"1.5 arcsec\"";

#[test]
fn an_expanded_uncertainty_is_divided_by_its_coverage_factor() {
    let radius = "radius = { value = \"1.146 m\", U = \"40 um\", k = 2, degrees_of_freedom = 12 }";
    let stated = "U = \"6 arcsec\", k = 3, degrees_of_freedom = 7";
    let opened = Campaign::new("expanded", radius, "", stated).open();
    let instances = &opened.problem.layout.instances;
    let setting = &instances.iter().find(|one| one.name == "radius").unwrap().setting;
    assert!((setting.sigma.as_ref().unwrap()[0] - 20e-6).abs() < 1e-18);
    assert_eq!(setting.degrees_of_freedom, Some(12.0));
    let campaign = &opened.campaigns[0];
    assert!((campaign.measurand_sigma[0] - 2.0 * ARCSEC).abs() < 1e-18);
    assert_eq!(campaign.measurand_degrees_of_freedom[0], Some(7.0));
}

/// With its certificate the encoder's error is gone from every delay; without, it is as large as
/// 20 arcsec at 50 deg/s, 111 µs.
#[test]
fn an_encoder_is_corrected_by_its_certificate() {
    let worst = |inputs: &str| {
        let folder = Campaign::new(&format!("encoder{}", inputs.len()), RADIUS, inputs, SIGMA)
            .with_corrections(&certificate());
        let opened = folder.open();
        let joint = calibrate(opened.problem.clone(), &Options::default()).unwrap();
        let mut worst: f64 = 0.0;
        let taken = Transformation::of(&opened.problem, &joint, 0);
        let Ok(_) = taken.delays(0, None, &mut |reading| {
            worst = worst.max((reading.delay - DELAY).abs());
            Ok::<_, Infallible>(())
        });
        worst
    };
    let bare = worst("arm_angle = { sigma = \"0.1 arcsec\" }");
    assert!((bare - 20.0 * ARCSEC / RATE).abs() < 1e-7, "{bare}");
    let corrected = worst(
        "arm_angle = { sigma = \"0.1 arcsec\", calibration = { U = \"1 arcsec\", k = 2, corrections = \"encoder.csv\" } }",
    );
    // Straight lines between rows a degree apart miss a sine of twice the angle by h² / 8 of its
    // curvature.
    let missed = 20.0 * ARCSEC * 4.0 * (PI / 180.0).powi(2) / 8.0;
    assert!(corrected < 1.1 * missed / RATE, "{corrected} {}", missed / RATE);
}

/// What the calibration leaves open is a common part of every delay: no number of readings makes it
/// smaller.
#[test]
fn what_calibration_leaves_open_stays_in_the_mean() {
    let inputs =
        "arm_angle = { resolution = \"0.36 arcsec\", calibration = { U = \"4.2 arcsec\", k = 2 } }";
    let opened = Campaign::new("open", RADIUS, inputs, SIGMA).open();
    let resolution = opened.campaigns[0].input_sigma[0].unwrap();
    assert!((resolution - 0.36 * ARCSEC / 12.0_f64.sqrt()).abs() < 1e-18);
    let joint = calibrate(opened.problem.clone(), &Options::default()).unwrap();
    let taken = Transformation::of(&opened.problem, &joint, 0);
    let mut widening = Widening::new(taken.problem(), 0, &taken.fit().fit.point);
    let open = 2.1 * ARCSEC / RATE;
    let Ok(mut delays) = taken.delays(0, None, &mut |reading| {
        let wide = widening.see(reading);
        assert!((wide.common - reading.common.hypot(open)).abs() < 1e-6 * open);
        Ok::<_, Infallible>(())
    });
    let before = delays.measurands[0].clone();
    widening.widen(&mut delays);
    let one = &delays.measurands[0];
    let widened = before.sigma_of_mean.unwrap().hypot(open);
    assert!((one.sigma_of_mean.unwrap() - widened).abs() < 1e-6 * widened);
}

/// A campaign that is written again states the same certificates, and values that are corrected
/// already are not corrected twice.
#[test]
fn a_campaign_is_written_with_its_certificates() {
    let inputs = "arm_angle = { sigma = \"0.1 arcsec\", resolution = \"0.36 arcsec\", calibration = { U = \"1 arcsec\", k = 2, degrees_of_freedom = 9, corrections = \"encoder.csv\" } }";
    let stated = "U = \"6 arcsec\", k = 3, degrees_of_freedom = 7";
    let radius = "radius = { value = \"1.146 m\", U = \"40 um\", k = 2, degrees_of_freedom = 12 }";
    let folder = Campaign::new("written", radius, inputs, stated).with_corrections(&certificate());
    let first = folder.open();
    let again = folder.0.join("again");
    let runs = &first.problem.parts[0].runs;
    write_campaign(&again, &first.campaigns[0], &first.models[0], runs).unwrap();
    let second = open(&Request::new([&again])).unwrap();
    let (a, b) = (&first.campaigns[0], &second.campaigns[0]);
    assert_eq!(a.input_spread[0].calibration, b.input_spread[0].calibration);
    assert_eq!(a.input_spread[0].resolution, b.input_spread[0].resolution);
    assert_eq!(a.measurand_degrees_of_freedom[0], b.measurand_degrees_of_freedom[0]);
    let of = |opened: &Opened| {
        let instances = &opened.problem.layout.instances;
        let radius = instances.iter().find(|one| one.name == "radius").unwrap();
        (radius.setting.sigma.clone(), radius.setting.degrees_of_freedom)
    };
    assert_eq!(of(&first), of(&second));
    let at = |opened: &Opened, row| -> f64 {
        opened.problem.parts[0].runs[0].held().inputs[0].at(row, 0.0, 0.0, 0)
    };
    assert!((0..400).all(|row| (at(&first, row) - at(&second, row)).abs() < 1e-15 * 10.0));
}

#[test]
fn certificates_that_cannot_be_used() {
    let radius = |said: &str| {
        let radius = format!("radius = {{ value = \"1.146 m\", {said} }}");
        Campaign::new(&format!("fault{}", said.len()), &radius, "", SIGMA).fault()
    };
    assert_eq!(
        radius("U = \"40 um\""),
        "campaign.toml:3:35 the coverage factor of `radius` is not stated | write it beside U: k = 2"
    );
    assert_eq!(
        radius("U = \"40 um\", k = 2, sigma = \"1 um\""),
        "campaign.toml:3:35 `radius` has two uncertainties, `sigma` and `U` | keep one: sigma = U / k"
    );
    assert_eq!(
        radius("U = \"40 um\", k = -2"),
        "campaign.toml:3:48 k of `radius` must be greater than zero | "
    );
    assert_eq!(
        radius("U = \"-40 um\", k = 2"),
        "campaign.toml:3:35 U of `radius` must be greater than zero | for a value known exactly write `fixed = true`"
    );
    assert_eq!(
        radius("U = \"40 um\", k = 2, degrees_of_freedom = \"few\""),
        "campaign.toml:3:72 expected a plain number for degrees_of_freedom, found a text | as in degrees_of_freedom = 2"
    );
    let encoder = |said: &str, rows: &str| {
        let inputs = format!("arm_angle = {{ calibration = {{ {said} }} }}");
        Campaign::new(&format!("rows{}", said.len() + rows.len()), RADIUS, &inputs, SIGMA)
            .with_corrections(rows)
            .fault()
    };
    let table = "U = \"1 arcsec\", k = 2, corrections = \"encoder.csv\"";
    assert_eq!(
        encoder("corrections = \"encoder.csv\"", &certificate()),
        "campaign.toml:7:29 the calibration of `arm_angle` has no uncertainty | state `sigma`, or `U` with its `k`"
    );
    assert_eq!(
        encoder(table, "arm_angle [deg],correction [arcsec]\n0,1\n20,2\n10,3\n"),
        "encoder.csv:4:1 the positions are out of order here | each is beyond the one before"
    );
    assert_eq!(
        encoder(table, "arm_angle [deg],correction [arcsec]\n0,1\n20,2\n370,3\n"),
        "encoder.csv:4:1 the positions go on after a whole turn | corrections repeat by turns"
    );
    assert_eq!(
        encoder(table, "arm_angle [deg],correction [um]\n0,1\n"),
        "encoder.csv:1:29 `um` is not a unit of `correction` | it is measured in units such as `rad`"
    );
    assert_eq!(
        encoder(table, "arm_angle [deg]\n0\n"),
        "campaign.toml:7:68 `encoder.csv` lacks a column | the calibration of `arm_angle` needs `arm_angle [rad]` and `correction [rad]`; columns found: arm_angle"
    );
}
