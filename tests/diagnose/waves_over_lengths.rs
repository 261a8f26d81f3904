//! Waves over a way of hundreds of metres, as a rail makes them from one support to the next: there is room
//! for more fine waves than can be tried.

use homepoint::diagnose::budget::answer::Verdict;

use crate::found::told;
use crate::own_effects::Campaign;
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

const AXIS: &str = r#"
name = "axis"
title = "Place of a carriage"
[inputs]
sent = { unit = "m" }
[parameters]
gain = { unit = "1", scope = "rig", start = "1" }
zero = { unit = "m", scope = "run" }
[measurands]
seen = { value = 'gain * sent + zero', unit = "m" }
"#;

/// An axis at stops that are as far apart as this (m), or nearly so, three times over in no order; with a
/// wave of so many a metre. What is found, as a part of that.
fn found_of(seed: u64, (spacing, off): (f64, f64), waves: f64) -> f64 {
    let mut random = Stream(seed);
    let mut log = "time [s],sent [m],seen [m]\n".to_owned();
    for row in 0..303_i32 {
        let sent = spacing * f64::from(row * row * row % 101) + off * random.normal();
        let wave = 3e-6 * (std::f64::consts::TAU * waves * sent + 0.7).sin();
        let seen = sent + wave + 1.2e-6 * random.normal();
        log += &format!("{},{sent:.9},{seen:.9}\n", 2 * row);
    }
    let campaign = "title = \"Axis\"\nmodel = \"model.toml\"\n[measurands]\nseen = { sigma = \"1.2 um\" }\n[[runs]]\nname = \"a\"\ndata = \"a.csv\"\n";
    let files = [("model.toml", AXIS), ("a.csv", &log), ("campaign.toml", campaign)];
    let found = diagnosed(&files.map(|(name, text)| (name.to_owned(), text.to_owned())));
    assert_eq!(found.verdict, Verdict::Unknown, "{seed}: {}", told(&found));
    let words = &found.remainder[0].place.words;
    let number = words.split(", ").nth(1).and_then(|one| one.split(" waves a metre").next());
    let number = number.and_then(|one| one.parse::<f64>().ok());
    number.unwrap_or_else(|| panic!("{seed}: {words}")) / waves
}

/// At stops of an even spacing a wave is a finer one, too: the longest is named.
#[test]
fn at_even_stops_the_longest_wave_is_named() {
    for (seed, off, waves) in [(5, 0.0, 8.0), (6, 2e-5, 8.0), (7, 1e-4, 13.0), (8, 0.0, 33.0)] {
        let part = found_of(seed, (0.01, off), waves);
        assert!((part - 1.0).abs() < 0.01, "{seed}: {part}");
    }
}

/// Over 60 m of a rail a wave may be 12.5 m long, over 0.8 m of a belt 2 mm, over 0.1 mm of a scale 20 µm.
#[test]
fn long_ways_have_long_waves_and_short_ones_short_waves() {
    for (seed, spacing, waves) in [(9, 0.6, 0.08), (11, 8e-3, 500.0), (10, 1e-6, 50_000.0)] {
        let part = found_of(seed, (spacing, 0.2 * spacing), waves);
        assert!((part - 1.0).abs() < 0.01, "{seed}: {part}");
    }
}

const BELT: &str = r#"
name = "belt"
title = "Parcels on a belt"
[inputs]
lines = { unit = "count" }
[parameters]
pitch = { unit = "m", scope = "rig", start = "0.0002 m" }
zero = { unit = "m", scope = "rig" }
[measurands]
place = { value = 'pitch * lines + zero', unit = "m" }
"#;

/// A splice comes around every 43,600 lines, at speeds that vary.
#[test]
fn a_wave_over_what_is_counted_has_its_period() {
    for seed in 21..=22 {
        let mut random = Stream(seed);
        let mut log = "lines [count],place [m]\n".to_owned();
        let mut lines: f64 = 40.0;
        for row in 0..900 {
            lines +=
                (400.0 + 150.0 * (f64::from(row) / 37.0).sin() + 60.0 * random.normal()).round();
            let wave = 1.4e-3 * (std::f64::consts::TAU * lines / 43_600.0 + 0.7).sin();
            let place = 2.01e-4 * lines + 0.3 + wave + 6e-4 * random.normal();
            log += &format!("{lines},{place:.5}\n");
        }
        let measurands = "place = { sigma = \"0.6 mm\" }";
        let found = Campaign { model: BELT, effects: &[], measurands, log }.diagnosed();
        assert_eq!(found.verdict, Verdict::Unknown, "{seed}: {}", told(&found));
        let [part] = &found.remainder[..] else { panic!("{seed}: {}", told(&found)) };
        let period = part.place.words.split("over lines, a wave every ").nth(1).unwrap();
        let period: f64 = period.parse().unwrap();
        assert!((period / 43_600.0 - 1.0).abs() < 0.02, "{seed}: {period}");
    }
}
