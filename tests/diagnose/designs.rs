//! Designs in which not every run or setup shows an effect, and runs that are wrong as wholes.

use std::path::Path;

use homepoint::diagnose::budget::answer::Verdict;
use homepoint::diagnose::library::wanted::Wanted;
use homepoint::diagnose::power::power;
use homepoint::diagnose::{diagnose, judge};
use homepoint::engine::Problem;
use homepoint::engine::open::{Opened, Request, open};
use homepoint::engine::simulate::simulate;
use homepoint::estimate::batch::Options;
use homepoint::estimate::start::start;
use homepoint::graph::Scope;
use homepoint::model::Override;

use crate::drawn::{drawn_at, folder, run};
use crate::found::{names, told};

/// Some runs of two of the example's four setups, with the axis of the platform beside the standing
/// axis.
fn beside(shift: f64, runs: &[&str]) -> (Opened, Problem) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/four_setups");
    let mut request = Request::new([folder]);
    request.with = vec!["platform_offset".to_owned()];
    let (opened, problem) = drawn_at(&request, 5, &|_| Some(shift));
    let mut parts = problem.parts;
    parts[0].runs.retain(|run| runs.contains(&run.name.as_str()));
    parts[0].setups.truncate(2);
    (opened, Problem::new(parts))
}

const STILL: [&str; 8] =
    ["A_ccw5", "A_cw5", "A_ccw50", "A_cw50", "B_ccw5", "B_cw5", "B_ccw50", "B_cw50"];

/// The platform turns in one setup: in the other the effect's values are not determined.
#[test]
fn an_effect_that_one_setup_does_not_show_is_named_with_what_is_known_of_it() {
    let turning = ["A_ccw50_platform-30", "A_cw50_platform+30"];
    let (opened, problem) = beside(40e-6, &[&STILL[..], &turning].concat());
    let found = run(problem, &opened);
    assert_eq!((found.verdict, names(&found)), (Verdict::Explained, vec!["platform_offset"]));
    let estimates = found.explained.as_ref().unwrap().estimates();
    let mut known = 0;
    for one in estimates.iter().filter(|one| one.name.starts_with("platform_offset.")) {
        match one.of.as_deref() {
            Some("A") => {
                let (value, sigma) = (one.value.unwrap(), one.sigma.unwrap());
                assert!((value - 40e-6).abs() < 4.0 * sigma && sigma < 2e-6, "{one:?}");
                known += 1;
            }
            _ => assert_eq!((one.value, one.sigma), (None, None), "{one:?}"),
        }
    }
    assert_eq!(known, 2);
}

/// Most of the evidence lies in one run: left out as a whole it would leave little to learn from.
#[test]
fn an_effect_that_mostly_one_run_shows_is_judged_within_it() {
    let (opened, problem) = beside(40e-6, &[&STILL[..], &["A_ccw50_platform-30"]].concat());
    let found = run(problem, &opened);
    assert_eq!((found.verdict, names(&found)), (Verdict::Explained, vec!["platform_offset"]));
    let gap = found.gap.unwrap();
    assert_eq!(gap.folds, 9 * 5);
    assert!(gap.held_out_drop > 0.3 * gap.lambda.powi(2), "{gap:?}");
    let [low, high] = gap.closed_interval;
    assert!(low > 0.9 && high == 1.0, "{gap:?}");
}

/// A reading that is off by a constant in one run is that, not noise with a memory, whatever its
/// size.
#[test]
fn a_run_beside_the_others_is_told() {
    let opened = open(&Request::new([folder()])).unwrap();
    for (number, shift) in [(9, 500e-6), (4, 17.5e-3)] {
        let mut parts = opened.problem.parts.clone();
        let name = parts[0].runs[number].name.clone();
        parts[0].runs[number].record.edit(|samples| {
            samples.readings[2].iter_mut().for_each(|reading| *reading += shift);
        });
        let found = run(Problem::new(parts), &opened);
        assert!(found.rows.is_empty() && found.autocorrelation.is_empty(), "{}", told(&found));
        // It spoils the fit of all the others, or it does not.
        if shift > 1e-3 {
            let [of_run] = &found.left_out.runs[..] else { unreachable!("{}", told(&found)) };
            assert_eq!((&of_run.run, &of_run.measurand[..]), (&name, "distance"));
            assert_eq!(found.verdict, Verdict::Explained, "{}", told(&found));
        } else {
            let words = &found.remainder[0].place.words;
            assert!(words.contains("`distance`") && words.contains("run"), "{}", told(&found));
            assert_eq!(found.verdict, Verdict::Unknown, "{}", told(&found));
        }
    }
}

