//! A clock that runs fast or slow: through all runs of one recording, or anew in each.

use std::fmt::Write as _;

use homepoint::diagnose::Diagnosis;
use homepoint::engine::open::{Request, open};
use homepoint::report::diagnosis_text::{Asked, text};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::drawn::run;
use crate::found::{names, told};

/// When each run begins and ends (s).
const RUNS: [(f64, f64); 3] = [(15.0, 75.0), (120.0, 200.0), (210.0, 260.0)];

/// How a slider moves.
fn place(t: f64) -> f64 {
    0.5 * (0.61 * t).sin() + 0.3 * (1.73 * t + 0.8).sin() + 0.2 * (0.19 * t).sin()
}

/// What the stamps of a run do.
#[derive(Clone, Copy)]
enum Clock {
    /// Slow by this share since the recording began.
    Continuous(f64),
    /// Slow by this share since the run began.
    Anew(f64),
    /// Late by so much in each run (s).
    Restarted([f64; 3]),
}

/// Diagnoses readings every 80 ms, 30 ms late; with `from_zero` the times of each run begin at zero.
fn diagnosed(clock: Clock, from_zero: bool, seed: u64) -> Diagnosis {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut campaign = "title = \"Slider\"\nmodel = \"model.toml\"\n\
         [measurands]\nreading = { sigma = \"0.2 mm\" }\n"
        .to_owned();
    for (run, (begin, end)) in RUNS.into_iter().enumerate() {
        let zero = if from_zero { begin } else { 0.0 };
        let mut stream = "time [s],x [m]\n".to_owned();
        let mut readings = "time [s],reading [m]\n".to_owned();
        let mut t = begin - 2.0;
        while t < end + 2.0 {
            writeln!(stream, "{:.3},{:.8}", t - zero, place(t)).unwrap();
            t += 0.02;
        }
        t = begin;
        while t < end {
            let late = match clock {
                Clock::Continuous(rate) => rate * t,
                Clock::Anew(rate) => rate * (t - begin),
                Clock::Restarted(late) => late[run],
            };
            let noise: f64 = StandardNormal.sample(&mut random);
            let stamp = t - 0.03 - late - zero;
            writeln!(readings, "{stamp:.7},{:.8}", place(t) + 0.1 + 2e-4 * noise).unwrap();
            t += 0.08;
        }
        write(&format!("stream_{run}.csv"), &stream);
        write(&format!("readings_{run}.csv"), &readings);
        writeln!(
            campaign,
            "[[runs]]\nname = \"{run}\"\ndata = \"readings_{run}.csv\"\nsignals = [\"stream_{run}.csv\"]"
        )
        .unwrap();
    }
    write(
        "model.toml",
        "name = \"slider\"\ntitle = \"A scale on a slider\"\n\
         [inputs]\nx = { unit = \"m\", signal = true }\n\
         [parameters]\noffset = { unit = \"m\" }\n\
         [measurands]\nreading = { value = 'x + offset', unit = \"m\" }\n",
    );
    write("campaign.toml", &campaign);
    let opened = open(&Request::new([folder.path().to_owned()])).unwrap();
    run(opened.problem.clone(), &opened)
}

/// The value of the first row (the rate of the instrument's clock by its own stamps) and its
/// standard uncertainty.
fn rate(found: &Diagnosis) -> (f64, f64) {
    let value = &found.rows[0].values[0];
    (value.value.unwrap(), value.sigma.unwrap())
}

#[test]
fn a_clock_that_is_not_set_between_runs_has_one_rate() {
    for (seed, slow) in [2e-5, -3e-4, 2e-3].into_iter().enumerate() {
        let found = diagnosed(Clock::Continuous(slow), false, 60 + seed as u64);
        assert_eq!(names(&found), ["clock_drift_continuous"], "{}", told(&found));
        assert!(!found.verdict.has_remainder(), "{}", told(&found));
        // By the stamps, which count slower than the time does.
        let (value, sigma) = rate(&found);
        assert!((value - slow / (1.0 - slow)).abs() < 4.0 * sigma, "{value} {sigma}");
        assert!(sigma < 1e-6, "{sigma}");
    }
}

#[test]
fn a_clock_that_begins_anew_in_each_run_is_another_effect() {
    let found = diagnosed(Clock::Anew(3e-4), false, 70);
    assert_eq!(names(&found), ["clock_drift"], "{}", told(&found));
    assert!(!found.verdict.has_remainder(), "{}", told(&found));
}

/// A recorder that was started anew for each run: no rate of a clock, but a delay for each run, and how to
/// state it.
#[test]
fn a_delay_that_differs_between_runs_is_the_next_step() {
    let found = diagnosed(Clock::Restarted([0.004, -0.007, 0.011]), false, 72);
    assert_eq!(names(&found), [""; 0], "{}", told(&found));
    assert_eq!(found.remainder[0].place.delayed_by_run(), Some("reading"), "{}", told(&found));
    let text = text("", &found, &Asked::default());
    let due = "Next: give `reading.delay` a value for each run (`\"reading.delay\" = { scope = \"run\" }`) in [parameters], and diagnose again.";
    assert!(text.contains(due), "{text}");
}

/// Runs whose times all begin at zero: one effect, not two by the same form.
#[test]
fn runs_that_are_not_in_sequence_have_no_common_time() {
    let found = diagnosed(Clock::Anew(3e-4), true, 71);
    assert_eq!(names(&found), ["clock_drift"], "{}", told(&found));
    let out = found.not_testable.iter().find(|one| one.name == "clock_drift_continuous");
    assert!(out.unwrap().why.contains("not in sequence"), "{}", told(&found));
    assert!(found.rows[0].confounded.iter().all(|one| !one.name.contains("continuous")));
}
