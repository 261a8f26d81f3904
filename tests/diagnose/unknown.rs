//! Causes that no library holds: unknown, with their place.

use std::path::Path;

use homepoint::diagnose::budget::answer::{Remainder, Verdict};
use homepoint::diagnose::diagnose;
use homepoint::diagnose::library::wanted::Wanted;
use homepoint::engine::layout::Instance;
use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::Options;

use crate::drawn::{drawn_at, folder};
use crate::found::told;
use crate::nameless::{
    best_place, with_a_nameless, with_a_nameless_and_without, with_a_nameless_in,
};

/// A common delay that changed in one run: no effect of the library says so, and a wave that every
/// sample of that run meets at the same phase must not.
#[test]
fn what_happened_to_one_run() {
    let text = "[parameters]\nlate = { unit = \"s\", typical = \"10 us\", scope = \"run\" }\n\
                [patch]\nt = 't + late'\n";
    for (name, seed) in [("A_ccw50", 61), ("B_cw190", 62)] {
        let late = |one: &Instance| if one.of.as_deref() == Some(name) { 7e-6 } else { 0.0 };
        let found = with_a_nameless(text, seed, &late);
        let place = best_place(&found);
        assert_eq!(place.covariate, "run", "{name}: {}", told(&found));
        assert!(place.words.contains("timing error"), "{name}: {}", told(&found));
    }
}

/// A prism whose constant changed in one of four setups is nearly what a target beside its radius
/// is. Where unknown structure is likelier than that by far it has no name, even if nothing can be
/// seen beside it.
#[test]
#[ignore = "long"]
fn what_changed_in_one_setup() {
    let text = "[parameters]\nprism = { unit = \"m\", typical = \"30 um\", scope = \"setup\" }\n\
                [patch]\ndistance = 'distance + prism'\n";
    let campaign = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/four_setups");
    for seed in 83..87 {
        let prism = |one: &Instance| if one.of.as_deref() == Some("C") { 30e-6 } else { 0.0 };
        let found = with_a_nameless_in(campaign.clone(), &[], text, seed, &prism);
        if let [one] = &found.rows[..] {
            assert_eq!(one.name, "target_radial_offset", "{seed}");
            assert!(one.posterior > 0.2, "{seed}: {}", one.posterior);
            continue;
        }
        let place = best_place(&found);
        assert!(place.words.contains("`distance`"), "{seed}: {}", place.words);
    }
}

/// Finer than waves of blocks are: at each rate it is an oscillation of a frequency of its own.
#[test]
fn an_encoder_with_twelve_or_thirty_waves_a_turn() {
    for (order, seed) in [(12, 64), (30, 65)] {
        let text = format!(
            "[parameters]\nwave = {{ unit = \"rad\", typical = \"1 arcsec\", scope = \"rig\" }}\n\
             [patch]\narm_angle = 'arm_angle + wave * cos({order} * arm_angle)'\n"
        );
        let found = with_a_nameless(&text, seed, &|_| 15e-6);
        let place = best_place(&found);
        assert!(place.words.ends_with(&format!("{order} waves a turn")), "{}", place.words);
        assert_eq!(place.covariate, "arm_angle");
    }
}

/// A belt that goes round once while the arm goes round twice, and a pedestal that the drive pushes
/// back (a walk could have come to the same places).
#[test]
fn what_belts_and_pedestals_do() {
    let belt = "cos(arm_angle / 2 + 1) * rotate(arm_turn, [1, 0, 0])";
    let half = "a radial displacement of the target over arm_angle, 0.5 waves a turn";
    let push = "sign(rate(arm_angle)) * [1, 0.4, 0]";
    let sense = "a displacement of the rig's pedestal over sense of arm_angle";
    for (moved, words, seed) in [(belt, half, 71), (push, sense, 75)] {
        let text = format!(
            "[parameters]\nby = {{ unit = \"m\", typical = \"10 um\", scope = \"rig\" }}\n\
             [patch]\ntarget = 'target + by * {moved}'\n"
        );
        let found = with_a_nameless(&text, seed, &|_| 9e-6);
        assert_eq!(best_place(&found).words, words);
    }
}

