//! Are captures made into reference times, and does what is not known of them widen the delays?
//! (Depenthal 2009, sections 2.2 and 2.3)
//!
//! Readings come from the seed's equations written by hand; a delay counts from the request.

use std::convert::Infallible;
use std::f64::consts::PI;
use std::fmt::Write as _;
use std::fs;

use homepoint::campaign::Samples;
use homepoint::campaign::write::{write_campaign, write_campaign_with};
use homepoint::campaign::write_run::RunTable;
use homepoint::engine::open::{Opened, Request, open};
use homepoint::engine::{Point, simulate::simulate};
use homepoint::estimate::batch::Options;
use homepoint::estimate::budget::budgets;
use homepoint::estimate::calibrate::calibrate;
use homepoint::estimate::delays::Summary;
use homepoint::estimate::newton::ReadingDelay;
use homepoint::estimate::transformation::{Transformation, delays_of, each_delay_of};

use crate::folder::Folder;
use crate::seed;

const RATE: f64 = 190.0 * PI / 180.0;
const DELAYS: [f64; 3] = [0.2e-3, -0.15e-3, 0.05e-3];
const POSITION: [f64; 3] = [0.4, 0.1, 1.4];
const RADIUS: f64 = 1.146;

/// The transformation is known exactly, so that delays are as exact as the arithmetic.
const HEAD: &str = r#"model = "polar_one_rotation"
[parameters]
radius      = { value = "1.146 m", fixed = true }
orientation = { value = ["0 rad", "0 rad", "0 rad"], fixed = true }
position    = { value = ["0.4 m", "0.1 m", "1.4 m"], fixed = true }
[measurands]
horizontal = { sigma = "10 urad" }
vertical   = { sigma = "10 urad" }
distance   = { sigma = "10 um" }
"#;
const RUN: &str = "[[runs]]\nname = \"fast\"\ndata = \"fast.csv\"\n";

impl Folder {
    fn open(&self) -> Opened {
        open(&Request::new([self])).unwrap()
    }
}

/// The three readings asked for at `request` (s), each its delay later.
fn readings(request: f64) -> String {
    let at = |delay: f64| {
        let angle = RATE * (request + delay);
        seed::polar_one_rotation(angle, RADIUS, [1.0, 0.0, 0.0, 0.0], POSITION)
    };
    let [a, b, c] = DELAYS;
    let horizontal = at(a)[0].rem_euclid(2.0 * PI);
    format!("{horizontal:?},{:?},{:?}", at(b)[1], at(c)[2])
}

const READ: &str = "horizontal [rad],vertical [rad],distance [m]";
const COUNT: usize = 60;

/// Requests every 25 ms.
fn requests() -> impl Iterator<Item = f64> {
    (0..COUNT).map(|k| 3.0 + 0.025 * k as f64)
}

/// What came of the readings, and the delay of each.
struct Found {
    measurands: Vec<Summary>,
    readings: Vec<ReadingDelay>,
}

fn delays(opened: &Opened) -> Found {
    let joint = calibrate(opened.problem.clone(), &Options::default()).unwrap();
    let mut readings = Vec::new();
    let Ok((_, delays)) = each_delay_of(&opened.problem, &joint, 0, &mut |reading| {
        readings.push(reading.clone());
        Ok::<_, Infallible>(())
    });
    Found { measurands: delays.measurands, readings }
}

/// Every delay that was solved is the true one to `tolerance` (s).
#[track_caller]
fn are_true(delays: &Found, tolerance: f64) {
    for summary in &delays.measurands {
        assert!(summary.solved > COUNT / 2, "{summary:?}");
    }
    for reading in delays.readings.iter().filter(|reading| reading.delay.is_finite()) {
        let error = reading.delay - DELAYS[reading.measurand];
        // A blind reading magnifies rounding.
        let tolerance = tolerance * (1.0 + reading.random / 1e-5);
        assert!(error.abs() < tolerance, "{error} {reading:?}");
    }
}

/// A trigger is latched one gate delay late, with the arm where it is then.
fn triggered(timing: &str, gate: f64) -> Folder {
    let mut data = format!("trigger [s],arm_angle [rad],arm_angle_rate [rad/s],{READ}\n");
    for request in requests() {
        let latch = request + gate;
        writeln!(data, "{latch:?},{:?},{RATE:?},{}", RATE * latch, readings(request)).unwrap();
    }
    let campaign = format!("{HEAD}[timing]\nmethod = \"trigger\"\n{timing}\n{RUN}");
    Folder::new(
        &format!("trigger-{}", timing.len()),
        &[("campaign.toml", &campaign), ("fast.csv", &data)],
    )
}

