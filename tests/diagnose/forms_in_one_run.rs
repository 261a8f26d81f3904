//! An error that depends on an input in one run alone is no noise of that run, in whatever order the
//! input was gone through.

use homepoint::diagnose::Diagnosis;
use homepoint::diagnose::budget::answer::Verdict;

use crate::found::told;
use crate::stream::Stream;
use crate::written::diagnosed;

const MODEL: &str = r#"
name = "anemometer"
title = "Anemometer in a wind tunnel beside its pitot tube"
[inputs]
flow = { unit = "m/s" }
humidity = { unit = "%" }
[parameters]
gain = { unit = "1", scope = "rig", start = "1" }
zero = { unit = "m/s", scope = "run" }
[measurands]
cup = { value = 'gain * flow + zero', unit = "m/s" }
"#;
/// Run in which something is wrong.
const WRONG: i32 = 2;

/// Five runs of 40 readings at flows in random order, with an error in one run, in units of the noise,
/// by the flow from 0 to 1.
fn found(seed: u64, error: impl Fn(f64, &mut Stream) -> f64) -> Diagnosis {
    let mut random = Stream(seed);
    let mut campaign =
        "title = \"Tunnel\"\nmodel = \"model.toml\"\n[measurands]\ncup = { sigma = \"0.02 m/s\" }\n"
            .to_owned();
    let mut files = vec![("model.toml".to_owned(), MODEL.to_owned())];
    for run in 0..5 {
        campaign += &format!("[[runs]]\nname = \"r{run}\"\ndata = \"r{run}.csv\"\n");
        let mut log = "flow [m/s],humidity [%],cup [m/s]\n".to_owned();
        let zero = 0.1 * random.normal();
        for _ in 0..40 {
            let part = random.uniform();
            let (flow, humidity) = (2.0 + 18.0 * part, 35.0 + 20.0 * random.uniform());
            let wrong = if run == WRONG { error(part, &mut random) } else { 0.0 };
            let cup = 1.013 * flow + zero + 0.02 * (random.normal() + wrong);
            log += &format!("{flow:.3},{humidity:.1},{cup:.4}\n");
        }
        files.push((format!("r{run}.csv"), log));
    }
    files.push(("campaign.toml".to_owned(), campaign));
    diagnosed(&files)
}

#[test]
fn an_error_over_an_input_in_one_run_has_its_place() {
    let hump = |part: f64, _: &mut Stream| 14.0 * (-((part - 0.6) / 0.12).powi(2)).exp();
    let line = |part: f64, _: &mut Stream| 9.0 * (part - 0.5);
    for seed in 1..5 {
        for found in [found(seed, hump), found(seed, line)] {
            assert_eq!(found.verdict, Verdict::Unknown, "{seed}: {}", told(&found));
            let first = &found.remainder[0].place;
            assert_eq!(first.covariate, "flow", "{seed}: {}", told(&found));
            assert_eq!(first.run.as_deref(), Some("r2"), "{seed}: {}", told(&found));
            assert!(found.remainder[0].share > 0.9, "{seed}: {}", told(&found));
            assert!(found.remainder[0].change.is_none(), "{seed}: {}", told(&found));
        }
    }
}

#[test]
fn noise_of_one_run_has_no_form() {
    for seed in 1..5 {
        let found = found(seed, |_, random| 3.0 * random.normal());
        assert_eq!(found.verdict, Verdict::Explained, "{seed}: {}", told(&found));
        assert!(found.remainder.is_empty(), "{seed}: {}", told(&found));
    }
}
