//! Effects put into a campaign's own recordings by `homepoint simulate`.
#![expect(clippy::unwrap_used, reason = "a failed test should stop")]

use std::path::Path;
use std::process::Command;

/// Values come from a fit without the effect; its constants are what they are there, too, for a formula
/// may divide by one.
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
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/rotating_arm"))
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
