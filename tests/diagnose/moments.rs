//! What changes at a moment in the course of a run: told with its row, and neither taken for an
//! effect nor for noise.

use std::path::Path;

use homepoint::campaign::Track;
use homepoint::diagnose::Diagnosis;
use homepoint::diagnose::library::place::{Of, Place};
use homepoint::engine::Problem;
use homepoint::engine::open::{Opened, Request, open};

use crate::drawn::{drawn_at, folder, run};
use crate::found::{names, told};

/// Readings drawn with effects of some sizes, and with a nameless one; both changes nothing where
/// it is zero.
fn drawn_with(
    nameless: &str,
    seed: u64,
    value: &dyn Fn(&str, Option<&str>) -> f64,
) -> (Opened, Problem) {
    let own = tempfile::tempdir().unwrap();
    let whole = format!(
        "name = \"nameless\"\ntitle = \"Nameless\"\nacts = \"arm\"\n[parameters]\n\
         size = {{ unit = \"1\", typical = \"1\", scope = \"run\" }}\n\
         after = {{ unit = \"s\", typical = \"1 s\", scope = \"run\" }}\n[patch]\n{nameless}\n"
    );
    std::fs::write(own.path().join("nameless.toml"), whole).unwrap();
    let mut request = Request::new([folder()]);
    request.effects = vec![own.path().to_owned()];
    request.with = vec!["nameless".to_owned(), "collimation".to_owned()];
    let set = |one: &homepoint::engine::layout::Instance| {
        let is_drawn = one.name.starts_with("nameless") || one.name.starts_with("collimation");
        (is_drawn && !one.setting.fixed).then(|| value(&one.name, one.of.as_deref()))
    };
    drawn_at(&request, seed, &set)
}

/// The places of what changed, and the effects beside which it did. What is off is no noise.
fn changes(found: &Diagnosis) -> (Vec<&Place>, Vec<&str>) {
    assert!(found.verdict.has_remainder(), "{}", told(found));
    assert!(found.levels.is_empty() && found.left_out.is_empty(), "{}", told(found));
    let places = found.remainder.iter().map(|one| &one.place);
    (places.filter(|place| place.rows.is_some()).collect(), names(found))
}

const HALF: &str = "(0.5 + 0.5 * sign(run_time - after)) * size";

/// A clock that is set while a run goes on, for that run or for good: rates of runs or delays of
/// setups would say nearly the same.
#[test]
fn a_clock_that_is_set() {
    let late = format!("t = 't + {HALF} * 1 us'");
    let (opened, problem) = drawn_with(&late, 301, &|name, run| match (name, run) {
        ("nameless.size", Some("B_ccw190")) => 20.0,
        ("nameless.after", Some("B_ccw190")) => 6.0,
        _ => 0.0,
    });
    let found = run(problem, &opened);
    let (places, effects) = changes(&found);
    assert!(effects.is_empty(), "{}", told(&found));
    let times = &opened.problem.parts[0].runs.iter().find(|run| run.name == "B_ccw190").unwrap();
    let times = &times.held().run_time;
    let true_row = 2 + times.partition_point(|time| *time < 6.0);
    // At one rate a timing error and a tangential displacement are one: for good both change, and
    // in the end that is one run.
    assert!(!places.is_empty() && places.len() == found.remainder.len(), "{}", told(&found));
    for place in places {
        let is_timing = place.words.starts_with("a timing error of all readings");
        let is_tangential = place.words.starts_with("a tangential displacement of the target");
        assert!(is_timing || is_tangential, "{}", told(&found));
        assert_eq!(place.run.as_deref(), Some("B_ccw190"), "{}", told(&found));
        let row = place.rows.unwrap().0;
        assert!(row.abs_diff(true_row) <= 1, "{row}, not {true_row}");
    }
}

