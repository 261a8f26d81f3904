//! What a wrong length, angle or clock of the rig does to the delays: the table of
//! `docs/traceability.md`, found by simulation.
//!
//! Readings without noise are drawn from a rig that is wrong somewhere, and solved as if it were
//! not. The tracker stands 1.4 m before the arm's plane, half a metre off its axis so that the
//! distance sees its delay, too; rates are those of the paper.

use std::convert::Infallible;
use std::fs;
use std::path::Path;

use homepoint::campaign::{Samples, Track};
use homepoint::engine::open::{Request, open};
use homepoint::engine::simulate::simulate;
use homepoint::engine::{Point, Problem};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::calibrate;
use homepoint::estimate::newton::State;
use homepoint::estimate::transformation::Transformation;

use crate::folder::Folder;

const PLAN: &str = r#"model = "polar_one_rotation"
[parameters]
radius      = { value = "1.146 m", RADIUS }
orientation = { start = ["-0.368181 rad", "-1.539657 rad", "0.370859 rad"] }
position    = { start = ["1.4 m", "0.4 m", "0.3 m"] }
[measurands]
horizontal = { sigma = "3.5 urad" }
vertical   = { sigma = "3.5 urad" }
distance   = { sigma = "9 um" }
[[runs]]
name = "slow_ccw"
role = "reference"
plan = { trigger = "10 Hz", duration = "72 s", arm_angle = { start = "0 deg", rate = "5 deg/s" } }
[[runs]]
name = "slow_cw"
role = "reference"
plan = { trigger = "10 Hz", duration = "72 s", arm_angle = { start = "0 deg", rate = "-5 deg/s" } }
[[runs]]
name = "ccw190"
plan = { trigger = "40 Hz", duration = "18 s", arm_angle = { start = "0 deg", rate = "190 deg/s" } }
"#;

const DELAYS: [f64; 3] = [148e-6, 116e-6, 235e-6];

fn planned(radius: &str, with: &[&str], set: &[&str]) -> Problem {
    let folder = Folder::new("planned", &[("campaign.toml", &PLAN.replace("RADIUS", radius))]);
    let mut request = Request::new([&folder]);
    request.with = with.iter().map(|name| (*name).to_owned()).collect();
    request.set = set.iter().map(|said| (*said).to_owned()).collect();
    open(&request).unwrap().problem
}

/// Readings of a rig with these effects and this radius, without noise.
fn drawn(radius: f64, with: &[&str], set: &[&str]) -> Problem {
    let mut problem = planned("sigma = \"2 um\"", with, set);
    let mut truth = Point::stated(&problem.layout);
    for (instance, value) in problem.layout.instances.iter().zip(&mut truth.values) {
        let names = ["horizontal.delay", "vertical.delay", "distance.delay"];
        if let Some(own) = names.iter().position(|name| *name == instance.name) {
            value[0] = DELAYS[own];
        }
        if instance.name == "radius" {
            value[0] = radius;
        }
    }
    problem.parts[0].sigma.fill(1e-13);
    simulate(&mut problem, &truth, 1, true);
    problem
}

/// By how much the mean delays are wrong (s), and at most a horizontal angle's own whose
/// uncertainty is less than three times the smallest.
#[derive(Debug)]
struct Wrong {
    means: [f64; 3],
    single: f64,
}

/// The readings of a rig solved as if nothing were wrong with it.
fn solved(radius: &str, drawn: &Problem, change: impl Fn(&mut Samples)) -> Wrong {
    let mut problem = planned(radius, &[], &[]);
    for (run, from) in problem.parts[0].runs.iter_mut().zip(&drawn.parts[0].runs) {
        let readings = from.held().readings.clone();
        run.record.edit(|samples| {
            samples.readings = readings;
            change(samples);
        });
    }
    let joint = calibrate(problem.clone(), &Options::default()).unwrap();
    assert!(joint.is_sound());
    let given = Transformation::of(&problem, &joint, 0);
    let mut own = Vec::new();
    let Ok(found) = given.each_delay(0, &given.wanted(0), &mut |one| {
        if one.measurand == 0 && one.state == State::Solved {
            own.push((one.random, one.delay - DELAYS[0]));
        }
        Ok::<_, Infallible>(())
    });
    let least = own.iter().map(|one| one.0).fold(f64::INFINITY, f64::min);
    let near = own.iter().filter(|one| one.0 < 3.0 * least);
    Wrong {
        means: [0, 1, 2].map(|k| found.measurands[k].mean.unwrap() - DELAYS[k]),
        single: near.map(|one| one.1.abs()).fold(0.0, f64::max),
    }
}

const STATED: &str = "sigma = \"2 um\"";
const HELD: &str = "fixed = true";
const R: f64 = 1.146;
/// Rate of the fast run (rad/s).
const RATE: f64 = 190.0 * std::f64::consts::PI / 180.0;
const ARCSECOND: f64 = std::f64::consts::PI / 648_000.0;

