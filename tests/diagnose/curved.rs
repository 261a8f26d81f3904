//! Effects that a delay absorbs to first order are found where they are large: readings pass an
//! exact low-pass filter, whose response to waves is known in closed form.

use std::fmt::Write as _;
use std::path::Path;

use homepoint::diagnose::budget::answer::Verdict;
use homepoint::diagnose::library::wanted::Wanted;
use homepoint::diagnose::{Diagnosis, diagnose};
use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::Options;

use crate::found::{names, told};
use crate::stream::Stream;

/// Angular frequency and amplitude of the waves of the command.
const WAVES: [(f64, f64); 3] = [(2.5, 0.9), (6.9, 0.3), (14.5, 0.1)];

/// The command, and its second derivative.
fn command(t: f64) -> [f64; 2] {
    let of = |(omega, amplitude): (f64, f64)| amplitude * (omega * t + omega).sin();
    let all = WAVES.into_iter();
    [all.clone().map(of).sum(), all.map(|one| -one.0 * one.0 * of(one)).sum()]
}

/// The command behind a filter with this time constant.
fn filtered(t: f64, lag: f64) -> f64 {
    let of = |(omega, amplitude): (f64, f64)| {
        let x: f64 = omega * lag;
        amplitude / x.hypot(1.0) * (omega * t + omega - x.atan()).sin()
    };
    WAVES.into_iter().map(of).sum()
}

/// Writes a campaign of angles that follow a command 6 ms late, and diagnoses it.
fn diagnosed(folder: &Path, readings: &[&dyn Fn(f64) -> f64], seed: u64) -> Diagnosis {
    diagnosed_with(folder, readings, seed, &Wanted::default())
}

fn diagnosed_with(
    folder: &Path,
    readings: &[&dyn Fn(f64) -> f64],
    seed: u64,
    wanted: &Wanted,
) -> Diagnosis {
    let mut random = Stream(seed);
    let names = &["q", "p"][..readings.len()];
    let each =
        |line: &dyn Fn(&str) -> String| names.iter().map(|name| line(name)).collect::<String>();
    let mut sent = "time [s],sent [rad]\n".to_owned();
    let mut read = format!("time [s]{}\n", each(&|name| format!(",{name} [rad]")));
    for i in 0..5000 {
        let t = 0.004 * f64::from(i);
        writeln!(sent, "{t:.3},{:.9}", command(t)[0]).unwrap();
        if (100..4900).contains(&i) {
            write!(read, "{t:.3}").unwrap();
            for reading in readings {
                write!(read, ",{:.9}", reading(t - 0.006) + 5e-5 * random.normal()).unwrap();
            }
            read.push('\n');
        }
    }
    let model = format!(
        "name = \"joint\"\ntitle = \"Joints follow a command\"\n\
         [inputs]\nsent = {{ unit = \"rad\", signal = true }}\n[measurands]\n{}\
         [delays]\nline = {{ of = {names:?} }}\n",
        each(&|name| {
            format!("{name} = {{ value = 'sent', kind = \"angle\", unit = \"rad\" }}\n")
        })
    );
    let text = format!(
        "title = \"Joint\"\nmodel = \"model.toml\"\ndelay_range = \"50 ms\"\n[measurands]\n{}\
         [[runs]]\nname = \"a\"\ndata = \"read.csv\"\nsignals = [\"sent.csv\"]\n",
        each(&|name| format!("{name} = {{ sigma = \"50 urad\" }}\n"))
    );
    for (name, text) in [
        ("sent.csv", sent.as_str()),
        ("read.csv", &read),
        ("model.toml", &model),
        ("campaign.toml", &text),
    ] {
        std::fs::write(folder.join(name), text).unwrap();
    }
    let opened = open(&Request::new([folder])).unwrap();
    diagnose(opened.problem, opened.recipes, wanted, &Options::default()).unwrap()
}

