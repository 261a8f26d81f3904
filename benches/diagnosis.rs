//! How long does a diagnosis take, as a multiple of the joint fit of the same readings, and how
//! much memory?
//!
//! `cargo bench --bench diagnosis -- mixture` takes the cases whose name contains a word. Readings
//! are drawn from plans: nothing but noise, one effect, a mixture of four; 40 and 80 runs; a million
//! readings of ten runs; nine measurands a sample. Memory is that of the whole process (`VmHWM`,
//! reset before each diagnosis; Linux alone).

#[path = "by_hand/process.rs"]
#[expect(dead_code, reason = "each bench uses a part")]
mod process;

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::time::Instant;

use homepoint::diagnose::diagnose;
use homepoint::diagnose::library::wanted::Wanted;
use homepoint::engine::open::{Opened, Request, open};
use homepoint::engine::simulate::simulate;
use homepoint::engine::{Point, Problem};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::calibrate;
use process::{say, status};

/// A campaign to be diagnosed.
struct Case {
    name: &'static str,
    model: Model,
    setups: usize,
    /// Runs of each setup, and samples of each run.
    runs: (usize, usize),
    /// What is put in, at so many times its typical size.
    effects: &'static [(&'static str, f64)],
}

/// Which instrument.
#[derive(Clone, Copy, PartialEq)]
enum Model {
    /// A polar instrument on a turning platform.
    Polar,
    /// Three targets on the arm in three coordinates each.
    NineCoordinates,
}

const MIXTURE: &[(&str, f64)] = &[
    ("trunnion_tilt", 2.0),
    ("encoder_second_harmonic", 2.0),
    ("gate_delay_per_setup", 1.0),
    ("distance_offset", 2.0),
];
const ONE: &[(&str, f64)] = &[("trunnion_tilt", 2.0)];
const ECCENTRICITY: &[(&str, f64)] = &[("encoder_eccentricity", 2.0)];

const CASES: &[Case] = &[
    Case { name: "clean, 40 runs", model: Model::Polar, setups: 4, runs: (10, 100), effects: &[] },
    Case {
        name: "one effect, 40 runs",
        model: Model::Polar,
        setups: 4,
        runs: (10, 100),
        effects: ONE,
    },
    Case {
        name: "mixture, 40 runs",
        model: Model::Polar,
        setups: 4,
        runs: (10, 100),
        effects: MIXTURE,
    },
    Case {
        name: "one effect, 80 runs",
        model: Model::Polar,
        setups: 8,
        runs: (10, 100),
        effects: ONE,
    },
    Case {
        name: "a million readings",
        model: Model::Polar,
        setups: 1,
        runs: (10, 33_334),
        effects: ONE,
    },
    Case {
        name: "nine measurands",
        model: Model::NineCoordinates,
        setups: 2,
        runs: (4, 500),
        effects: ECCENTRICITY,
    },
];

/// Rates of the arm (deg/s) and angles of the platform (deg) of the runs in turn.
const RATES: [f64; 10] = [190.0, -190.0, 50.0, -50.0, 120.0, -120.0, 5.0, -5.0, 90.0, -90.0];
const PLATFORM: [f64; 3] = [0.0, 70.0, -110.0];
/// Triggers a second.
const TRIGGER: f64 = 40.0;

const NINE: &str = r#"
name  = "nine_coordinates"
title = "Three targets on the arm in three coordinates each"
[inputs]
arm_angle = { unit = "rad", signal = true, period = "360 deg" }
[parameters]
radius      = { unit = "m", scope = "rig", start = "1 m", plausible = "10 mm" }
orientation = { kind = "rotation", scope = "setup", plausible = "10 mrad" }
position    = { kind = "vector", unit = "m", scope = "setup", plausible = "10 mm" }
[quantities]
arm_turn = 'rotation_z(arm_angle)'
target   = 'rotate(arm_turn, [radius, 0, 0])'
a        = 'rotate(orientation, target) + position'
b        = 'rotate(orientation, rotate(arm_turn, [0, 0.5 * radius, 0.2 * radius])) + position'
c        = 'rotate(orientation, rotate(arm_turn, [-0.4 * radius, 0.1 * radius, 0.6 * radius])) + position'
[measurands]
"#;

