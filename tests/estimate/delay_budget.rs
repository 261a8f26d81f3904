//! Is the uncertainty of a delay made of what its budget says, and is it expanded as the GUM does?

use std::convert::Infallible;
use std::f64::consts::PI;

use homepoint::engine::Point;
use homepoint::engine::open::{Opened, Request, open};
use homepoint::engine::simulate::simulate;
use homepoint::estimate::batch::Options;
use homepoint::estimate::budget::{Budget, Contribution, budgets};
use homepoint::estimate::calibrate::{Calibration, calibrate};
use homepoint::estimate::coverage::{Combined, coverage_factor};
use homepoint::estimate::delays::Summary;
use homepoint::estimate::newton::{ReadingDelay, State};
use homepoint::estimate::systematic::Widening;
use homepoint::estimate::transformation::{Choice, transformation};

use crate::folder::Folder;
use crate::seed;

const ARCSEC: f64 = PI / 180.0 / 3600.0;
const RATE: f64 = 190.0 * PI / 180.0;

const CAMPAIGN: &str = r#"model = "polar_one_rotation"
[parameters]
radius      = { value = "1.146 m", U = "40 um", k = 2, degrees_of_freedom = 12 }
orientation = { value = ["0.05 rad", "0.1 rad", "-0.2 rad"] }
position    = { value = ["0.4 m", "0.1 m", "1.4 m"] }
"horizontal.delay" = { value = "0.2 ms" }
"vertical.delay"   = { value = "0.15 ms" }
"distance.delay"   = { value = "-0.1 ms" }
[timing]
method = "trigger"
edge = "1 us"
resolution = "2 us"
jitter = "1 us"
controller_gate = { value = "60 ns", U = "40 ns", k = 2, degrees_of_freedom = 5 }
[inputs]
arm_angle = { sigma = "1 arcsec", resolution = "3.6 arcsec", calibration = { U = "4.2 arcsec", k = 2, degrees_of_freedom = 30 } }
[measurands]
horizontal = { sigma = "10 urad" }
vertical   = { U = "20 urad", k = 2, degrees_of_freedom = 8 }
distance   = { sigma = "10 um" }
[[runs]]
name = "slow"
role = "reference"
plan = { trigger = "10 Hz", duration = "20 s", arm_angle = { start = "0 deg", rate = "20 deg/s" } }
[[runs]]
name = "back"
role = "reference"
plan = { trigger = "10 Hz", duration = "20 s", arm_angle = { start = "0 deg", rate = "-20 deg/s" } }
[[runs]]
name = "fast"
plan = { trigger = "40 Hz", duration = "10 s", arm_angle = { start = "0 deg", rate = "190 deg/s" } }
"#;

/// What came of the readings, and the delay of each, widened by the encoder's calibration.
struct Found {
    measurands: Vec<Summary>,
    readings: Vec<ReadingDelay>,
}

struct Solved {
    opened: Opened,
    joint: Calibration,
}

impl Solved {
    fn of(name: &str, campaign: &str) -> Self {
        let folder = Folder::new(name, &[("campaign.toml", campaign)]);
        let mut opened = open(&Request::new([&folder])).unwrap();
        let truth = Point::stated(&opened.problem.layout);
        simulate(&mut opened.problem, &truth, 11, true);
        let joint = calibrate(opened.problem.clone(), &Options::default()).unwrap();
        assert!(joint.is_sound(), "{:?}", joint.unobservable);
        Self { opened, joint }
    }

    fn budgets(&self) -> (Found, Vec<Budget>) {
        self.budgets_by(Choice::Best)
    }

    fn budgets_by(&self, choice: Choice) -> (Found, Vec<Budget>) {
        let taken = transformation(&self.opened.problem, Some(&self.joint), 0, choice).unwrap();
        let mut widening = Widening::new(taken.problem(), 0, &taken.fit().fit.point);
        let mut readings = Vec::new();
        let Ok(mut delays) = taken.delays(0, None, &mut |reading| {
            readings.push(widening.see(reading));
            Ok::<_, Infallible>(())
        });
        widening.widen(&mut delays);
        let budgets = budgets(&taken, 0, &self.opened.campaigns[0]);
        (Found { measurands: delays.measurands, readings }, budgets)
    }
}