#[test]
fn the_latch_of_a_trigger_is_taken_back_by_the_gate_delay() {
    let folder = triggered("controller_gate = { at_most = \"100 ns\" }", 50e-9);
    are_true(&delays(&folder.open()), 2e-12);
    // Left alone, the gate delay would be taken off every delay.
    let folder = triggered("", 50e-9);
    let found = delays(&folder.open());
    assert!((found.measurands[0].mean.unwrap() - DELAYS[0] + 50e-9).abs() < 1e-11);
}

/// A request of 80 bits begins before it is complete; requests, replies and arm stand in a file of
/// their own. The arm turns 0.8 deg while the request comes in.
fn serial(timing: &str, run: &str, before: f64) -> Folder {
    let mut captures =
        "request [us],reply [us],arm_angle [deg],arm_angle_rate [deg/s]\n".to_owned();
    let mut data = format!("{READ}\n");
    for (k, request) in requests().enumerate() {
        let start = request - before;
        let reply = start + 12e-3 + 1e-5 * (k % 3) as f64;
        let arm = (RATE * start).to_degrees();
        writeln!(captures, "{:?},{:?},{arm:?},190", 1e6 * start, 1e6 * reply).unwrap();
        writeln!(data, "{}", readings(request)).unwrap();
    }
    let campaign =
        format!("{HEAD}[timing]\nmethod = \"serial\"\nbaud = \"19200 Bd\"\n{timing}\n{RUN}{run}");
    let name = format!("serial-{}-{}", timing.len(), run.len());
    Folder::new(
        &name,
        &[("campaign.toml", &campaign), ("fast.csv", &data), ("latch.csv", &captures)],
    )
}

#[test]
fn a_serial_request_counts_from_its_last_bit() {
    let run = "timing = { captures = \"latch.csv\" }";
    let opened = serial("bits = 80", run, 80.0 / 19200.0).open();
    are_true(&delays(&opened), 2e-12);
    let reply = &opened.campaigns[0].request_to_reply[0];
    assert_eq!((reply.run.as_str(), reply.count), ("fast", COUNT));
    assert!(
        (reply.time.smallest - 12e-3).abs() < 1e-9 && (reply.time.largest - 12.02e-3).abs() < 1e-9
    );
    assert!((reply.time.mean - 12.01e-3).abs() < 1e-9);
    // 20 each of -10, 0 and 10 µs about their mean.
    assert!((reply.time.standard_deviation - (40.0_f64 / 59.0).sqrt() * 1e-5).abs() < 1e-10);
}

#[test]
fn a_run_may_have_requests_of_its_own_length() {
    let run = "timing = { captures = \"latch.csv\", bits = 120 }";
    are_true(&delays(&serial("bits = 80", run, 120.0 / 19200.0).open()), 2e-12);
}

#[test]
fn the_start_bit_may_be_the_reference_point() {
    let run = "timing = { captures = \"latch.csv\" }";
    let folder = serial("bits = 80\nreference = \"start_bit\"", run, 0.0);
    are_true(&delays(&folder.open()), 2e-12);
}

/// Mean delays are less well known by exactly the common part of the chain, in both estimates.
#[test]
fn what_is_common_to_all_reference_times_widens_every_delay() {
    let chain = "edge = \"1 us\"\ncontroller_gate = { at_most = \"100 ns\" }";
    let common = (1e-6_f64 / 12.0_f64.sqrt()).hypot(100e-9 / 12.0_f64.sqrt());
    let (with, without) = (triggered(chain, 50e-9).open(), triggered("", 0.0).open());
    for (with, without) in delays(&with).measurands.iter().zip(delays(&without).measurands) {
        let widened = without.sigma_of_mean.unwrap().hypot(common);
        assert!((with.sigma_of_mean.unwrap() - widened).abs() < 1e-3 * widened);
        assert!((with.common.unwrap() - common).abs() < 1e-6 * common);
        assert!((with.random.unwrap() / without.random.unwrap() - 1.0).abs() < 1e-6);
    }
    let batch = |opened: &Opened| {
        let fit = calibrate(opened.problem.clone(), &Options::default()).unwrap();
        assert!(fit.is_sound());
        let all = fit.estimates();
        all.iter().find(|one| one.name == "vertical.delay").unwrap().sigma.unwrap()
    };
    let (with, without) = (batch(&with), batch(&without));
    assert!((with - without.hypot(common)).abs() < 1e-6 * with);
}

