//! A load cell behind a spring: its counts follow a travel that is logged, some of them are wrong.

use std::f64::consts::TAU;
use std::fmt::Write;
use std::path::Path;

use super::stream::Stream;

/// The cell's stamp plus this is the moment on the clock of the travel (s).
pub(crate) const DELAY: f64 = -0.11;
/// Counts per metre of travel.
pub(crate) const GAIN: f64 = 9.7e6;
/// What a converter sends where it has no value.
const CODES: [f64; 6] = [8_388_607.0, 4_194_303.0, 2_097_151.0, 1_048_575.0, 0.0, -1.0];

const MODEL: &str = r#"
name = "cell"
title = "Load cell"
[inputs]
travel = { unit = "m", signal = true }
[parameters]
tare = { unit = "counts", scope = "rig" }
gain = { unit = "counts/m", scope = "rig", start = "START counts/m" }
[measurands]
raw = { value = 'tare + gain * travel', unit = "counts" }
"#;

const CAMPAIGN: &str = r#"
title = "Load cell"
model = "model.toml"
[measurands]
raw = { sigma = "150 counts" }
[[runs]]
name = "a"
data = "log.csv"
signals = ["travel.csv"]
"#;

/// What is drawn, and what is stated.
pub(crate) struct LoadCell {
    pub(crate) seed: u64,
    /// The share of readings that are doubled or a code.
    pub(crate) wrong: f64,
    /// Where the gain is said to start.
    pub(crate) start: f64,
}

impl Default for LoadCell {
    fn default() -> Self {
        Self { seed: 1, wrong: 0.0, start: 1e6 }
    }
}

impl LoadCell {
    /// Writes its campaign into a folder; how many readings are wrong.
    pub(crate) fn written(&self, folder: &Path) -> usize {
        let mut random = Stream(self.seed);
        let waves: Vec<[f64; 3]> = (0..7)
            .map(|_| {
                let hertz = 0.03 + 0.37 * random.uniform();
                let phase = TAU * random.uniform();
                [hertz, phase, 8.3e-3 * (0.5 + 0.5 * random.uniform())]
            })
            .collect();
        let place = |t: f64| {
            let wave = |[hertz, phase, size]: &[f64; 3]| size * (TAU * hertz * t + phase).sin();
            0.04 + waves.iter().map(wave).sum::<f64>()
        };
        let mut travel = "time [s],travel [m]\n".to_owned();
        for i in 0..7700 {
            let t = 0.02 * f64::from(i) - 2.0;
            writeln!(travel, "{t:.2},{:.7}", place(t)).unwrap();
        }
        let (mut log, mut wrong) = ("time [s],raw [counts]\n".to_owned(), 0);
        for i in 0..1480 {
            let t = 0.1 * f64::from(i);
            let right = 84_000.0 + GAIN * place(t + DELAY) + 160.0 * random.normal();
            let is_wrong = (20..1460).contains(&i) && random.uniform() < self.wrong;
            wrong += usize::from(is_wrong);
            let raw = match (is_wrong, wrong % 2) {
                (false, _) => right,
                (true, 0) => 2.0 * right,
                (true, _) => CODES[wrong / 2 % CODES.len()],
            };
            writeln!(log, "{t:.1},{raw:.0}").unwrap();
        }
        let model = MODEL.replace("START", &self.start.to_string());
        let files = [("travel.csv", &*travel), ("log.csv", &log), ("model.toml", &model)];
        for (name, text) in files.into_iter().chain([("campaign.toml", CAMPAIGN)]) {
            std::fs::write(folder.join(name), text).unwrap();
        }
        wrong
    }
}