/// What a room's climate does in the course of a setup is neither noise with a memory nor a walk.
#[test]
fn what_swings_slowly() {
    for (period, patch, place_of, seed) in [
        (300.0, "distance = 'distance + SWING'", "an error of `distance`", 72),
        (60.0, "vertical = 'vertical + SWING / 1 m'", "an error of `vertical`", 73),
        (
            140.0,
            "position = 'position + SWING * [1, -0.5, 0.3]'",
            "a displacement of the instrument or the rig",
            74,
        ),
    ] {
        let text = format!(
            "[parameters]\nswing = {{ unit = \"m\", typical = \"10 um\", scope = \"rig\" }}\n\
             phase = {{ unit = \"rad\", typical = \"1 rad\", scope = \"setup\" }}\n\
             period = {{ unit = \"s\", value = \"{period} s\", fixed = true }}\n[patch]\n{patch}\n"
        )
        .replace("SWING", "swing * sin(2 * pi * setup_time / period + phase)");
        let value = |one: &Instance| match one.of.as_deref() {
            None => 8e-6,
            Some(setup) => setup.bytes().map(f64::from).sum::<f64>(),
        };
        let found = with_a_nameless(&text, seed, &value);
        let place = best_place(&found);
        let words: Vec<&str> = place.words.split(" over time, a wave every ").collect();
        assert_eq!(words[0], place_of);
        let said: f64 = words[1].trim_end_matches(" s").parse().unwrap();
        assert!((said / period - 1.0).abs() < 0.02, "{}", place.words);
    }
}

/// Exponential settling after each run begins is neither a slow wave nor a few outliers at its
/// start.
#[test]
fn what_comes_to_rest_in_each_run() {
    let rest = "creep * exp(-(run_time / rest_time))";
    for (time, size, patch, place_of, seed) in [
        (1.5, 60e-6, "vertical = 'vertical + REST / 1 m'", "an error of `vertical`", 76),
        (
            6.0,
            80e-6,
            "target = 'target + REST * sign(rate(arm_angle)) * rotate(arm_turn, [0, 1, 0])'",
            "a tangential displacement of the target",
            77,
        ),
    ] {
        let text = format!(
            "[parameters]\ncreep = {{ unit = \"m\", typical = \"10 um\", scope = \"rig\" }}\n\
             rest_time = {{ unit = \"s\", value = \"{time} s\", fixed = true }}\n[patch]\n{patch}\n"
        )
        .replace("REST", rest);
        let found = with_a_nameless(&text, seed, &|_| size);
        let place = best_place(&found);
        let words: Vec<&str> =
            place.words.split(" over run time, exponential settling in ").collect();
        assert_eq!(words[0], place_of);
        let said: f64 = words[1].trim_end_matches(" s").parse().unwrap();
        assert!((said / time - 1.0).abs() < 0.15, "{}", place.words);
        let left_out = &found.left_out;
        assert!(left_out.readings.len() < 4 && left_out.runs.is_empty(), "{left_out:?}");
    }
}

/// The same where the model has a platform, which never moves here: its sense is nothing.
#[test]
fn what_comes_to_rest_where_a_signal_stands_still() {
    let standing = tempfile::tempdir().unwrap();
    for file in std::fs::read_dir(folder()).unwrap() {
        let file = file.unwrap().path();
        let at = standing.path().join(file.file_name().unwrap());
        let Some("csv" | "toml") = file.extension().and_then(|end| end.to_str()) else { continue };
        let text = std::fs::read_to_string(&file).unwrap();
        let with_a_platform = |(row, line): (usize, &str)| {
            let columns =
                if row == 0 { "platform_angle [deg],platform_angle_rate [deg/s]" } else { "0,0" };
            format!("{line},{columns}\n")
        };
        let text = if file.extension().is_some_and(|end| end == "csv") {
            text.lines().enumerate().map(with_a_platform).collect()
        } else {
            text.replace("polar_one_rotation", "polar_two_rotations")
        };
        std::fs::write(at, text).unwrap();
    }
    let own = standing.path().join("own");
    std::fs::create_dir(&own).unwrap();
    std::fs::write(
        own.join("nameless.toml"),
        "name = \"nameless\"\ntitle = \"Nameless\"\nacts = \"instrument\"\n\
         [parameters]\ncreep = { unit = \"rad\", typical = \"10 urad\", scope = \"rig\" }\n\
         [patch]\nvertical = 'vertical + creep * exp(-(run_time / 6 s))'\n",
    )
    .unwrap();
    let mut request = Request::new([standing.path()]);
    request.effects = vec![own];
    request.with = vec!["nameless".to_owned()];
    let (opened, problem) = drawn_at(&request, 78, &|_| Some(60e-6));
    let found = diagnose(problem, opened.recipes, &Wanted::default(), &Options::default()).unwrap();
    let place = best_place(&found);
    let said =
        place.words.strip_prefix("an error of `vertical` over run time, exponential settling in ");
    let said: f64 = said.unwrap().trim_end_matches(" s").parse().unwrap();
    assert!((said / 6.0 - 1.0).abs() < 0.15, "{}", place.words);
}

