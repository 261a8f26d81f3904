//! Numbers that stand in the place of readings: the limit of an instrument, values that are logged
//! again, and stops that were taken for others.

use std::fmt::Write as _;

use homepoint::diagnose::Diagnosis;
use homepoint::diagnose::budget::answer::Verdict;
use homepoint::diagnose::found::{NoReading, Wrong};
use homepoint::engine::open::{Opened, Request, open};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::calibrate;
use homepoint::estimate::checks::repeated;
use homepoint::estimate::minima::improved;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::drawn::run;
use crate::folder::Folder;
use crate::found::{names, told};

fn normal(random: &mut ChaCha8Rng, sigma: f64) -> f64 {
    let drawn: f64 = StandardNormal.sample(random);
    sigma * drawn
}

fn way(t: f64) -> f64 {
    0.04 * (1.3 * t).sin() + 0.03 * (2.9 * t + 0.4).sin()
}

/// A gauge beside a slide, 20 ms late; `shown` is what stands in the table in place of a reading, by
/// the number of the row.
fn gauge(mut shown: impl FnMut(usize, f64) -> f64, seed: u64) -> (tempfile::TempDir, Opened) {
    let folder = tempfile::tempdir().unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut stream = "time [s],way [m]\n".to_owned();
    for i in 0..7000 {
        let t = -2.0 + 0.01 * f64::from(i);
        writeln!(stream, "{t:.3},{:.8}", way(t)).unwrap();
    }
    let mut readings = "time [s],gauge [m]\n".to_owned();
    for i in 0..3000 {
        let t = 0.02 * i as f64;
        let reading = 1.02 * way(t - 0.02) + 0.004 + normal(&mut random, 5e-5);
        writeln!(readings, "{t:.3},{:.7}", shown(i, reading)).unwrap();
    }
    let model = "name = \"slide\"\ntitle = \"A gauge on a slide\"\n\
         [inputs]\nway = { unit = \"m\", signal = true }\n\
         [parameters]\nzero = { unit = \"m\", scope = \"rig\" }\nscale = { unit = \"1\", scope = \"rig\", start = \"1\" }\n\
         [measurands]\ngauge = { value = 'scale * way + zero', unit = \"m\" }\n";
    let campaign = "title = \"Slide\"\nmodel = \"model.toml\"\n\
         [measurands]\ngauge = { sigma = \"50 um\" }\n\
         [[runs]]\nname = \"one\"\ndata = \"readings.csv\"\nsignals = [\"stream.csv\"]\n";
    for (name, text) in [
        ("stream.csv", stream.as_str()),
        ("readings.csv", &readings),
        ("model.toml", model),
        ("campaign.toml", campaign),
    ] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let opened = open(&Request::new([folder.path()])).unwrap();
    (folder, opened)
}

fn diagnosed(opened: &Opened) -> Diagnosis {
    run(opened.problem.clone(), opened)
}

#[test]
fn saturated_readings_are_left_out() {
    let (low, high) = (-0.048, 0.061);
    let (_folder, opened) = gauge(|_, reading| reading.clamp(low, high), 3);
    let found = diagnosed(&opened);
    assert_eq!(names(&found), [""; 0], "{}", told(&found));
    assert_eq!(found.verdict, Verdict::Explained, "{}", told(&found));
    let readings = &found.left_out.readings;
    let at = |limit: f64| {
        let all = readings.iter().filter(|one| one.instead == Some(NoReading::Limit(limit)));
        all.count()
    };
    assert!(at(low) > 20 && at(high) > 20, "{}", told(&found));
    assert_eq!(at(low) + at(high), readings.len(), "{}", told(&found));
}

/// A log that stands still for a while bends the fit, but not what is seen of the limits, nor these what
/// is seen of it.
#[test]
fn limits_and_a_frozen_log_are_seen_beside_each_other() {
    let (low, high, frozen) = (-0.055, 0.064, 800..860);
    let mut held = 0.0;
    let shown = |row: usize, reading: f64| {
        let reading = reading.clamp(low, high);
        if !frozen.contains(&row) || row == frozen.start {
            held = reading;
        }
        held
    };
    let (_folder, opened) = gauge(shown, 6);
    let found = diagnosed(&opened);
    assert_eq!(names(&found), [""; 0], "{}", told(&found));
    assert_eq!(found.verdict, Verdict::Explained, "{}", told(&found));
    let readings = &found.left_out.readings;
    for limit in [low, high] {
        let all = readings.iter().filter(|one| one.instead == Some(NoReading::Limit(limit)));
        assert!(all.count() > 20, "{}", told(&found));
    }
    let [stretch] = &found.left_out.stretches[..] else { panic!("{}", told(&found)) };
    assert_eq!((stretch.how, stretch.readings), (Wrong::Repeated, 59), "{}", told(&found));
}

