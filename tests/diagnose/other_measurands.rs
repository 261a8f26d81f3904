//! What remains in one measurand, however much it is, leaves no imitator of an effect that changes others.

use std::fmt::Write as _;

use homepoint::diagnose::budget::answer::Verdict;

use crate::found::{names, told};
use crate::stream::Stream;
use crate::written::diagnosed;

const DISH: &str = r#"
name = "dish"
title = "Indices of a dish"
[inputs]
az_of_source = { unit = "rad" }
el_of_source = { unit = "rad" }
[parameters]
az_zero = { unit = "rad", scope = "instrument" }
el_zero = { unit = "rad", scope = "instrument" }
[measurands]
az = { value = 'az_of_source + az_zero', kind = "angle", unit = "rad", period = "360 deg" }
el = { value = 'el_of_source + el_zero', kind = "angle", unit = "rad" }
[roles]
horizontal = "az"
vertical = "90 deg - el"
"#;

const CAMPAIGN: &str = r#"
title = "Sources"
model = "dish.toml"
[measurands]
az = { sigma = "10 urad" }
el = { sigma = "10 urad" }
[[runs]]
name = "night"
data = "night.csv"
"#;

/// A track under the wheels of a dish has three waves a turn, which its elevation shows.
#[test]
fn an_effect_stands_beside_a_large_remainder_in_another_measurand() {
    for seed in 1..=3 {
        let mut random = Stream(seed);
        let mut log = "az_of_source [rad],el_of_source [rad],az [rad],el [rad]\n".to_owned();
        for source in 0..160 {
            let az = f64::from(source * 67 % 160) / 160.0 * std::f64::consts::TAU;
            let el = 0.1 + 1.2 * f64::from(source * 43 % 160) / 160.0;
            let read_az = az + 2e-4 + 1e-4 / el.cos() + 1e-5 * random.normal();
            let read_el = el - 1e-4 + 6e-4 * (3.0 * az).sin() + 1e-5 * random.normal();
            writeln!(log, "{az:.8},{el:.8},{read_az:.8},{read_el:.8}").unwrap();
        }
        let files = [("dish.toml", DISH), ("campaign.toml", CAMPAIGN), ("night.csv", &log)];
        let found = diagnosed(&files.map(|(name, text)| (name.to_owned(), text.to_owned())));
        assert_eq!(found.verdict, Verdict::PartlyExplained, "{seed}: {}", told(&found));
        assert_eq!(names(&found), ["collimation"], "{seed}: {}", told(&found));
        let value = found.rows[0].values[0].value.unwrap();
        assert!((value.abs() / 1e-4 - 1.0).abs() < 0.1, "{seed}: {value}");
        assert!(found.remainder.iter().all(|part| part.place.words.contains("el")));
    }
}
