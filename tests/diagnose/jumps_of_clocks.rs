//! A clock that was set, or lost samples, by a good part of a period of the motion: no change that is
//! linear in the step sees that.

use homepoint::diagnose::Diagnosis;
use homepoint::diagnose::budget::answer::Verdict;
use homepoint::report::diagnosis_text::{Asked, text};

use crate::stream::Stream;
use crate::written::diagnosed;

/// Samples of a run, the first of the second part, and the sample period (s).
const SAMPLES: usize = 1100;
const FIRST: usize = 480;
const PERIOD: f64 = 0.02;

/// A shaker that swings at 0.9 Hz and 2.3 Hz, in two runs: of the second one the stamps are `late` (s)
/// too small from a sample on.
fn shaker(late: f64) -> Diagnosis {
    let swing = |t: f64| 60.0 * (5.65 * t).sin() + 9.0 * (14.45 * t + 0.4).sin();
    let model = "name = \"shaker\"\ntitle = \"Shaker\"\n[inputs]\ntable = { unit = \"m\", signal = true }\n\
         [parameters]\nzero = { unit = \"m\", scope = \"rig\" }\ngain = { unit = \"1\", scope = \"rig\", start = \"1\" }\n\
         [measurands]\npot = { value = 'zero + gain * table', unit = \"m\", sigma = \"0.3 mm\" }\n";
    let mut campaign =
        "title = \"Shaker\"\nmodel = \"model.toml\"\ndelay_range = \"1 s\"\n".to_owned();
    let mut files: Vec<(String, String)> = vec![("model.toml".into(), model.into())];
    let mut noise = Stream(11);
    for (name, by, start) in [("calm", 0.0, 0.0), ("set", late, 30.0)] {
        campaign += &format!(
            "[[runs]]\nname = \"{name}\"\ndata = \"{name}.csv\"\nsignals = [\"{name}_table.csv\"]\n"
        );
        let mut data = "time [s],pot [mm]\n".to_owned();
        for sample in 0..SAMPLES {
            let stamp = start + PERIOD * sample as f64;
            let late = if sample >= FIRST { by } else { 0.0 };
            let read = 2.0 + 1.004 * swing(stamp + late - 0.031) + 0.3 * noise.normal();
            data += &format!("{stamp:.4},{read:.4}\n");
        }
        let mut table = "time [s],table [mm]\n".to_owned();
        for sample in -40..(SAMPLES as i32 + 60) * 2 {
            let stamp = start + 0.5 * PERIOD * f64::from(sample);
            table += &format!("{stamp:.4},{:.5}\n", swing(stamp));
        }
        files.push((format!("{name}.csv"), data));
        files.push((format!("{name}_table.csv"), table));
    }
    files.push(("campaign.toml".into(), campaign));
    diagnosed(&files)
}

#[test]
fn a_clock_that_was_set_is_a_timing_error_from_its_row_on() {
    let found = shaker(0.4137);
    assert!(found.rows.is_empty(), "{:?}", found.rows);
    let [part] = &found.remainder[..] else { panic!("{:?}", found.remainder) };
    let text = text("", &found, &Asked::default());
    // The row of the file, whose head is row 1; a sample at the edge may fit at both moments.
    let from = part.place.rows.unwrap().0;
    assert!(part.share > 0.99 && from.abs_diff(FIRST + 2) <= 1, "{text}");
    assert!(text.contains("change 413.") && text.contains("a timing error of `pot`"), "{text}");
}

#[test]
fn samples_lost_in_a_full_buffer_are_left_out() {
    let found = shaker(21.0 * PERIOD);
    assert_eq!(found.verdict, Verdict::Explained);
    let [lost] = &found.left_out.lost[..] else { panic!("{:?}", found.left_out) };
    assert_eq!((lost.periods, &*lost.name), (21, "set"));
    assert!((lost.seconds - 21.0 * PERIOD).abs() < 0.1 * PERIOD && !lost.is_whole_run, "{lost:?}");
    // A sample at the edge may fit at both moments by chance.
    assert!(lost.samples.start.abs_diff(FIRST) <= 1 && lost.samples.end == SAMPLES, "{lost:?}");
}

/// What was left out beside the fit without the jump is not left out beside the one with it, and
/// nothing is listed twice.
#[test]
fn no_reading_is_left_out_twice() {
    for late in [0.31, 0.4137, 0.5123] {
        let found = shaker(late);
        let rows: Vec<_> = found.left_out.readings.iter().map(|one| (&one.run, one.row)).collect();
        let mut each = rows.clone();
        each.dedup();
        assert!(rows.len() == each.len() && rows.len() <= 4, "{late}: {rows:?}");
        assert!(
            found.rows.is_empty() && found.remainder.len() == 1,
            "{late} {}",
            crate::found::told(&found)
        );
    }
}

#[test]
fn nothing_is_wrong_without_a_jump() {
    assert_eq!(shaker(0.0).verdict, Verdict::Adequate);
}