/// A random error of the reference time is shared by the readings of a sample: as the effect
/// `timestamp_jitter` has it, and in the delay of one reading it is itself.
#[test]
fn what_scatters_from_sample_to_sample_is_a_jitter_of_the_time() {
    let jittery = triggered("jitter = \"7 us\"\nresolution = \"24 us\"", 0.0);
    let jitter = 7e-6_f64.hypot(24e-6 / 12.0_f64.sqrt());
    let (with, without) = (jittery.open(), triggered("", 0.0).open());
    let (found, plain) = (delays(&with), delays(&without));
    let pairs = found.readings.iter().zip(&plain.readings).filter(|(a, _)| a.random.is_finite());
    for (with, without) in pairs {
        assert!((with.random - without.random.hypot(jitter)).abs() < 1e-6 * with.random);
    }
    let ready = triggered("# the same as an effect", 0.0);
    let mut request = Request::new([&ready]);
    request.with = vec!["timestamp_jitter".into()];
    request.set = vec![format!("timestamp_jitter.jitter={jitter} s")];
    let mut effect = open(&request).unwrap();
    for random in &mut effect.problem.parts[0].system.randoms {
        random.fixed = true;
    }
    let effect = delays(&effect);
    for (a, b) in found.measurands.iter().zip(&effect.measurands) {
        assert!((a.random.unwrap() / b.random.unwrap() - 1.0).abs() < 1e-9);
    }
}

/// From known truth: planned, drawn, written with captures, read back.
#[test]
fn a_simulated_campaign_carries_captures_and_gives_the_delays_back() {
    let plan = format!(
        r#"{HEAD}[timing]
method = "serial"
baud = "9600 Bd"
bits = 60
baud_tolerance = "50 ppm"
resolution = "25 ns"
controller_gate = {{ value = "60 ns", U = "20 ns", k = 2, degrees_of_freedom = 12 }}
[[runs]]
name = "fast"
plan = {{ trigger = "40 Hz", duration = "10 s", arm_angle = {{ start = "0 deg", rate = "90 deg/s", acceleration = "10 deg/s^2" }} }}
"#
    );
    let stated = ["horizontal", "vertical", "distance"]
        .iter()
        .zip(DELAYS)
        .map(|(name, delay)| format!("{name}.delay = {{ value = \"{delay} s\" }}\n"))
        .collect::<String>();
    let plan = plan.replace("[measurands]", &format!("{stated}[measurands]"));
    let planned = Folder::new("planned", &[("campaign.toml", &plan)]);
    let mut opened = planned.open();
    let truth = Point::stated(&opened.problem.layout);
    simulate(&mut opened.problem, &truth, 5, true);
    let written = Folder::new("written", &[]);
    let runs = &opened.problem.parts[0].runs;
    write_campaign(&written, &opened.campaigns[0], &opened.models[0], runs).unwrap();
    let header = fs::read_to_string(written.join("fast.csv")).unwrap();
    assert!(header.starts_with("request [s],arm_angle [rad]"), "{}", &header[..60]);

    let again = written.open();
    let (a, b) = (runs[0].held(), again.problem.parts[0].runs[0].held());
    for row in 0..a.len() {
        assert!((a.time[row] - b.time[row]).abs() < 1e-14 * (1.0 + a.time[row].abs()) * 4.0);
    }
    for order in 0..=2 {
        for row in 0..a.len() {
            let at = |run: &Samples| run.inputs[0].at::<f64>(row, 0.0, 0.0, order);
            assert!((at(a) - at(b)).abs() < 1e-13 * (1.0 + at(a).abs()), "{order} {row}");
        }
    }
    let common = (60.0 / 9600.0 * 50e-6 / 3.0_f64.sqrt()).hypot(10e-9);
    for (summary, truth) in delays(&again).measurands.iter().zip(DELAYS) {
        let sigma = summary.sigma_of_mean.unwrap();
        assert!((summary.mean.unwrap() - truth).abs() < 4.0 * sigma, "{summary:?}");
        assert!((summary.common.unwrap() - common).abs() < 1e-6 * common, "{summary:?}");
    }
}

