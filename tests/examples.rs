//! What the shipped examples give, to four digits, with the work it took.
#![expect(clippy::unwrap_used, reason = "a failed test should stop")]

use std::fmt::Write;
use std::path::Path;

use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::calibrate;
use homepoint::estimate::compare::compare;
use homepoint::estimate::transformation::delays_of;
use homepoint::report::figure;

fn told(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(name);
    let problem = open(&Request::new([folder])).unwrap().problem;
    let result = calibrate(problem.clone(), &Options::default()).unwrap();
    let sig = |value: f64| figure::sig(value, 4);
    let mut text = format!(
        "{} readings, {} unknowns, {} iterations, {}\nvariance factor {:.4}\n",
        result.readings,
        result.unknowns(),
        result.fit.iterations,
        result.fit.outcome,
        result.variance_factor().unwrap()
    );
    for one in result.estimates().iter().filter(|one| !one.fixed) {
        let of = one.of.as_deref().unwrap_or("-");
        let (value, sigma) = (one.value.unwrap(), one.sigma.unwrap());
        writeln!(text, "{} {of} {} ± {}", one.name, sig(value), figure::sig(sigma, 3)).unwrap();
    }
    let (from, delays) = delays_of(&problem, &result, 0);
    writeln!(text, "transformation: {}", from.word()).unwrap();
    for one in &delays.measurands {
        let counts = (one.readings, one.solved, one.blind, one.failed);
        let (mean, u) = (one.mean.map(sig), one.sigma_of_mean.map(|u| figure::sig(u, 3)));
        writeln!(text, "{} {counts:?} mean {mean:?} u {u:?}", one.measurand).unwrap();
    }
    for one in compare(&result, 0, &delays.measurands) {
        let normalised = one.normalised().unwrap();
        writeln!(text, "{} normalised difference {normalised:.2}", one.measurand).unwrap();
        assert!(normalised.abs() < 4.0, "{}: {normalised}", one.measurand);
    }
    text
}

#[test]
fn the_rotating_arm() {
    insta::assert_snapshot!(told("rotating_arm"));
}

#[test]
fn the_hand_eye_recording() {
    insta::assert_snapshot!(told("hand_eye"));
}

#[test]
fn the_rail_car() {
    insta::assert_snapshot!(told("rail_car"));
}
