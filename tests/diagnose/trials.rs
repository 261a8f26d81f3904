//! `homepoint trials`: the score is the same at any number of threads and after an interruption,
//! what is drawn has the size that is asked for, and the score can be bad.

use std::path::PathBuf;

use homepoint::diagnose::library::wanted::Wanted;
use homepoint::engine::gram::LeastSquares;
use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::{Options, fit};
use homepoint::progress::Progress;
use homepoint::trials::design::Design;
use homepoint::trials::draw::{Drawn, draw};
use homepoint::trials::heading::Heading;
use homepoint::trials::ledger::{Ledger, LedgerError};
use homepoint::trials::outcome;
use homepoint::trials::plan::{Kind, Plan};
use homepoint::trials::run;
use homepoint::trials::tally::tally;

fn design() -> Design {
    let campaign = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("examples/rotating_arm");
    Design::new(open(&Request::new([campaign])).unwrap()).unwrap()
}

/// A ledger goes on wherever its campaign is looked at from.
#[test]
fn a_design_is_the_same_by_every_path() {
    let stamp = |path: PathBuf| Design::new(open(&Request::new([path])).unwrap()).unwrap().stamp();
    let folder = PathBuf::from("examples/rotating_arm");
    let whole = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(&folder);
    let own = stamp(folder.clone());
    for path in [PathBuf::from(".").join(&folder), folder.join("campaign.toml"), whole] {
        assert_eq!(stamp(path.clone()), own, "{}", path.display());
    }
    assert_ne!(stamp(PathBuf::from("examples/hand_eye")), own);
}

#[test]
fn threads_and_interruptions_change_nothing() {
    let design = design();
    let plan = Plan::standard(2, 11);
    let at_once = run(&design, &plan, None, 1, &Progress::default()).unwrap();
    assert_eq!(at_once.len(), 2);

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("trials.jsonl");
    let heading = Heading::of(&plan, &design);
    let mut ledger = Ledger::open(&path, &heading).unwrap();
    run(&design, &plan, Some(&mut ledger), 1, &Progress::default()).unwrap();
    drop(ledger);
    // Interrupted in the middle of a line.
    let whole = std::fs::read(&path).unwrap();
    std::fs::write(&path, &whole[..whole.len() - 40]).unwrap();
    let mut ledger = Ledger::open(&path, &heading).unwrap();
    assert_eq!(ledger.outcomes.len(), 1);
    let resumed = run(&design, &plan, Some(&mut ledger), 2, &Progress::default()).unwrap();
    assert_eq!(resumed, at_once);
    assert_eq!(tally(&resumed), tally(&at_once));
    assert_eq!(Ledger::open(&path, &heading).unwrap().outcomes.len(), 2);

    // A line that cannot be read costs its own trial and no other.
    let whole = std::fs::read_to_string(&path).unwrap();
    let mut lines: Vec<&str> = whole.lines().collect();
    lines[1] = "{\"trial\":";
    std::fs::write(&path, lines.join("\n") + "\n").unwrap();
    let mut ledger = Ledger::open(&path, &heading).unwrap();
    assert_eq!(ledger.outcomes.len(), 1);
    let mended = run(&design, &plan, Some(&mut ledger), 1, &Progress::default()).unwrap();
    assert_eq!(mended, at_once);

    // Trials of something else are not mixed in.
    let other = Heading::of(&Plan::standard(2, 12), &design);
    let refused = Ledger::open(&path, &other);
    assert!(matches!(refused, Err(LedgerError::Other { what: "seed" })));
}

/// The length of what was drawn by a second route: readings without noise, and a nonlinear fit of
/// the nominal model to them.
fn length(design: &Design, drawn: &Drawn) -> f64 {
    let mut quiet = design.problem.clone();
    for (part, other) in quiet.parts.iter_mut().zip(&drawn.noiseless().unwrap().parts) {
        for (run, other) in part.runs.iter_mut().zip(&other.runs) {
            run.record.clone_from(&other.record);
        }
    }
    quiet.reweight(&design.truth);
    fit(&mut quiet, design.truth.clone(), &Options::default()).unwrap().cost.sqrt()
}

#[test]
fn an_effect_has_the_length_that_is_asked_for() {
    let design = design();
    for (number, lambda) in [(0, 25.0), (1, 40.0), (2, 60.0)] {
        let plan = Plan::of(3, 5, &[Kind::One], &[lambda]);
        let drawn = draw(&design, &plan.trial(number));
        let found = length(&design, &drawn);
        let name = &drawn.doses[0].cause.name;
        assert!((found / lambda - 1.0).abs() < 0.02, "{name}: {found} instead of {lambda}");
    }
}

/// Slow noise in forty runs: many blocks imitate it, some of them reduced beside a row, until noise explains
/// more than all of these.
#[test]
fn slow_noise_that_many_blocks_imitate_is_noise() {
    let campaign = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("examples/four_setups");
    let design = Design::new(open(&Request::new([campaign])).unwrap()).unwrap();
    let found = outcome::of(&design, &Plan::standard(60, 20_261_129), 7);
    assert!(found.named.is_empty(), "{found:?}");
}

/// Values go to their rig and instrument, whether those have names or not.
#[test]
fn effects_are_put_in_where_instrument_and_rig_have_names() {
    let shipped = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("examples/rotating_arm");
    let own = tempfile::tempdir().unwrap();
    for file in std::fs::read_dir(&shipped).unwrap() {
        let file = file.unwrap();
        std::fs::copy(file.path(), own.path().join(file.file_name())).unwrap();
    }
    let path = own.path().join("campaign.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, format!("instrument = \"T1\"\nrig = \"R1\"\n{text}")).unwrap();
    let named = Design::new(open(&Request::new([own.path()])).unwrap()).unwrap();
    let plan = Plan::of(8, 5, &[Kind::One], &[25.0]);
    for number in 0..8 {
        let drawn = draw(&named, &plan.trial(number));
        let (found, name) = (length(&named, &drawn), &drawn.doses[0].cause.name);
        assert!((found / 25.0 - 1.0).abs() < 0.02, "{name}: {found}");
    }
}

#[test]
fn a_diagnosis_without_a_library_scores_badly() {
    let mut design = design();
    let plan = Plan::of(3, 7, &[Kind::One], &[40.0]);
    let good = tally(&run(&design, &plan, None, 2, &Progress::default()).unwrap());
    design.wanted = Wanted { only: vec!["collimation".to_owned()], ..design.wanted.clone() };
    let bad = tally(&run(&design, &plan, None, 2, &Progress::default()).unwrap());
    let first = |tally: &homepoint::trials::tally::Tally| tally.cells[0].top1.hits;
    assert!(first(&good) >= 2, "{:?}", good.confusion);
    assert!(first(&bad) <= 1, "{:?}", bad.confusion);
}