/// Eq. (1): both gates, and an edge in which each system switches somewhere.
#[test]
fn the_lag_of_both_gates() {
    let opened = triggered(
        "edge = \"1 us\"\ncontroller_gate = { at_most = \"100 ns\" }\n\
         instrument_gate = { value = \"3 us\", sigma = \"0.5 us\" }",
        50e-9,
    )
    .open();
    let lag = opened.campaigns[0].timing.as_ref().unwrap().lag().unwrap();
    assert!((lag.value - (50e-9 - 3e-6)).abs() < 1e-15);
    let variance = 1e-14 / 12.0 + 0.25e-12 + 2.0 * 1e-12 / 12.0;
    assert!((lag.spread.sigma.powi(2) - variance).abs() < 1e-6 * variance);
}

/// Block by block as at once: reference times, arm, replies, and what the delays' uncertainty is
/// made of.
#[test]
fn a_run_may_be_longer_than_memory() {
    let count = 20_000;
    let before = 80.0 / 19200.0;
    let mut captures = "request [s],reply [s],arm_angle [rad],arm_angle_rate [rad/s]\n".to_owned();
    let mut data = format!("{READ}\n");
    for k in 0..count {
        let request = 3.0 + 0.025 * f64::from(k);
        let start = request - before;
        let reply = start + 12e-3 + 1e-6 * f64::from(k % 2);
        writeln!(captures, "{start:?},{reply:?},{:?},{RATE:?}", RATE * start).unwrap();
        writeln!(data, "{}", readings(request)).unwrap();
    }
    let inputs = "[inputs]\narm_angle = { resolution = \"0.36 arcsec\", calibration = { U = \"4.2 arcsec\", k = 2 } }\n";
    let timing = "[timing]\nmethod = \"serial\"\nbaud = \"19200 Bd\"\nbits = 80\nedge = \"1 us\"\n";
    let campaign = format!("{HEAD}{inputs}{timing}{RUN}timing = {{ captures = \"latch.csv\" }}\n");
    let folder = Folder::new(
        "long",
        &[("campaign.toml", &campaign), ("fast.csv", &data), ("latch.csv", &captures)],
    );
    let answers = [0, 1_000_000_000].map(|memory| {
        let mut request = Request::new([&folder]);
        request.memory = Some(memory);
        let opened = open(&request).unwrap();
        let record = &opened.problem.parts[0].runs[0].record;
        assert_eq!((record.is_spilled(), record.len()), (memory == 0, count as usize));
        record.walk(|stretch| {
            for sample in stretch.each() {
                let request = 3.0 + 0.025 * sample.number as f64;
                assert!((sample.time() - request).abs() < 1e-12 * request);
                let arm: f64 = sample.samples.inputs[0].at(sample.at, 0.0, 0.0, 0);
                assert!((arm - RATE * request).abs() < 1e-11 * request);
            }
        });
        let reply = opened.campaigns[0].request_to_reply[0].clone();
        let joint = calibrate(opened.problem.clone(), &Options::default()).unwrap();
        let taken = Transformation::of(&opened.problem, &joint, 0);
        let budgets = budgets(&taken, 0, &opened.campaigns[0]);
        let blind = delays_of(&opened.problem, &joint, 0).1.measurands[1].blind_ranges.clone();
        (reply, budgets, blind)
    });
    let [(reply, few, blind), (other_reply, many, other_blind)] = answers;
    assert_eq!((&reply, &blind), (&other_reply, &other_blind));
    assert!(!blind.is_empty());
    assert_eq!(reply.count, count as usize);
    assert!((reply.time.mean - 12.0005e-3).abs() < 1e-9);
    for (few, many) in few.iter().zip(&many) {
        assert_eq!(few.contributions, many.contributions);
    }
    // A capture too many, and one too few, long after the first block.
    for (rows, expected) in
        [(count + 1, "this reading has no capture"), (count - 1, "this capture has no reading")]
    {
        let mut data = format!("{READ}\n");
        for _ in 0..rows {
            data.push_str("1,1,1\n");
        }
        fs::write(folder.join("fast.csv"), data).unwrap();
        let faults = open(&Request::new([&folder])).unwrap_err();
        assert_eq!(faults.0[0].message, expected);
        assert_eq!(faults.0[0].place.as_ref().unwrap().line, count.min(rows) as usize + 2);
    }
}

