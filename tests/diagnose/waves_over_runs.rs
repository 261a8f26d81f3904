//! A wave over time that goes on through runs far apart: its line is as narrow as all of them are long,
//! and has side lobes at the interval from one run to the next.

use homepoint::diagnose::budget::answer::Verdict;

use crate::found::told;
use crate::stream::Stream;
use crate::written::diagnosed;

const MODEL: &str = r#"
name = "bridge"
title = "Strain of a bridge"
[inputs]
load = { unit = "N" }
[parameters]
zero = { unit = "1", scope = "rig" }
gain = { unit = "1/N", scope = "rig" }
[measurands]
strain = { value = 'zero + gain * load', unit = "1" }
"#;

#[test]
fn a_wave_through_runs_far_apart_has_its_period() {
    for (seed, period) in [(1, 37.0), (2, 52.3), (3, 23.4)] {
        let mut random = Stream(seed);
        let mut files = vec![("model.toml".to_owned(), MODEL.to_owned())];
        let mut campaign = "title = \"Bridge\"\nmodel = \"model.toml\"\n[measurands]\nstrain = { sigma = \"2e-6\" }\n".to_owned();
        for run in 0..20 {
            campaign += &format!("[[runs]]\nname = \"r{run}\"\ndata = \"r{run}.csv\"\n");
            let mut log = "time [s],load [N],strain [1]\n".to_owned();
            for row in 0..500 {
                let time = 2000.0 * f64::from(run) + 2.0 * f64::from(row);
                let load = 100.0 * random.uniform();
                let wave = 0.9e-6 * (std::f64::consts::TAU * time / period + 0.4).sin();
                let strain = 1e-5 + 2e-7 * load + wave + 2e-6 * random.normal();
                log += &format!("{time:.1},{load:.3},{strain:.5e}\n");
            }
            files.push((format!("r{run}.csv"), log));
        }
        files.push(("campaign.toml".to_owned(), campaign));
        let found = diagnosed(&files);
        assert_eq!(found.verdict, Verdict::Unknown, "{seed}: {}", told(&found));
        let [part] = &found.remainder[..] else { panic!("{seed}: {}", told(&found)) };
        let words = &part.place.words;
        assert!(words.contains(&format!("a wave every {period} s")), "{seed}: {words}");
        assert!(found.autocorrelation.is_empty(), "{seed}: {}", told(&found));
    }
}
