//! Stretches of wrong readings are left out with their rows, and change nothing else; what only looks
//! like them is structure.

use std::ops::Range;

use homepoint::campaign::{Samples, Track};
use homepoint::diagnose::Diagnosis;
use homepoint::diagnose::budget::answer::Verdict;
use homepoint::diagnose::outliers::lost::look;
use homepoint::engine::Problem;
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::calibrate;
use homepoint::report::diagnosis_text::{Asked, text};

use crate::drawn::{drawn, run};
use homepoint::diagnose::found::Wrong;

use crate::found::told;

fn edit(problem: &mut Problem, name: &str, change: impl FnMut(&mut Samples)) {
    let runs = &mut problem.parts[0].runs;
    runs.iter_mut().find(|run| run.name == name).unwrap().record.edit(change);
}

/// Run, samples and measurand of each stretch; row 2 is that of sample 0.
fn stretches(found: &Diagnosis) -> Vec<(&str, Range<usize>, &str)> {
    let each = found.left_out.stretches.iter();
    let samples = |rows: (usize, usize)| rows.0 - 2..rows.1 - 1;
    each.map(|one| (one.run.as_str(), samples(one.rows), one.measurand.as_str())).collect()
}

fn delays(found: &Diagnosis) -> Vec<(f64, f64)> {
    let all = found.nominal.estimates().into_iter().filter(|one| one.name.ends_with(".delay"));
    all.map(|one| (one.value.unwrap(), one.sigma.unwrap())).collect()
}

/// The verdict is that of readings left out, and delays are as without the wrong stretches.
fn is_right(found: &Diagnosis, clean: &Diagnosis) {
    assert_eq!(found.verdict, Verdict::Explained, "{}", told(found));
    assert!(found.rows.is_empty() && found.autocorrelation.is_empty(), "{}", told(found));
    for ((value, _), (due, sigma)) in delays(found).into_iter().zip(delays(clean)) {
        assert!((value - due).abs() < sigma, "{value} is not {due} \u{b1} {sigma}");
    }
}

const BURSTS: [(&str, Range<usize>); 4] =
    [("A_cw50", 20..32), ("A_cw50", 71..83), ("B_ccw190", 50..60), ("B_cw50", 90..104)];

/// An instrument that repeats its last readings bit for bit while the arm moves on.
#[test]
fn readings_that_stand_still_are_left_out() {
    let (opened, nominal) = drawn(&[], &[], 611);
    let mut problem = nominal.clone();
    for (name, samples) in BURSTS {
        edit(&mut problem, name, |all| {
            for column in &mut all.readings {
                let last = column[samples.start - 1];
                column[samples.clone()].fill(last);
            }
        });
    }
    let found = run(problem, &opened);
    is_right(&found, &run(nominal, &opened));
    assert!(
        found.left_out.stretches.iter().all(|one| one.how == Wrong::Repeated),
        "{}",
        told(&found)
    );
    for (name, samples) in BURSTS {
        for measurand in ["horizontal", "vertical", "distance"] {
            let due = (name, samples.clone(), measurand);
            assert!(stretches(&found).contains(&due), "{due:?} in {:?}", stretches(&found));
        }
    }
    let text = text("", &found, &Asked::default());
    assert!(text.contains("in rows 22 to 33 of run `A_cw50`: repeat their last values"), "{text}");
}

/// Distances along another way for a while, by a dozen standard deviations.
#[test]
fn a_measurand_that_is_wrong_for_a_while_is_left_out() {
    let (opened, nominal) = drawn(&[], &[], 612);
    let mut problem = nominal.clone();
    for (number, (name, samples)) in BURSTS.into_iter().enumerate() {
        edit(&mut problem, name, |all| {
            let by = 8e-6 * [14.0, 18.0, 12.0, 16.0][number];
            all.readings[2][samples.clone()].iter_mut().for_each(|value| *value += by);
        });
    }
    let found = run(problem, &opened);
    is_right(&found, &run(nominal, &opened));
    assert_eq!(stretches(&found).len(), BURSTS.len(), "{:?}", stretches(&found));
    for (name, samples) in BURSTS {
        assert!(stretches(&found).contains(&(name, samples, "distance")), "{}", told(&found));
    }
}

/// Distances far out, and angles of the same samples by less than shows reading by reading.
#[test]
fn what_is_off_beside_a_burst_is_left_out_with_it() {
    let (opened, nominal) = drawn(&[], &[], 614);
    let mut problem = nominal.clone();
    let long = [("A_cw50", 20..44), ("B_cw50", 60..86)];
    for (name, samples) in long.clone() {
        edit(&mut problem, name, |all| {
            for (column, by) in [(0, 18e-6), (2, 0.1)] {
                all.readings[column][samples.clone()].iter_mut().for_each(|value| *value += by);
            }
        });
    }
    let found = run(problem, &opened);
    is_right(&found, &run(nominal, &opened));
    for (name, samples) in long {
        for (measurand, is_off) in [("horizontal", true), ("vertical", false), ("distance", true)] {
            let one = (name, samples.clone(), measurand);
            assert_eq!(stretches(&found).contains(&one), is_off, "{one:?}: {}", told(&found));
        }
    }
}

