//! What is off in a part of a run, and single gross readings that bend the fit: told with their
//! rows, and neither taken for noise nor for an effect.

use std::collections::BTreeSet;
use std::ops::Range;

use homepoint::campaign::{Samples, Track};
use homepoint::diagnose::Diagnosis;
use homepoint::diagnose::budget::answer::Verdict;
use homepoint::diagnose::library::place::Of;
use homepoint::engine::Problem;
use homepoint::report::diagnosis_text::{Asked, text as told};

use crate::drawn::{drawn, run};
use crate::found::told as brief;
use crate::stream::Stream;

/// Changes the samples of a run.
fn edit(problem: &mut Problem, name: &str, change: impl FnMut(&mut Samples)) {
    let runs = &mut problem.parts[0].runs;
    runs.iter_mut().find(|run| run.name == name).unwrap().record.edit(change);
}

/// The angles of the arm.
fn angles(samples: &mut Samples) -> &mut Vec<f64> {
    let Track::Captured { value, .. } = &mut samples.inputs[0] else { unreachable!() };
    value
}

fn left_out(found: &Diagnosis) -> BTreeSet<(String, usize, String)> {
    assert!(found.left_out.runs.is_empty());
    let readings = found.left_out.readings.iter();
    let readings = readings.map(|one| (one.run.to_string(), one.row, one.measurand.to_string()));
    let stretches = found.left_out.stretches.iter().flat_map(|one| {
        (one.rows.0..=one.rows.1).map(|row| (one.run.clone(), row, one.measurand.clone()))
    });
    readings.chain(stretches).collect()
}

/// The farthest that a delay is from another one's, in standard uncertainties.
fn farthest(found: &Diagnosis, other: &Diagnosis) -> f64 {
    let of = |one: &Diagnosis| {
        let all = one.nominal.estimates().into_iter();
        all.filter(|one| one.name.ends_with(".delay")).collect::<Vec<_>>()
    };
    let apart = of(found)
        .into_iter()
        .zip(of(other))
        .map(|(a, b)| (a.value.unwrap() - b.value.unwrap()).abs() / b.sigma.unwrap());
    apart.fold(0.0, f64::max)
}

/// Who knocks against a tripod while a run is recorded displaces one reading from there on, or
/// until it is put right; small steps pass for a memory of the noise, large ones for outliers.
#[test]
fn a_step_within_a_run() {
    steps(&[("A_ccw50", 1, 80..119, 40.0 * 6e-6)]);
}

#[test]
fn a_small_step_within_a_run() {
    steps(&[("B_cw50", 0, 60..119, 5.0 * 6e-6)]);
}

#[test]
fn a_step_within_a_run_that_is_put_right() {
    steps(&[("A_cw190", 2, 30..75, 15.0 * 8e-6)]);
}

fn steps(all: &[(&str, usize, Range<usize>, f64)]) {
    let (opened, nominal) = drawn(&[], &[], 71);
    for (name, column, samples, by) in all.iter().cloned() {
        let mut problem = nominal.clone();
        edit(&mut problem, name, |all| {
            all.readings[column][samples.clone()].iter_mut().for_each(|value| *value += by);
        });
        let found = run(problem, &opened);
        let text = told("", &found, &Asked::default());
        assert_eq!(found.verdict, Verdict::Unknown, "{name}: {}", brief(&found));
        let measurand = ["horizontal", "vertical", "distance"][column];
        let places = found.remainder.iter().map(|one| &one.place);
        let own: Vec<_> = places.filter(|one| one.run.as_deref() == Some(name)).collect();
        let [place] = own[..] else { unreachable!("{}", brief(&found)) };
        assert_eq!(place.of, Of::Measurand(measurand.to_owned()));
        // The header is row 1. A small step is not seen to the sample.
        let Range { start, end } = samples;
        let off = |row: usize, sample: usize| row.abs_diff(sample + 2);
        let (first, last) = place.rows.unwrap();
        assert!(off(first, start) <= 2, "{place:?}");
        assert!(last.is_some_and(|last| off(last, end - 1) <= 2), "{place:?}");
        assert!(found.left_out.is_empty(), "{text}");
    }
}

/// A clock that jumps within a run: every reading of it is off from there on, as its target moves.
#[test]
fn a_clock_that_jumps_within_a_run() {
    let (opened, mut problem) = drawn(&[], &[], 72);
    let rate = 50.0_f64.to_radians();
    edit(&mut problem, "B_ccw50", |all| {
        angles(all)[50..].iter_mut().for_each(|angle| *angle += rate * 3e-4);
    });
    let found = run(problem, &opened);
    assert_eq!(found.verdict, Verdict::Unknown, "{}", brief(&found));
    let place = &found.remainder[0].place.words;
    assert!(place.contains("in run `B_ccw50`"), "{place}");
}

