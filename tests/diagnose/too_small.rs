//! Effects that are seen but too small for a name: they stay in the model without one, so that no
//! other value is biased by their absence and nothing is adequate with them.

use std::fmt::Write as _;

use homepoint::diagnose::Diagnosis;
use homepoint::diagnose::budget::answer::Verdict;

use crate::found::{names, told};
use crate::own_effects::Campaign;
use crate::several_causes::{RAIL, SCALE};
use crate::stream::Stream;

/// From 5 to 10 m most of it is an offset and a scale.
const BOW: (&str, &str, &str) = (
    "bow",
    "size = { unit = \"m\", typical = \"1 mm\", scope = \"rig\" }",
    "place = 'place + size * (sent / 10 m)^2'",
);

/// Sixty places from 5 to 10 m, with a scale and a bow.
fn rail(seed: u64, scale: f64, bow: f64) -> Diagnosis {
    let mut random = Stream(seed);
    let mut log = "sent [m],read [m]\n".to_owned();
    for row in 0..60 {
        let sent = 5.0 + 5.0 * f64::from(row * 37 % 60) / 59.0;
        let error = scale * sent + bow * (0.1 * sent).powi(2) + 5e-5 * random.normal();
        writeln!(log, "{sent:.6},{:.8}", sent + error).unwrap();
    }
    Campaign {
        model: RAIL,
        effects: &[SCALE, BOW],
        measurands: "read = { sigma = \"50 um\" }",
        log,
    }
    .diagnosed()
}

/// Without the bow the scale would be 350 ppm off, many standard uncertainties.
#[test]
fn a_value_is_that_beside_an_effect_too_small_for_a_name() {
    let mut without_a_name = 0;
    for seed in 1..=6 {
        let found = rail(seed, 3e-3, 2.3e-3);
        assert!(names(&found).contains(&"scale"), "{seed}: {}", told(&found));
        let scale = found.rows.iter().find(|row| row.name == "scale").unwrap();
        let (value, sigma) = (scale.values[0].value.unwrap(), scale.values[0].sigma.unwrap());
        let far = (value - 3e-3) / sigma;
        assert!(far.abs() < 4.0, "{seed}: {far}, {}", told(&found));
        if found.verdict == Verdict::PartlyExplained {
            without_a_name += 1;
            assert!(found.remainder[0].place.words.contains("bow"), "{}", told(&found));
        }
    }
    assert!(without_a_name > 0);
}

#[test]
fn alone_it_is_unknown_and_what_it_is_like_is_said() {
    let mut unknown = 0;
    for seed in 11..=16 {
        // Noncentrality 6 to 8.
        let found = rail(seed, 3.2e-5, 0.0);
        if found.verdict == Verdict::Unknown {
            unknown += 1;
            assert!(found.remainder[0].place.is_effect(), "{}", told(&found));
        }
    }
    assert!(unknown > 2, "{unknown}");
}
