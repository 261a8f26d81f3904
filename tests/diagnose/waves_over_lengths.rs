//! Waves over a way of hundreds of metres, as a rail makes them from one support to the next: there is room
//! for more fine waves than can be tried.

use homepoint::diagnose::budget::answer::Verdict;

use crate::found::told;
use crate::stream::Stream;
use crate::written::diagnosed;

const MODEL: &str = r#"
name = "rail"
title = "Height of a rail"
[inputs]
position = { unit = "m", signal = true }
design = { unit = "m", signal = true }
cant = { unit = "m" }
[parameters]
zero = { unit = "m", scope = "rig" }
[quantities]
hangs = 'design + zero'
[measurands]
height = { value = 'hangs', unit = "m" }
"#;

#[test]
fn a_wave_over_a_long_way_has_its_length() {
    for (seed, length) in [(1, 4.0), (2, 1.7), (3, 2.6)] {
        let mut random = Stream(seed);
        let mut files = vec![("model.toml".to_owned(), MODEL.to_owned())];
        let mut campaign = "title = \"Rail\"\nmodel = \"model.toml\"\n[parameters]\n\"height.delay\" = { value = \"0 ms\", sigma = \"5 ms\" }\n[measurands]\nheight = { sigma = \"3 mm\" }\n".to_owned();
        for run in 0..2 {
            campaign += &format!(
                "[[runs]]\nname = \"r{run}\"\ndata = \"r{run}.csv\"\nsignals = [\"s{run}.csv\"]\n"
            );
            let mut stream = "time [s],position [m],design [m]\n".to_owned();
            let mut log = "time [s],cant [m],height [m]\n".to_owned();
            let mut position = 0.0;
            for step in -20..3620 {
                let t = 0.05 * f64::from(step);
                let speed = 5.0 + 1.5 * (t / 11.0).sin() + 0.5 * (t / 4.6 + f64::from(run)).sin();
                position += 0.05 * speed;
                let design = 5.3 + 0.03 * (t / 14.0).sin();
                stream += &format!("{t:.2},{position:.4},{design:.4}\n");
                // One row in twenty is missing.
                if (0..3600).contains(&step) && step % 2 == 0 && step % 38 != 4 {
                    let cant = 0.025 * (t / 13.0).cos();
                    let wave = 4.3e-3 * (std::f64::consts::TAU * position / length).sin();
                    let height = design + 0.012 + wave + 3e-3 * random.normal();
                    log += &format!("{t:.2},{cant:.4},{height:.5}\n");
                }
            }
            files.push((format!("s{run}.csv"), stream));
            files.push((format!("r{run}.csv"), log));
        }
        files.push(("campaign.toml".to_owned(), campaign));
        let found = diagnosed(&files);
        assert_eq!(found.verdict, Verdict::Unknown, "{seed}: {}", told(&found));
        let [part] = &found.remainder[..] else { panic!("{seed}: {}", told(&found)) };
        let words = &part.place.words;
        let number = words.split("over position, ").nth(1).and_then(|one| one.split(' ').next());
        let waves: f64 = number.unwrap_or_else(|| panic!("{words}")).parse().unwrap();
        assert!((waves * length - 1.0).abs() < 0.01, "{seed}: {words}");
        assert!(found.autocorrelation.is_empty(), "{seed}: {}", told(&found));
    }
}