/// A plan as text.
fn plan(case: &Case) -> String {
    let name =
        if case.model == Model::Polar { "polar_two_rotations" } else { "nine_coordinates.toml" };
    let mut text = format!(
        "title = \"{}\"\nmodel = \"{name}\"\n[parameters]\nradius = {{ value = \"1.146 m\", sigma = \"20 um\" }}\n",
        case.name
    );
    for setup in 0..case.setups {
        let angle = setup as f64;
        let _ = write!(
            text,
            "[setups.S{setup}]\norientation = {{ value = [\"{} rad\", \"1.2 rad\", \"-0.4 rad\"] }}\nposition = {{ value = [\"{} m\", \"1.6 m\", \"0.2 m\"] }}\n",
            0.3 + 0.2 * angle,
            0.3 - 0.1 * angle
        );
    }
    text.push_str("[measurands]\n");
    if case.model == Model::Polar {
        text.push_str("horizontal = { sigma = \"6 urad\" }\nvertical = { sigma = \"6 urad\" }\ndistance = { sigma = \"8 um\" }\n");
    } else {
        for name in coordinates() {
            let _ = writeln!(text, "{name} = {{ sigma = \"10 um\" }}");
        }
    }
    let (runs, samples) = case.runs;
    for setup in 0..case.setups {
        for run in 0..runs {
            let (rate, platform) = (RATES[run % RATES.len()], PLATFORM[run % PLATFORM.len()]);
            let platform = if case.model == Model::Polar {
                format!(", platform_angle = {{ start = \"{platform} deg\", rate = \"0 deg/s\" }}")
            } else {
                String::new()
            };
            let _ = write!(
                text,
                "[[runs]]\nname = \"S{setup}_{run}\"\nsetup = \"S{setup}\"\nplan = {{ trigger = \"{TRIGGER} Hz\", duration = \"{} s\", arm_angle = {{ start = \"0 deg\", rate = \"{rate} deg/s\" }}{platform} }}\n",
                samples as f64 / TRIGGER
            );
        }
    }
    text
}

/// Names of the nine measurands.
fn coordinates() -> Vec<String> {
    let of = |target: char| ["x", "y", "z"].map(|axis| format!("{target}_{axis}"));
    ['a', 'b', 'c'].into_iter().flat_map(of).collect()
}

/// The campaign of a case with drawn readings.
fn drawn(case: &Case, folder: &Path) -> Result<(Opened, Problem), Box<dyn Error>> {
    let mut model = NINE.to_owned();
    for name in coordinates() {
        let (target, axis) = name.split_once('_').unwrap_or(("a", "x"));
        let _ = writeln!(model, "{name} = {{ value = '{target}.{axis}', unit = \"m\" }}");
    }
    let _ = writeln!(model, "[delays]\nclock = {{ of = {:?} }}", coordinates());
    if case.model == Model::NineCoordinates {
        fs::write(folder.join("nine_coordinates.toml"), model)?;
    }
    let file = folder.join("plan.toml");
    fs::write(&file, plan(case))?;
    let opened = open(&Request::new([file.clone()]))?;
    let mut request = Request::new([file]);
    request.with = case.effects.iter().map(|(name, _)| (*name).to_owned()).collect();
    let mut truth = open(&request)?.problem;
    let mut point = Point::stated(&truth.layout);
    // What sums to zero over the setups alternates in sign.
    let mut sign = 1.0;
    for (value, instance) in point.values.iter_mut().zip(&truth.layout.instances) {
        let effect = instance.name.split('.').next().unwrap_or_default();
        if let Some((_, times)) = case.effects.iter().find(|(name, _)| *name == effect) {
            value[0] = sign * times * instance.setting.typical.unwrap_or(0.0);
            sign *= if instance.setting.sum_zero { -1.0 } else { 1.0 };
        }
    }
    simulate(&mut truth, &point, 1, true);
    let mut parts = opened.problem.parts.clone();
    for (part, other) in parts.iter_mut().zip(&truth.parts) {
        part.runs.clone_from(&other.runs);
    }
    Ok((opened, Problem::new(parts)))
}

fn main() -> Result<(), Box<dyn Error>> {
    let wanted: Vec<String> =
        std::env::args().skip(1).filter(|one| !one.starts_with('-')).collect();
    say("diagnosis: seconds, times the joint fit, memory of the process, what is found\n")?;
    for case in CASES {
        if !wanted.is_empty() && !wanted.iter().any(|word| case.name.contains(word)) {
            continue;
        }
        let folder = tempfile::tempdir()?;
        let (opened, problem) = drawn(case, folder.path())?;
        let readings = problem.reading_count();
        let start = Instant::now();
        calibrate(problem.clone(), &Options::default())?;
        let fit = start.elapsed().as_secs_f64();
        let _ = fs::write("/proc/self/clear_refs", "5");
        let start = Instant::now();
        let found = diagnose(problem, opened.recipes, &Wanted::default(), &Options::default())?;
        let seconds = start.elapsed().as_secs_f64();
        let rows: Vec<&str> = found.rows.iter().map(|row| row.name.as_str()).collect();
        say(&format!(
            "{:<22} {readings:>8} readings: {seconds:>6.1} s, {:>5.0} times, {:>5.0} MB, {}: {}\n",
            case.name,
            seconds / fit,
            status("VmHWM").unwrap_or(f64::NAN),
            found.verdict.word(),
            rows.join(", ")
        ))?;
    }
    Ok(())
}