fn line<'a>(budget: &'a Budget, name: &str) -> &'a Contribution {
    budget.contributions.iter().find(|one| one.name == name).unwrap()
}

#[track_caller]
fn close(found: f64, expected: f64, relative: f64) {
    assert!((found - expected).abs() <= relative * expected.abs(), "{found} is not {expected}");
}

/// Newton's own uncertainties come from the lanes; the lines are evaluated one by one.
#[test]
fn the_lines_add_up_to_the_uncertainty_of_the_delays() {
    add_up(&Solved::of("sum", CAMPAIGN).budgets());
}

/// What the delays found bring into the transformation stands in its line and in the readings'.
#[test]
fn the_lines_add_up_where_transformation_and_delays_are_found_in_turn() {
    let campaign = CAMPAIGN.replace("-20 deg/s", "5 deg/s");
    add_up(&Solved::of("turn", &campaign).budgets_by(Choice::Iterated));
}

#[track_caller]
fn add_up((delays, budgets): &(Found, Vec<Budget>)) {
    assert_eq!(budgets.len(), 3);
    for (measurand, (budget, summary)) in budgets.iter().zip(&delays.measurands).enumerate() {
        let part = |common: bool, of: fn(&Contribution) -> f64| {
            let own = budget.contributions.iter().filter(|one| one.is_common == common);
            own.map(of).fold(0.0, f64::hypot)
        };
        close(part(true, |one| one.mean), summary.common.unwrap(), 1e-9);
        close(part(false, |one| one.mean), summary.random.unwrap(), 1e-9);
        close(budget.mean.sigma, summary.sigma_of_mean.unwrap(), 1e-9);
        let solved: Vec<_> = delays
            .readings
            .iter()
            .filter(|one| one.measurand == measurand && one.state == State::Solved)
            .collect();
        let rms = |of: fn(&ReadingDelay) -> f64| {
            let squares: f64 = solved.iter().map(|one| of(one).powi(2)).sum();
            (squares / solved.len() as f64).sqrt()
        };
        close(part(true, |one| one.reading), rms(|one| one.common), 1e-9);
        close(part(false, |one| one.reading), rms(|one| one.random), 1e-9);
    }
}

/// Encoder and timing chain act on the moment alone: their part in one reading needs no model.
#[test]
fn encoder_and_timing_chain_by_hand() {
    let (_, budgets) = Solved::of("hand", CAMPAIGN).budgets();
    let root = 12.0_f64.sqrt();
    for budget in &budgets {
        let expected = [
            ("arm_angle.noise", 1.0 * ARCSEC / RATE, false),
            ("arm_angle.resolution", 3.6 * ARCSEC / root / RATE, false),
            ("arm_angle.calibration", 2.1 * ARCSEC / RATE, true),
            ("timing.edge", 1e-6 / root, true),
            ("timing.controller_gate", 20e-9, true),
            ("timing.resolution", 2e-6 / root, false),
            ("timing.jitter", 1e-6, false),
        ];
        for (name, sigma, is_common) in expected {
            let line = line(budget, name);
            close(line.reading, sigma, 1e-6);
            assert_eq!(line.is_common, is_common);
            // A common part is the same in the mean, a random one is not.
            if is_common { close(line.mean, sigma, 1e-6) } else { assert!(line.mean < 0.2 * sigma) }
        }
        assert_eq!(line(budget, "timing.controller_gate").degrees_of_freedom, Some(5.0));
        assert_eq!(line(budget, "arm_angle.calibration").degrees_of_freedom, Some(30.0));
    }
    let vertical = budgets.iter().find(|one| one.measurand == "vertical").unwrap();
    assert_eq!(line(vertical, "reading").degrees_of_freedom, Some(8.0));
}