/// Two measurands far out, and the third of the same samples by less: each is left out once.
#[test]
fn what_is_off_beside_two_bursts_is_left_out_once() {
    let (opened, nominal) = drawn(&[], &[], 615);
    let mut problem = nominal.clone();
    let long = [("A_cw50", 20..44), ("B_cw50", 60..86)];
    for (name, samples) in long.clone() {
        edit(&mut problem, name, |all| {
            for (column, by) in [(0, 0.02), (1, 18e-6), (2, 0.1)] {
                all.readings[column][samples.clone()].iter_mut().for_each(|value| *value += by);
            }
        });
    }
    let found = run(problem, &opened);
    is_right(&found, &run(nominal, &opened));
    for (name, samples) in long {
        for measurand in ["horizontal", "vertical", "distance"] {
            let all = stretches(&found);
            let count =
                all.iter().filter(|one| **one == (name, samples.clone(), measurand)).count();
            assert_eq!(count, 1, "{measurand} of {name}: {}", told(&found));
        }
    }
}

/// An instrument that follows another target for a while: whole samples, far out.
#[test]
fn whole_samples_that_are_wrong_are_left_out() {
    let (opened, nominal) = drawn(&[], &[], 613);
    let mut problem = nominal.clone();
    for (name, samples) in BURSTS {
        edit(&mut problem, name, |all| {
            for (column, by) in [(0, 0.02), (1, -0.03), (2, 0.1)] {
                all.readings[column][samples.clone()].iter_mut().for_each(|value| *value += by);
            }
        });
    }
    let found = run(problem, &opened);
    is_right(&found, &run(nominal, &opened));
    for (name, samples) in BURSTS {
        for measurand in ["horizontal", "vertical", "distance"] {
            let due = (name, samples.clone(), measurand);
            assert!(stretches(&found).contains(&due), "{due:?} in {:?}", stretches(&found));
        }
    }
}

/// Distances that are wrong at the same angles of the arm, run after run, are structure.
#[test]
fn what_comes_back_at_an_angle_is_no_burst() {
    let (opened, mut problem) = drawn(&[], &[], 614);
    for run in &mut problem.parts[0].runs {
        run.record.edit(|all| {
            let Track::Captured { value: angles, .. } = &all.inputs[0] else { unreachable!() };
            let sector =
                |angle: &f64| (1.0..1.3).contains(&angle.rem_euclid(std::f64::consts::TAU));
            let wrong: Vec<bool> = angles.iter().map(sector).collect();
            let pairs = all.readings[2].iter_mut().zip(wrong);
            pairs.filter(|(_, wrong)| *wrong).for_each(|(value, _)| *value += 14.0 * 8e-6);
        });
    }
    let found = run(problem, &opened);
    assert!(found.left_out.stretches.is_empty(), "{}", told(&found));
    assert!(found.verdict.has_remainder(), "{}", told(&found));
}

/// Moves the moments of a run's samples from one on.
fn set_clock(problem: &mut Problem, name: &str, from: usize, periods: f64) {
    edit(problem, name, |all| {
        let set = periods * (all.time[1] - all.time[0]);
        for input in &mut all.inputs {
            if let Track::Captured { value, rate: Some(rate), .. } = input {
                let pairs = value.iter_mut().zip(rate).skip(from);
                pairs.for_each(|(value, rate)| *value += *rate * set);
            }
        }
    });
}

/// A clock that is set by parts of a period has lost no samples.
#[test]
fn only_whole_periods_are_lost_samples() {
    let options = Options::default();
    for periods in [1.4, 1.95, -2.9] {
        let (_, mut problem) = drawn(&[], &[], 615);
        set_clock(&mut problem, "A_ccw50", 60, periods);
        let nominal = calibrate(problem, &options).unwrap();
        let (point, factor) = (&nominal.fit.point, nominal.variance_factor());
        let lost = look(&nominal.problem, point, factor, &options).unwrap();
        assert!(lost.lost.is_empty(), "{periods}: {lost:?}");
    }
}

/// Many frames that were lost at once.
#[test]
fn eight_lost_samples_are_reported() {
    let (opened, mut problem) = drawn(&[], &[], 616);
    edit(&mut problem, "A_ccw50", |all| {
        for column in &mut all.readings {
            column[40..].rotate_left(8);
            let count = column.len();
            column[count - 8..].fill(f64::NAN);
        }
    });
    let found = run(problem, &opened);
    assert_eq!(found.verdict, Verdict::Explained, "{}", told(&found));
    let [lost] = &found.left_out.lost[..] else { unreachable!("{:?}", found.left_out) };
    assert_eq!((lost.periods, lost.samples.start), (8, 40), "{lost:?}");
}
