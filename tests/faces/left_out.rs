//! Readings that `--leave-out` lists are left out of an estimate, and `diagnose --out` lists those that
//! it leaves out.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

fn run(arguments: &[&str], folder: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_homepoint"));
    command.args(arguments).current_dir(folder).output().unwrap()
}

fn json(arguments: &[&str], folder: &Path) -> Value {
    let output = run(&[arguments, &["--format", "json", "--quiet"]].concat(), folder);
    serde_json::from_slice(&output.stdout).unwrap_or_else(|_| unreachable!("{output:?}"))
}

/// The example of a rotating arm, with one distance 20 mm too long in the row that is given.
fn campaign(folder: &Path, wrong: Option<usize>) {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/rotating_arm");
    fs::create_dir_all(folder.join("C")).unwrap();
    for file in fs::read_dir(&from).unwrap() {
        let file = file.unwrap();
        fs::copy(file.path(), folder.join("C").join(file.file_name())).unwrap();
    }
    let text = fs::read_to_string(from.join("A_ccw50.csv")).unwrap();
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let header = lines.iter().position(|line| line.contains("distance")).unwrap();
    let mut names = lines[header].split(',');
    let column = names.position(|name| name.trim().starts_with("distance")).unwrap();
    if let Some(row) = wrong {
        let mut cells: Vec<String> = lines[row - 1].split(',').map(str::to_owned).collect();
        let value: f64 = cells[column].trim().parse().unwrap();
        cells[column] = format!("{:.9}", value + 0.02);
        lines[row - 1] = cells.join(",");
    }
    fs::write(folder.join("C/A_ccw50.csv"), lines.join("\n") + "\n").unwrap();
}

#[test]
fn rows_of_a_table_are_left_out() {
    let folder = tempfile::tempdir().unwrap();
    campaign(folder.path(), None);
    let all = json(&["calibrate", "C"], folder.path())["fit"]["readings"].as_u64().unwrap();
    let table = "first_row,last_row,measurand,run\n20,24,,A_ccw50\n30,30,distance,\"A_ccw50\"\n";
    fs::write(folder.path().join("out.csv"), table).unwrap();
    let arguments = ["calibrate", "C", "--leave-out", "out.csv"];
    let rest = json(&arguments, folder.path())["fit"]["readings"].as_u64().unwrap();
    assert_eq!(all - rest, 5 * 3 + 1);
}

/// A run that is left out as a whole has nothing to determine, also where it has delays of its own.
#[test]
fn a_whole_run_is_left_out() {
    let folder = tempfile::tempdir().unwrap();
    campaign(folder.path(), None);
    let path = folder.path().join("C/campaign.toml");
    let text = fs::read_to_string(&path).unwrap();
    fs::write(
        &path,
        text.replacen(
            "[parameters]\n",
            "[parameters]\n\"distance.delay\" = { scope = \"run\" }\n",
            1,
        ),
    )
    .unwrap();
    let table = "first_row,last_row,measurand,run\n2,100000,,A_ccw50\n";
    fs::write(folder.path().join("out.csv"), table).unwrap();
    let output = run(&["calibrate", "C", "--leave-out", "out.csv"], folder.path());
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{text}");
    assert!(text.contains("distance.delay") && !text.contains("A_ccw50"), "{text}");
}

#[test]
fn a_table_of_something_else_is_refused_with_its_line() {
    let folder = tempfile::tempdir().unwrap();
    campaign(folder.path(), None);
    let head = "first_row,last_row,measurand,run\n";
    for (text, expected) in [
        ("a,b\n".to_owned(), "is no table of readings that are left out"),
        (format!("{head}1,2,,C_ccw50\n"), "line 2: there is no run `C_ccw50`"),
        (format!("{head}1,2,height,A_ccw50\n"), "there is no `height` in run `A_ccw50`"),
        (format!("{head}1,x,,A_ccw50\n"), "line 2: expected first and last row"),
        (format!("{head}30,20,,A_ccw50\n"), "line 2: expected first and last row"),
    ] {
        fs::write(folder.path().join("out.csv"), &text).unwrap();
        let output = run(&["calibrate", "C", "--leave-out", "out.csv"], folder.path());
        let told = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{text}: {told}");
        assert!(told.contains(expected), "{text}: {told}");
    }
    let output = run(&["calibrate", "C", "--leave-out", "none.csv"], folder.path());
    assert!(String::from_utf8(output.stderr).unwrap().contains("cannot read `none.csv`"));
}

#[test]
fn what_a_diagnosis_leaves_out_is_left_out_of_the_estimate_that_it_names() {
    let folder = tempfile::tempdir().unwrap();
    campaign(folder.path(), Some(60));
    let output = run(&["diagnose", "C", "--out", "D"], folder.path());
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("Next: `homepoint calibrate C "), "{text}");
    assert!(text.contains("--leave-out D/left_out.csv"), "{text}");
    let table = fs::read_to_string(folder.path().join("D/left_out.csv")).unwrap();
    assert_eq!(table, "first_row,last_row,measurand,run\n60,60,distance,A_ccw50\n");
    let delay = |arguments: &[&str]| {
        let found = json(arguments, folder.path());
        let parameters = found["parameters"].as_array().unwrap().clone();
        let own = parameters.iter().find(|one| one["name"] == "distance.delay").unwrap().clone();
        own["value"].as_f64().unwrap()
    };
    let with = delay(&["calibrate", "C"]);
    let without = delay(&["calibrate", "C", "--leave-out", "D/left_out.csv"]);
    campaign(folder.path(), None);
    let due = delay(&["calibrate", "C"]);
    assert!((without - due).abs() < 0.05 * (with - due).abs(), "{with} {without} {due}");
}

#[test]
fn the_table_that_the_next_command_reads_is_made_first_with_the_options_of_the_call() {
    let folder = tempfile::tempdir().unwrap();
    campaign(folder.path(), Some(60));
    let set = "distance.delay=0 s";
    let output = run(&["diagnose", "C", "--without", "air_drag", "--set", set], folder.path());
    let text = String::from_utf8(output.stdout).unwrap();
    let options = format!("C --set '{set}'");
    let make = format!("Next: `homepoint diagnose {options} --without air_drag --out DIR`");
    let read = format!("then `homepoint calibrate {options} ");
    let place = |what: &str| text.find(what).unwrap_or_else(|| unreachable!("{what}: {text}"));
    assert!(place(&make) < place(&read), "{text}");
    assert!(text.contains("--leave-out DIR/left_out.csv`"), "{text}");
}
