//! Gyroscopes beside a turntable whose angle is a noisy stream: what the smoothed stream brings into
//! the readings is noise, and what an unmodelled effect brings is not.

use std::fmt::Write as _;
use std::path::Path;

use homepoint::diagnose::Diagnosis;
use homepoint::diagnose::budget::answer::Verdict;
use homepoint::engine::open::{Request, open};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::drawn::run;
use crate::found::told;

const PI: f64 = std::f64::consts::PI;

/// The rate of the turntable, and its second derivative.
fn rate(t: f64) -> [f64; 2] {
    let wave = |amplitude: f64, hertz: f64, phase: f64| {
        let omega = 2.0 * PI * hertz;
        let rate = amplitude * omega * (omega * t + phase).cos();
        [rate, -omega * omega * rate]
    };
    let (slow, fast) = (wave(1.2, 0.3, 0.0), wave(0.4, 0.8, 1.0));
    [slow[0] + fast[0], slow[1] + fast[1]]
}

fn angle(t: f64) -> f64 {
    1.2 * (2.0 * PI * 0.3 * t).sin() + 0.4 * (2.0 * PI * 0.8 * t + 1.0).sin()
}

/// Writes a campaign whose readings are off by `error` times the acceleration of the rate, and
/// diagnoses it.
fn campaign(folder: &Path, smooth: &str, error: f64, seed: u64) -> Diagnosis {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = |sigma: f64| -> f64 {
        let drawn: f64 = StandardNormal.sample(&mut random);
        sigma * drawn
    };
    let mut table = "time [s],angle [rad]\n".to_owned();
    for i in 0..3200 {
        let t = 0.01 * f64::from(i);
        writeln!(table, "{t:.3},{:.6}", angle(t) + normal(1e-4)).unwrap();
    }
    let mut gyro = "time [s],gyro [rad/s]\n".to_owned();
    for i in 0..3000 {
        let t = 1.003 + 0.01 * f64::from(i);
        let [rate, acceleration] = rate(t + 0.012);
        let reading = rate + 0.005 + error * acceleration + normal(3e-3);
        writeln!(gyro, "{t:.3},{reading:.6}").unwrap();
    }
    let model = format!(
        "name = \"gyro\"\ntitle = \"A gyroscope on a turntable\"\n\
         [inputs]\nangle = {{ unit = \"rad\", signal = true, smooth = \"{smooth}\" }}\n\
         [parameters]\nbias = {{ unit = \"rad/s\", scope = \"instrument\" }}\n\
         [measurands]\ngyro = {{ value = 'rate(angle) + bias', unit = \"rad/s\" }}\n"
    );
    let text = "title = \"Turntable\"\nmodel = \"model.toml\"\n\
                [measurands]\ngyro = { sigma = \"3 mrad/s\" }\n\
                [[runs]]\nname = \"a\"\ndata = \"gyro.csv\"\nsignals = [\"table.csv\"]\n";
    for (name, text) in [
        ("table.csv", table.as_str()),
        ("gyro.csv", &gyro),
        ("model.toml", &model),
        ("campaign.toml", text),
    ] {
        std::fs::write(folder.join(name), text).unwrap();
    }
    let opened = open(&Request::new([folder])).unwrap();
    run(opened.problem.clone(), &opened)
}

/// Where samples are kept does not matter.
#[test]
fn a_smoothed_stream_beside_samples_in_a_file_gives_the_same_diagnosis() {
    let folder = tempfile::tempdir().unwrap();
    let in_memory = campaign(folder.path(), "0.12 s", 5e-5, 6);
    let opened = open(&Request { memory: Some(1), ..Request::new([folder.path()]) }).unwrap();
    assert!(opened.problem.parts[0].runs[0].record.is_spilled());
    let in_file = run(opened.problem.clone(), &opened);
    assert_eq!(told(&in_memory), told(&in_file));
    let gains = |found: &Diagnosis| -> Vec<u64> {
        found.remainder.iter().map(|one| one.gain.gain.to_bits()).collect()
    };
    assert_eq!(gains(&in_memory), gains(&in_file));
}

#[test]
fn the_noise_of_a_smoothed_stream_is_no_structure() {
    for (smooth, seed) in [("0.06 s", 1), ("0.06 s", 2), ("0.12 s", 3), ("0.12 s", 4)] {
        let folder = tempfile::tempdir().unwrap();
        let found = campaign(folder.path(), smooth, 0.0, seed);
        let is_noise = matches!(found.verdict, Verdict::Adequate | Verdict::Explained);
        assert!(is_noise && found.rows.is_empty(), "{smooth} {seed}: {}", told(&found));
    }
}

/// An error over the acceleration is seen as before, though that has the stream's noise, too: where it
/// is mostly noise, as the oscillation that most of the motion is.
#[test]
fn an_error_over_the_acceleration_of_a_smoothed_stream_is_seen() {
    for (smooth, seed) in [("0.06 s", 5), ("0.12 s", 6)] {
        let folder = tempfile::tempdir().unwrap();
        let found = campaign(folder.path(), smooth, 5e-5, seed);
        assert_eq!(found.verdict, Verdict::Unknown, "{smooth} {seed}: {}", told(&found));
        let words = &found.remainder[0].place.words;
        let is_seen = ["acceleration", "0.8 Hz"].iter().any(|one| words.contains(one));
        assert!(is_seen, "{smooth} {seed}: {}", told(&found));
    }
}
