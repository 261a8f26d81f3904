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
    let mut command = Command::new(env!("CARGO_BIN_EXE_homepoint"));
    let output = command.args(["diagnose", "."]).current_dir(folder).output().unwrap();
    String::from_utf8(output.stdout).unwrap()
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
}

/// Where it leaves a bad fit, another error remains: what else may be done is still there.
#[test]
fn beside_a_doubtful_convention_the_rest_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let text = diagnosis(folder.path(), 4.448_221_6, 2.0);
    assert!(text.contains("`in_pounds_force`") && text.contains("another error remains"), "{text}");
    assert!(!text.contains("set this right and diagnose again"), "{text}");
    assert!(text.contains("Next: describe what may cause"), "{text}");
}
