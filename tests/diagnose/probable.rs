//! Which of several aliases is the row: the most probable one beside all rows, whichever entered first.

use std::fmt::Write as _;

use homepoint::diagnose::Diagnosis;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use crate::found::told;
use crate::written::diagnosed;

const MODEL: &str = r#"
name = "bench"
title = "Carriage on a bench"
[inputs]
place = { unit = "m" }
[parameters]
zero_y = { unit = "mm", scope = "instrument" }
zero_z = { unit = "mm", scope = "instrument" }
zero_w = { unit = "mm", scope = "instrument" }
[measurands]
y = { value = 'zero_y', unit = "mm" }
z = { value = 'zero_z', unit = "mm" }
w = { value = 'zero_w', unit = "mm" }
"#;

const CAMPAIGN: &str = r#"
model = "bench.toml"
[measurands]
y = { sigma = "1 mm" }
z = { sigma = "1 mm" }
w = { sigma = "1 mm" }
[[runs]]
name = "there"
data = "there.csv"
"#;

const SIZE: &str = r#"size = { unit = "mm/m", typical = "3 mm/m", scope = "instrument" }"#;
const BEND: &str = r#"bend = { unit = "mm/m^2", typical = "3 mm/m^2", scope = "instrument" }"#;

fn effect(name: &str, parameters: &str, patch: &str) -> (String, String) {
    let text = format!(
        "name = \"{name}\"\ntitle = \"{name}\"\nacts = \"instrument\"\nabout = \"A form.\"\n\
         [parameters]\n{parameters}\n[patch]\n{patch}\n"
    );
    (format!("effects/{name}.toml"), text)
}

/// A slope of `y` and `w`, and a twist of `z` that bends `y`. A bow is a slope with a bend: beside the
/// slope alone it explains some of the twist, beside the twist nothing more than the slope.
fn found(seed: u64) -> Diagnosis {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut readings = String::from("time [s],place [m],y [mm],z [mm],w [mm]\n");
    for row in 0..200 {
        let x = f64::from(row) / 199.0;
        let noise: [f64; 3] = std::array::from_fn(|_| random.sample(StandardNormal));
        let [y, z, w] =
            [3.0 * x + 3.0 * x.powi(3) + noise[0], 3.0 * x + noise[1], 3.0 * x + noise[2]];
        writeln!(readings, "{row},{x},{y},{z},{w}").unwrap();
    }
    let slope = "y = 'y + size * place'\nw = 'w + size * place'";
    let bow = "y = 'y + size * place + bend * place^2'\nw = 'w + size * place + bend * place^2'";
    let twist = "y = 'y + size * place^3 / (1 m^2)'\nz = 'z + size * place'";
    diagnosed(&[
        ("bench.toml".to_owned(), MODEL.to_owned()),
        ("campaign.toml".to_owned(), CAMPAIGN.to_owned()),
        ("there.csv".to_owned(), readings),
        effect("slope", SIZE, slope),
        effect("bow", &format!("{SIZE}\n{BEND}"), bow),
        effect("twist", SIZE, twist),
    ])
}

#[test]
fn the_most_probable_of_aliases_is_the_row() {
    let mut exchanged = 0;
    for seed in 1..=12 {
        let found = found(seed);
        let rows: Vec<&str> = found.rows.iter().map(|row| row.name.as_str()).collect();
        let Some(row) = found.rows.iter().find(|row| row.name != "twist") else {
            unreachable!("{}", told(&found))
        };
        assert!(rows.len() == 2 && rows.contains(&"twist"), "{}", told(&found));
        // Where both are as probable, the one of the more typical size is the row.
        assert!(row.posterior > 0.4, "seed {seed}: {} {}", row.name, row.posterior);
        exchanged += usize::from(found.log.iter().any(|step| step.contains("for its alias bow")));
    }
    assert!(exchanged >= 2, "{exchanged}");
}
