//! `homepoint trials --replay`: recorded trials come out as they were, and what was altered is
//! listed.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use homepoint::trials::ledger::Recorded;
use homepoint::trials::plan::{Kind, Plan};
use homepoint::trials::replay::plan;
use serde_json::Value;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn shipped(name: &str) -> PathBuf {
    root().join("docs/trials").join(name)
}

fn trials(campaign: &str, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_homepoint"));
    command.current_dir(root()).args(["trials", campaign, "--quiet"]);
    command.args(arguments).output().unwrap()
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// The lines of a ledger, changed by number: 0 is the heading.
fn altered(path: &Path, to: &Path, change: impl Fn(usize, &mut Value)) {
    let text = std::fs::read_to_string(path).unwrap();
    let lines = text.lines().enumerate().map(|(number, line)| {
        let mut value: Value = serde_json::from_str(line).unwrap();
        change(number, &mut value);
        format!("{value}\n")
    });
    std::fs::write(to, lines.collect::<String>()).unwrap();
}

#[test]
fn equal_trials_pass_and_altered_ones_are_listed() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let arm = "examples/rotating_arm";
    let made = trials(arm, &["--trials", "2", "--seed", "11", "--out", out]);
    assert!(made.status.success(), "{made:?}");
    let ledger = folder.path().join("trials.jsonl");
    let replay = |path: &Path, more: &[&str]| {
        let arguments = [&["--replay", path.to_str().unwrap()], more].concat();
        trials(arm, &arguments)
    };

    // A verdict, a name, a probability, and nothing that counts.
    let recorded = Recorded::read(&ledger).unwrap().outcomes;
    let with_name = recorded.iter().find(|one| !one.named.is_empty()).unwrap().trial;
    let with_odds = recorded.iter().find(|one| one.brier.is_some()).unwrap().trial;
    let other = folder.path().join("altered.jsonl");
    altered(&ledger, &other, |number, line| {
        let Some(trial) = number.checked_sub(1) else { return };
        let of = line["trial"].as_u64().unwrap() as usize;
        if of == with_name {
            line["named"][0] = "beam_offset_of_nobody".into();
        }
        if of == with_odds {
            line["brier"] = (line["brier"].as_f64().unwrap() + 2e-6).into();
            line["confidence"] = (line["confidence"].as_f64().unwrap() + 0.2e-6).into();
        }
        if trial == 1 {
            line["verdict"] = "a_later_word".into();
        }
    });
    let listed = replay(&other, &[]);
    assert_eq!(listed.status.code(), Some(1), "{listed:?}");
    let text = stdout(&listed);
    for field in ["named: beam_offset_of_nobody -> ", "brier: ", "verdict: a_later_word -> "] {
        assert!(text.contains(field), "{field}: {text}");
    }
    assert!(!text.contains("confidence"), "{text}");

    // Scores may change, and a word that this program lacks is counted.
    let summary = replay(&other, &["--compare", "summary"]);
    assert_eq!(summary.status.code(), Some(0), "{summary:?}");
    assert!(stdout(&summary).contains("a_later_word"), "{summary:?}");

    // Another campaign or library is refused; their scores can be looked at.
    altered(&ledger, &other, |number, line| {
        if number == 0 {
            line["design"] = "0123456789abcdef".into();
        }
    });
    let refused = replay(&other, &[]);
    let words = String::from_utf8(refused.stderr.clone()).unwrap();
    assert_eq!(refused.status.code(), Some(2), "{refused:?}");
    assert!(words.contains("another campaign or library"), "{words}");
    let summary = replay(&other, &["--compare", "summary", "--sample", "1", "--format", "json"]);
    assert_eq!(summary.status.code(), Some(0), "{summary:?}");
    let json: Value = serde_json::from_str(&stdout(&summary)).unwrap();
    assert_eq!(json["replayed"], 1);
}

/// The shipped ledgers can be read whole, and their plans make their trials.
#[test]
fn shipped_ledgers_hold_the_trials_of_their_plans() {
    for (name, count) in LEDGERS {
        let recorded = Recorded::read(&shipped(name)).unwrap();
        assert_eq!((recorded.outcomes.len(), recorded.unreadable.len()), (*count, 0), "{name}");
        let plan = plan(&recorded).unwrap();
        for one in &recorded.outcomes {
            let trial = plan.trial(one.trial);
            assert_eq!((one.seed, one.kind.as_str()), (trial.seed, trial.kind.word()), "{name}");
            assert_eq!(one.mixed, trial.mixed, "{name} {}", one.trial);
            assert_eq!(one.situation, trial.situation.map(|one| one.name), "{name}");
        }
    }
}

/// Files of trials and how many they hold.
const LEDGERS: &[(&str, usize)] =
    &[("four_setups.jsonl.gz", 30), ("situations.jsonl.gz", 12), ("mixtures.jsonl.gz", 4)];

/// One trial of the oldest ledger, whose heading and lines have the fewest fields.
#[test]
fn a_shipped_trial_comes_out_as_recorded() {
    let path = shipped("four_setups.jsonl.gz");
    let arguments = ["--replay", path.to_str().unwrap(), "--sample", "1"];
    let equal = trials("examples/four_setups", &arguments);
    assert_eq!(equal.status.code(), Some(0), "{equal:?}");
    assert!(stdout(&equal).contains("1 of 1 replayed trials are equal, 0 differ (30 recorded)"));
}

/// Situations and mixtures are ledgers like any other.
#[test]
fn situations_and_mixtures_are_plans_of_their_own() {
    let each = Plan::situations(0, 1).strata.len();
    let kinds = |plan: &Plan| (0..plan.trials).map(|n| plan.trial(n).kind).collect::<Vec<_>>();
    assert!(kinds(&Plan::situations(each, 1)).iter().all(|one| *one == Kind::Situation));
    assert!(kinds(&Plan::mixtures(5, 1)).iter().all(|one| *one == Kind::Mixture));
    let names: std::collections::BTreeSet<String> = (0..each)
        .filter_map(|n| Some(Plan::situations(each, 1).trial(n).situation?.name))
        .collect();
    assert_eq!(names.len(), each);
}