#[test]
fn a_clock_that_is_set_for_good() {
    let late = format!("t = 't + {HALF} * 1 us'");
    let later = ["B_ccw50", "B_cw50", "B_ccw190", "B_cw190"];
    let (opened, problem) = drawn_with(&late, 302, &|name, run| match (name, run) {
        ("nameless.size", Some(name)) if later.contains(&name) => 20.0,
        ("nameless.after", Some("B_ccw50")) => 18.0,
        ("nameless.after", _) => -1.0,
        _ => 0.0,
    });
    let found = run(problem, &opened);
    let (places, effects) = changes(&found);
    assert!(effects.is_empty(), "{}", told(&found));
    let [place] = places[..] else { unreachable!("{}", told(&found)) };
    assert!(place.words.starts_with("a timing error of all readings"), "{}", told(&found));
    assert_eq!(place.run.as_deref(), Some("B_ccw50"), "{}", told(&found));
}

/// A clock that is set for good by so much that the model is not linear beside it: the change is fitted,
/// and nothing else is found.
#[test]
fn a_clock_that_is_set_by_much() {
    let late = format!("t = 't + {HALF} * 1 us'");
    let later = ["B_ccw50", "B_cw50", "B_ccw190", "B_cw190"];
    let (opened, problem) = drawn_with(&late, 305, &|name, run| match (name, run) {
        ("nameless.size", Some(name)) if later.contains(&name) => 3000.0,
        ("nameless.after", Some("B_ccw50")) => 18.0,
        ("nameless.after", _) => -1.0,
        _ => 0.0,
    });
    let found = run(problem, &opened);
    let (places, effects) = changes(&found);
    assert!(effects.is_empty() && places.len() == found.remainder.len(), "{}", told(&found));
    let [place] = places[..] else { unreachable!("{}", told(&found)) };
    assert!(place.words.starts_with("a timing error of all readings"), "{}", told(&found));
    assert_eq!(place.run.as_deref(), Some("B_ccw50"), "{}", told(&found));
    let change = found.remainder[0].change.as_ref().unwrap();
    assert!((change.value - 0.003).abs() < 4.0 * change.sigma, "{change:?}");
}

/// A tripod that is knocked moves and turns: one change of its pose, with how far and by how much, small or
/// beyond what is linear.
#[test]
fn a_tripod_that_is_knocked() {
    let knock = "position = 'position + size * [10 um, -5 um, 3 um] * (0.5 + 0.5 * sign(run_time - after))'\n\
                 orientation = 'orientation * turn(size * (0.5 + 0.5 * sign(run_time - after)) * [2 urad, 3 urad, 6 urad])'";
    let later = ["B_cw50", "B_ccw190", "B_cw190"];
    for (size, seed) in [(8.0, 311), (300.0, 312)] {
        let (opened, problem) = drawn_with(knock, seed, &|name, run| match (name, run) {
            ("nameless.size", Some(name)) if later.contains(&name) => size,
            ("nameless.after", _) => -1.0,
            _ => 0.0,
        });
        let found = run(problem, &opened);
        assert!(found.rows.is_empty() && found.levels.is_empty(), "{}", told(&found));
        let [part] = &found.remainder[..] else { unreachable!("{}", told(&found)) };
        assert_eq!(part.place.words, "another pose of the instrument from run `B_cw50` on");
        let moved = part.change.as_ref().unwrap();
        assert!(
            (moved.value / size - 134_f64.sqrt() * 1e-6).abs() < 4.0 * moved.sigma / size,
            "{moved:?}"
        );
        let turned = part.turn.as_ref().unwrap();
        assert!((turned.value - size * 7e-6).abs() < 4.0 * turned.sigma, "{turned:?}");
    }
}