/// The arm swings along its axis, which distances show best, the instrument along its beam and, as
/// slowly as its noise might, in its zenith angle, each run with a phase of its own.
#[test]
fn what_swings_otherwise_than_in_torsion() {
    let swing = "swing * cos(2 * pi * f * run_time + phase)";
    let parameters = "[parameters]\nswing = { unit = \"m\", typical = \"10 um\", scope = \"rig\" }\n\
                      phase = { unit = \"rad\", typical = \"1 rad\", scope = \"run\" }\n\
                      f = { unit = \"Hz\", value = \"FREQUENCY Hz\", fixed = true }\n[patch]\n";
    for (frequency, patch, seed) in [
        ("1.433", "target = 'target + [0, 0, SWING]'", 66),
        ("3.07", "distance = 'distance + SWING'", 67),
        ("0.22", "vertical = 'vertical + SWING / 1 m'", 68),
    ] {
        let text = format!("{parameters}{patch}\n");
        let text = text.replace("SWING", swing).replace("FREQUENCY", frequency);
        let value = |one: &Instance| match one.of.as_deref() {
            None => 12e-6,
            Some(run) => run.bytes().map(f64::from).sum::<f64>(),
        };
        let found = with_a_nameless(&text, seed, &value);
        let place = best_place(&found);
        assert_eq!(place.covariate, "oscillation", "{}", told(&found));
        assert!(found.noise.is_empty(), "{}", told(&found));
        let said: f64 = place.words.split_whitespace().rev().nth(1).unwrap().parse().unwrap();
        assert!((said - frequency.parse::<f64>().unwrap()).abs() < 0.01, "{}", place.words);
    }
}

/// A swing that is shaken again and again is no wave with a phase of each run's own: it passed for
/// noise that is larger than stated. Beside an effect of the library it is not all there is.
#[test]
fn what_swings_without_a_steady_phase() {
    let own = "[parameters]\nswing = { unit = \"m\", typical = \"30 um\", scope = \"rig\" }\n\
               f = { unit = \"Hz\", value = \"2.6 Hz\", fixed = true }\n\
               second = { unit = \"s\", value = \"1 s\", fixed = true }\n\
               bow = { unit = \"rad\", typical = \"1 urad\", scope = \"rig\" }\n[patch]\n";
    let wander = "0.04 * (run_time / second)^2 + 3 * sin(0.71 * run_time / second)";
    let swing = format!("swing * cos(2 * pi * f * run_time + {wander})");
    let swings = format!("{own}distance = 'distance + {swing}'\n");
    let moving = || Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/05_two_rotations");
    let value = |one: &Instance| if one.name.ends_with("swing") { 7e-6 } else { 0.0 };
    let found = with_a_nameless_in(moving(), &[], &swings, 75, &value);
    let place = best_place(&found);
    assert!(place.is_oscillation(), "{}", told(&found));
    let said: f64 = place.words.split_whitespace().rev().nth(1).unwrap().parse().unwrap();
    assert!((said - 2.6).abs() < 1.0, "{}", told(&found));
    assert!(found.noise.is_empty() && found.explained.is_none());

    let beside = format!("{swings}vertical = 'vertical + bow * cos(vertical)'\n");
    let value = |one: &Instance| if one.name.ends_with("bow") { 8e-6 } else { value(one) };
    let found = with_a_nameless_in(moving(), &[], &beside, 76, &value);
    assert_eq!(found.verdict, Verdict::PartlyExplained, "{}", told(&found));
    assert_eq!(found.rows[0].name, "vertical_circle_eccentricity");
    assert!(found.gap.as_ref().is_some_and(|gap| gap.leftover > 25.0));
    assert!(found.remainder[0].place.is_oscillation(), "{}", told(&found));
}

/// A distance meter that counts from another zero once it was switched off and on: as seen from one
/// setup the rig might have been displaced.
#[test]
#[ignore = "long"]
fn what_changed_for_good_between_two_runs() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/four_setups");
    let opened = open(&Request::new([folder])).unwrap();
    let mut problem = opened.problem.clone();
    let later = ["C_ccw120", "C_cw120", "C_ccw190_platform+20", "C_cw190_platform-20"];
    let part = &mut problem.parts[0];
    let column = part.slots()[2].column;
    for run in part.runs.iter_mut().filter(|run| later.contains(&run.name.as_str())) {
        run.record.edit(|samples| {
            samples.readings[column].iter_mut().for_each(|distance| *distance += 20e-6);
        });
    }
    let wanted = Wanted::default();
    let found = diagnose(problem, opened.recipes, &wanted, &Options::default()).unwrap();
    let words = &best_place(&found).words;
    assert!(words.starts_with("an error of `distance`"), "{}", told(&found));
}