#[test]
fn a_low_pass_filter_is_named_with_its_time_constant_and_the_delay_beside_it() {
    for (lag, seed) in [(0.012, 1), (0.025, 2), (0.04, 3)] {
        let folder = tempfile::tempdir().unwrap();
        let found = diagnosed(folder.path(), &[&|t| filtered(t, lag)], seed);
        assert_eq!(names(&found), ["first_order_lowpass"], "{lag}: {}", told(&found));
        assert_eq!(found.verdict, Verdict::Explained, "{lag}: {}", told(&found));
        let value = &found.rows[0].values[0];
        let (estimate, u) = (value.value.unwrap(), value.sigma.unwrap());
        assert!((estimate - lag).abs() < 4.0 * u && u < 0.01 * lag, "{lag}: {estimate} {u}");
    }
}

/// Two axes behind filters of their own: a lag in proportion to acceleration may have a value for each
/// angle, and so may the filter.
#[test]
fn filters_of_two_axes_have_a_time_constant_each() {
    let folder = tempfile::tempdir().unwrap();
    let lags = [0.012, 0.03];
    let readings: [&dyn Fn(f64) -> f64; 2] = [&|t| filtered(t, lags[0]), &|t| filtered(t, lags[1])];
    let found = diagnosed(folder.path(), &readings, 6);
    assert_eq!(names(&found), ["first_order_lowpass"], "{}", told(&found));
    let values = &found.rows[0].values;
    assert_eq!(values.len(), 2, "{}", told(&found));
    for (value, lag) in values.iter().zip(lags) {
        let (estimate, u) = (value.value.unwrap(), value.sigma.unwrap());
        assert!((estimate - lag).abs() < 4.0 * u && u < 0.01 * lag, "{lag}: {estimate} {u}");
    }
}

/// What lags in proportion to its acceleration alone is no filter.
#[test]
fn a_lag_in_proportion_to_acceleration_is_not_taken_for_a_filter() {
    for (lag, seed) in [(-3e-4, 4), (3e-4, 5)] {
        let folder = tempfile::tempdir().unwrap();
        let found = diagnosed(folder.path(), &[&|t| command(t)[0] - lag * command(t)[1]], seed);
        assert_eq!(names(&found), ["servo_acceleration_lag"], "{lag}: {}", told(&found));
    }
}

/// Where the filter alone is asked for, no other effect enters beside which it would be tried.
#[test]
fn a_filter_is_found_where_it_alone_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let only = Wanted::new(&["first_order_lowpass".to_owned()], &[]);
    let found = diagnosed_with(folder.path(), &[&|t| filtered(t, 0.025)], 4, &only);
    assert_eq!(names(&found), ["first_order_lowpass"], "{}", told(&found));
    assert_eq!(found.verdict, Verdict::Explained, "{}", told(&found));
    let value = &found.rows[0].values[0];
    let (estimate, u) = (value.value.unwrap(), value.sigma.unwrap());
    assert!((estimate - 0.025).abs() < 4.0 * u && u < 2.5e-4, "{estimate} {u}");
}

/// An error of the angle once a turn is no filter, however much of it the second-order part of one would
/// absorb.
#[test]
fn an_error_over_the_angle_is_not_taken_for_a_filter() {
    for (amplitude, phase, seed) in [(1e-3, 2.0, 2), (1e-3, 2.0, 7), (1.2e-3, 1.9, 8)] {
        let folder = tempfile::tempdir().unwrap();
        let read = |t: f64| command(t)[0] + amplitude * (command(t)[0] + phase).cos();
        let found = diagnosed(folder.path(), &[&read], seed);
        assert_eq!(names(&found), [""; 0], "{phase} {seed}: {}", told(&found));
        assert_eq!(found.verdict, Verdict::Unknown, "{phase} {seed}: {}", told(&found));
    }
}

/// What two parts of a remainder have in common is a part of the gap once.
#[test]
fn parts_of_a_remainder_that_overlap_are_the_whole_gap() {
    let mut most = 0;
    for seed in [1, 4, 5] {
        let folder = tempfile::tempdir().unwrap();
        let error = |angle: f64| 1e-3 * (8.0 * angle).tanh() + 3e-4 * (3.0 * angle).cos();
        let read = |t: f64| command(t)[0] + error(command(t)[0]);
        let found = diagnosed(folder.path(), &[&read], seed);
        most = most.max(found.remainder.len());
        let shares: f64 = found.remainder.iter().map(|one| one.share).sum();
        assert!((0.99..=1.001).contains(&shares), "{seed} {shares}: {}", told(&found));
    }
    assert!(most > 1);
}
