//! A run of few readings that is noisier than the others: its noise is its own, and no stretch of it is a
//! change.

use std::fmt::Write as _;

use homepoint::diagnose::Diagnosis;
use homepoint::diagnose::budget::answer::Verdict;
use homepoint::report::diagnosis_text;

use crate::found::told;
use crate::stream::Stream;
use crate::written::diagnosed;

const AXIS: &str = "name = \"axis\"\ntitle = \"Axis\"\n[inputs]\nx = { unit = \"m\" }\n\
                    [parameters]\nzero = { unit = \"m\" }\nscale = { unit = \"1\" }\n\
                    [measurands]\nlaser = { value = 'zero + x * (1 + scale)', unit = \"m\" }\n";

/// Ten passes over 21 places; the noise of each reading in standard deviations, by pass and place.
fn passes(seed: u64, noise: impl Fn(usize, usize, f64) -> f64) -> Diagnosis {
    let mut random = Stream(seed);
    let mut campaign =
        "title = \"Axis\"\nmodel = \"axis.toml\"\n[measurands]\nlaser = { sigma = \"1 um\" }\n"
            .to_owned();
    let mut files = vec![("axis.toml".to_owned(), AXIS.to_owned())];
    for pass in 0..10 {
        let mut log = "x [mm],laser [mm]\n".to_owned();
        for place in 0..21 {
            let x = 20.0 * place as f64;
            let laser = x + 1e-3 * noise(pass, place, random.normal());
            writeln!(log, "{x},{laser:.5}").unwrap();
        }
        files.push((format!("pass_{pass}.csv"), log));
        write!(campaign, "[[runs]]\nname = \"pass_{pass}\"\ndata = \"pass_{pass}.csv\"\n").unwrap();
    }
    files.push(("campaign.toml".to_owned(), campaign));
    diagnosed(&files)
}

#[test]
fn a_short_run_has_noise_of_its_own() {
    for seed in 1..=6 {
        let found = passes(seed, |pass, _, noise| if pass == 3 { 3.0 * noise } else { noise });
        assert_eq!(found.verdict, Verdict::Explained, "{seed}: {}", told(&found));
        assert!(found.remainder.is_empty(), "{seed}: {}", told(&found));
        let own: Vec<_> = found.levels.iter().filter(|one| one.run.is_some()).collect();
        let [own] = &own[..] else { panic!("{seed}: {}", told(&found)) };
        assert_eq!(own.run.as_deref(), Some("pass_3"));
        assert!((1.9..4.2).contains(&own.factor), "{seed}: {own:?}");
        let text = diagnosis_text::text("", &found, &diagnosis_text::Asked::default());
        assert!(text.contains("calibrate CAMPAIGN --noise sandwich"), "{text}");
    }
}

/// Two outliers of a run are no noise of it.
#[test]
fn two_outliers_make_no_noise_of_a_run() {
    for seed in 1..=6 {
        let is_far = |pass, place| pass == 3 && (place == 4 || place == 15);
        let far = |noise: f64| noise + 5.5_f64.copysign(noise);
        let found =
            passes(seed, |pass, place, noise| if is_far(pass, place) { far(noise) } else { noise });
        assert!(found.levels.iter().all(|one| one.run.is_none()), "{seed}: {}", told(&found));
    }
}
