//! What the shipped examples give, to four digits, with the work it took.

use std::fmt::Write;
use std::path::Path;

use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::calibrate;
use homepoint::estimate::compare::compare;
use homepoint::estimate::deviations::deviations;
use homepoint::estimate::transformation::{Choice, delays_of, transformation};
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
        // What is nothing but rounding is nothing.
        let value = if value.abs() < 1e-6 * sigma { 0.0 } else { value };
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

/// The deviations of each run to the tenth of a micrometre, and what its head must follow.
fn deviating(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(name);
    let problem = open(&Request::new([folder])).unwrap().problem;
    let joint = calibrate(problem.clone(), &Options::default()).unwrap();
    let given = transformation(&problem, Some(&joint), 0, Choice::Best).unwrap();
    let mut text = String::new();
    for (run, data) in problem.parts[0].runs.iter().enumerate() {
        let (head, found) = deviations(&given.problem, 0, run, &given.point);
        let found = found.unwrap();
        let rate = found.arm_rate.to_degrees();
        writeln!(text, "{}, arm at {rate:.2} deg/s", data.name).unwrap();
        for (frame, spreads) in
            [("arm", found.in_arm_frame), ("circle", found.in_circle_frame.unwrap())]
        {
            for (channel, one) in ["planar", "radial", "tangential"].iter().zip(spreads) {
                let [mean, deviation, low, high] =
                    [one.mean, one.deviation, one.minimum, one.maximum]
                        .map(|value| (value * 1e7).round() / 10.0 + 0.0);
                writeln!(text, "  {frame} {channel} {mean} ± {deviation}, {low} to {high} µm")
                    .unwrap();
            }
        }
        for angle in head.angles {
            let places: Vec<String> = angle
                .reversals
                .iter()
                .flatten()
                .map(|one| format!("{:.1}", one.arm_angle.to_degrees()))
                .collect();
            let (rate, places) = (angle.largest.unwrap().value, places.join(" "));
            let name = &problem.parts[0].system.assembly.names.measurands[angle.measurand].name;
            writeln!(text, "  {name} {rate:.3} rad/s, reverses at {places} deg").unwrap();
        }
        writeln!(text, "  target {:.3} m/s", head.largest_speeds[0].unwrap().value).unwrap();
    }
    text
}

/// A snapshot that says in itself what of the paper it stands for.
macro_rules! lesson {
    ($name:literal, $stands_for:literal) => {
        insta::with_settings!({ description => concat!("Depenthal 2009, ", $stands_for) }, {
            insta::assert_snapshot!(told($name) + &deviating($name));
        });
    };
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

#[test]
fn at901_without_t_cam() {
    lesson!(
        "01_at901_without_t_cam",
        "section 4: Fig. 5 planar, Fig. 6 radial, Fig. 7 tangential deviations, Fig. 9 delay of the vertical angle"
    );
}

#[test]
fn at901_with_t_cam() {
    lesson!(
        "02_at901_with_t_cam",
        "section 4: Fig. 8 tangential deviations that follow the head, Fig. 10 delay of the vertical angle"
    );
}

#[test]
fn ltd500() {
    lesson!("03_ltd500", "section 4: \"nearly the same results as AT901 without TCAM\"");
}

#[test]
fn robotic_tacheometer() {
    lesson!("04_robotic_tacheometer", "section 2.3: requests and replies over a serial line");
}

#[test]
fn changed_distance() {
    lesson!("07_changed_distance", "section 4: self-calibration by a changed distance");
}

#[test]
fn two_rotations() {
    lesson!("05_two_rotations", "section 3.2.2: Fig. 4, eqs. (12)-(14)");
}

#[test]
fn igps_with_two_stations() {
    lesson!("06_igps_two_stations", "section 3.3: eqs. (15), (16)");
}
