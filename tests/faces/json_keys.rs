//! The keys that programs rely on: `docs/formats.md`, section 6.

use std::collections::BTreeSet;
use std::path::Path;

use homepoint::diagnose::library::wanted::Wanted;
use homepoint::diagnose::{diagnose, judge};
use homepoint::engine::Problem;
use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::Options;
use homepoint::estimate::bias::bias;
use homepoint::estimate::budget::budgets;
use homepoint::estimate::calibrate::calibrate;
use homepoint::estimate::compare::compare;
use homepoint::estimate::conditions::self_calibration;
use homepoint::estimate::deviations::deviations;
use homepoint::estimate::intersection::intersection;
use homepoint::estimate::repeatability::of_campaigns;
use homepoint::estimate::transformation::{Choice, Transformation, delays_of, transformation};
use homepoint::report::deviations::{Shown, Whole};
use homepoint::report::{self, json};
use serde_json::Value;

use crate::drawn::{drawn, run};

/// Every path to a value with the value's type; lists and the names of measurands as `*`.
fn paths(value: &Value, path: &str, into: &mut BTreeSet<String>) {
    let measurands = ["horizontal", "vertical", "distance"];
    match value {
        Value::Object(map) => {
            for (key, inner) in map {
                let key = if measurands.contains(&key.as_str()) { "*" } else { key };
                paths(inner, &format!("{path}.{key}"), into);
            }
        }
        Value::Array(list) => {
            if list.is_empty() {
                into.insert(format!("{path}[] empty"));
            }
            for inner in list {
                paths(inner, &format!("{path}[*]"), into);
            }
        }
        Value::Null => drop(into.insert(format!("{path}: null"))),
        Value::Bool(_) => drop(into.insert(format!("{path}: bool"))),
        Value::Number(_) => drop(into.insert(format!("{path}: number"))),
        Value::String(_) => drop(into.insert(format!("{path}: text"))),
    }
}

#[test]
fn results_have_the_promised_keys() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let problem = open(&Request::new([folder.join("examples/rotating_arm")])).unwrap().problem;
    let result = calibrate(problem.clone(), &Options::default()).unwrap();
    let (_, delays) = delays_of(&problem, &result, 0);
    let rows = compare(&result, 0, &delays.measurands);
    let single = open(&Request::new([folder.join("tests/cli/one_run")])).unwrap().problem;
    let undetermined = calibrate(single, &Options::default()).unwrap();
    let given = transformation(&problem, Some(&result), 0, Choice::Best).unwrap();
    let paper = transformation(&problem, Some(&result), 0, Choice::Paper).unwrap();
    let list = bias(&paper, &paper.iterated(&problem, 0).unwrap(), 0);
    let runs: Vec<Shown> = (0..given.problem.parts[0].runs.len())
        .map(|run| {
            let (head, found) = deviations(&given.problem, 0, run, &given.point);
            let gap = intersection(&given.problem, 0, run, &given.point);
            Shown { head, found, gap }
        })
        .collect();
    let specification = &Default::default();
    let whole = Whole { problem: &given.problem, part: 0, specification, runs: &runs };
    let twice = [given.clone(), given.clone()];
    let agreement = of_campaigns(&twice, &[delays.clone(), delays.clone()]);
    let mut found = BTreeSet::new();
    paths(&report::deviations::json(whole), "deviations", &mut found);
    paths(&report::conditions::transformation_json(&given), "delays", &mut found);
    paths(&report::conditions::bias_json(&paper, 0, &list), "delays", &mut found);
    let conditions = self_calibration(&given, 0);
    paths(&report::conditions::json(&given, 0, &conditions), "delays", &mut found);
    let labels = ["first".to_owned(), "second".to_owned()];
    let told = report::conditions::repeatability_json(&labels, &agreement);
    paths(&told, "delays of several campaigns", &mut found);
    paths(&json::calibration(&result), "calibrate", &mut found);
    paths(&json::delays(&delays.measurands), "delays", &mut found);
    paths(&json::comparison(&rows), "compare", &mut found);
    let told = json::calibration(&undetermined)["unobservable"].clone();
    paths(&told, "undetermined", &mut found);
    let captured = open(&Request::new([folder.join("tests/cli/captures")])).unwrap();
    let joint = calibrate(captured.problem.clone(), &Options::default()).unwrap();
    let taken = Transformation::of(&captured.problem, &joint, 0);
    for budget in budgets(&taken, 0, &captured.campaigns[0]) {
        paths(&report::budget::json(&budget), "budget", &mut found);
    }
    paths(&report::timing::json(&captured.campaigns[0]), "timing", &mut found);
    insta::assert_snapshot!(found.into_iter().collect::<Vec<_>>().join("\n"));
    // A parameter is called by its components.
    let json = json::calibration(&result);
    let names: Vec<&str> = json["parameters"]
        .as_array()
        .unwrap()
        .iter()
        .map(|one| one["name"].as_str().unwrap())
        .collect();
    for name in ["radius", "orientation.x", "position.z", "horizontal.delay"] {
        assert!(names.contains(&name), "{name}");
    }
}

/// Of an effect that is named, here and on a held-out campaign, one that is withheld, and bad
/// noise.
#[test]
fn diagnoses_have_the_promised_keys() {
    let mut found = BTreeSet::new();
    let options = Options::default();
    let tilt = ["trunnion_tilt.tilt=6 arcsec"];
    let (opened, problem) = drawn(&["trunnion_tilt"], &tilt, 9);
    let (mut other, again) = drawn(&["trunnion_tilt"], &tilt, 10);
    other.problem = again;
    let mut explained = run(problem, &opened);
    paths(&report::diagnosis::json(&explained, None), "explained", &mut found);
    judge(&mut explained, &other, &options).unwrap();
    let gap = &report::diagnosis::json(&explained, None)["gap"];
    paths(gap, "held out: gap", &mut found);
    let (opened, problem) = drawn(&["tracking_reversal"], &[], 3);
    let without = Wanted::new(&[], &["tracking_reversal".to_owned()]);
    let unknown = diagnose(problem, opened.recipes.clone(), &without, &options).unwrap();
    paths(&report::diagnosis::json(&unknown, None), "unknown", &mut found);
    // Jitter, a level, a noisier run, a gross reading.
    let (opened, problem) = drawn(&["timestamp_jitter"], &[], 4);
    let mut parts = problem.parts;
    parts[0].sigma[2] *= 0.5;
    parts[0].runs[1].record.edit(|samples| samples.readings[2][7] += 0.1);
    let noisy = run(Problem::new(parts), &opened);
    paths(&report::diagnosis::json(&noisy, None), "noise", &mut found);
    insta::assert_snapshot!(found.into_iter().collect::<Vec<_>>().join("\n"));
}
