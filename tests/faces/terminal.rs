//! What reaches a terminal, a pipe and a program that reads JSON: no character that acts on a
//! terminal, one JSON object whatever happens, as many threads as there can be.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

use crate::scale::{SCALE, Scales};

fn homepoint(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_homepoint"));
    // As on a terminal: colours and all.
    command.args(arguments).env("CLICOLOR_FORCE", "1").env("TERM", "xterm-256color");
    command
}

fn run(arguments: &[&str]) -> Output {
    homepoint(arguments).output().unwrap()
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// Characters that act on a terminal, as TOML writes them: OSC, clear screen, BEL, DEL, C1, marks of
/// direction.
const HOSTILE: &str = r"\u001b]0;owned\u0007\u001b[2J\u007f\u009b31m\u0085\u202e\u2066\u200f\r";

/// What is found in an output that may be drawn with colours.
fn hostile(bytes: &[u8]) -> Option<String> {
    let text = String::from_utf8_lossy(bytes);
    let acts = [
        "\u{1b}]",
        "\u{1b}[2J",
        "\u{7}",
        "\u{7f}",
        "\u{9b}",
        "\u{85}",
        "\u{202e}",
        "\u{2066}",
        "\u{200f}",
        "\r",
    ];
    acts.iter().find(|one| text.contains(**one)).map(|one| format!("{one:?} in {text:?}"))
}

/// A campaign whose every name and title is hostile.
fn hostile_campaign(scales: &Scales) -> PathBuf {
    let model = SCALE.replace("A scale", HOSTILE).replace(
        "scope = \"instrument\"",
        &format!("scope = \"instrument\", about = \"{HOSTILE}\""),
    );
    let head = format!("title = \"{HOSTILE}\"\ninstrument = \"i{HOSTILE}\"\n");
    let folder =
        scales.written("c", &model, &head, "", "x = { sigma = \"1 m\" }", "m", &[4.0, 6.0, 5.0]);
    let campaign = folder.join("campaign.toml");
    let text = std::fs::read_to_string(&campaign).unwrap();
    let text =
        text.replace("name = \"one\"", &format!("name = \"one{HOSTILE}\"\nsetup = \"s{HOSTILE}\""));
    std::fs::write(&campaign, text).unwrap();
    folder
}

#[test]
fn no_text_acts_on_a_terminal() {
    let scales = Scales::new();
    let folder = hostile_campaign(&scales);
    let (campaign, model) = (text(&folder).to_owned(), folder.join("model.toml"));
    let effects = scales.path().join("effects");
    std::fs::create_dir_all(&effects).unwrap();
    let effect = format!(
        "name = \"own\"\ntitle = \"{HOSTILE}\"\nacts = \"instrument\"\nabout = \"{HOSTILE}\"\n[parameters]\nb = {{ unit = \"m\", scope = \"instrument\", about = \"{HOSTILE}\" }}\n[patch]\nx = 'x + b'\n"
    );
    std::fs::write(effects.join("own.toml"), effect).unwrap();
    let effects = text(&effects);
    let argument = "\u{1b}[2J\u{9b}31m";
    let all: Vec<Vec<&str>> = vec![
        vec!["check", &campaign],
        vec!["check", text(&model)],
        vec!["show", text(&model)],
        vec!["show", text(&model), "--latex"],
        vec!["effects", "--effects", effects],
        vec!["calibrate", &campaign],
        vec!["calibrate", &campaign, "--format", "json"],
        vec!["delays", &campaign],
        vec!["compare", &campaign],
        vec!["deviations", &campaign],
        vec!["diagnose", &campaign],
        vec!["power", &campaign],
        vec!["calibrate", argument],
        vec!["calibrate", &campaign, "--with", argument],
        vec!["calibrate", &campaign, "--set", argument],
        vec![argument],
        vec!["calibrate", &campaign, "--memory", argument],
    ];
    for arguments in all {
        let output = run(&arguments);
        for (name, bytes) in [("stdout", &output.stdout), ("stderr", &output.stderr)] {
            let found = hostile(bytes);
            assert!(found.is_none(), "{arguments:?} {name}: {}", found.unwrap());
        }
        assert!(output.status.code().is_some_and(|code| code <= 2), "{arguments:?}");
    }
    // JSON still says all of it.
    let output = run(&["calibrate", &campaign, "--format", "json"]);
    let value: Value = serde_json::from_slice(&output.stdout).unwrap();
    let title = value["campaigns"][0]["title"].as_str().unwrap();
    assert!(["\u{1b}]0;", "\u{9b}", "\u{202e}", "\r"].iter().all(|one| title.contains(one)));
}

#[test]
fn a_failure_is_one_json_object_too() {
    let scales = Scales::new();
    let (head, sigma) = ("", "x = { sigma = \"1 m\" }");
    // Only the sum of two parameters is read: the fit is not sound.
    let two = "b = { unit = \"m\", scope = \"instrument\" }\n\n[measurands]\n";
    let model = SCALE.replace("[measurands]\n", two).replace("value = 'a'", "value = 'a + b'");
    let unsound = scales.written("unsound", &model, head, "", sigma, "m", &[4.0, 6.0]);
    // A model without a value at its start.
    let model = SCALE.replace("value = 'a'", "value = 'a * log(-1 - (a / (1 m))^2)'");
    let undefined = scales.written("undefined", &model, head, "", sigma, "m", &[4.0, 6.0]);
    // Readings too large to be squared.
    let huge = scales.campaign("huge", "", &[1e308, -1e308]);
    let out = scales.path().join("out");
    let commands =
        ["calibrate", "delays", "compare", "deviations", "diagnose", "power", "simulate"];
    for folder in [&unsound, &undefined, &huge] {
        for command in commands {
            let mut arguments = vec![command, text(folder), "--format", "json", "--quiet"];
            if command == "simulate" {
                arguments.extend(["--out", text(&out)]);
            }
            let output = run(&arguments);
            let code = output.status.code();
            assert!(code.is_some_and(|code| code <= 2), "{arguments:?}: {output:?}");
            if code == Some(1) {
                let value: Result<Value, _> = serde_json::from_slice(&output.stdout);
                assert!(value.is_ok_and(|one| one.is_object()), "{arguments:?}: {output:?}");
            }
            if command == "calibrate" {
                assert_eq!(code, Some(1), "{arguments:?}: {output:?}");
            }
        }
    }
    // Words for people stay on standard error, the reading among them.
    let output = run(&["calibrate", text(&huge)]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(said.contains("run `one`, row 2"), "{said}");
    assert!(output.stdout.is_empty());
}

#[test]
fn threads_are_as_many_as_can_be_and_change_nothing() {
    let scales = Scales::new();
    let folder = scales.campaign("c", "", &[4.0, 6.0, 5.0]);
    let base = |threads: &str| run(&["calibrate", text(&folder), "--threads", threads]);
    let known = base("1");
    assert_eq!(known.status.code(), Some(0), "{known:?}");
    for threads in ["2", "8", "5000", "18446744073709551615"] {
        let output = base(threads);
        assert_eq!((output.status.code(), &output.stdout), (Some(0), &known.stdout), "{threads}");
    }
    let said = String::from_utf8_lossy(&base("5000").stderr).into_owned();
    assert!(said.contains("5000 threads are asked for"), "{said}");
    for said in ["100000", "0", "many", "-3"] {
        let mut command = homepoint(&["calibrate", text(&folder)]);
        let output = command.env("RAYON_NUM_THREADS", said).output().unwrap();
        assert_eq!((output.status.code(), &output.stdout), (Some(0), &known.stdout), "{said}");
    }
}
