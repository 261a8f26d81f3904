//! Are the lessons' recordings what their plans say? Each plan names its own command; the program
//! runs it and the readings come out again, but for the digits that were rounded off.

use std::collections::HashSet;
use std::fs;
use std::io::Read;
use std::path::Path;
use std::process::Command;

use crate::folder::Folder;

/// The header and the columns of a CSV file, packed or not.
fn columns(path: &Path) -> (Vec<String>, Vec<Vec<f64>>) {
    let mut text = String::new();
    let file = fs::File::open(path).unwrap();
    match path.extension().is_some_and(|end| end == "gz") {
        true => flate2::read::GzDecoder::new(file).read_to_string(&mut text).unwrap(),
        false => std::io::BufReader::new(file).read_to_string(&mut text).unwrap(),
    };
    let mut lines = text.lines();
    let header: Vec<String> = lines.next().unwrap().split(',').map(str::to_owned).collect();
    let mut columns = vec![Vec::new(); header.len()];
    for line in lines {
        for (column, cell) in columns.iter_mut().zip(line.split(',')) {
            column.push(cell.parse::<f64>().unwrap());
        }
    }
    (header, columns)
}

/// Half of the last digit that the recordings keep, in the unit of the column.
fn rounding(header: &str) -> f64 {
    match header.split_once(" [").unwrap().1 {
        "s]" => 0.5e-9,
        "m]" => 0.5e-7,
        _ => 0.5e-8,
    }
}

/// Runs the command that a plan names; the folder it wrote.
fn simulated(plan: &Path) -> Folder {
    let text = fs::read_to_string(plan).unwrap();
    let said = text.lines().find_map(|line| line.strip_prefix("#   homepoint ")).unwrap();
    let words: Vec<&str> = said.split_whitespace().collect();
    let ["simulate", path, "--seed", seed, "--out", "FOLDER"] = words[..] else {
        unreachable!("{said}")
    };
    assert!(plan.ends_with(path), "{} names {path}", plan.display());
    let name = path.replace(['/', '.'], "_");
    let out = Folder::new(&name, &[]);
    let done = Command::new(env!("CARGO_BIN_EXE_homepoint"))
        .arg("simulate")
        .arg(plan)
        .args(["--quiet", "--seed", seed, "--out"])
        .arg(&*out)
        .output()
        .unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    out
}

#[test]
fn every_plan_gives_its_recordings_again() {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let mut count = 0;
    for lesson in fs::read_dir(examples).unwrap() {
        let lesson = lesson.unwrap().path();
        let files = || fs::read_dir(&lesson).unwrap().map(|entry| entry.unwrap().path());
        let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
        let mut recorded: HashSet<String> =
            files().map(|path| name(&path)).filter(|name| name.ends_with(".csv.gz")).collect();
        for plan in files().filter(|path| name(path).starts_with("plan")) {
            let out = simulated(&plan);
            for entry in fs::read_dir(&out).unwrap() {
                let drawn = entry.unwrap().path();
                let packed = format!("{}.gz", name(&drawn));
                // A run may be left out of a lesson.
                if !recorded.remove(&packed) {
                    continue;
                }
                let (header, kept) = columns(&lesson.join(&packed));
                let (again, drawn) = columns(&drawn);
                assert_eq!(header, again, "{packed}");
                for ((header, kept), drawn) in header.iter().zip(kept).zip(drawn) {
                    assert_eq!(kept.len(), drawn.len(), "{packed} {header}");
                    for (row, (kept, drawn)) in kept.iter().zip(&drawn).enumerate() {
                        let most = 1.01 * rounding(header) + 1e-12 * drawn.abs();
                        assert!(
                            (kept - drawn).abs() < most,
                            "{packed} {header} row {row}: {kept} {drawn}"
                        );
                    }
                }
                count += 1;
            }
            assert!(lesson.join("campaign.toml").exists());
        }
        // A lesson with a plan holds nothing that does not come from one.
        if files().any(|path| name(&path).starts_with("plan")) {
            assert!(recorded.is_empty(), "{}: {recorded:?}", lesson.display());
        }
    }
    assert!(count >= 20, "{count}");
}

/// The commands that lessons and documents name, with their own words for folders.
fn commands(text: &str) -> impl Iterator<Item = &str> {
    let named = text.lines().filter_map(|line| {
        line.strip_prefix("#   homepoint ").or_else(|| line.strip_prefix("$ homepoint "))
    });
    // What a command is for stands behind it, after a gap.
    named.map(|line| line.split("  ").next().unwrap()).filter(|line| !line.contains(" A B"))
}

#[test]
fn every_command_that_is_named_runs() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let own = Folder::new("named", &[]);
    let out = own.join("out");
    let mut texts = vec![root.join("docs/the-seed.md")];
    for lesson in fs::read_dir(root.join("examples")).unwrap() {
        texts.push(lesson.unwrap().path().join("campaign.toml"));
    }
    let mut run = HashSet::new();
    for text in texts {
        for said in commands(&fs::read_to_string(text).unwrap()) {
            let mut words: Vec<String> = said.split_whitespace().map(str::to_owned).collect();
            if let Some(at) = words.iter().position(|word| word == "--out") {
                words[at + 1] = out.to_string_lossy().into_owned();
            }
            if !run.insert(words.clone()) {
                continue;
            }
            let mut command = Command::new(env!("CARGO_BIN_EXE_homepoint"));
            let done = command.current_dir(root).args(&words).output().unwrap();
            let told = String::from_utf8_lossy(&done.stderr).into_owned();
            assert!(done.status.success() && !done.stdout.is_empty(), "{said}: {told}");
        }
    }
    assert!(run.len() > 15, "{}", run.len());
}

