//! One run of several carries what distinguishes two effects: the other runs leave the values of both
//! uncertain, and what they predict of that run is wide, not wrong.

use homepoint::diagnose::budget::answer::Verdict;

use crate::found::{names, told};
use crate::stream::Stream;
use crate::written::diagnosed;

const MODEL: &str = r#"
name = "lift"
title = "Cabin of a lift beside the encoder of its drum"
[inputs]
height = { unit = "m" }
load = { unit = "kg" }
shaft = { unit = "K" }
[parameters]
zero = { unit = "m", scope = "rig" }
gain = { unit = "1", scope = "rig", start = "1" }
[quantities]
cabin = 'zero + gain * height'
[measurands]
laser = { value = 'cabin', unit = "m" }
"#;
/// Name, unit, typical size, form, and the value that is put in.
const EFFECTS: [(&str, &str, &str, &str, f64); 3] = [
    ("stretch", "1/kg", "3e-7", "load * (60 m - height)", 3.0e-7),
    ("springs", "m/kg", "5e-6", "load", 8.0e-6),
    ("warmth", "1/K", "12e-6", "(shaft - 288.15 K) * (60 m - height)", 1.3e-5),
];

#[test]
fn effects_of_which_one_run_carries_the_contrast_are_named() {
    for seed in 1..5 {
        let mut random = Stream(seed);
        let mut files = vec![("model.toml".to_owned(), MODEL.to_owned())];
        for (name, unit, typical, form, _) in EFFECTS {
            files.push((
                format!("effects/{name}.toml"),
                format!(
                    "name = \"{name}\"\ntitle = \"{name}\"\nacts = \"arm\"\n[parameters]\nk = {{ unit = \"{unit}\", typical = \"{typical} {unit}\", scope = \"rig\" }}\n[patch]\ncabin = 'cabin - k * {form}'\n"
                ),
            ));
        }
        let mut campaign = "title = \"Lift\"\nmodel = \"model.toml\"\n[measurands]\nlaser = { sigma = \"1 mm\" }\n".to_owned();
        for run in 0..5 {
            campaign += &format!("[[runs]]\nname = \"r{run}\"\ndata = \"r{run}.csv\"\n");
            let mut log = "time [s],height [m],load [kg],shaft [K],laser [m]\n".to_owned();
            let phase = 6.0 * random.uniform();
            for row in 0..300 {
                let height = 30.0 + 29.0 * (0.07 * f64::from(row) + phase).sin();
                let load = if run == 3 { 620.0 } else { 78.0 } + 4.0 * random.normal();
                let shaft = 285.0 + 2.2 * f64::from(run) + 3.0 * (0.02 * f64::from(row)).sin();
                let below = 60.0 - height;
                let [stretch, springs, warmth] = EFFECTS.map(|one| one.4);
                let cabin = 0.35 + 1.0007 * height
                    - stretch * load * below
                    - springs * load
                    - warmth * (shaft - 288.15) * below;
                let laser = cabin + 1e-3 * random.normal();
                let time = 1000 * run + 2 * row;
                log += &format!("{time},{height:.6},{load:.3},{shaft:.4},{laser:.6}\n");
            }
            files.push((format!("r{run}.csv"), log));
        }
        files.push(("campaign.toml".to_owned(), campaign));
        let found = diagnosed(&files);
        assert_eq!(found.verdict, Verdict::Explained, "{seed}: {}", told(&found));
        let mut named = names(&found);
        named.sort_unstable();
        assert_eq!(named, ["springs", "stretch", "warmth"], "{seed}: {}", told(&found));
        for (name, .., due) in EFFECTS {
            let row = found.rows.iter().find(|row| row.name == name).unwrap();
            let value = &row.values[0];
            let far = (value.value.unwrap() - due) / value.sigma.unwrap();
            assert!(far.abs() < 4.0, "{seed}: {name} {far}");
        }
    }
}