/// A display that repeats readings now and then makes them thousands of uncertainties wrong: those
/// are left out, however many there are, and nothing else is.
#[test]
fn repeated_readings_are_left_out_and_no_others() {
    let (opened, nominal) = drawn(&[], &[], 73);
    let clean = run(nominal.clone(), &opened);
    let names: Vec<String> = nominal.parts[0].runs.iter().map(|run| run.name.clone()).collect();
    for (share, columns) in [(2.0, 2..3), (8.0, 2..3), (8.0, 0..3)] {
        let (mut problem, mut stream) = (nominal.clone(), Stream(7));
        let mut repeated = BTreeSet::new();
        for name in &names {
            edit(&mut problem, name, |all| {
                for sample in (1..119).rev() {
                    if 100.0 * stream.uniform() < share {
                        for column in columns.clone() {
                            all.readings[column][sample] = all.readings[column][sample - 1];
                            let measurand = ["horizontal", "vertical", "distance"][column];
                            repeated.insert((name.clone(), sample + 2, measurand.to_owned()));
                        }
                    }
                }
            });
        }
        let found = run(problem, &opened);
        assert_eq!(found.verdict, Verdict::Explained, "{share}: {}", brief(&found));
        assert!(found.rows.is_empty(), "{share}: {}", brief(&found));
        let out = left_out(&found);
        assert!(out.difference(&repeated).count() <= 1, "{share}: {:?}", out.difference(&repeated));
        // Where the reading stands still by itself its repetition is right.
        assert!(
            10 * out.len() > 9 * repeated.len(),
            "{share}: {} of {}",
            out.len(),
            repeated.len()
        );
        assert!(farthest(&found, &clean) < 2.0, "{share}: {}", farthest(&found, &clean));
    }
}

/// What an instrument writes where it lost its target keeps the fit from settling or spoils it: all
/// such codes are left out, and nothing else is, though a code may be a reading that could be.
#[test]
fn codes_in_the_place_of_readings() {
    let (opened, nominal) = drawn(&[], &[], 75);
    let clean = run(nominal.clone(), &opened);
    let names: Vec<String> = nominal.parts[0].runs.iter().map(|run| run.name.clone()).collect();
    for (code, columns, every) in
        [(99_999.0, 2..3, 30), (-1.0, 2..3, 9), (0.0, 2..3, 4), (0.0, 0..3, 3), (1e6, 1..2, 60)]
    {
        let (mut problem, mut lost) = (nominal.clone(), BTreeSet::new());
        for (start, name) in names.iter().enumerate() {
            edit(&mut problem, name, |all| {
                for sample in (start % every..119).step_by(every) {
                    for column in columns.clone() {
                        all.readings[column][sample] = code;
                        let measurand = ["horizontal", "vertical", "distance"][column];
                        lost.insert((name.clone(), sample + 2, measurand.to_owned()));
                    }
                }
            });
        }
        let found = run(problem, &opened);
        assert_eq!(found.verdict, Verdict::Explained, "{code}: {}", brief(&found));
        assert!(found.rows.is_empty(), "{code}: {}", brief(&found));
        let out = left_out(&found);
        assert!(lost.difference(&out).next().is_none(), "{code}: {}", brief(&found));
        assert!(out.difference(&lost).count() <= 1, "{code}: {}", brief(&found));
        assert!(farthest(&found, &clean) < 3.0, "{code}: {}", farthest(&found, &clean));
    }
}

/// The log of an encoder that stands still for a moment is no jitter of all runs.
#[test]
fn a_log_that_stands_still_for_three_samples() {
    let (opened, mut problem) = drawn(&[], &[], 74);
    edit(&mut problem, "A_cw50", |all| {
        let still = angles(all)[70];
        angles(all)[71..74].fill(still);
    });
    let found = run(problem, &opened);
    assert_eq!(found.verdict, Verdict::Explained, "{}", brief(&found));
    assert!(found.rows.is_empty() && found.noise.is_empty(), "{}", brief(&found));
    assert!(
        left_out(&found).iter().all(|(run, row, _)| run == "A_cw50" && (73..=75).contains(row))
    );
}

/// Noise of unit variance, a part of which lasts from sample to sample.
fn lasting(seed: u64, count: usize, share: f64, decay: f64) -> Vec<f64> {
    let mut stream = Stream(seed);
    let mut normal = || stream.normal();
    let mut slow = normal();
    let mut next = || {
        slow = decay * slow + (1.0 - decay * decay).sqrt() * normal();
        share.sqrt() * slow + (1.0 - share).sqrt() * normal()
    };
    (0..count).map(|_| next()).collect()
}

/// A memory that all runs have is noise, even where one run is much noisier than the others.
#[test]
fn a_noisier_run_with_the_memory_of_all_is_noise() {
    let (opened, nominal) = drawn(&[], &[], 75);
    for (factor, seed) in [(1.0, 1), (4.0, 2)] {
        let mut problem = nominal.clone();
        for (number, run) in problem.parts[0].runs.iter_mut().enumerate() {
            let own = lasting(1000 * seed + number as u64, 119, 0.6, 0.85);
            let size = 8e-6 * if number == 7 { factor } else { 1.0 };
            run.record.edit(|all| {
                all.readings[1].iter_mut().zip(&own).for_each(|(value, own)| *value += size * own);
            });
        }
        let found = run(problem, &opened);
        assert_ne!(found.verdict, Verdict::Unknown, "{factor}: {}", brief(&found));
        assert!(!found.autocorrelation.is_empty(), "{factor}: {}", brief(&found));
    }
}

/// What is read while a beam is broken goes with its rows, and spoils nothing else.
#[test]
fn a_burst_in_one_run() {
    let (opened, nominal) = drawn(&[], &[], 76);
    let clean = run(nominal.clone(), &opened);
    for (column, by) in [(2, 3000.0 * 8e-6), (0, -300.0 * 6e-6)] {
        let mut problem = nominal.clone();
        edit(&mut problem, "B_cw50", |all| {
            all.readings[column][40..52].iter_mut().for_each(|value| *value += by);
        });
        let found = run(problem, &opened);
        let rows: BTreeSet<usize> = left_out(&found).into_iter().map(|(_, row, _)| row).collect();
        assert_eq!(rows, (42..54).collect(), "{}", brief(&found));
        assert!(found.levels.is_empty(), "{:?}", found.levels);
        assert!(farthest(&found, &clean) < 1.0);
    }
}
