//! No command writes its tables over a file that it reads, whatever the file is called.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

fn run(arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_homepoint"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

/// Tables by the commands that write them.
const TABLES: [(&str, &str); 12] = [
    ("calibrate", "parameters.csv"),
    ("calibrate", "residuals.csv"),
    ("calibrate", "covariance.csv"),
    ("delays", "delays.csv"),
    ("delays", "replies.csv"),
    ("deviations", "deviations.csv"),
    ("diagnose", "candidates.csv"),
    ("power", "effects.csv"),
    ("trials", "trials.jsonl"),
    ("simulate", "A_ccw50.csv"),
    ("simulate", "campaign.toml"),
    ("simulate", "truth.json"),
];

#[test]
fn tables_do_not_replace_recordings() {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cli/one_run");
    let text = fs::read_to_string(from.join("campaign.toml")).unwrap();
    for (command, table) in TABLES {
        let root = tempfile::tempdir().unwrap();
        let data = root.path().join("C/data");
        fs::create_dir_all(&data).unwrap();
        fs::copy(from.join("A_ccw50.csv"), data.join(table)).unwrap();
        let said = text.replace("\"A_ccw50.csv\"", &format!("\"data/{table}\""));
        fs::write(root.path().join("C/campaign.toml"), said).unwrap();
        // `simulate` asks for this before all else.
        let is_own_table = table == "campaign.toml" || table == "truth.json";
        if command == "simulate" && !is_own_table {
            fs::write(data.join("truth.json"), "{}").unwrap();
        }
        let output = run(&[command, "C", "--out", "C/data", "--quiet"], root.path());
        let told = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{command} {table}: {told}");
        let expected =
            if table == "campaign.toml" { "was not simulated" } else { "would be written over" };
        assert!(told.contains(expected), "{command} {table}: {told}");
        assert!(output.stdout.is_empty(), "{command} {table} computed before it refused");
        let same =
            fs::read(from.join("A_ccw50.csv")).unwrap() == fs::read(data.join(table)).unwrap();
        assert!(same, "{command} {table}");
    }
}

/// A model that is infinite at one place and undefined beyond it.
#[test]
fn simulated_values_that_are_not_finite_are_counted() {
    let root = tempfile::tempdir().unwrap();
    let model = "name = \"m\"\ntitle = \"m\"\n[inputs]\nq = { unit = \"1\", signal = true }\n\
        [parameters]\nc = { unit = \"1\", scope = \"rig\" }\n[measurands]\n\
        x = { value = 'c / (q - 2)', unit = \"1\" }\ny = { value = 'c * sqrt(4.5 - q)', unit = \"1\" }\n\
        z = { value = 'q + c', unit = \"1\" }\n";
    let campaign = "model = \"m.toml\"\n[parameters]\nc = { value = \"1\", fixed = true }\n\
        x.delay = { value = \"0 s\", fixed = true }\ny.delay = { value = \"0 s\", fixed = true }\n\
        z.delay = { value = \"0 s\", fixed = true }\n\
        [measurands]\nx = { sigma = \"1e-3\" }\ny = { sigma = \"1e-3\" }\nz = { sigma = \"1e-3\" }\n\
        [[runs]]\nname = \"planned\"\n\
        plan = { trigger = \"1 Hz\", duration = \"8 s\", q = { start = \"0\", rate = \"1 1/s\" } }\n";
    fs::write(root.path().join("m.toml"), model).unwrap();
    fs::write(root.path().join("campaign.toml"), campaign).unwrap();
    let output = run(&["simulate", ".", "--out", "out"], root.path());
    let told = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{told}");
    assert!(
        told.contains("run `planned`: 1 of 8 values of `x` are infinite or undefined"),
        "{told}"
    );
    assert!(told.contains("run `planned`: 3 of 8 values of `y`"), "{told}");
    assert!(!told.contains("values of `z`"), "{told}");
    let table = fs::read_to_string(root.path().join("out/planned.csv")).unwrap();
    assert!(!table.contains("inf") && !table.contains("NaN"), "{table}");
    // What is written is read again; readings that were not there before are not counted.
    let output = run(&["check", "out"], root.path());
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let output = run(&["simulate", "out", "--out", "again"], root.path());
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && !told.contains("values of"), "{told}");
}

#[test]
fn confined_commands_read_nothing_outside() {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cli/one_run");
    let root = tempfile::tempdir().unwrap();
    let text = fs::read_to_string(from.join("campaign.toml")).unwrap();
    fs::create_dir(root.path().join("C")).unwrap();
    fs::copy(from.join("A_ccw50.csv"), root.path().join("data.csv")).unwrap();
    let said = text.replace("\"A_ccw50.csv\"", "\"../data.csv\"");
    fs::write(root.path().join("C/campaign.toml"), said).unwrap();
    for command in ["check", "calibrate", "delays", "compare", "deviations", "diagnose", "power"] {
        let output = run(&[command, "C", "--confined"], root.path());
        let told = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{command}: {told}");
        assert!(told.contains("lies outside the campaign's folder"), "{command}: {told}");
    }
    let output = run(&["check", "C"], root.path());
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
}