/// A distance in millimetres where metres are said keeps the whole fit from settling.
#[test]
fn a_run_in_another_unit_is_told() {
    let opened = open(&Request::new([folder()])).unwrap();
    for number in [2, 7] {
        let mut parts = opened.problem.parts.clone();
        let name = parts[0].runs[number].name.clone();
        let mut all = 0;
        parts[0].runs[number].record.edit(|samples| {
            samples.readings[2].iter_mut().for_each(|reading| *reading *= 1000.0);
            all = samples.readings[2].iter().filter(|reading| !reading.is_nan()).count();
        });
        let found = run(Problem::new(parts), &opened);
        assert_eq!((found.verdict, found.rows.len()), (Verdict::Explained, 0), "{name}");
        assert!(found.remainder.is_empty(), "{}", told(&found));
        let left_out = &found.left_out;
        let [of_run] = &left_out.runs[..] else { unreachable!("{left_out:?}") };
        assert_eq!((&of_run.run, &of_run.measurand[..], of_run.readings), (&name, "distance", all));
        assert!(left_out.readings.is_empty() && of_run.deviations > 1e3, "{left_out:?}");
    }
}

/// Angles that changed places in one run, and distances in another: the fit settles, spoilt, and no
/// other run is blamed.
#[test]
fn runs_that_spoil_the_fit_are_told_and_no_others() {
    let opened = open(&Request::new([folder()])).unwrap();
    for wrong in [&[3][..], &[1, 6]] {
        let mut parts = opened.problem.parts.clone();
        let name = |number: &usize| parts[0].runs[*number].name.clone();
        let names: Vec<String> = wrong.iter().map(name).collect();
        for number in wrong {
            parts[0].runs[*number].record.edit(|samples| samples.readings.swap(0, 1));
        }
        let found = run(Problem::new(parts), &opened);
        assert_eq!((found.verdict, found.rows.len()), (Verdict::Explained, 0), "{names:?}");
        let runs = found.left_out.runs.iter();
        let words: Vec<String> = runs.map(|one| format!("`{}`", one.run)).collect();
        for words in &words {
            assert!(names.iter().any(|name| words.contains(&format!("`{name}`"))), "{words}");
        }
        for name in &names {
            assert!(words.iter().any(|words| words.contains(&format!("`{name}`"))), "{name}");
        }
        let levels = &found.levels;
        assert!(levels.is_empty(), "{levels:?}");
    }
}

/// Rates that rise from run to run: an effect of the rate is then as displacements before the fast
/// runs, but says the same with one value. Without it in the library they are what is seen.
#[test]
fn an_effect_of_the_rate_is_not_taken_for_displacements() {
    let own = tempfile::tempdir().unwrap();
    let text = "name = \"spin_lift\"\ntitle = \"Bearing lifts\"\nacts = \"arm\"\n\
        [parameters]\n\
        lift = { unit = \"m/(rad/s)^2\", typical = \"1 um/(rad/s)^2\", scope = \"rig\" }\n\
        [patch]\ntarget = 'target + [0, 0, lift * rate(arm_angle)^2]'\n";
    std::fs::write(own.path().join("spin_lift.toml"), text).unwrap();
    let known = Request { effects: vec![own.path().to_owned()], ..Request::new([folder()]) };
    let recipes = open(&known).unwrap().recipes;
    let truth = Request { with: vec!["spin_lift".to_owned()], ..known };
    for (seed, lift) in [(1, 1e-6), (3, 5e-6)] {
        let (_, problem) = drawn_at(&truth, seed, &|_| Some(lift));
        let of = |without: &[String]| {
            let wanted = Wanted::new(&[], without);
            diagnose(problem.clone(), recipes.clone(), &wanted, &Options::default()).unwrap()
        };
        let found = of(&[]);
        assert_eq!(found.verdict, Verdict::Explained, "{seed}: {}", told(&found));
        assert_eq!(names(&found), ["spin_lift"], "{seed}");
        assert!(found.contradicted.is_empty() && found.gap.is_some(), "{seed}");
        let without = of(&["spin_lift".to_owned()]);
        assert_eq!(without.verdict, Verdict::Unknown, "{seed}");
    }
}