/// Where nothing but its certificate tells the radius, its part is `∂m/∂r u(r) / m'`, and its
/// degrees of freedom count.
#[test]
fn a_certificate_with_few_degrees_of_freedom() {
    let position = [0.4, 0.1, 1.4];
    let campaign = r#"model = "polar_one_rotation"
[parameters]
radius      = { value = "1.146 m", U = "1 mm", k = 2, degrees_of_freedom = 3 }
orientation = { value = ["0 rad", "0 rad", "0 rad"], fixed = true }
position    = { value = ["0.4 m", "0.1 m", "1.4 m"], fixed = true }
"horizontal.delay" = { value = "0 s", fixed = true }
"distance.delay"   = { value = "0 s", fixed = true }
[measurands]
horizontal = { sigma = "1 rad" }
vertical   = { sigma = "1 mrad" }
distance   = { sigma = "1 m" }
[[runs]]
name = "fast"
plan = { trigger = "40 Hz", duration = "0.5 s", arm_angle = { start = "50 deg", rate = "190 deg/s" } }
"#;
    let solved = Solved::of("radius", campaign);
    let sigma = 500e-6;
    let estimates = solved.joint.estimates();
    let found = estimates.iter().find(|one| one.name == "radius").unwrap().sigma.unwrap();
    assert!(found < sigma, "{found}");
    let (delays, budgets) = solved.budgets();
    let budget = budgets.iter().find(|one| one.measurand == "vertical").unwrap();
    let samples = solved.opened.problem.parts[0].runs[0].held();
    let mut squares = Vec::new();
    for reading in delays.readings.iter().filter(|one| one.measurand == 1) {
        if reading.state == State::Solved {
            let at = |t: f64, r: f64| {
                let arm: f64 = samples.inputs[0].at(reading.sample, 0.0, reading.delay + t, 0);
                seed::polar_one_rotation(arm, r, [1.0, 0.0, 0.0, 0.0], position)[1]
            };
            let by_radius = (at(0.0, 1.1461) - at(0.0, 1.1459)) / 2e-4;
            let by_time = (at(1e-5, 1.146) - at(-1e-5, 1.146)) / 2e-5;
            squares.push((by_radius / by_time).powi(2));
        }
    }
    // Of the radius' variance after the fit, the certificate's part is its own weight in it.
    let gain = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    let line = line(budget, "radius");
    close(line.reading, gain * found * found / sigma, 2e-3);
    assert_eq!(line.degrees_of_freedom, Some(3.0));
    let variance: f64 = budget.contributions.iter().map(|one| one.mean.powi(2)).sum();
    let degrees = variance.powi(2) / (line.mean.powi(4) / 3.0);
    close(budget.mean.degrees_of_freedom, degrees, 1e-9);
    close(budget.mean.coverage_factor, coverage_factor(degrees), 1e-12);
    close(budget.mean.expanded(), coverage_factor(degrees) * variance.sqrt(), 1e-12);
    assert!(budget.mean.coverage_factor > 2.01, "{:?}", budget.mean);
}

/// GUM, table G.2, column 95.45 %.
#[test]
fn coverage_factors_are_those_of_the_table() {
    let table = [
        (1.0, 13.97),
        (2.0, 4.53),
        (3.0, 3.31),
        (4.0, 2.87),
        (5.0, 2.65),
        (6.0, 2.52),
        (7.0, 2.43),
        (8.0, 2.37),
        (9.0, 2.32),
        (10.0, 2.28),
        (20.0, 2.13),
        (30.0, 2.09),
        (50.0, 2.05),
    ];
    for (degrees, expected) in table {
        let found = coverage_factor(degrees);
        assert!((found - expected).abs() <= 0.005 + 1e-9, "{degrees}: {found}");
    }
    assert!((coverage_factor(100.0) - 2.025).abs() < 5e-4);
    assert_eq!(coverage_factor(f64::INFINITY), 2.0);
    assert!((coverage_factor(1e6) - 2.0).abs() < 1e-5);
}

/// GUM, H.1.6: the end gauge of 50 mm, effective degrees of freedom 16.7.
#[test]
fn effective_degrees_of_freedom_of_the_end_gauge() {
    let parts = [(25.0, Some(18.0)), (9.7, Some(25.6)), (2.9, Some(50.0)), (16.6, Some(2.0))];
    let combined = Combined::of(parts);
    assert!((combined.degrees_of_freedom - 16.7).abs() < 0.1, "{combined:?}");
    assert!((combined.sigma - 32.0).abs() < 0.5);
    let infinite = Combined::of([(3.0, None), (4.0, None)]);
    assert_eq!((infinite.sigma, infinite.coverage_factor), (5.0, 2.0));
}
