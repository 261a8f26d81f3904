//! Do both ways to the uncertainty of a delay give the seed's figures, and where do they part?
//! (Depenthal 2009, sections 3.4 and 4, Figs. 9 and 10)
//!
//! A tracker on the arm's axis, 1.4 m from the plane of a vertical arm of 1.146 m; 40 Hz. At
//! 190 deg/s 1440 readings are 19 turns and fall on 1440 different arm angles.

use std::convert::Infallible;
use std::f64::consts::{PI, TAU};

use homepoint::campaign::Samples;
use homepoint::engine::open::{Opened, Request, open};
use homepoint::engine::simulate::simulate;
use homepoint::engine::{Point, Problem};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::{Calibration, calibrate};
use homepoint::estimate::delays::Delays;
use homepoint::estimate::differences::Differences;
use homepoint::estimate::newton::{ReadingDelay, State};
use homepoint::estimate::transformation::each_delay_of;

use crate::folder::Folder;
use crate::seed;

const RADIUS: f64 = 1.146;
const AHEAD: f64 = 1.4;
/// Standard uncertainty of the vertical angle (rad).
const VERTICAL: f64 = 30e-6;
const MEASURAND: usize = 1;

/// Readings without noise to speak of, but weighted as if they had the seed's.
fn campaign(name: &str, rate: f64, duration: f64) -> Solved {
    let half_pi = PI / 2.0;
    let text = format!(
        r#"model = "polar_one_rotation"
[parameters]
radius      = {{ value = "{RADIUS} m", fixed = true }}
orientation = {{ value = ["0 rad", "{half_pi:?} rad", "0 rad"], fixed = true }}
position    = {{ value = ["{AHEAD} m", "0 m", "0 m"], fixed = true }}
[measurands]
horizontal = {{ sigma = "30 urad" }}
vertical   = {{ sigma = "30 urad" }}
distance   = {{ sigma = "10 um" }}
[[runs]]
name = "fast"
plan = {{ trigger = "40 Hz", duration = "{duration} s", arm_angle = {{ start = "0.1 deg", rate = "{rate} deg/s" }} }}
"#
    );
    let folder = Folder::new(name, &[("campaign.toml", &text)]);
    let mut opened = open(&Request::new([&folder])).unwrap();
    let problem = &mut opened.problem;
    let truth = Point::stated(&problem.layout);
    let sigma = std::mem::replace(&mut problem.parts[0].sigma, vec![1e-12; 3]);
    simulate(problem, &truth, 3, true);
    problem.parts[0].sigma = sigma;
    // The distance does not change on the axis, and so has no delay.
    problem.parts[0].runs[0]
        .record
        .edit(|samples: &mut Samples| samples.readings[2].fill(f64::NAN));
    let problem = without_distance_delay(&opened.problem);
    let joint = calibrate(problem.clone(), &Options::default()).unwrap();
    assert!(joint.is_sound(), "{:?}", joint.unobservable);
    let mut vertical = Vec::new();
    let Ok((_, delays)) = each_delay_of(&problem, &joint, 0, &mut |reading| {
        if reading.measurand == MEASURAND {
            vertical.push(reading.clone());
        }
        Ok::<_, Infallible>(())
    });
    Solved { opened, joint, delays, vertical }
}

struct Solved {
    opened: Opened,
    joint: Calibration,
    delays: Delays,
    /// The readings of the vertical angle.
    vertical: Vec<ReadingDelay>,
}

impl Solved {
    /// Expanded uncertainties by differences over 1 ms.
    fn table(&self) -> Vec<f64> {
        let point = &self.joint.fit.point;
        let mut table = Differences::new(&self.opened.problem, 0, point);
        self.vertical.iter().map(|reading| table.expanded(VERTICAL, reading)).collect()
    }
}

fn without_distance_delay(problem: &Problem) -> Problem {
    let mut parts = problem.parts.clone();
    let system = &mut parts[0].system;
    let delay = system.assembly.names.measurands[2].delay;
    system.settings[delay].fixed = true;
    system.settings[delay].value = Some(vec![0.0]);
    Problem::new(parts)
}

/// The vertical angle's rate (rad/s) some time after an arm angle was passed, from eqs. (8) to (11)
/// by a difference over 2 µs.
fn slope(angle: f64, rate: f64, after: f64) -> f64 {
    let half = (PI / 4.0).cos();
    let at = |t: f64| {
        let orientation = [half, 0.0, half, 0.0];
        seed::polar_one_rotation(angle + rate * (after + t), RADIUS, orientation, [AHEAD, 0.0, 0.0])
            [1]
    };
    (at(1e-6) - at(-1e-6)) / 2e-6
}