/// The slide itself stands still at its ends: its readings are right.
#[test]
fn an_end_at_which_the_rig_stands_is_no_limit() {
    let (_folder, opened) = gauge(|row, reading| if row < 40 { 0.02 } else { reading }, 4);
    let found = diagnosed(&opened);
    let has_limit = found.left_out.readings.iter().any(|one| one.instead.is_some());
    assert!(!has_limit, "{}", told(&found));
}

/// A gauge that reads at 10 Hz and is logged at 50 Hz: the delay is that of what it read.
#[test]
fn readings_that_are_logged_again_are_left_out() {
    let mut last = 0.0;
    let shown = move |row: usize, reading: f64| {
        if row.is_multiple_of(5) {
            last = reading;
        }
        last
    };
    let (_folder, opened) = gauge(shown, 5);
    let left_out = &opened.campaigns[0].left_out;
    assert_eq!(left_out.iter().map(|one| one.samples).sum::<usize>(), 2400);
    let result = calibrate(opened.problem.clone(), &Options::default()).unwrap();
    let estimates = result.estimates();
    let delay = estimates.iter().find(|one| one.name == "gauge.delay").unwrap();
    let (value, sigma) = (delay.value.unwrap(), delay.sigma.unwrap());
    assert!((value + 0.02).abs() < 4.0 * sigma, "{value} {sigma}");
}

/// Stops of which one in four or five was taken for another one.
#[test]
fn stops_that_were_mistaken_are_left_out() {
    for (seed, every) in [(1, 5), (2, 5), (3, 4)] {
        let folder = tempfile::tempdir().unwrap();
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut rows = "a [m],b [m],x [m],y [m]\n".to_owned();
        let place = |n: f64| [0.4 * (1.7 * n).sin(), 0.3 * (2.3 * n + 0.5).cos()];
        for n in 0..30 {
            let [a, b] = place(f64::from(n));
            let [p, q] = if n % every == 2 { place(f64::from(n + 11)) } else { [a, b] };
            let (sin, cos) = 0.35_f64.sin_cos();
            let mut noise = || normal(&mut random, 2e-4);
            let (x, y) = (cos * p - sin * q + 1.2 + noise(), sin * p + cos * q - 0.7 + noise());
            writeln!(rows, "{a:.6},{b:.6},{x:.6},{y:.6}").unwrap();
        }
        let model = "name = \"plane\"\ntitle = \"Stops in a plane\"\n\
             [inputs]\na = { unit = \"m\" }\nb = { unit = \"m\" }\n\
             [parameters]\nturn_by = { unit = \"rad\", scope = \"rig\" }\n\
             dx = { unit = \"m\", scope = \"rig\" }\ndy = { unit = \"m\", scope = \"rig\" }\n\
             [measurands]\n\
             x = { value = 'cos(turn_by) * a - sin(turn_by) * b + dx', unit = \"m\" }\n\
             y = { value = 'sin(turn_by) * a + cos(turn_by) * b + dy', unit = \"m\" }\n";
        let campaign = "title = \"Stops\"\nmodel = \"model.toml\"\n\
             [measurands]\nx = { sigma = \"0.2 mm\" }\ny = { sigma = \"0.2 mm\" }\n\
             [[runs]]\nname = \"stops\"\ndata = \"stops.csv\"\n";
        for (name, text) in
            [("stops.csv", rows.as_str()), ("model.toml", model), ("campaign.toml", campaign)]
        {
            std::fs::write(folder.path().join(name), text).unwrap();
        }
        let opened = open(&Request::new([folder.path()])).unwrap();
        let found = run(opened.problem.clone(), &opened);
        let mut rows: Vec<usize> = found.left_out.readings.iter().map(|one| one.row).collect();
        rows.sort_unstable();
        rows.dedup();
        let due: Vec<usize> = (0..30).filter(|n| n % every == 2).map(|n| n as usize + 2).collect();
        assert_eq!(rows, due, "{}", told(&found));
        assert!(!found.verdict.has_remainder(), "{}", told(&found));
    }
}

