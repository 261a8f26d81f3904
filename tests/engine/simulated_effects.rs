//! Effects put into a campaign's own recordings by `homepoint simulate`.

use std::path::{Path, PathBuf};
use std::process::Command;

use homepoint::engine::Point;
use homepoint::engine::open::{Request, open};
use homepoint::engine::simulate::simulate;

fn example() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/rotating_arm")
}

/// Values come from a fit without the effect; its constants are what they are there, too, for a
/// formula may divide by one.
#[test]
fn constants_of_an_effect_hold_while_it_is_switched_off() {
    let folder = tempfile::tempdir().unwrap();
    let own = folder.path().join("effects");
    std::fs::create_dir(&own).unwrap();
    let text = "name = \"settling\"\ntitle = \"Settles\"\nacts = \"transformation\"\n[parameters]\n\
                step = { unit = \"m\", typical = \"20 um\", scope = \"rig\" }\n\
                after = { unit = \"s\", value = \"100 s\", fixed = true }\n\
                [patch]\nposition = 'position + step * exp(-setup_time / after) * [1, 0, 0]'\n";
    std::fs::write(own.join("settling.toml"), text).unwrap();
    let out = folder.path().join("out");
    let done = Command::new(env!("CARGO_BIN_EXE_homepoint"))
        .arg("simulate")
        .arg(example())
        .args(["--quiet", "--with", "settling", "--effects"])
        .arg(&own)
        .arg("--out")
        .arg(&out)
        .output()
        .unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let truth = std::fs::read_to_string(out.join("truth.json")).unwrap();
    let truth: serde_json::Value = serde_json::from_str(&truth).unwrap();
    let value = |name: &str| {
        let all = truth["parameters"].as_array().unwrap();
        all.iter().find(|one| one["name"] == name).unwrap()["value"][0].as_f64().unwrap()
    };
    assert!((value("settling.step") - 20e-6).abs() < 1e-18);
    assert!((value("settling.after") - 100.0).abs() < 1e-12);
}

/// A walk begins where a setup begins and goes on from run to run: what it does in a pause is as
/// long as the pause.
#[test]
fn a_walk_goes_on_from_run_to_run() {
    let own = tempfile::tempdir().unwrap();
    let text = "name = \"wandering\"\ntitle = \"Wanders\"\nacts = \"noise\"\n[parameters]\n\
                walk = { unit = \"mm/min^0.5\", typical = \"1 mm/min^0.5\", scope = \"sample\", \
                process = \"walk\" }\n[patch]\ndistance = 'distance + walk'\n";
    std::fs::write(own.path().join("wandering.toml"), text).unwrap();
    let mut request = Request::new([example()]);
    request.effects = vec![own.path().to_owned()];
    request.with = vec!["wandering".to_owned()];
    let mut problem = open(&request).unwrap().problem;
    let point = Point::stated(&problem.layout);
    let mut drawn = |sigma: f64| {
        problem.parts[0].random_sigma.fill(sigma);
        simulate(&mut problem, &point, 3, true);
        problem.parts[0].runs.clone()
    };
    let sigma = 1e-3 / 60.0_f64.sqrt();
    let (with, without) = (drawn(sigma), drawn(0.0));
    let distance = problem.parts[0].columns()[2];
    let mut last: Option<(usize, f64, f64)> = None;
    let mut pauses = 0;
    for (with, without) in with.iter().zip(&without) {
        let mut walk = Vec::new();
        for run in [with, without] {
            run.record.walk(|stretch| {
                let of = |column: &[f64]| column[stretch.range()].to_vec();
                walk.push((of(&stretch.samples.time), of(&stretch.samples.readings[distance])));
            });
        }
        let (times, readings) = &walk[0];
        let walk: Vec<f64> = readings.iter().zip(&walk[1].1).map(|(a, b)| a - b).collect();
        match last.filter(|(setup, ..)| *setup == with.setup) {
            None => assert!(walk[0].abs() < 1e-12, "{}", with.name),
            Some((_, ended, at)) => {
                pauses += 1;
                let due = sigma * (times[0] - ended).sqrt();
                assert!((walk[0] - at).abs() < 5.0 * due, "{}: {} {at}", with.name, walk[0]);
                // It does not begin anew.
                assert!(walk[0].abs() > 1e-9, "{}", with.name);
            }
        }
        last = Some((with.setup, times[times.len() - 1], walk[walk.len() - 1]));
    }
    assert_eq!(pauses, 10);
}

/// Six runs of one setup: what a walk does is seen as displacements over time, and as no effect of
/// the library that does something else.
#[test]
fn a_walk_in_few_runs_is_no_other_effect() {
    let folder = tempfile::tempdir().unwrap();
    let whole = std::fs::read_to_string(example().join("campaign.toml")).unwrap();
    let (part, _) = whole.split_once("[[runs]]\nname  = \"B_ccw5\"").unwrap();
    std::fs::write(folder.path().join("campaign.toml"), part).unwrap();
    for entry in std::fs::read_dir(example()).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if name.starts_with("A_") {
            std::fs::copy(&path, folder.path().join(name)).unwrap();
        }
    }
    for seed in ["1", "2", "3"] {
        let out = folder.path().join(seed);
        let mut simulate = Command::new(env!("CARGO_BIN_EXE_homepoint"));
        simulate.arg("simulate").arg(folder.path()).args(["--quiet", "--seed", seed]);
        simulate.args(["--with", "station_random_walk"]).arg("--out").arg(&out);
        for axis in ["x", "y", "z"] {
            let set = format!("station_random_walk.walk_{axis}=20 um/min^0.5");
            simulate.args(["--set", &set]);
        }
        let done = simulate.output().unwrap();
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        let found = Command::new(env!("CARGO_BIN_EXE_homepoint"))
            .arg("diagnose")
            .arg(&out)
            .args(["--format", "json", "--quiet"])
            .output()
            .unwrap();
        let found: serde_json::Value = serde_json::from_slice(&found.stdout).unwrap();
        let effects = found["effects"].as_array().unwrap();
        assert!(effects.is_empty(), "{seed}: {:?} {}", effects, found["search"]);
        assert_eq!(found["verdict"], "unknown", "{seed}: {}", found["where"]);
        let mut places = found["where"].as_array().unwrap().iter();
        assert!(places.any(|one| one["channel"] == "rig"), "{seed}: {}", found["where"]);
    }
}
