//! A clock that was set while it recorded: readings go on uniformly where their stamps jump.

use std::fmt::Write as _;

use homepoint::diagnose::Diagnosis;
use homepoint::diagnose::budget::stamp_jumps::Side;
use homepoint::engine::open::{Request, open};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::drawn::run;
use crate::found::{names, told};

/// A table's angle.
fn angle(t: f64) -> f64 {
    0.9 * (0.61 * t).sin() + 0.4 * (1.73 * t + 0.8).sin() + 0.3 * (0.19 * t).sin()
}

/// Where from on stamps are later, by how much; the rate error of the clock; what stamps scatter by.
#[derive(Clone, Copy)]
struct Clock<'a> {
    set: &'a [(f64, f64)],
    rate: f64,
    jitter: f64,
    /// Rows are missing from one second to another.
    pause: Option<(f64, f64)>,
}

/// Diagnoses 100 s of readings every 40 ms, 30 ms late, with stamps of this clock.
fn diagnosed(clock: &Clock<'_>, seed: u64) -> Diagnosis {
    diagnosed_runs(&[("one", clock)], seed)
}

/// The same of several runs of one delay.
fn diagnosed_runs(clocks: &[(&str, &Clock<'_>)], seed: u64) -> Diagnosis {
    let folder = tempfile::tempdir().unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = |sigma: f64| -> f64 {
        let drawn: f64 = StandardNormal.sample(&mut random);
        sigma * drawn
    };
    let mut stream = "time [s],theta [rad]\n".to_owned();
    for i in 0..11_000 {
        let t = -5.0 + 0.01 * f64::from(i);
        writeln!(stream, "{t:.3},{:.8}", angle(t)).unwrap();
    }
    let mut campaign = "title = \"Table\"\nmodel = \"model.toml\"\n\
         [measurands]\nangle = { sigma = \"0.2 mrad\" }\n"
        .to_owned();
    for (name, clock) in clocks {
        let mut readings = "time [s],angle [rad]\n".to_owned();
        for i in 0..2500 {
            let t = 0.04 * f64::from(i);
            if clock.pause.is_some_and(|(from, to)| (from..to).contains(&t)) {
                continue;
            }
            let set: f64 = clock.set.iter().filter(|(at, _)| t >= *at).map(|(_, by)| by).sum();
            let stamp = t + 0.03 + set + clock.rate * t + normal(clock.jitter);
            writeln!(readings, "{stamp:.6},{:.8}", angle(t) + 2e-3 + normal(2e-4)).unwrap();
        }
        std::fs::write(folder.path().join(format!("{name}.csv")), readings).unwrap();
        write!(
            campaign,
            "[[runs]]\nname = \"{name}\"\ndata = \"{name}.csv\"\nsignals = [\"stream.csv\"]\n"
        )
        .unwrap();
    }
    let model = "name = \"table\"\ntitle = \"A sensor on a table\"\n\
         [inputs]\ntheta = { unit = \"rad\", signal = true }\n\
         [parameters]\noffset = { unit = \"rad\", scope = \"rig\" }\n\
         [measurands]\nangle = { value = 'theta + offset', unit = \"rad\" }\n";
    for (name, text) in
        [("stream.csv", stream.as_str()), ("model.toml", model), ("campaign.toml", &campaign)]
    {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let opened = open(&Request::new([folder.path().to_owned()])).unwrap();
    run(opened.problem.clone(), &opened)
}

/// The share of the jumps that is the clock's, with its uncertainty.
fn share(found: &Diagnosis) -> (f64, f64) {
    let row = found.rows.iter().find(|row| row.name == "clock_steps").unwrap();
    let value = &row.values[0];
    (value.value.unwrap(), value.sigma.unwrap())
}

#[test]
fn a_clock_that_was_set_is_named_with_its_rows() {
    let cases: [&[(f64, f64)]; 4] = [
        &[(31.0, 0.09)],
        &[(31.0, 0.05), (66.0, -0.02)],
        &[(20.0, 0.02), (45.0, 0.03), (80.0, 0.01)],
        &[(31.0, 2.5)],
    ];
    for (seed, set) in cases.iter().enumerate() {
        let clock = Clock { set, rate: 0.0, jitter: 0.0, pause: None };
        let found = diagnosed(&clock, 40 + seed as u64);
        assert_eq!(names(&found), ["clock_steps"], "{}", told(&found));
        assert!(!found.verdict.has_remainder(), "{}", told(&found));
        let (share, sigma) = share(&found);
        assert!((share - 1.0).abs() < 4.0 * sigma && sigma < 0.01, "{share} {sigma}");
        let jumps = &found.rows[0].stamp_jumps;
        assert_eq!(jumps.len(), set.len());
        for (jump, (at, by)) in jumps.iter().zip(*set) {
            // The header is row 1.
            assert_eq!(jump.row, 2 + (at / 0.04).ceil() as usize);
            assert!((jump.size - by).abs() < 1e-6 && jump.run == "one", "{jump:?}");
            // The delay of the only run follows either side.
            assert_eq!(jump.right, None);
        }
    }
}

/// Runs of one delay say which stamps are right, in whichever part of a run the clock was set.
/// It was set by no whole number of intervals: else readings that are rows off explain as much.
#[test]
fn the_right_stamps_are_those_of_the_delay_of_other_runs() {
    let steady = Clock { set: &[], rate: 0.0, jitter: 0.0, pause: None };
    for (seed, at, side) in [
        (60, 31.0, Side::Before),
        (61, 31.0, Side::After),
        (62, 67.0, Side::Before),
        (63, 67.0, Side::After),
    ] {
        let offset = if side == Side::Before { 0.0 } else { -0.21 };
        let set = [(-1.0, offset), (at, 0.21)];
        let clock = Clock { set: &set, ..steady };
        let found = diagnosed_runs(&[("one", &steady), ("two", &clock), ("three", &steady)], seed);
        assert_eq!(found.verdict.word(), "explained", "{}", told(&found));
        assert_eq!(names(&found), ["clock_steps"], "{}", told(&found));
        assert!(!found.verdict.has_remainder(), "{}", told(&found));
        let [jump] = &found.rows[0].stamp_jumps[..] else { panic!("{}", told(&found)) };
        assert_eq!((jump.run.as_str(), jump.right), ("two", Some(side)), "{}", told(&found));
        let two = found.rows[0].values.iter().find(|one| one.of.as_deref() == Some("two"));
        let (share, sigma) = two.map(|one| (one.value.unwrap(), one.sigma.unwrap())).unwrap();
        assert!((share - 1.0).abs() < 4.0 * sigma && sigma < 0.01, "{share} {sigma}");
    }
}

/// A clock that was corrected in two runs, early in one and late in the other: right
/// are the stamps after it, the longest stretch of one run alone.
#[test]
fn a_clock_that_was_corrected_in_two_runs_is_one_cause() {
    let steady = Clock { set: &[], rate: 0.0, jitter: 0.0, pause: None };
    let early = Clock { set: &[(-1.0, -0.15), (24.0, 0.15)], ..steady };
    let late = Clock { set: &[(-1.0, -0.21), (77.0, 0.21)], ..steady };
    let found = diagnosed_runs(&[("one", &early), ("two", &late), ("three", &steady)], 64);
    assert_eq!(names(&found), ["clock_steps"], "{}", told(&found));
    assert!(!found.verdict.has_remainder(), "{}", told(&found));
    let right: Vec<_> = found.rows[0].stamp_jumps.iter().map(|jump| jump.right).collect();
    assert_eq!(right, [Some(Side::After); 2], "{}", told(&found));
    for name in ["one", "two"] {
        let own = found.rows[0].values.iter().find(|one| one.of.as_deref() == Some(name)).unwrap();
        let (share, sigma) = (own.value.unwrap(), own.sigma.unwrap());
        assert!((share - 1.0).abs() < 4.0 * sigma && sigma < 0.01, "{name} {share} {sigma}");
    }
}

#[test]
fn a_rate_beside_it_keeps_its_value() {
    let clock = Clock { set: &[(40.0, 0.05)], rate: 3e-4, jitter: 0.0, pause: None };
    let found = diagnosed(&clock, 51);
    let named = names(&found);
    assert!(named.len() == 2 && named.contains(&"clock_steps"), "{}", told(&found));
    let rate = found.rows.iter().find(|row| row.name != "clock_steps").unwrap();
    assert!(["clock_drift", "sample_clock_rate"].contains(&&*rate.name), "{}", told(&found));
    let value = rate.values[0].value.unwrap();
    assert!((value + 3e-4).abs() < 4.0 * rate.values[0].sigma.unwrap() + 1e-6, "{value}");
}

/// Stamps that scatter: the steps are named with their sizes, and no rate imitates them.
#[test]
fn it_is_named_beside_jitter() {
    let clock = Clock { set: &[(25.0, 0.03), (60.0, -0.02)], rate: 0.0, jitter: 2e-3, pause: None };
    let found = diagnosed(&clock, 52);
    assert!(names(&found).contains(&"clock_steps"), "{}", told(&found));
    let (share, _) = share(&found);
    assert!((share - 1.0).abs() < 0.05, "{share}");
    let large = |row: &&homepoint::diagnose::budget::answer::Row| {
        row.name.contains("clock_") && row.name != "clock_steps"
    };
    for row in found.rows.iter().filter(large) {
        assert!(row.values[0].value.unwrap().abs() < 3e-5, "{}", told(&found));
    }
}

#[test]
fn a_pause_is_no_step() {
    let clock = Clock { set: &[], rate: 0.0, jitter: 0.0, pause: Some((30.0, 33.7)) };
    let found = diagnosed(&clock, 53);
    assert_eq!(names(&found), [""; 0], "{}", told(&found));
    assert!(!found.verdict.has_remainder(), "{}", told(&found));
}
