//! Noise that remembers a little, as all real noise does: five per cent of its variance make no change
//! point, no wave and no oscillation.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use homepoint::diagnose::budget::answer::Verdict;

use crate::found::told;
use crate::stream::Stream;
use crate::written::diagnosed;

const PLATE: &str = r#"
name = "plate"
title = "A plate that turns under a tracker"
[inputs]
angle = { unit = "rad", signal = true }
[parameters]
radius = { unit = "m", scope = "rig", start = "0.3 m" }
centre = { kind = "vector", unit = "m", scope = "rig" }
[quantities]
target = 'rotate(rotation_z(angle), [radius, 0, 0]) + centre'
[measurands]
x = { value = 'target.x', unit = "m" }
y = { value = 'target.y', unit = "m" }
z = { value = 'target.z', unit = "m" }
[delays]
tracker = { of = ["x", "y", "z"] }
"#;
const SAMPLES: usize = 1200;
const INTERVAL: f64 = 0.02;
const SIGMA: f64 = 6e-5;

/// Noise of which a share of the variance has a memory of 0.3 s.
fn noise(share: f64, random: &mut Stream) -> Vec<f64> {
    let decay = (-INTERVAL / 0.3_f64).exp();
    let mut state = random.normal();
    let next = |_| {
        state = decay * state + (1.0 - decay * decay).sqrt() * random.normal();
        SIGMA * ((1.0 - share).sqrt() * random.normal() + share.sqrt() * state)
    };
    (0..SAMPLES).map(next).collect()
}

/// Three runs in three coordinates.
fn plate(share: f64, seed: u64) -> Vec<(String, String)> {
    let mut random = Stream(seed);
    let mut campaign = "title = \"Plate\"\nmodel = \"plate.toml\"\n[measurands]\nx = { sigma = \"60 um\" }\ny = { sigma = \"60 um\" }\nz = { sigma = \"60 um\" }\n".to_owned();
    let mut files = vec![("plate.toml".to_owned(), PLATE.to_owned())];
    for (number, turns) in [0.11, 0.18, -0.14].into_iter().enumerate() {
        let [x, y, z] = [0; 3].map(|_| noise(share, &mut random));
        let mut log = "time [s],angle [rad],x [m],y [m],z [m]\n".to_owned();
        for (sample, ((x, y), z)) in x.iter().zip(&y).zip(&z).enumerate() {
            let time = 100.0 * number as f64 + INTERVAL * sample as f64;
            let angle = TAU * turns * INTERVAL * sample as f64;
            let (x, y, z) = (0.3 * angle.cos() + 0.1 + x, 0.3 * angle.sin() - 0.2 + y, 0.5 + z);
            writeln!(log, "{time:.2},{angle:.7},{x:.7},{y:.7},{z:.7}").unwrap();
        }
        files.push((format!("run_{number}.csv"), log));
        write!(
            campaign,
            "[[runs]]\nname = \"run_{number}\"\nsetup = \"A\"\ndata = \"run_{number}.csv\"\n"
        )
        .unwrap();
    }
    files.push(("campaign.toml".to_owned(), campaign));
    files
}

/// Neighbours of such noise hardly correlate; stretches of it do.
#[test]
fn weak_slow_noise_is_no_structure() {
    let mut found_in = 0;
    for seed in 1..=6 {
        let found = diagnosed(&plate(0.05, seed));
        assert!(found.remainder.is_empty() && found.rows.is_empty(), "{seed}: {}", told(&found));
        for one in &found.autocorrelation {
            assert!((0.01..0.15).contains(&one.noise.share()), "{seed}: {one:?}");
        }
        found_in += usize::from(!found.autocorrelation.is_empty());
    }
    assert!(found_in >= 4, "{found_in}");
    let white = diagnosed(&plate(0.0, 9));
    assert_eq!(white.verdict, Verdict::Adequate, "{}", told(&white));
    assert!(white.autocorrelation.is_empty());
}
