//! A motion that repeats, beside a clock that is off by much: without the clock's rate the best delay is
//! that of another cycle, and with it the right one is found again.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use homepoint::diagnose::budget::answer::Verdict;

use crate::found::told;
use crate::stream::Stream;
use crate::written::diagnosed;

const MODEL: &str = r#"
name = "carriage"
title = "Carriage"
[inputs]
x = { unit = "m", signal = true }
[parameters]
zero = { unit = "m", scope = "rig" }
[quantities]
shown = 'x + zero'
[measurands]
y = { value = 'shown', unit = "m" }
"#;
const CAMPAIGN: &str = r#"
title = "Carriage"
model = "model.toml"
delay_range = "10 s"
[measurands]
y = { sigma = "1 mm" }
[[runs]]
name = "a"
data = "rig.csv"
signals = ["ref.csv"]
"#;
/// The rate error of the clock, and the delay (s).
const RATE: f64 = 0.02;
const DELAY: f64 = 5.0;

/// Every nine seconds nearly the same.
fn place(t: f64) -> f64 {
    let w = TAU * t / 9.0;
    w.sin() + 0.4 * (3.0 * w + 0.5).sin() + 0.2 * (5.0 * w).cos() + 0.01 * (TAU * t / 71.0).sin()
}

#[test]
fn a_clock_is_found_beside_a_motion_that_repeats() {
    for seed in [1, 2] {
        let mut random = Stream(seed);
        let mut stream = "time [s],x [m]\n".to_owned();
        for step in -300..6800 {
            let t = 0.05 * f64::from(step);
            writeln!(stream, "{t:.3},{:.7}", place(t)).unwrap();
        }
        let mut log = "time [s],y [m]\n".to_owned();
        for step in 0..3000 {
            let t = 0.1 * f64::from(step);
            let y = place(t * (1.0 + RATE) + DELAY) + 1e-3 * random.normal();
            writeln!(log, "{t:.3},{y:.6}").unwrap();
        }
        let files = [
            ("model.toml", MODEL.to_owned()),
            ("campaign.toml", CAMPAIGN.to_owned()),
            ("ref.csv", stream),
            ("rig.csv", log),
        ];
        let found = diagnosed(&files.map(|(name, text)| (name.to_owned(), text)));
        assert_eq!(found.verdict, Verdict::Explained, "{seed}: {}", told(&found));
        let [row] = found.rows.as_slice() else { panic!("{seed}: {}", told(&found)) };
        let clocks = ["sample_clock_rate", "clock_drift"];
        assert!(clocks.contains(&row.name.as_str()), "{seed}: {}", told(&found));
        let value = &row.values[0];
        let far = (value.value.unwrap() - RATE) / value.sigma.unwrap();
        assert!(far.abs() < 4.0, "{seed}: {far}");
    }
}