/// What sums to zero over the setups does so in what is drawn, too, and is there to be found.
#[test]
fn values_that_sum_to_zero_alternate() {
    let out = tempfile::tempdir().unwrap();
    let out = out.path().join("drawn");
    let done = Command::new(env!("CARGO_BIN_EXE_homepoint"))
        .args([
            "simulate",
            "examples/rotating_arm",
            "--with",
            "gate_delay_per_setup",
            "--quiet",
            "--out",
        ])
        .arg(&out)
        .output()
        .unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let truth: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(out.join("truth.json")).unwrap()).unwrap();
    let parameters = truth["parameters"].as_array().unwrap();
    let own = |one: &&serde_json::Value| {
        one["name"].as_str().unwrap().starts_with("gate_delay_per_setup")
    };
    let values: Vec<f64> =
        parameters.iter().filter(own).map(|one| one["value"][0].as_f64().unwrap()).collect();
    assert!(values.len() > 1 && values.iter().all(|value| value.abs() > 1e-6), "{values:?}");
    for name in parameters.iter().filter(own).map(|one| &one["name"]) {
        let same = parameters.iter().filter(|one| one["name"] == *name);
        let sum: f64 = same.map(|one| one["value"][0].as_f64().unwrap()).sum();
        assert!(sum.abs() < 1e-15, "{name}: {sum}");
    }
}

/// A setup that is planned beside measured ones stands where it is stated, in `power` and in what
/// is drawn of it.
#[test]
fn a_planned_setup_beside_measured_ones_stands_where_it_is_stated() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = tempfile::tempdir().unwrap();
    let campaign = folder.path().join("planned");
    fs::create_dir(&campaign).unwrap();
    for entry in fs::read_dir(root.join("examples/rotating_arm")).unwrap() {
        let file = entry.unwrap().path();
        fs::copy(&file, campaign.join(file.file_name().unwrap())).unwrap();
    }
    let orientation = ["1.48 rad", "0.62 rad", "0.61 rad"];
    let mut text = fs::read_to_string(campaign.join("campaign.toml")).unwrap();
    text.push_str(&format!(
        "\n[setups.C]\norientation = {{ value = {orientation:?} }}\nposition = {{ value = [\"1.2 m\", \"2.4 m\", \"-0.3 m\"] }}\n"
    ));
    for rate in [50, -50] {
        text.push_str(&format!(
            "\n[[runs]]\nname = \"C_{rate}\"\nsetup = \"C\"\nplan = {{ trigger = \"5 Hz\", duration = \"20 s\", arm_angle = {{ start = \"0 deg\", rate = \"{rate} deg/s\" }} }}\n"
        ));
    }
    fs::write(campaign.join("campaign.toml"), text).unwrap();
    let run = |words: &[&str]| {
        let done = Command::new(env!("CARGO_BIN_EXE_homepoint")).args(words).output().unwrap();
        let told = String::from_utf8_lossy(&done.stderr).into_owned();
        assert!(done.status.success(), "{words:?}: {told}");
        (String::from_utf8(done.stdout).unwrap(), told)
    };
    let (_, told) = run(&["power", campaign.to_str().unwrap(), "--only", "gravity_sag"]);
    assert!(!told.contains("no file states"), "{told}");
    // One of which nothing is stated has no place: `power` says so, and nothing is drawn of it.
    let silent = folder.path().join("silent");
    fs::create_dir(&silent).unwrap();
    for entry in fs::read_dir(&campaign).unwrap() {
        let file = entry.unwrap().path();
        fs::copy(&file, silent.join(file.file_name().unwrap())).unwrap();
    }
    let text = fs::read_to_string(silent.join("campaign.toml")).unwrap();
    let kept = text.lines().filter(|line| !line.contains("1.48 rad") && !line.contains("2.4 m"));
    fs::write(silent.join("campaign.toml"), kept.collect::<Vec<_>>().join("\n")).unwrap();
    let (_, told) = run(&["power", silent.to_str().unwrap(), "--only", "gravity_sag"]);
    assert!(
        told.contains("no file states where `orientation` (C), `position` (C) stand"),
        "{told}"
    );
    let out = folder.path().join("nowhere");
    let done = Command::new(env!("CARGO_BIN_EXE_homepoint"))
        .args(["simulate", silent.to_str().unwrap(), "--out", out.to_str().unwrap()])
        .output()
        .unwrap();
    assert_eq!(done.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&done.stderr).contains("`position` (C)"));
    let out = folder.path().join("drawn");
    let (json, _) = run(&[
        "simulate",
        campaign.to_str().unwrap(),
        "--out",
        out.to_str().unwrap(),
        "--format",
        "json",
    ]);
    let written: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(written["campaign"].as_str(), out.to_str());
    assert!(Path::new(written["truth"].as_str().unwrap()).is_file());
    let (json, _) = run(&["calibrate", out.to_str().unwrap(), "--format", "json"]);
    let found: serde_json::Value = serde_json::from_str(&json).unwrap();
    let parameters = found["parameters"].as_array().unwrap();
    for (name, value) in [("orientation.x", 1.48), ("position.y", 2.4), ("position.z", -0.3)] {
        let own = parameters.iter().find(|one| one["name"] == name && one["of"] == "C").unwrap();
        let off = own["value"].as_f64().unwrap() - value;
        // Where it is stated with no uncertainty nobody looked: 300 readings find it again.
        assert!(off.abs() < 6.0 * own["sigma"].as_f64().unwrap(), "{name}: {off}");
    }
}
