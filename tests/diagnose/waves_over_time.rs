//! Waves over time: of a day, which are no noise with a memory, and of no time at all, which are none.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use homepoint::diagnose::budget::answer::Verdict;
use homepoint::engine::open::{Request, open};

use crate::drawn::run;
use crate::folder::Folder;
use crate::found::{names, told};
use crate::own_effects::Campaign;
use crate::stream::Stream;

/// A tilt meter on a dam, with a thermometer.
const DAM: &str = r#"
name = "dam"
title = "Tilt meter on a dam"
[inputs]
temperature = { unit = "K" }
level = { unit = "m" }
[parameters]
zero = { unit = "rad", scope = "rig" }
[quantities]
leaning = 'zero'
[measurands]
tilt = { value = 'leaning', unit = "rad" }
"#;
const PRESSED: (&str, &str, &str) = (
    "pressed",
    "by = { unit = \"rad/m\", typical = \"2 urad/m\", scope = \"rig\" }",
    "leaning = 'leaning + by * level'",
);

/// Twelve days, a reading every twenty minutes: the sun bends the dam, beside the water that leans on
/// it.
#[test]
fn a_wave_of_a_day_is_no_noise_that_remembers() {
    let mut random = Stream(97);
    let mut log = "time [s],temperature [K],level [m],tilt [rad]\n".to_owned();
    for row in 0..864 {
        let time = 1200.0 * f64::from(row);
        let level = 0.8 * (TAU * time / 4.1e5).sin() + 0.1 * random.normal();
        let day = 3e-6 * (TAU * time / 86_164.0 + 0.6).cos();
        let tilt = 2e-5 + 3e-6 * level + day + 1e-6 * random.normal();
        let temperature = 285.0 + random.normal();
        writeln!(log, "{time},{temperature:.2},{level:.4},{tilt:.9}").unwrap();
    }
    let measurands = "tilt = { sigma = \"1 urad\" }";
    let found = Campaign { model: DAM, effects: &[PRESSED], measurands, log }.diagnosed();
    assert_eq!(names(&found), ["pressed"], "{}", told(&found));
    assert_eq!(found.verdict, Verdict::PartlyExplained, "{}", told(&found));
    let words = &found.remainder[0].place.words;
    let period = words.strip_prefix("an error of `tilt` over time, a wave every ");
    let period = period.and_then(|rest| rest.strip_suffix(" s")?.parse::<f64>().ok());
    let period = period.unwrap_or_else(|| panic!("{}", told(&found)));
    assert!((period / 86_164.0 - 1.0).abs() < 0.01, "{period}");
    assert!(found.autocorrelation.is_empty(), "{}", told(&found));
}

/// A station that sees points at rest, in a table without times.
const STATION: &str = r#"
name = "station"
title = "Points seen from a station"
[inputs]
x = { unit = "m" }
y = { unit = "m" }
z = { unit = "m" }
[parameters]
zero = { unit = "rad", scope = "rig" }
position = { unit = "m", kind = "vector", scope = "rig", start = ["1 m", "1 m", "1 m"] }
[quantities]
seen = '[x, y, z] - position'
azimuth = 'atan2(seen.y, seen.x) - zero'
height = 'atan2(hypot(seen.x, seen.y), seen.z)'
[measurands]
horizontal = { value = 'azimuth', kind = "angle", unit = "rad" }
vertical = { value = 'height', kind = "angle", unit = "rad" }
distance = { value = 'norm(seen)', unit = "m" }
"#;
/// Where time stands still a wave over it is the same as a constant of each measurand, and would stand
/// for two effects at once.
#[test]
fn constants_of_two_measurands_are_no_oscillation_where_there_is_no_time() {
    let mut random = Stream(101);
    let mut log = "x [m],y [m],z [m],horizontal [rad],vertical [rad],distance [m]\n".to_owned();
    for _ in 0..45 {
        let mut along = |size: f64| size * (2.0 * random.uniform() - 1.0);
        let (x, y, z) = (along(60.0), along(60.0), along(25.0));
        let mut noise = |size: f64| size * random.normal();
        let horizontal = y.atan2(x) - 0.3 + noise(15e-6);
        let vertical = x.hypot(y).atan2(z) + 8e-5 + noise(15e-6);
        let distance = (x * x + y * y + z * z).sqrt() - 0.012 + noise(2e-3);
        writeln!(log, "{x:.4},{y:.4},{z:.4},{horizontal:.7},{vertical:.7},{distance:.4}").unwrap();
    }
    let measurands = "horizontal = { sigma = \"15 urad\" }\nvertical = { sigma = \"15 urad\" }\ndistance = { sigma = \"2 mm\" }";
    let found = Campaign { model: STATION, effects: &[], measurands, log }.diagnosed();
    let mut all = names(&found);
    all.sort_unstable();
    assert_eq!(all, ["distance_offset", "vertical_index"], "{}", told(&found));
    assert_eq!(found.verdict, Verdict::Explained, "{}", told(&found));
}

/// A tide with a period that nobody knows, seen in 24 short runs over a day: half a period is longer than
/// each run, but not than the campaign.
#[test]
fn a_wave_through_a_campaign_may_be_slower_than_its_runs() {
    let model = "name = \"gauge\"\ntitle = \"Tide gauge\"\n[inputs]\nlevel = { unit = \"m\" }\n\
         [parameters]\nzero = { unit = \"m\", scope = \"rig\" }\n[quantities]\nheight = 'level + zero'\n\
         [measurands]\nread = { value = 'height', unit = \"m\" }\n";
    let tide = "name = \"tide\"\ntitle = \"Tide\"\nacts = \"arm\"\n[parameters]\n\
         co = { unit = \"m\", typical = \"10 mm\", scope = \"rig\" }\n\
         si = { unit = \"m\", typical = \"10 mm\", scope = \"rig\" }\n\
         [shape]\nfrequency = { unit = \"Hz\", from = \"1e-5 Hz\", to = \"1e-4 Hz\" }\n\
         [patch]\nheight = 'height + co * cos(2 * pi * frequency * time) + si * sin(2 * pi * frequency * time)'\n";
    let mut campaign =
        "title = \"Day\"\nmodel = \"model.toml\"\n[measurands]\nread = { sigma = \"2 mm\" }\n"
            .to_owned();
    let mut random = Stream(113);
    let mut files = vec![
        ("model.toml".to_owned(), model.to_owned()),
        ("effects/tide.toml".to_owned(), tide.to_owned()),
    ];
    for number in 0..24 {
        let mut log = "time [s],level [m],read [m]\n".to_owned();
        for row in 0..40 {
            let time = 3600.0 * f64::from(number) + 5.0 * f64::from(row);
            let level = 0.5 * random.uniform();
            let wave = 0.02 * (TAU * 2.315e-5 * time - 1.1).cos();
            writeln!(log, "{time},{level:.4},{:.5}", level + 0.3 + wave + 2e-3 * random.normal())
                .unwrap();
        }
        files.push((format!("{number}.csv"), log));
        writeln!(campaign, "[[runs]]\nname = \"{number}\"\ndata = \"{number}.csv\"").unwrap();
    }
    files.push(("campaign.toml".to_owned(), campaign));
    let files: Vec<(&str, &str)> = files.iter().map(|(a, b)| (a.as_str(), b.as_str())).collect();
    let folder = Folder::new("tide", &files);
    let opened = open(&Request::new([&*folder])).unwrap();
    let found = run(opened.problem.clone(), &opened);
    assert_eq!(names(&found), ["tide"], "{}", told(&found));
    assert_eq!(found.verdict, Verdict::Explained, "{}", told(&found));
}