/// Somebody knocks against the tripod before a run, or moves the arm for one run and back: that is
/// no walk, although it looks like one.
#[test]
fn a_rig_that_was_displaced() {
    let text = "[parameters]\nmoved = { unit = \"m\", typical = \"10 um\", scope = \"run\" }\n\
                [patch]\nposition = 'position + moved * [1, -0.5, 0.3]'\n";
    let from = ["B_cw50", "B_ccw190", "B_cw190"];
    for (moved, when, seed) in
        [(&from[..], "from run `B_cw50` on", 68), (&from[..1], "in run `B_cw50`", 69)]
    {
        let value = |one: &Instance| match one.of.as_deref() {
            Some(run) if moved.contains(&run) => 60e-6,
            _ => 0.0,
        };
        let found = with_a_nameless(text, seed, &value);
        let place = best_place(&found);
        assert_eq!(place.covariate, "run");
        let words: Vec<&str> = found.remainder.iter().map(|one| one.place.words.as_str()).collect();
        assert!(words.len() == 1 && words[0].ends_with(when), "{words:?}");
    }
}

/// Somebody knocks against the tripod while a run goes on.
#[test]
fn a_rig_that_was_displaced_in_the_course_of_a_run() {
    let text = "[parameters]\nmoved = { unit = \"m\", typical = \"10 um\", scope = \"run\" }\n\
                after = { unit = \"s\", typical = \"1 s\", scope = \"run\" }\n[patch]\n\
                position = 'position + (0.5 + 0.5 * sign(run_time - after)) * moved * [1, -0.5, 0.3]'\n";
    let value = |one: &Instance| match (one.of.as_deref(), one.name.as_str()) {
        (Some("B_ccw50"), "nameless.after") => 18.0,
        (_, "nameless.after") => -1.0,
        (Some("B_ccw50" | "B_cw50" | "B_ccw190" | "B_cw190"), _) => 60e-6,
        _ => 0.0,
    };
    let found = with_a_nameless(text, 94, &value);
    best_place(&found);
    let parts = open(&Request::new([folder()])).unwrap().problem.parts;
    let knocked = parts[0].runs.iter().find(|run| run.name == "B_ccw50").unwrap();
    // The header is row 1.
    let true_row = 2 + knocked.held().run_time.partition_point(|time| *time < 18.0);
    let mut changes = found.remainder.iter().filter(|one| one.place.run.is_some());
    let is_knock = |one: &Remainder| {
        let row = one.place.rows.map_or(0, |(first, _)| first);
        one.place.run.as_deref() == Some("B_ccw50")
            && one.place.words.contains("displacement")
            && row.abs_diff(true_row) <= 2
    };
    assert!(changes.any(is_knock), "{true_row}: {}", told(&found));
}

/// A station that settles in each setup is no steady drift. (A walk could do as much.)
#[test]
fn a_rig_that_creeps_to_rest() {
    let text = "[parameters]\nstep = { unit = \"m\", typical = \"20 um\", scope = \"rig\" }\n\
                after = { unit = \"s\", value = \"200 s\", fixed = true }\n[patch]\n\
                position = 'position + step * exp(-setup_time / after) * [1, -0.5, 0.3]'\n";
    let walk = "station_random_walk";
    let found = with_a_nameless_and_without(&[walk], text, 70, &|_| 80e-6);
    let place = best_place(&found);
    assert_eq!(place.words, "a displacement of the instrument or the rig over time");
}

/// A camera that reads its attitude wrong where the hand is high, or swings on its mount: without
/// blocks of rotations either is noise with a memory.
#[test]
#[ignore = "a known wrong answer: docs/diagnosis-evidence.md"]
fn what_an_attitude_reads_wrong() {
    let example = || Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/hand_eye");
    let own = "attitude = 'attitude * turn([0, 0, wrong * hand_z / 1 m])'";
    let fixed = "attitude = 'turn([wrong * hand_y / 1 m, 0, 0]) * attitude'";
    let swing = "attitude = 'attitude * turn([0, wrong * cos(2 * pi * 2.3 * run_time / 1 s), 0])'";
    for (patch, value, words, seed) in [
        (own, 0.05, "an error of `attitude` about its own axes over hand_z", 91),
        (fixed, 0.05, "an error of `attitude` about fixed axes over hand_y", 92),
        (swing, 0.002, "an oscillation of `attitude` at 2.3 Hz", 93),
    ] {
        let text = format!(
            "[parameters]\nwrong = {{ unit = \"rad\", typical = \"1 mrad\", scope = \"instrument\" }}\n\
             [patch]\n{patch}\n"
        );
        let found = with_a_nameless_in(example(), &[], &text, seed, &|_| value);
        assert_eq!(best_place(&found).words, words);
    }
}
