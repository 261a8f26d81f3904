//! What a diagnosis says of numbers that were misread: first, and as what is to be done.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

/// The text of a diagnosis of a load cell, in a unit (N) other than that of its header, and with a
/// dependence on the load that no effect has (N).
fn diagnosis(folder: &Path, unit: f64, bow: f64) -> String {
    let write = |name: &str, text: &str| fs::write(folder.join(name), text).unwrap();
    write(
        "cell.toml",
        "name = \"cell\"\ntitle = \"Load cell\"\n[inputs]\nload = { unit = \"kg\" }\n\
         [parameters]\nzero = { unit = \"N\", scope = \"rig\" }\n\
         [measurands]\nforce = { value = 'load * 9.81 m/s^2 + zero', unit = \"N\" }\n",
    );
    write(
        "campaign.toml",
        "title = \"Weights\"\nmodel = \"cell.toml\"\n[measurands]\nforce = { sigma = \"0.05 N\" }\n\
         [[runs]]\nname = \"weights\"\ndata = \"weights.csv\"\n",
    );
    let mut table = "load [kg],force [N]\n".to_owned();
    for i in 0..60 {
        let load = 0.5 * f64::from(i * 17 % 60);
        let error = 0.05 * (f64::from(i * 29 % 60) / 17.0 - 1.76);
        let force = load * 9.81 + 2.0 + bow * (load / 5.0).sin() + error;
        writeln!(table, "{load:.2},{:.4}", force / unit).unwrap();
    }
    write("weights.csv", &table);
    diagnosed(folder, "text")
}

/// The answer for the campaign in a folder.
fn diagnosed(folder: &Path, format: &str) -> String {
    said(folder, &["diagnose", ".", "--format", format])
}

/// What a command writes in a folder.
fn said(folder: &Path, arguments: &[&str]) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_homepoint"));
    let output = command.args(arguments).current_dir(folder).output().unwrap();
    String::from_utf8(output.stdout).unwrap()
}

/// The same for programs.
fn answer(folder: &Path) -> serde_json::Value {
    serde_json::from_str(&diagnosed(folder, "json")).unwrap()
}

/// Where a convention explains all, it comes behind the verdict, and nothing else: a budget of
/// numbers that were misread is worth nothing.
#[test]
fn a_mistaken_convention_is_what_is_to_be_done() {
    let folder = tempfile::tempdir().unwrap();
    let text = diagnosis(folder.path(), 4.448_221_6, 0.0);
    let place = |what: &str| text.find(what).unwrap_or_else(|| unreachable!("{what}: {text}"));
    assert!(place("Unknown: ") < place("`in_pounds_force`"), "{text}");
    assert!(!text.contains("effect  ") && !text.contains("remainder"), "{text}");
    assert_eq!(text.matches("Next: ").count(), 1, "{text}");
    place("Next: set this right and diagnose again.");
    let answer = answer(folder.path());
    assert_eq!(answer["verdict"], "unknown");
    for key in ["effects", "where", "candidates"] {
        assert_eq!(answer[key], serde_json::json!([]), "{key}");
    }
}

/// Where it leaves a bad fit, another error remains: what else may be done is still there.
#[test]
fn beside_a_doubtful_convention_the_rest_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let text = diagnosis(folder.path(), 4.448_221_6, 2.0);
    assert!(text.contains("`in_pounds_force`") && text.contains("another error remains"), "{text}");
    assert!(!text.contains("set this right and diagnose again"), "{text}");
    assert!(text.contains("Next: describe what may cause"), "{text}");
    assert_ne!(answer(folder.path())["where"], serde_json::json!([]));
}

/// A stated value that is wrong by the factor of a convention explains as much: both are reported, in the
/// text as for programs.
#[test]
fn a_wrong_stated_value_is_listed_beside_the_convention_that_is_like_it() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let write = |name: &str, text: &str| fs::write(folder.join(name), text).unwrap();
    write(
        "winch.toml",
        "name = \"winch\"\ntitle = \"Winch\"\n[inputs]\nturns = { unit = \"1\" }\n\
         [parameters]\nzero = { unit = \"m\", scope = \"rig\" }\nradius = { unit = \"m\", scope = \"rig\" }\n\
         [measurands]\nlaser = { value = 'zero + 2 * pi * radius * turns', unit = \"m\" }\n",
    );
    write(
        "campaign.toml",
        "title = \"Rope\"\nmodel = \"winch.toml\"\n[measurands]\nlaser = { sigma = \"4 mm\" }\n\
         [parameters]\nradius = { value = \"0.4 m\", sigma = \"0.1 mm\" }\n\
         [[runs]]\nname = \"up\"\ndata = \"up.csv\"\n",
    );
    let mut table = "turns [1],laser [m]\n".to_owned();
    for i in 0..200 {
        let turns = 0.5 * f64::from(i * 17 % 200);
        let error = 0.004 * (f64::from(i * 29 % 60) / 17.0 - 1.76);
        let laser = std::f64::consts::TAU * 0.2 * turns + 3.0 + error;
        writeln!(table, "{turns:.2},{laser:.5}").unwrap();
    }
    write("up.csv", &table);
    let (text, answer) = (diagnosed(folder, "text"), answer(folder));
    assert!(text.contains("or, about as well: a wrong stated value of `radius`"), "{text}");
    assert!(text.contains("turns / 2") && text.contains("remainder"), "{text}");
    assert!(
        text.contains("Next: set the convention right, or correct the stated value of `radius`"),
        "{text}"
    );
    assert_eq!(answer["conventions"]["stated"], "radius");
    let verdict = answer["verdict"].as_str().unwrap();
    assert!(text.to_lowercase().contains(&format!("\n\n{verdict}: ")), "{verdict} {text}");
    assert_eq!(answer["set_free"], "radius");
}

/// `calibrate` has it before the values, which hold only without it.
#[test]
fn a_mistaken_convention_comes_before_the_values() {
    let folder = tempfile::tempdir().unwrap();
    diagnosis(folder.path(), 1000.0, 0.0);
    let text = said(folder.path(), &["calibrate", "."]);
    let places =
        ["may have been mistaken", "To use it", "\nparameter "].map(|words| text.find(words));
    assert!(places.iter().all(Option::is_some) && places.is_sorted(), "{text}");
}