fn arm_angles(opened: &Opened) -> Vec<f64> {
    let samples = opened.problem.parts[0].runs[0].held();
    (0..samples.len()).map(|row| samples.inputs[0].at(row, 0.0, 0.0, 0)).collect()
}

/// Share of the readings whose uncertainty exceeds the smallest by each factor, in percent.
fn shares(uncertainties: &[f64]) -> [f64; 3] {
    let least = uncertainties.iter().copied().fold(f64::INFINITY, f64::min);
    [2.0, 3.0, 10.0].map(|factor| {
        let above = uncertainties.iter().filter(|u| **u > factor * least).count();
        100.0 * above as f64 / uncertainties.len() as f64
    })
}

#[test]
fn the_vertical_angle_on_the_axis_exactly() {
    let readings = campaign("exact", 190.0, 36.0).vertical;
    assert_eq!(readings.len(), 1440);
    let random: Vec<f64> = readings.iter().map(|one| one.random_at_reference).collect();
    for (found, expected) in shares(&random).into_iter().zip([26.7, 17.0, 4.9]) {
        assert!((found - expected).abs() < 0.15, "{found} instead of {expected}");
    }
    let least = 2.0 * random.iter().copied().fold(f64::INFINITY, f64::min);
    assert!((least - 28.6e-6).abs() < 0.05e-6, "{least}");
}

#[test]
fn the_vertical_angle_on_the_axis_by_differences_over_a_millisecond() {
    let table = campaign("table", 190.0, 36.0).table();
    for (found, expected) in shares(&table).into_iter().zip([26.7, 17.0, 4.9]) {
        assert!((found - expected).abs() < 0.15, "{found} instead of {expected}");
    }
    let least = table.iter().copied().fold(f64::INFINITY, f64::min);
    assert!((least - 28.6e-6).abs() < 0.05e-6, "{least}");
}

#[test]
fn the_uncertainty_grows_as_the_arm_slows_down() {
    let least = |name, rate| {
        let readings = campaign(name, rate, 36.0).vertical;
        readings.iter().map(|one| one.random).fold(f64::INFINITY, f64::min)
    };
    assert!((least("50", 50.0) / least("190", 190.0) - 3.8).abs() < 1e-3);
}

/// The difference over 1 ms is the mean slope in it, that is, the slope half a millisecond later.
#[test]
fn both_ways_part_as_the_slope_changes_in_half_a_millisecond() {
    let solved = campaign("both", 190.0, 36.0);
    let (readings, table) = (&solved.vertical, solved.table());
    let angles = arm_angles(&solved.opened);
    let rate = 190.0 * PI / 180.0;
    let least = readings.iter().map(|one| one.random).fold(f64::INFINITY, f64::min);
    let (mut near, mut far) = (0.0_f64, 0.0_f64);
    for (reading, table) in readings.iter().zip(&table) {
        let now = slope(angles[reading.sample], rate, 0.0);
        let later = slope(angles[reading.sample], rate, 0.5e-3);
        assert!((2.0 * VERTICAL / later.abs() / table - 1.0).abs() < 2e-4, "{reading:?}");
        if reading.state != State::Solved {
            continue;
        }
        let exact = reading.expanded_uncertainty();
        assert!((2.0 * VERTICAL / now.abs() / exact - 1.0).abs() < 1e-6, "{reading:?}");
        let apart = (table / exact).max(exact / table) - 1.0;
        if reading.random > 3.0 * least { far = far.max(apart) } else { near = near.max(apart) }
    }
    // Where the measurand moves they agree within a percent; at the edge of blindness, not.
    assert!(near < 0.01, "{near}");
    assert!(far > 0.015, "{far}");
}

/// Twice a turn, where the vertical angle turns round, it tells nothing of time.
#[test]
fn the_blind_ranges_are_where_the_vertical_angle_turns_round() {
    let delays = campaign("blind", 190.0, 36.0).delays;
    let ranges = &delays.measurands[MEASURAND].blind_ranges;
    assert_eq!(ranges.len(), 2, "{ranges:?}");
    // Top and bottom of the arm's circle: the arm's x axis points down at the homepoint.
    for (range, middle) in ranges.iter().zip([PI, TAU]) {
        assert!((0.5 * (range.from + range.to) - middle).abs() < 0.3 * PI / 180.0, "{range:?}");
        let width = (range.to - range.from) / TAU;
        assert!((width - 0.0245).abs() < 0.001, "{range:?}");
    }
    let blind: usize = ranges.iter().map(|range| range.readings).sum();
    assert_eq!(blind, delays.measurands[MEASURAND].blind);
    // At any other angle there is sight: the horizontal angle is blind elsewhere.
    let other = &delays.measurands[0].blind_ranges;
    assert!(other.iter().all(|a| ranges.iter().all(|b| a.to < b.from || b.to < a.from)));
}
