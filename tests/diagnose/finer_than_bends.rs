//! Errors over an input that are finer than the octiles at which a line over it bends: they come back with
//! the place in each pass, and are no noise.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use homepoint::diagnose::Diagnosis;
use homepoint::diagnose::budget::answer::Verdict;
use homepoint::diagnose::found::AutocorrelatedNoise;

use crate::found::told;
use crate::own_effects::Campaign;
use crate::stream::Stream;

const STAGE: &str = r#"
name = "stage"
title = "A stage against a laser"
[inputs]
place = { unit = "m" }
[parameters]
zero = { unit = "m", scope = "rig" }
scale = { unit = "1", scope = "rig", start = "1 1" }
[measurands]
laser = { value = 'scale * place + zero', unit = "m" }
"#;

/// Nine slow strokes there and back, with this error of each place (µm), noise of 0.5 µm, and as much noise
/// that is correlated over so many rows.
fn strokes(seed: u64, rows: f64, error: impl Fn(f64) -> f64) -> Diagnosis {
    let (mut stream, mut slow) = (Stream(seed), 0.0);
    let kept = if rows > 0.0 { (-1.0 / rows).exp() } else { 0.0 };
    let mut log = "time [s],place [m],laser [m]\n".to_owned();
    for row in 0..4000 {
        let time = 0.1 * f64::from(row);
        let place = 0.45 - 0.4 * (TAU * time / 44.0).cos();
        slow = kept * slow + (1.0_f64 - kept * kept).sqrt() * stream.normal();
        let noise = stream.normal() + if rows > 0.0 { slow } else { 0.0 };
        let laser = place + 1e-6 * (error(place) + 0.5 * noise) + 0.12;
        let _ = writeln!(log, "{time:.1},{place:.9},{laser:.10}");
    }
    let measurands = "laser = { sigma = \"0.5 um\" }";
    Campaign { model: STAGE, effects: &[], measurands, log }.diagnosed()
}

fn bump(place: f64) -> f64 {
    1.6 * (-((place - 0.52) / 0.02).powi(2)).exp()
}

/// It was taken for two waves and for noise that is correlated over a second.
#[test]
fn a_bump_between_octiles_is_an_error_over_the_place() {
    for seed in [401, 402] {
        let found = strokes(seed, 0.0, bump);
        assert_eq!(found.verdict, Verdict::Unknown, "{}", told(&found));
        assert!(found.autocorrelation.is_empty(), "{}", told(&found));
        let [only] = &found.remainder[..] else { panic!("{}", told(&found)) };
        assert_eq!(only.place.words, "an error of `laser` over place", "{}", told(&found));
        // The root mean square of the bump over these strokes, less what the nominal values absorb.
        let (rms, _) = only.rms.as_ref().unwrap();
        assert!((0.2e-6..0.35e-6).contains(rms), "{rms:e}");
    }
}

/// What does not come back with the place is noise, with a bump and without.
#[test]
fn correlated_noise_beside_passes_stays_noise() {
    let found = strokes(403, 40.0, |_| 0.0);
    assert!(!found.autocorrelation.is_empty() && found.remainder.is_empty(), "{}", told(&found));
    let found = strokes(404, 40.0, bump);
    let [AutocorrelatedNoise { noise, .. }] = &found.autocorrelation[..] else {
        panic!("{}", told(&found))
    };
    assert!((noise.share() - 0.5).abs() < 0.15, "{}", noise.share());
    let [only] = &found.remainder[..] else { panic!("{}", told(&found)) };
    assert_eq!(only.place.words, "an error of `laser` over place", "{}", told(&found));
}
