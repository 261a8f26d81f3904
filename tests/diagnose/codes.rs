//! Codes in the place of readings: they are no measurements, are told as what they are, and change
//! nothing else.

use std::path::Path;

use homepoint::diagnose::Diagnosis;
use homepoint::diagnose::budget::answer::Verdict;
use homepoint::diagnose::found::{NoReading, Reading};
use homepoint::engine::Problem;
use homepoint::engine::open::{Request, open};
use homepoint::report;

use crate::drawn::{drawn, folder, run};

fn out(found: &Diagnosis) -> &[Reading] {
    &found.left_out.readings
}

/// Puts numbers into the columns of every so many samples; how many that are.
fn put(problem: &mut Problem, every: usize, codes: &[(usize, f64)]) -> usize {
    let mut count = 0;
    for run in problem.parts.iter_mut().flat_map(|part| &mut part.runs) {
        run.record.edit(|samples| {
            for sample in (3..samples.len()).step_by(every) {
                for (column, code) in codes {
                    samples.readings[*column][sample] = *code;
                }
                count += 1;
            }
        });
    }
    count
}

/// A code for a missing value keeps a fit from settling; it is a few readings of thousands.
#[test]
fn codes_for_missing_values_are_left_out_by_row() {
    let opened = open(&Request::new([folder()])).unwrap();
    for code in [99_999.0, 9_999.999, -999.0] {
        let mut parts = opened.problem.parts.clone();
        let rows = [7, 90, 100, 101];
        parts[0].runs[2].record.edit(|samples| {
            rows.iter().for_each(|row| samples.readings[2][*row] = code);
        });
        let row = |sample: &usize| parts[0].runs[2].record.row(*sample);
        let due: Vec<usize> = rows.iter().map(row).collect();
        let name = parts[0].runs[2].name.clone();
        let found = run(Problem::new(parts), &opened);
        // Four of thousands are more than chance gives: outliers, and nothing else.
        assert_eq!((found.verdict, found.rows.len()), (Verdict::Explained, 0), "{code}");
        assert!(found.noise.iter().all(|one| one.name == "outliers"), "{code}");
        let left_out = &found.left_out;
        let own = left_out.readings.iter();
        let told: Vec<usize> = own
            .filter(|one| *one.run == *name && &*one.measurand == "distance")
            .map(|one| one.row)
            .collect();
        assert_eq!((told, left_out.readings.len()), (due, rows.len()), "{code}");
        assert!(
            left_out.readings.iter().all(|one| one.instead == Some(NoReading::Code(code))),
            "{code}"
        );
    }
}

/// An instrument that writes zero where its beam is broken, in a campaign with a level of its own,
/// which would grow until zeros fit.
#[test]
fn codes_do_not_hide_in_an_open_level() {
    let (_, mut problem) = drawn(&[], &[], 51);
    let mut request = Request::new([folder()]);
    request.with = vec!["timestamp_jitter".to_owned()];
    let mut opened = open(&request).unwrap();
    let count = put(&mut problem, 7, &[(2, 0.0)]);
    for (part, other) in opened.problem.parts.iter_mut().zip(problem.parts) {
        part.runs = other.runs;
    }
    let found = run(opened.problem.clone(), &opened);
    assert_eq!((found.verdict, found.rows.len()), (Verdict::Explained, 0));
    assert_eq!(out(&found).len(), count);
    assert!(out(&found).iter().all(|one| one.instead == Some(NoReading::Code(0.0))));
    let text = report::diagnosis_text::text("", &found, &report::diagnosis_text::Asked::default());
    let told = format!("{count} readings of `distance` are 0 m, a code for what was not measured");
    assert!(text.contains(&told) && !text.contains("outliers"), "{text}");
}

/// A camera that writes no turn and no way where it does not see its target.
#[test]
fn a_rotation_that_was_not_measured_is_a_code() {
    let (found, count) = hand_eye_with_codes(900);
    let codes = out(&found).iter().filter(|one| one.instead.is_some()).count();
    assert_eq!(codes, count);
    let text = report::diagnosis_text::text("", &found, &report::diagnosis_text::Asked::default());
    let told = format!("{count} readings of `attitude` are one and the same turn, a code");
    assert!(text.contains(&told), "{text}");
}

#[test]
#[ignore = "a known wrong answer: docs/diagnosis-evidence.md"]
fn jitter_is_named_beside_codes() {
    let (found, _) = hand_eye_with_codes(usize::MAX);
    assert_eq!(found.verdict, Verdict::Explained);
}

/// At most so many samples of the recording of the example, with the turn of every ninth not measured,
/// and their number.
fn hand_eye_with_codes(most: usize) -> (Diagnosis, usize) {
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/hand_eye");
    let opened = open(&Request::new([example])).unwrap();
    let mut problem = opened.problem.clone();
    let record = &mut problem.parts[0].runs[0].record;
    if record.len() > most {
        *record = record.spread(most, 30).into();
    }
    let slots = problem.parts[0].slots().to_vec();
    let rotation = slots.iter().find(|slot| slot.width == 4).unwrap();
    let none: Vec<(usize, f64)> = rotation.columns().zip([1.0, 0.0, 0.0, 0.0]).collect();
    let count = put(&mut problem, 9, &none);
    (run(problem, &opened), count)
}
