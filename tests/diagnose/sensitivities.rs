//! Effects from a simulator's sensitivities: what is found beyond their linear range is simulated
//! again.

use std::fmt::Write as _;
use std::path::Path;

use homepoint::diagnose::library::wanted::Wanted;
use homepoint::diagnose::{Diagnosis, diagnose};
use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::Options;
use homepoint::report;

use crate::stream::Stream;

const MODEL: &str = r#"
name  = "cooling"
title = "A simulated decay and its sensitivity to the rate"
[inputs]
simulated   = { unit = "m", about = "what the simulator predicts" }
sensitivity = { unit = "m s", about = "its derivative by the rate" }
[parameters]
offset = { unit = "m", scope = "rig" }
[quantities]
predicted = 'simulated'
[measurands]
height = { value = 'predicted + offset', unit = "m" }
"#;

const EFFECT: &str = r#"
name  = "rate_of_decay"
title = "The simulator's rate is wrong"
acts  = "arm"
[parameters]
change = { unit = "1/s", typical = "0.05 1/s", scope = "rig", linear_range = "0.05 1/s" }
[patch]
predicted = 'predicted + change * sensitivity'
"#;

/// The diagnosis of a decay at 1.3 1/s against simulations at another rate.
fn against(folder: &Path, rate: f64) -> Diagnosis {
    std::fs::create_dir_all(folder.join("effects")).unwrap();
    std::fs::write(folder.join("cooling.toml"), MODEL).unwrap();
    std::fs::write(folder.join("effects/rate_of_decay.toml"), EFFECT).unwrap();
    let campaign = format!(
        "title = \"Decay\"\nmodel = \"cooling.toml\"\n[parameters]\n\
         rate_of_decay.change = {{ simulated_at = \"{rate} 1/s\" }}\n\
         [measurands]\nheight = {{ sigma = \"1 mm\" }}\n\
         [[runs]]\nname = \"one\"\nsetup = \"A\"\ndata = \"log.csv\"\n"
    );
    std::fs::write(folder.join("campaign.toml"), campaign).unwrap();
    let mut stream = Stream(17);
    let mut log = String::from("time [s],simulated [m],sensitivity [m s],height [m]\n");
    for sample in 0..400 {
        let time = 0.01 * f64::from(sample);
        let simulated = (-rate * time).exp();
        let height = (-1.3 * time).exp() + 0.2 + 1e-3 * stream.normal();
        let _ = writeln!(log, "{time},{simulated},{},{height}", -time * simulated);
    }
    std::fs::write(folder.join("log.csv"), log).unwrap();
    let opened = open(&Request::new([folder])).unwrap();
    diagnose(opened.problem, opened.recipes, &Wanted::default(), &Options::default()).unwrap()
}

/// The first answer says where to simulate again; the values go to the truth, and the last is within
/// the range.
#[test]
fn what_is_beyond_the_linear_range_is_simulated_again() {
    for start in [1.0, 1.7] {
        let own = tempfile::tempdir().unwrap();
        let mut rate = start;
        let mut far = Vec::new();
        let last = (0..5).find_map(|round| {
            let found = against(&own.path().join(round.to_string()), rate);
            let text =
                report::diagnosis_text::text("", &found, &report::diagnosis_text::Asked::default());
            let Some(beyond) = found.beyond_range.first() else {
                assert!(!text.contains("simulate again"), "{text}");
                let change = found.rows.first().map_or(0.0, |row| row.values[0].value.unwrap());
                return Some((rate + change, round));
            };
            assert_eq!(beyond.parameter, "rate_of_decay.change");
            rate = beyond.simulate_at.unwrap();
            // To a hundredth of the range.
            let words = format!("simulate again at {rate:.4}");
            assert!(text.contains(words.trim_end_matches('0')), "{words}: {text}");
            let json = report::diagnosis::json(&found, None);
            assert_eq!(json["beyond_linear_range"][0]["simulate_at"].as_f64(), Some(rate));
            far.push((rate - 1.3).abs());
            assert!(far.windows(2).all(|pair| pair[1] < pair[0]), "{far:?}");
            None
        });
        let (found, rounds) = last.unwrap();
        assert!((found - 1.3).abs() < 0.01 && rounds > 0, "{found} after {rounds}: {far:?}");
    }
}

/// A range of a delay, or of several numbers, is an error with its place.
#[test]
fn a_linear_range_belongs_to_a_declared_scalar() {
    let own = tempfile::tempdir().unwrap();
    against(own.path(), 1.28);
    let file = own.path().join("campaign.toml");
    let campaign = std::fs::read_to_string(&file).unwrap();
    for (line, words) in [
        ("height.delay = { linear_range = \"1 ms\" }", "`height.delay` has `linear_range`"),
        ("rate_of_decay.change = { linear_range = \"-1 1/s\" }", "must be greater than zero"),
        ("rate_of_decay.change = { simulated_at = \"1 m\" }", "must be a quantity like"),
    ] {
        let text = campaign.replace("rate_of_decay.change = { simulated_at = \"1.28 1/s\" }", line);
        std::fs::write(&file, text).unwrap();
        let mut request = Request::new([own.path()]);
        request.with = vec!["rate_of_decay".to_owned()];
        let error = open(&request).unwrap_err().to_string();
        assert!(error.contains(words), "{line}: {error}");
    }
}