/// A parameter of the model that has another value in one run.
#[test]
fn an_orientation_that_is_another_one_in_a_run() {
    let turned =
        "orientation = 'orientation * turn(size * [1 urad, 0, 0]) * turn(after * [0 rad/s, 0, 0])'";
    let (opened, problem) = drawn_with(turned, 306, &|name, run| match (name, run) {
        ("nameless.size", Some("B_cw50")) => 300.0,
        _ => 0.0,
    });
    let found = run(problem, &opened);
    assert!(found.verdict.has_remainder() && found.rows.is_empty(), "{}", told(&found));
    let [change] = &found.remainder[..] else { unreachable!("{}", told(&found)) };
    assert!(change.place.words.contains("another value of `orientation`"), "{}", told(&found));
    assert_eq!(change.place.run.as_deref(), Some("B_cw50"), "{}", told(&found));
    let found = change.change.as_ref().unwrap();
    assert!((found.value - 300e-6).abs() < 4.0 * found.sigma, "{found:?}");
}

/// Puts a distance off in some rows of a run.
fn off(rows: std::ops::Range<usize>, by: f64, problem: &mut Problem) {
    let part = &mut problem.parts[0];
    let column = part.slots()[2].column;
    let run = part.runs.iter_mut().find(|run| run.name == "A_cw50").unwrap();
    run.record.edit(|all| {
        all.readings[column][rows].iter_mut().for_each(|distance| *distance += by);
    });
}

const NOTHING: &str = "t = 't + size * after * 0'";

#[test]
fn a_distance_that_is_off_for_a_while() {
    let (opened, mut problem) = drawn_with(NOTHING, 303, &|_, _| 0.0);
    off(30..70, 16e-6, &mut problem);
    let found = run(problem, &opened);
    let (places, effects) = changes(&found);
    assert!(effects.is_empty(), "{}", told(&found));
    let [place] = places[..] else { unreachable!("{}", told(&found)) };
    assert_eq!(place.of, Of::Measurand("distance".to_owned()), "{}", told(&found));
    assert_eq!(place.run.as_deref(), Some("A_cw50"), "{}", told(&found));
    let (first, last) = place.rows.unwrap();
    assert!(first.abs_diff(32) <= 2 && last.unwrap().abs_diff(71) <= 2, "{first} {last:?}");
}

#[test]
fn a_distance_that_is_off_from_a_row_on_beside_an_effect() {
    let (opened, mut problem) = drawn_with(NOTHING, 304, &|name, _| {
        if name.starts_with("collimation") { 40e-6 } else { 0.0 }
    });
    off(50..119, 16e-6, &mut problem);
    let found = run(problem, &opened);
    let (places, effects) = changes(&found);
    assert_eq!(effects, ["collimation"], "{}", told(&found));
    let [place] = places[..] else { unreachable!("{}", told(&found)) };
    assert_eq!(place.of, Of::Measurand("distance".to_owned()), "{}", told(&found));
    assert_eq!(place.run.as_deref(), Some("A_cw50"), "{}", told(&found));
    let (row, last) = place.rows.unwrap();
    assert!(row.abs_diff(52) <= 3 && last.unwrap().abs_diff(120) <= 2, "{row} {last:?}");
}

/// A clock that is set for good in the second of four setups.
#[test]
#[ignore = "long"]
fn a_clock_that_is_set_for_good_in_one_of_four_setups() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/four_setups");
    let opened = open(&Request::new([folder])).unwrap();
    let (mut problem, set) = (opened.problem.clone(), 30e-6);
    let runs = &mut problem.parts[0].runs;
    let at = runs.iter().position(|run| run.name == "B_cw50").unwrap();
    for (number, run) in runs.iter_mut().enumerate().skip(at) {
        run.record.edit(|all| {
            let from = if number == at { 20 } else { 0 };
            for input in &mut all.inputs {
                if let Track::Captured { value, rate: Some(rate), .. } = input {
                    let pairs = value.iter_mut().zip(rate).skip(from);
                    pairs.for_each(|(value, rate)| *value += *rate * set);
                }
            }
        });
    }
    let found = run(problem, &opened);
    let (places, effects) = changes(&found);
    assert!(effects.is_empty(), "{}", told(&found));
    let [place] = places[..] else { unreachable!("{}", told(&found)) };
    assert!(place.words.starts_with("a timing error of all readings"), "{}", told(&found));
    assert_eq!(place.run.as_deref(), Some("B_cw50"), "{}", told(&found));
    assert!(place.rows.unwrap().0.abs_diff(22) <= 2, "{}", told(&found));
}