/// A simulated run's replies: as stated, within their requests, on the clock's grid, from the seed
/// alone.
#[test]
fn simulated_replies_are_captured_and_read_back() {
    let plan = format!(
        r#"{HEAD}[timing]
method = "serial"
baud = "19200 Bd"
bits = 150
resolution = "25 ns"
reply = {{ after = "18 ms", scatter = "4 ms" }}
[[runs]]
name = "fast"
plan = {{ trigger = "40 Hz", duration = "20 s", arm_angle = {{ start = "0 deg", rate = "90 deg/s", acceleration = "2 deg/s^2" }} }}
"#
    );
    let planned = Folder::new("reply-plan", &[("campaign.toml", &plan)]);
    let mut opened = planned.open();
    let truth = Point::stated(&opened.problem.layout);
    simulate(&mut opened.problem, &truth, 5, true);
    let write = |opened: &Opened, seed: u64, name: &str| {
        let written = Folder::new(name, &[]);
        let runs = &opened.problem.parts[0].runs;
        let fill = &mut |run: usize, table: &mut RunTable| {
            table.seed(seed, run);
            runs[run].record.try_walk(|stretch| table.write(stretch, None))
        };
        let (campaign, model) = (&opened.campaigns[0], &opened.models[0]);
        write_campaign_with(&written, campaign, model, runs, fill).unwrap();
        written
    };
    let written = write(&opened, 1, "reply-1");
    let text = |folder: &Folder| fs::read_to_string(folder.join("fast.csv")).unwrap();
    assert!(text(&written).starts_with("request [s],reply [s],arm_angle [rad]"));
    assert_eq!(text(&written), text(&write(&opened, 1, "reply-1-again")));
    assert_ne!(text(&written), text(&write(&opened, 2, "reply-2")));

    let again = written.open();
    let replied = &again.campaigns[0].request_to_reply[0];
    assert_eq!((replied.count, replied.replies.len()), (800, 800));
    // 800 draws, cut off where the next request begins and where the request itself ends.
    let length = 150.0 / 19200.0;
    assert!(replied.time.smallest >= length && replied.time.largest < 25e-3);
    assert!((replied.time.mean - 18e-3).abs() < 0.5e-3, "{replied:?}");
    assert!((replied.time.standard_deviation - 4e-3).abs() < 0.6e-3);
    for one in &replied.replies {
        let steps = one.reply / 25e-9;
        assert!((steps - steps.round()).abs() < 1e-3, "{one:?}");
        // Where the arm is then, by hand: planned from the reference time zero on.
        let at = |time: f64| {
            let since = time - (replied.replies[0].request + length);
            (90.0 * since + since * since).to_radians()
        };
        let [[then, later]] = one.inputs[..] else { unreachable!() };
        assert!((then - at(one.request)).abs() < 1e-9, "{one:?}");
        assert!((later - at(one.reply)).abs() < 1e-9, "{one:?}");
    }
    let (name, moved) = &replied.moved[0];
    assert_eq!(name, "arm_angle");
    assert!(moved.smallest > 0.0 && moved.largest < (130.0 * 25e-3_f64).to_radians());
    let table = homepoint::report::timing::replies(&again.campaigns[0], &again.models[0]);
    assert_eq!(table.lines().count(), 801);
    assert!(table.starts_with(
        "run,row,request [s],reply [s],request_to_reply [s],arm_angle_at_request [rad],arm_angle_at_reply [rad]\nfast,2,"
    ));
    // What was recorded once comes again where the table says nothing.
    let text = fs::read_to_string(written.join("campaign.toml")).unwrap();
    let silent: String =
        text.lines().filter(|line| !line.contains("\"reply\"")).collect::<Vec<_>>().join("\n");
    assert_ne!(silent.lines().count(), text.lines().count());
    fs::write(written.join("campaign.toml"), silent).unwrap();
    let third = write(&written.open(), 3, "reply-3").open();
    let replied = &third.campaigns[0].request_to_reply[0];
    assert!((replied.time.mean - 18e-3).abs() < 0.5e-3, "{replied:?}");
}