/// The rows of the table, as the document has them.
fn rows() -> Vec<(&'static str, Wrong)> {
    let as_drawn = |_: &mut Samples| {};
    let with = |effect: &str, set: &str| drawn(R, &[effect], &[set]);
    let rate = 50e-6;
    let fast_clock = |samples: &mut Samples| {
        samples.time.iter_mut().for_each(|time| *time *= 1.0 + rate);
        for input in &mut samples.inputs {
            if let Track::Captured { rate: Some(rates), .. } = input {
                rates.iter_mut().for_each(|one| *one /= 1.0 + rate);
            }
        }
    };
    let eccentric = with("encoder_eccentricity", "encoder_eccentricity.cosine=2.1 arcsec");
    let second = with("encoder_second_harmonic", "encoder_second_harmonic.cosine=2.1 arcsec");
    let homepoint = with("homepoint_offset", "homepoint_offset.shift=10 arcsec");
    let gate = with("gate_delay", "gate_delay.gate=1 us");
    let scale = with("distance_scale", "distance_scale.scale=10 ppm");
    vec![
        ("nothing", solved(STATED, &drawn(R, &[], &[]), as_drawn)),
        ("radius, 20 µm, held", solved(HELD, &drawn(R + 20e-6, &[], &[]), as_drawn)),
        ("radius, 20 µm, with sigma = \"20 um\"", {
            solved("sigma = \"20 um\"", &drawn(R + 20e-6, &[], &[]), as_drawn)
        }),
        ("distance, 10 ppm", solved(STATED, &scale, as_drawn)),
        ("homepoint, 10 arcsec", solved(STATED, &homepoint, as_drawn)),
        ("encoder, 2.1 arcsec once a turn", solved(STATED, &eccentric, as_drawn)),
        ("encoder, 2.1 arcsec twice a turn", solved(STATED, &second, as_drawn)),
        ("clock, 1 µs late", solved(STATED, &gate, as_drawn)),
        ("clock, 50 ppm fast", solved(STATED, &drawn(R, &[], &[]), fast_clock)),
    ]
}

#[test]
fn the_table_is_what_simulation_gives() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/traceability.md");
    let text = fs::read_to_string(path).unwrap_or_default();
    let rows = rows();
    // Without a sign where nothing is left.
    let nanoseconds = |seconds: f64| format!("{:.0}", 1e9 * seconds).replace("-0", "0");
    let told: Vec<String> = rows[1..]
        .iter()
        .map(|(what, Wrong { means, single })| {
            let [a, b, c] = means.map(nanoseconds);
            format!("| {what} | {a} | {b} | {c} | {} |", nanoseconds(*single))
        })
        .collect();
    for line in &told {
        assert!(text.contains(line), "docs/traceability.md does not say\n{}", told.join("\n"));
    }
    let of = |start: &str| &rows.iter().find(|(what, _)| what.starts_with(start)).unwrap().1;
    let largest = |wrong: &Wrong| wrong.means.iter().fold(wrong.single, |a, b| a.max(b.abs()));
    // Nothing comes of nothing, and a turn of the homepoint is a turn of the transformation.
    assert!(largest(of("nothing")) < 1e-10, "{:?}", of("nothing"));
    assert!(largest(of("homepoint")) < 1e-10, "{:?}", of("homepoint"));
    // All delays begin later by what the clock is late.
    for mean in of("clock, 1").means {
        assert!((mean - 1e-6).abs() < 2e-9, "{mean}");
    }
    // In the controller's seconds, of which it counts more.
    for (mean, delay) in of("clock, 50").means.iter().zip(DELAYS) {
        assert!((mean / (50e-6 * delay) - 1.0).abs() < 0.05, "{mean}");
    }
    // No encoder error makes more of a delay than itself over the arm's rate; once a turn it is a
    // shift of the arm's centre to first order.
    let bound = 2.1 * ARCSECOND / RATE;
    for name in ["encoder, 2.1 arcsec once", "encoder, 2.1 arcsec twice"] {
        let Wrong { means, .. } = of(name);
        assert!(means.iter().take(2).all(|mean| mean.abs() < bound), "{name} {means:?} {bound}");
    }
}

/// Angles alone do not know lengths: all of them scale together and no delay changes.
#[test]
fn where_only_angles_are_read_a_wrong_radius_does_nothing_to_delays() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/06_igps_two_stations");
    let means = |said: &str| {
        let mut request = Request::new([&folder]);
        request.set = vec![said.to_owned()];
        let problem = open(&request).unwrap().problem;
        let joint = calibrate(problem.clone(), &Options::default()).unwrap();
        let base = joint.estimates().into_iter().find(|one| one.name == "base_distance").unwrap();
        let given = Transformation::of(&problem, &joint, 0);
        let found = given.means(0, &given.wanted(0)).measurands;
        (base.value.unwrap(), found.iter().map(|one| one.mean.unwrap()).collect::<Vec<_>>())
    };
    let (base, delays) = means("radius=1.146 m");
    let (longer, same) = means("radius=1.1471 m");
    assert!((longer / base - 1.1471 / 1.146).abs() < 1e-9, "{base} {longer}");
    for (one, other) in delays.iter().zip(&same) {
        assert!((one - other).abs() < 1e-10, "{one} {other}");
    }
}