/// A clock that is set is no unknown form that an effect of the user's own might imitate.
#[test]
fn an_effect_beside_a_clock_that_was_set_is_named() {
    use std::fmt::Write as _;
    let mut random = crate::stream::Stream(3);
    let mut campaign = "title = \"Stage\"\nmodel = \"model.toml\"\n".to_owned();
    let mut files: Vec<(String, String)> = Vec::new();
    for run in 0..3 {
        let phase = 1.7 * f64::from(run);
        let stage = |t: f64| 1.1 * (0.5 * t + phase).sin() + 0.5 * (1.3 * t).cos();
        let (mut sent, mut read) =
            ("time [s],stage [rad]\n".to_owned(), "time [s],yaw [rad]\n".to_owned());
        for i in 0..2200 {
            let t = 0.02 * f64::from(i);
            writeln!(sent, "{t:.2},{:.7}", stage(t)).unwrap();
            if i % 2 == 0 && (60..2140).contains(&i) {
                let set = if run == 1 && i > 1000 { 8e-3 } else { 0.0 };
                let angle = stage(t + 4e-3 + set);
                let yaw = angle + 0.02 + 1.2e-3 * angle.powi(2) + 3e-4 * random.normal();
                writeln!(read, "{t:.2},{yaw:.7}").unwrap();
            }
        }
        writeln!(
            campaign,
            "[[runs]]\nname = \"r{run}\"\ndata = \"r{run}.csv\"\nsignals = [\"s{run}.csv\"]"
        )
        .unwrap();
        files.extend([(format!("s{run}.csv"), sent), (format!("r{run}.csv"), read)]);
    }
    let model = "name = \"stage\"\ntitle = \"Stage\"\n\
        [inputs]\nstage = { unit = \"rad\", signal = true }\n\
        [parameters]\nzero = { unit = \"rad\" }\n\
        [measurands]\nyaw = { value = 'stage + zero', unit = \"rad\", kind = \"angle\", sigma = \"0.3 mrad\" }\n";
    let effect = "name = \"cable_torque\"\ntitle = \"A cable turns the sensor\"\nacts = \"instrument\"\n\
        [parameters]\npull = { unit = \"1/rad\", typical = \"1e-3 1/rad\", scope = \"rig\" }\n\
        [patch]\nyaw = 'yaw + pull * stage^2'\n";
    for (name, text) in
        [("model.toml", model), ("effects/cable_torque.toml", effect), ("campaign.toml", &campaign)]
    {
        files.push((name.to_owned(), text.to_owned()));
    }
    let files: Vec<(&str, &str)> = files.iter().map(|(a, b)| (a.as_str(), b.as_str())).collect();
    let folder = crate::folder::Folder::new("clock_set", &files);
    let request = homepoint::engine::open::Request::new([&*folder]);
    let opened = homepoint::engine::open::open(&request).unwrap();
    let found = run(opened.problem.clone(), &opened);
    assert_eq!(names(&found), ["cable_torque"], "{}", told(&found));
    let value = &found.rows[0].values[0];
    let (pull, u) = (value.value.unwrap(), value.sigma.unwrap());
    assert!((pull - 1.2e-3).abs() < 4.0 * u && u < 1e-4, "{pull} {u}");
    let words: Vec<&str> = found.remainder.iter().map(|one| one.place.words.as_str()).collect();
    assert!(words.iter().any(|one| one.contains("in run `r1`")), "{words:?}");
}
