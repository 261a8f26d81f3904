//! Some of many runs have another zero, beside an effect that differs between runs, too: a value for each
//! run would follow both, but a few values and the effect are simpler.

use homepoint::diagnose::budget::answer::Verdict;

use crate::found::{names, told};
use crate::stream::Stream;
use crate::written::diagnosed;

const MODEL: &str = r#"
name = "balance"
title = "Balance under a wing"
[inputs]
push = { unit = "N" }
warmth = { unit = "K" }
[parameters]
zero = { unit = "N", scope = "rig" }
gain = { unit = "1", scope = "rig", start = "1" }
[quantities]
shown = 'zero + gain * push'
[measurands]
lift = { value = 'shown', unit = "N" }
"#;
const CREEP: &str = r#"
name = "creep"
title = "The zero goes with the temperature of the balance"
acts = "instrument"
[parameters]
k = { unit = "N/K", typical = "0.2 N/K", scope = "rig" }
[patch]
shown = 'shown + k * (warmth - 293.15 K)'
"#;
/// Runs, readings of each, their standard deviation (N), and the effect (N/K).
const RUNS: usize = 12;
const READINGS: usize = 60;
const SIGMA: f64 = 0.8;
const DUE: f64 = 0.3;

/// The files of a campaign in which some runs have another zero (N).
fn campaign(seed: u64, other: &[(usize, f64)]) -> Vec<(String, String)> {
    let mut random = Stream(seed);
    let mut campaign = format!(
        "title = \"Polars\"\nmodel = \"model.toml\"\n[measurands]\nlift = {{ sigma = \"{SIGMA} N\" }}\n"
    );
    let mut files = vec![
        ("model.toml".to_owned(), MODEL.to_owned()),
        ("effects/creep.toml".to_owned(), CREEP.to_owned()),
    ];
    for run in 0..RUNS {
        campaign += &format!("[[runs]]\nname = \"r{run}\"\ndata = \"r{run}.csv\"\n");
        let mut log = "time [s],push [N],warmth [K],lift [N]\n".to_owned();
        let zero = other.iter().find(|one| one.0 == run).map_or(0.0, |one| one.1);
        let of_run = 292.0 + 0.7 * ((5 * run) % 9) as f64;
        for row in 0..READINGS {
            let push = 20.0 * row as f64 + random.normal();
            let warmth = of_run + 0.01 * row as f64 + 0.03 * random.normal();
            let lift =
                0.8 + zero + 1.002 * push + DUE * (warmth - 293.15) + SIGMA * random.normal();
            log += &format!("{},{push:.3},{warmth:.3},{lift:.3}\n", 1000 * run + 5 * row);
        }
        files.push((format!("r{run}.csv"), log));
    }
    files.push(("campaign.toml".to_owned(), campaign));
    files
}

#[test]
fn runs_with_another_zero_are_named_beside_an_effect() {
    for seed in 1..5 {
        for other in [&[(7, 3.0)][..], &[(7, 3.0), (4, -2.0)]] {
            let found = diagnosed(&campaign(seed, other));
            assert_eq!(found.verdict, Verdict::PartlyExplained, "{seed}: {}", told(&found));
            assert_eq!(names(&found), ["creep"], "{seed}: {}", told(&found));
            let row = &found.rows[0].values[0];
            let far = (row.value.unwrap() - DUE) / row.sigma.unwrap();
            assert!(far.abs() < 4.0, "{seed}: {far}");
            let mut runs: Vec<_> =
                found.remainder.iter().filter_map(|one| one.place.run.clone()).collect();
            runs.sort_unstable();
            let mut due: Vec<_> = other.iter().map(|(run, _)| format!("r{run}")).collect();
            due.sort_unstable();
            assert_eq!(runs, due, "{seed}: {}", told(&found));
            assert_eq!(found.remainder.len(), other.len(), "{seed}: {}", told(&found));
        }
    }
}
