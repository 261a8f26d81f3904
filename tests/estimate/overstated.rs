//! A measurand in a wrong unit scatters far less than stated, and the pooled test does not show it;
//! residuals larger than stated are reported whether or not everything is determined.

use std::fmt::Write as _;
use std::process::{Command, Output};

use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::calibrate;
use homepoint::estimate::overstated::overstated;
use homepoint::report::text;

use crate::folder::Folder;
use crate::problems::Stream;

const MODEL: &str = r#"
name = "cell"
title = "Load cell beside a rule"
[inputs]
place = { unit = "m" }
[parameters]
zero = { unit = "m" }
load = { unit = "N" }
idle = { unit = "m" }
[measurands]
length = { value = 'place + zero', unit = "m" }
force = { value = 'load + 0 N/m * idle', unit = "N" }
"#;

/// Forces scatter by 25 N and lengths by so many millimetres; the header says this unit of the forces,
/// which are in kN.
fn cell(unit: &str, length: f64, idle: &str) -> Folder {
    let mut random = Stream(3);
    let mut table = format!("time [s],place [m],length [m],force [{unit}]\n");
    for number in 0..300 {
        let place = 0.01 * f64::from(number);
        let read = place + 0.2 + 1e-3 * length * random.normal();
        let force = 20.0 + 0.025 * random.normal();
        writeln!(table, "{number},{place},{read},{force}").unwrap();
    }
    let campaign = format!(
        "model = \"model.toml\"\n[parameters]\n\"length.delay\" = {{ value = \"0 s\", fixed = true }}\n\
         \"force.delay\" = {{ value = \"0 s\", fixed = true }}\n{idle}\n\
         [measurands]\nlength = {{ sigma = \"1 mm\" }}\nforce = {{ sigma = \"25 N\" }}\n\
         [[runs]]\nname = \"one\"\ndata = \"one.csv\"\n"
    );
    Folder::new("cell", &[("model.toml", MODEL), ("campaign.toml", &campaign), ("one.csv", &table)])
}

const FIXED: &str = "idle = { value = \"0 m\", fixed = true }";

fn calibrated(folder: &Folder) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_homepoint"));
    command.arg("calibrate").arg(&**folder).output().unwrap()
}

#[test]
fn a_measurand_that_scatters_far_less_than_stated_is_asked_for_its_unit() {
    let found = |folder: &Folder| {
        let problem = open(&Request::new([&**folder])).unwrap().problem;
        overstated(&calibrate(problem, &Options::default()).unwrap())
    };
    assert!(found(&cell("kN", 1.0, FIXED)).is_empty());
    let wrong = cell("N", 1.0, FIXED);
    let all = found(&wrong);
    let [one] = &all[..] else { panic!("{all:?}") };
    assert_eq!(one.measurand, "force");
    assert!((one.times() / 1000.0 - 1.0).abs() < 0.1, "{one:?}");
    let output = calibrated(&wrong);
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(told.contains("the residuals of `force` are "), "{told}");
    assert!(told.contains(" times smaller than stated (is its unit right?)"), "{told}");
    assert!(told.contains("stated is 25 N"), "{told}");
    assert!(!told.contains("`length`"), "{told}");
    // A parameter that is not determined does not silence it.
    let told = calibrated(&cell("N", 1.0, ""));
    let told = String::from_utf8_lossy(&told.stderr).into_owned();
    assert!(told.contains("smaller than stated (is its unit right?)"), "{told}");
}

#[test]
fn larger_residuals_are_reported_where_a_parameter_is_not_determined() {
    let output = calibrated(&cell("kN", 30.0, ""));
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(said.contains("These readings do not determine everything"), "{said}");
    assert!(said.contains("times as large as stated: the uncertainties do not hold"), "{said}");
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(told.contains("times as large as stated: readings or the model are wrong"), "{told}");
}

/// The words for a fit that ends near its solution blame a sign where there is one.
#[test]
fn a_sign_is_named_where_a_formula_has_one() {
    use homepoint::estimate::batch::Outcome;
    let folder = cell("kN", 1.0, FIXED);
    let said = || {
        let problem = open(&Request::new([&*folder])).unwrap().problem;
        let mut fit = calibrate(problem, &Options::default()).unwrap();
        fit.fit.outcome = Outcome::Near;
        text::trouble(&fit)
    };
    let smooth = said();
    assert!(smooth.contains("from its solution.") && !smooth.contains("jump"), "{smooth}");
    let jumps = MODEL.replace("'place + zero'", "'place + zero * abs(place / (1 m))'");
    std::fs::write(folder.join("model.toml"), jumps).unwrap();
    let jumps = said();
    assert!(jumps.contains("as with the sign of a noisy rate"), "{jumps}");
}

/// A scale that starts at 1 absorbs a wrong unit, and every other number is right.
#[test]
fn a_scale_that_takes_up_a_unit_is_asked_for_it() {
    for (unit, is_doubtful) in [("kg", false), ("g", true), ("lb", false)] {
        let model = "name = \"scale\"\n[inputs]\nload = { unit = \"kg\" }\n\
            [parameters]\ngain = { unit = \"1\", start = \"1\" }\nzero = { unit = \"g\" }\n\
            [measurands]\nweight = { value = 'gain * load + zero', unit = \"g\" }\n";
        let mut random = Stream(5);
        let mut table = format!("load [{unit}],weight [g]\n");
        for number in 0..200 {
            let load = 0.01 * f64::from(number);
            writeln!(table, "{load},{}", 1e3 * load * 0.9995 + 12.0 + random.normal()).unwrap();
        }
        let campaign = "model = \"model.toml\"\n[measurands]\nweight = { sigma = \"1 g\" }\n\
            [[runs]]\nname = \"one\"\ndata = \"one.csv\"\n";
        let files = [("model.toml", model), ("campaign.toml", campaign), ("one.csv", &*table)];
        let folder = Folder::new("scale", &files);
        for command in ["calibrate", "diagnose"] {
            let output = Command::new(env!("CARGO_BIN_EXE_homepoint"));
            let output = { output }.arg(command).arg(&*folder).output().unwrap();
            let told = String::from_utf8_lossy(&output.stderr).into_owned();
            let words = "`gain` starts at 1 and is estimated as 999.";
            assert_eq!(told.contains(words), is_doubtful, "{unit}: {told}");
            assert_eq!(told.contains("within 1 % of 1000 (is its unit right?)"), is_doubtful);
        }
    }
}