/// A gauge that hangs from the middle of the log on repeats its last reading to the end: most of the
/// readings are wrong, and the search for a start must pass over them.
#[test]
fn a_log_that_repeats_its_last_reading_to_the_end_is_found_though_that_is_most_of_it() {
    for first in [1300, 700] {
        let mut last = 0.0;
        let repeat = |row: usize, reading: f64| {
            last = if row < first { reading } else { last };
            last
        };
        let (_folder, opened) = gauge(repeat, 5);
        let warned = repeated(&opened.problem);
        assert_eq!(warned.len(), 1);
        let rows = format!("rows {} to 3001 of run `one`", first + 2);
        assert!(warned[0].message.contains(&rows), "{}", warned[0].message);
        let (searched, _) = improved(opened.problem.clone());
        let found = run(searched, &opened);
        assert_eq!(found.verdict, Verdict::Explained, "{}", told(&found));
        let [stretch] = &found.left_out.stretches[..] else { panic!("{}", told(&found)) };
        assert_eq!(stretch.how, Wrong::Repeated, "{}", told(&found));
        assert_eq!(stretch.rows, (first + 2, 3001), "{}", told(&found));
        let delay = found.nominal.estimates().into_iter().find(|one| one.name == "gauge.delay");
        let delay = delay.and_then(|one| one.value).unwrap();
        assert!((delay + 0.02).abs() < 1e-4, "{delay}");
    }
}

/// What stands still beside inputs that stand still, the steps of a display, a channel that is logged now
/// and then, and one that never changes are no reason for a warning.
#[test]
fn rests_displays_and_sparse_channels_give_no_warning_of_repeats() {
    let table = |input: fn(usize) -> f64, reading: fn(usize) -> f64| {
        let mut log = "time [s],way [m],gauge [m]\n".to_owned();
        for row in 0..2000 {
            let read = reading(row);
            let read = if read.is_nan() { String::new() } else { format!("{read:.6}") };
            writeln!(log, "{:.2},{:.6},{read}", 0.02 * row as f64, input(row)).unwrap();
        }
        let model = "name = \"slide\"\ntitle = \"Slide\"\n[inputs]\nway = { unit = \"m\" }\n\
             [parameters]\nzero = { unit = \"m\" }\n[measurands]\ngauge = { value = 'way + zero', unit = \"m\" }\n";
        let campaign = "title = \"Slide\"\nmodel = \"model.toml\"\n[measurands]\ngauge = { sigma = \"1 mm\" }\n\
             [[runs]]\nname = \"one\"\ndata = \"log.csv\"\n";
        let files = [("model.toml", model), ("campaign.toml", campaign), ("log.csv", log.as_str())];
        let folder = Folder::new("repeated", &files);
        repeated(&open(&Request::new([&*folder])).unwrap().problem).len()
    };
    let path: fn(usize) -> f64 = |row| (0.02 * row as f64).sin() + 0.1 * (0.171 * row as f64).sin();
    assert_eq!(table(path, |row| 0.5 + (0.02 * row.min(1200) as f64).sin()), 1);
    // At rest with its input; the steps of a display; now and then; never.
    assert_eq!(
        table(|row| (0.02 * row.min(1200) as f64).sin(), |row| (0.02 * row.min(1200) as f64).sin()),
        0
    );
    assert_eq!(table(path, |row| (row / 150) as f64), 0);
    assert_eq!(table(path, |row| if row % 50 == 0 { (row / 200) as f64 } else { f64::NAN }), 0);
    assert_eq!(table(path, |_| 3.1), 0);
}

/// A gauge that is blocked for a while: it stands still but for its noise, and leaks away.
#[test]
fn readings_that_do_not_respond_are_left_out() {
    let mut random = ChaCha8Rng::seed_from_u64(9);
    let mut held = 0.0;
    let blocked = |row: usize, reading: f64| {
        if !(1600..1990).contains(&row) {
            held = reading;
            return reading;
        }
        held -= 4e-5;
        held + normal(&mut random, 5e-5)
    };
    let (_folder, opened) = gauge(blocked, 11);
    let found = diagnosed(&opened);
    assert_eq!(found.verdict, Verdict::Explained, "{}", told(&found));
    let [stretch] = &found.left_out.stretches[..] else { panic!("{}", told(&found)) };
    assert_eq!(stretch.how, Wrong::Unresponsive, "{}", told(&found));
    let (first, last) = stretch.rows;
    assert!(first.abs_diff(1602) < 20 && last.abs_diff(1991) < 20, "{first} {last}");
}