/// Formulas count time from the first sample: stamps of the day say the same.
#[test]
fn the_origin_of_the_stamps_does_not_matter() {
    let own = tempfile::tempdir().unwrap();
    for file in std::fs::read_dir(folder()).unwrap() {
        let path = file.unwrap().path();
        let to = own.path().join(path.file_name().unwrap());
        if path.extension().is_none_or(|extension| extension != "csv") {
            std::fs::copy(&path, to).unwrap();
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        let later = |line: &str| match line.split_once(',') {
            Some((time, rest)) => match time.parse::<f64>() {
                Ok(time) => format!("{:.6},{rest}\n", time + 36_000.0),
                Err(_) => format!("{line}\n"),
            },
            None => format!("{line}\n"),
        };
        std::fs::write(to, text.lines().map(later).collect::<String>()).unwrap();
    }
    let of = |folder: &Path| {
        let opened = open(&Request::new([folder])).unwrap();
        let found = run(opened.problem.clone(), &opened);
        let own = found.candidates.into_iter().find(|one| one.name == "arm_thermal_growth");
        own.unwrap().gain.gain
    };
    let (as_is, later) = (of(&folder()), of(own.path()));
    assert!((as_is - later).abs() < 1e-3 * as_is.max(1.0), "{as_is} {later}");
}

/// A campaign as one request opens it, with readings drawn as another one says.
fn drawn_as(request: &Request, truth: &Request, seed: u64) -> Opened {
    let mut drawn = open(truth).unwrap().problem;
    for part in &mut drawn.parts {
        for (sigma, random) in part.random_sigma.iter_mut().zip(&part.system.randoms) {
            *sigma = random.sigma.or(random.typical).unwrap_or(0.0);
        }
    }
    let (point, _) = start(&drawn);
    simulate(&mut drawn, &point, seed, true);
    let mut opened = open(request).unwrap();
    for (part, other) in opened.problem.parts.iter_mut().zip(drawn.parts) {
        part.runs = other.runs;
    }
    opened.problem = Problem::new(opened.problem.parts);
    opened
}

/// A request for the example with effects and stated values.
fn asked(with: &[&str], set: &[&str]) -> Request {
    let own = |all: &[&str]| all.iter().map(|one| (*one).to_owned()).collect();
    Request { with: own(with), set: own(set), ..Request::new([folder()]) }
}

/// A model whose own random quantity is estimated: what is found of it holds for the other
/// campaign, too.
#[test]
fn a_held_out_campaign_has_the_noise_that_was_found() {
    let request = asked(&["timestamp_jitter"], &[]);
    let truth = asked(&["timestamp_jitter", "trunnion_tilt"], &["trunnion_tilt.tilt=6 arcsec"]);
    let (first, other) = (drawn_as(&request, &truth, 1), drawn_as(&request, &truth, 2));
    let mut found = run(first.problem.clone(), &first);
    assert_eq!(names(&found), ["trunnion_tilt"]);
    let own = found.gap.clone().unwrap();
    judge(&mut found, &other, &Options::default()).unwrap();
    let gap = found.gap.unwrap();
    // A half of the readings, at other rates on the mean.
    for ((name, floor), (_, before)) in gap.floor.iter().zip(&own.floor) {
        assert!((floor / before - 1.0).abs() < 0.2, "{name}: {floor} {before}");
    }
    assert!(gap.left_out < 25 && gap.closed > 0.9, "{gap:?}");
}

/// A constant of an effect that only the fitted campaign states holds for the other one, too.
#[test]
fn a_held_out_campaign_takes_the_constants_of_effects() {
    let period = "sampling_grid.period=20 us";
    let truth = asked(&["sampling_grid"], &[period, "sampling_grid.depth=60 us"]);
    let (first, other) =
        (drawn_as(&asked(&[], &[period]), &truth, 1), drawn_as(&asked(&[], &[]), &truth, 2));
    let mut found = run(first.problem.clone(), &first);
    assert_eq!(names(&found), ["sampling_grid"]);
    judge(&mut found, &other, &Options::default()).unwrap();
    let gap = found.gap.unwrap();
    assert!(gap.closed > 0.9, "{gap:?}");
}

/// A value that nominal parameters absorb does not make an effect harder to see.
#[test]
fn what_cannot_be_seen_is_no_part_of_a_size() {
    let own = tempfile::tempdir().unwrap();
    let size = "{ unit = \"m\", typical = \"20 um\", scope = \"rig\" }";
    let wave = "rotate(arm_turn, [0, wave * sin(3 * arm_angle), 0])";
    for (name, more, lift) in [("bent", "lift", "[0, 0, lift] + "), ("alone", "", "")] {
        let second = if more.is_empty() { String::new() } else { format!("{more} = {size}\n") };
        let text = format!(
            "name = \"{name}\"\ntitle = \"Own\"\nacts = \"arm\"\n[parameters]\nwave = {size}\n{second}\
             [patch]\ntarget = 'target + {lift}{wave}'\n"
        );
        std::fs::write(own.path().join(format!("{name}.toml")), text).unwrap();
    }
    let mut request = Request::new([folder()]);
    request.effects = vec![own.path().to_path_buf()];
    let opened = open(&request).unwrap();
    let (point, _) = start(&opened.problem);
    let only = Wanted::new(&["bent".to_owned(), "alone".to_owned()], &[]);
    let found = power(opened.problem, opened.recipes, point, &only).unwrap();
    let size =
        |name: &str| found.rows.iter().find(|one| one.name == name).unwrap().detectable.unwrap();
    assert!(
        (size("bent") / size("alone") - 1.0).abs() < 0.05,
        "{} {}",
        size("bent"),
        size("alone")
    );
}

/// Effects of the user's own: one with a value that nominal parameters absorb, one that is never
/// off.
#[test]
fn own_effects_are_tested_by_what_can_be_seen_of_them_and_where_they_can_be_off() {
    let own = tempfile::tempdir().unwrap();
    let write = |name: &str, lines: &str| {
        let text = format!("name = \"{name}\"\ntitle = \"Own\"\nacts = \"arm\"\n{lines}");
        std::fs::write(own.path().join(format!("{name}.toml")), text).unwrap();
    };
    let size = "{ unit = \"m\", typical = \"20 um\", scope = \"rig\" }";
    write(
        "bent",
        &format!(
            "[parameters]\nwave = {size}\nlift = {size}\n[patch]\n\
             target = 'target + [0, 0, lift] + rotate(arm_turn, [0, wave * sin(3 * arm_angle), 0])'\n"
        ),
    );
    write(
        "always_on",
        &format!("[parameters]\nsize = {size}\n[patch]\nradius = 'radius * 1.001 + size'\n"),
    );
    let mut request = Request::new([folder()]);
    request.effects = vec![own.path().to_path_buf()];
    let mut truth = request.clone();
    truth.with = vec!["bent".to_owned()];
    truth.set = vec!["bent.wave=30 um".to_owned(), "bent.lift=30 um".to_owned()];
    let opened = drawn_as(&request, &truth, 6);
    let found = run(opened.problem.clone(), &opened);
    assert_eq!((found.verdict, names(&found)), (Verdict::Explained, vec!["bent"]));
    let estimates = found.explained.as_ref().unwrap().estimates();
    let value = |name: &str| estimates.iter().find(|one| one.name == name).unwrap().value;
    assert!((value("bent.wave").unwrap() - 30e-6).abs() < 3e-6);
    assert_eq!(value("bent.lift"), None);
    let said = found.not_testable.iter().find(|one| one.name == "always_on").unwrap();
    assert!(said.why.contains("where its parameters are zero"), "{}", said.why);
}

/// An effect may be a turn, of which a part is not determined: the fit starts from a turn, and what
/// it explains is switched off as one.
#[test]
fn an_own_effect_that_is_a_turn_is_named() {
    let own = tempfile::tempdir().unwrap();
    let text = "name = \"mount\"\ntitle = \"The instrument leans on its platform\"\nacts = \"platform\"\n\
        [parameters]\nlean = { kind = \"rotation\", unit = \"rad\", typical = \"50 urad\", scope = \"instrument\" }\n\
        [patch]\nplatform_turn = 'lean * platform_turn'\n";
    std::fs::write(own.path().join("mount.toml"), text).unwrap();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/05_two_rotations");
    let mut request = Request::new([folder]);
    request.effects = vec![own.path().to_path_buf()];
    let mut truth = request.clone();
    truth.with = vec!["mount".to_owned()];
    truth.set = vec!["mount.lean=80 urad, -60 urad, 30 urad".to_owned()];
    let opened = drawn_as(&request, &truth, 7);
    let only = Wanted::new(&["mount".to_owned()], &[]);
    let options = Options::default();
    let found = homepoint::diagnose::diagnose(
        opened.problem.clone(),
        opened.recipes.clone(),
        &only,
        &options,
    );
    let found = found.unwrap();
    assert_eq!((found.verdict, names(&found)), (Verdict::Explained, vec!["mount"]));
    let gap = found.gap.as_ref().unwrap();
    assert!(gap.closed > 0.99, "{gap:?}");
    for ((name, after), (other, noise)) in gap.after.iter().zip(&gap.floor) {
        assert!(name == other && after / noise < 1.1, "{name}: {after} {noise}");
    }
}

/// Where every frequency of a family is one that these runs cannot tell from a slower one, none is
/// tried.
#[test]
fn a_family_whose_frequencies_cannot_be_told_is_not_testable() {
    let own = tempfile::tempdir().unwrap();
    let mut text = String::from(
        r#"title = "Sampled slowly"
model = "polar_one_rotation"
[parameters]
radius = { value = "1.15 m", sigma = "1 um" }
orientation = { value = ["0.1 rad", "0.2 rad", "0.32 rad"] }
position = { value = ["2.2 m", "0.5 m", "0.4 m"] }
[inputs]
arm_angle = { sigma = "0.2 arcsec" }
[measurands]
horizontal = { sigma = "6 urad" }
vertical = { sigma = "6 urad" }
distance = { sigma = "8 um" }
"#,
    );
    for (number, rate) in [50, -50, 97, -97, 131, -131].iter().enumerate() {
        text.push_str(&format!(
            "[[runs]]\nname = \"r{number}\"\nsetup = \"A\"\nplan = {{ trigger = \"0.9 Hz\", duration = \"200 s\", \
             arm_angle = {{ start = \"0 deg\", rate = \"{rate} deg/s\" }} }}\n"
        ));
    }
    std::fs::write(own.path().join("campaign.toml"), text).unwrap();
    let request = Request::new([own.path()]);
    let opened = drawn_as(&request, &request, 3);
    let name = "arm_torsion_oscillation";
    let (point, _) = start(&opened.problem);
    let before =
        power(opened.problem.clone(), opened.recipes.clone(), point, &Wanted::default()).unwrap();
    let row = before.rows.iter().find(|one| one.name == name).unwrap();
    assert!(row.words.contains("none of its frequencies"), "{}", row.words);
    let found = run(opened.problem.clone(), &opened);
    let said = found.not_testable.iter().find(|one| one.name == name).unwrap();
    assert!(said.why.contains("none of its frequencies"), "{}", said.why);
    assert!(found.candidates.iter().all(|one| one.name != name));
}

/// Four long runs of one setup: a station that drifts steadily is no walk, and one that walks far
/// is one, of which few sines of each run would leave much.
#[test]
#[ignore = "long"]
fn a_drift_and_a_walk_in_few_long_runs() {
    let text = |lines: &str| {
        let mut text = format!(
            r#"title = "Few long runs"
model = "polar_one_rotation"
[parameters]
radius = {{ value = "1.15 m", sigma = "1 um" }}
{lines}
[setups.A]
orientation = {{ value = ["0.1 rad", "-1.5 rad", "0.2 rad"] }}
position = {{ value = ["1.4 m", "0.3 m", "-0.1 m"] }}
[inputs]
arm_angle = {{ sigma = "0.2 arcsec" }}
[measurands]
horizontal = {{ sigma = "6 urad" }}
vertical = {{ sigma = "6 urad" }}
distance = {{ sigma = "8 um" }}
"#
        );
        for rate in [2, -2, 20, -20] {
            text.push_str(&format!(
                "[[runs]]\nname = \"r{rate}\"\nsetup = \"A\"\nplan = {{ trigger = \"2 Hz\", duration = \"1000 s\", \
                 arm_angle = {{ start = \"0 deg\", rate = \"{rate} deg/s\" }} }}\n"
            ));
        }
        text
    };
    let [own, other] = [(); 2].map(|()| tempfile::tempdir().unwrap());
    std::fs::write(own.path().join("campaign.toml"), text("")).unwrap();
    let walk = ["x", "y", "z"].map(|axis| {
        format!("\"station_random_walk.walk_{axis}\" = {{ value = \"2 um/min^0.5\" }}\n")
    });
    let drift =
        "\"station_drift.velocity\" = { value = [\"3 um/h\", \"1.5 um/h\", \"-1 um/h\"] }\n";
    for (name, lines, seed) in [
        ("station_drift", drift, 1),
        ("station_drift", drift, 2),
        ("station_drift", drift, 3),
        ("station_random_walk", &walk.concat(), 3),
        ("station_random_walk", &walk.concat(), 5),
    ] {
        std::fs::write(other.path().join("campaign.toml"), text(lines)).unwrap();
        let mut truth = Request::new([other.path()]);
        truth.with = vec![name.to_owned()];
        let opened = drawn_as(&Request::new([own.path()]), &truth, seed);
        let found = run(opened.problem.clone(), &opened);
        // Displacements over time are what is seen of a walk.
        let is_drift = name == "station_drift";
        let (verdict, named) =
            if is_drift { (Verdict::Explained, vec![name]) } else { (Verdict::Unknown, vec![]) };
        let said = told(&found);
        assert_eq!((found.verdict, names(&found)), (verdict, named), "{name} {seed}: {said}");
    }
}

/// A run that is wrong as a whole takes its own delay with it: that is not asked of readings that
/// are left out.
#[test]
fn a_dead_run_with_a_delay_of_its_own_is_told() {
    let mut opened = open(&Request::new([folder()])).unwrap();
    let (name, scope) = ("distance.delay".to_owned(), Some(Scope::Run));
    opened.recipes[0].overrides.push(Override { name, scope, ..Override::default() });
    let part = &opened.problem.parts[0];
    let mut part = part.with_system(opened.recipes[0].with(&[]).unwrap());
    let name = part.runs[3].name.clone();
    part.runs[3].record.edit(|samples| {
        samples.readings.iter_mut().for_each(|readings| readings.fill(0.0));
    });
    let found = run(Problem::new(vec![part]), &opened);
    assert_eq!((found.verdict, found.rows.len()), (Verdict::Explained, 0), "{}", told(&found));
    let left_out = &found.left_out;
    assert!(!left_out.runs.is_empty() && left_out.runs.iter().all(|one| one.run == name));
    assert!(found.remainder.is_empty(), "{}", told(&found));
    let delays = found.nominal.estimates().into_iter().filter(|one| one.name.ends_with(".delay"));
    assert!(
        delays.clone().count() > 6 && delays.into_iter().all(|one| one.of != Some(name.clone()))
    );
}
