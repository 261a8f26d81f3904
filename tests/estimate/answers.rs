//! Answers in words and across campaigns: what cannot be determined, what looks wrong, what several
//! campaigns share. All on drawn readings of planned runs.

use std::path::PathBuf;

use homepoint::campaign::Track;
use homepoint::engine::open::{Opened, Request, open};
use homepoint::engine::simulate::simulate;
use homepoint::engine::{Point, Problem};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::{Calibration, calibrate};
use homepoint::estimate::checks::check;
use homepoint::estimate::unrecorded::{Unrecorded, unrecorded};

use crate::folder::Folder;
use crate::problems::Stream;

impl Folder {
    fn campaign(&self, name: &str, text: &str) -> PathBuf {
        let folder = self.join(name);
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("campaign.toml"), text).unwrap();
        folder
    }
}

const HEAD: &str = r#"
model = "polar_one_rotation"
[parameters]
radius             = { value = "1.15 m", sigma = "10 um" }
orientation        = { start = ["0.3 rad", "1.2 rad", "-0.4 rad"] }
position           = { start = ["0.3 m", "1.6 m", "0.2 m"] }
"horizontal.delay" = { start = "0.2 ms" }
[inputs]
arm_angle = { sigma = "0.2 arcsec" }
[measurands]
horizontal = { sigma = "6 urad" }
vertical   = { sigma = "6 urad" }
distance   = { sigma = "8 um" }
"#;

fn runs(rates: &[(&str, &str, f64)]) -> String {
    rates.iter().fold(String::new(), |text, (name, setup, rate)| {
        let duration = 2.0 * 360.0 / rate.abs();
        text + &format!(
            "[[runs]]\nname = \"{name}\"\nsetup = \"{setup}\"\nplan = {{ trigger = \"{} Hz\", duration = \"{duration} s\", arm_angle = {{ start = \"10 deg\", rate = \"{rate} deg/s\" }} }}\n",
            rate.abs() / 5.0
        )
    })
}

fn drawn(opened: Opened, seed: u64) -> Problem {
    let mut problem = opened.problem;
    let truth = Point::start(&problem.layout);
    simulate(&mut problem, &truth, seed, true);
    Problem::new(problem.parts)
}

fn fit(problem: Problem) -> Calibration {
    calibrate(problem, &Options::default()).unwrap()
}

fn words(result: &Calibration) -> String {
    let all: Vec<String> = result
        .unobservable
        .iter()
        .map(|one| format!("{} / remedy: {}", one.words, one.remedy))
        .collect();
    all.join("\n")
}

#[test]
fn a_common_delay_and_a_turn_are_named_with_the_run_that_tells_them_apart() {
    let scratch = Folder::new("one_run", &[]);
    let one = scratch.campaign("one", &(HEAD.to_owned() + &runs(&[("ccw50", "A", 50.0)])));
    let result = fit(drawn(open(&Request::new([&one])).unwrap(), 1));
    let said = words(&result);
    assert!(!result.is_sound());
    assert!(said.contains("a common delay of all measurands"), "{said}");
    assert!(said.contains("acts as a turn of `orientation` about the arm axis"), "{said}");
    assert!(said.contains("opposite sense"), "{said}");
    assert!(result.unobservable.iter().all(|one| !one.direction.is_empty()));
    // The run that was named does it.
    let both = runs(&[("ccw50", "A", 50.0), ("cw50", "A", -50.0)]);
    let two = scratch.campaign("two", &(HEAD.to_owned() + &both));
    let result = fit(drawn(open(&Request::new([&two])).unwrap(), 1));
    assert!(
        result.is_sound(),
        "{} {} {}",
        words(&result),
        result.fit.outcome,
        result.fit.iterations
    );
}

/// A run that is not measured yet brings delays of its own: no run tells those of the others from a
/// turn.
#[test]
fn no_run_is_wanted_that_brings_what_it_would_determine() {
    let scratch = Folder::new("own_delays", &[]);
    let own = ["horizontal", "vertical", "distance"]
        .map(|of| format!("\"{of}.delay\" = {{ start = \"0.2 ms\", scope = \"run\" }}\n"))
        .concat();
    let head = HEAD.replace("\"horizontal.delay\" = { start = \"0.2 ms\" }\n", &own);
    let design = runs(&[("ccw", "A", 50.0), ("cw", "A", -50.0), ("fast", "A", 100.0)]);
    let folder = scratch.campaign("own", &(head + &design));
    let result = fit(drawn(open(&Request::new([&folder])).unwrap(), 5));
    let said = words(&result);
    assert!(!result.is_sound() && !said.contains("measure one more run"), "{said}");
    assert!(said.contains("state a value"), "{said}");
    // Each delay is told with its run.
    assert!(said.contains("`horizontal.delay` (ccw)"), "{said}");
}

/// Two readings of reference runs are no transformation: the start looks at all runs then.
#[test]
fn a_start_looks_beyond_reference_runs_of_too_few_readings() {
    let scratch = Folder::new("few_references", &[]);
    let design = runs(&[("ccw", "A", 50.0), ("cw", "A", -50.0), ("slow", "A", 5.0)]);
    let reference = "name = \"slow\"\nrole = \"reference\"\n";
    let design = design.replace("name = \"slow\"\n", reference);
    let folder = scratch.campaign("few", &(HEAD.to_owned() + &design));
    let mut problem = drawn(open(&Request::new([&folder])).unwrap(), 6);
    problem.parts[0].runs[2].record.edit(|samples| {
        samples.readings.iter_mut().for_each(|readings| readings[2..].fill(f64::NAN));
    });
    let result = fit(Problem::new(problem.parts));
    assert!(result.is_sound(), "{} {}", words(&result), result.fit.outcome);
    assert!(result.aligned.iter().all(|(_, aligned)| aligned.is_ok()), "{:?}", result.aligned);
}

#[test]
fn a_run_in_which_time_stands_still_is_warned_of() {
    let scratch = Folder::new("still", &[]);
    let design = runs(&[("ccw", "A", 50.0), ("cw", "A", -50.0)]);
    let folder = scratch.campaign("still", &(HEAD.to_owned() + &design));
    let mut problem = drawn(open(&Request::new([&folder])).unwrap(), 7);
    let said = |problem: &Problem| {
        let told: Vec<String> = check(problem).into_iter().map(|one| one.message).collect();
        told.join("\n")
    };
    assert!(!said(&problem).contains("same time"), "{}", said(&problem));
    problem.parts[0].runs[1].record.edit(|samples| {
        let half = samples.time.len() / 2;
        samples.time[..half].fill(3.0);
        samples.time[half..].fill(4.0);
    });
    let rounded = said(&problem);
    assert!(rounded.contains("run `cw` has 2 times in its"), "{rounded}");
    assert!(rounded.contains("its stamps are rounded"), "{rounded}");
    problem.parts[0].runs[1].record.edit(|samples| samples.time.fill(3.0));
    assert!(said(&problem).contains("run `cw` has the same time in all its"), "{}", said(&problem));
}

#[test]
fn absorbed_effects_are_named_with_what_they_act_as() {
    let scratch = Folder::new("absorbed", &[]);
    let design = runs(&[("slow", "A", 20.0), ("ccw", "A", 100.0), ("cw", "A", -100.0)]);
    let folder = scratch.campaign("full", &(HEAD.to_owned() + &design));
    for (effect, acts_as) in [
        ("homepoint_offset", "orientation"),
        ("gate_delay", "delay"),
        ("target_axial_offset", "position"),
        ("range_rate_error", "distance.delay"),
    ] {
        let mut request = Request::new([&folder]);
        request.with = vec![effect.to_owned()];
        let result = fit(drawn(open(&request).unwrap(), 2));
        let said = words(&result);
        assert!(!result.is_sound(), "{effect} was taken for determined");
        assert!(said.contains(effect) && said.contains(acts_as), "{effect}: {said}");
    }
}

#[test]
fn what_has_no_effect_is_said_to_have_none() {
    let scratch = Folder::new("no_effect", &[]);
    let design = runs(&[("ccw", "A", 100.0), ("cw", "A", -100.0)]);
    let folder = scratch.campaign("one", &(HEAD.to_owned() + &design));
    let mut problem = drawn(open(&Request::new([&folder])).unwrap(), 3);
    for run in &mut problem.parts[0].runs {
        run.record.edit(|samples| samples.readings[2].fill(f64::NAN));
    }
    let result = fit(Problem::new(problem.parts));
    let said = words(&result);
    assert!(said.contains("`distance.delay` has no effect on any reading"), "{said}");
    // The rest is still told.
    let estimates = result.estimates();
    let horizontal = estimates.iter().find(|one| one.name == "horizontal.delay").unwrap();
    assert!((horizontal.value.unwrap() - 2e-4).abs() < 5.0 * horizontal.sigma.unwrap());
}

#[test]
fn campaigns_share_what_they_name() {
    let scratch = Folder::new("shared", &[]);
    let design = runs(&[("ccw", "A", 100.0), ("cw", "A", -100.0)]);
    let named = "instrument = \"tracker 12\"\nrig = \"arm\"\n".to_owned() + HEAD + &design;
    let (a, b) = (scratch.campaign("a", &named), scratch.campaign("b", &named));
    let alone = fit(drawn(open(&Request::new([&a])).unwrap(), 4));
    let together = fit(drawn(open(&Request::new([&a, &b])).unwrap(), 4));
    assert!(together.is_sound());
    let of = |result: &Calibration, name: &str| {
        result.estimates().into_iter().filter(|one| one.name == name).collect::<Vec<_>>()
    };
    let delay = of(&together, "horizontal.delay");
    assert_eq!(delay.len(), 1);
    assert_eq!(delay[0].of, None);
    let setups: Vec<_> = of(&together, "position.x").into_iter().map(|one| one.of).collect();
    assert_eq!(setups, [Some("a/A".to_owned()), Some("b/A".to_owned())]);
    // Twice the readings: √2 less uncertain.
    let ratio = of(&alone, "horizontal.delay")[0].sigma.unwrap() / delay[0].sigma.unwrap();
    assert!((ratio - 2_f64.sqrt()).abs() < 0.05, "{ratio}");
    // Unnamed ones share nothing.
    let unnamed = HEAD.to_owned() + &design;
    let (c, d) = (scratch.campaign("c", &unnamed), scratch.campaign("d", &unnamed));
    let apart = fit(drawn(open(&Request::new([&c, &d])).unwrap(), 4));
    assert_eq!(of(&apart, "horizontal.delay").len(), 2);
}

#[test]
fn a_campaign_gives_a_parameter_another_scope() {
    let scratch = Folder::new("scope", &[]);
    let design =
        runs(&[("a1", "A", 100.0), ("a2", "A", -100.0), ("b1", "B", 100.0), ("b2", "B", -100.0)]);
    let text =
        HEAD.replace("{ start = \"0.2 ms\" }", "{ start = \"0.2 ms\", scope = \"run\" }") + &design;
    let folder = scratch.campaign("one", &text);
    let result = fit(drawn(open(&Request::new([&folder])).unwrap(), 5));
    assert!(result.is_sound(), "{}", words(&result));
    let delays: Vec<_> =
        result.estimates().into_iter().filter(|one| one.name == "horizontal.delay").collect();
    let of: Vec<_> = delays.iter().map(|one| one.of.clone().unwrap()).collect();
    assert_eq!(of, ["a1", "a2", "b1", "b2"]);
    for delay in delays {
        assert!((delay.value.unwrap() - 2e-4).abs() < 4.0 * delay.sigma.unwrap());
    }
}

/// Delays follow from rates: a rate that is off by two in a hundred puts every delay off by as
/// much.
#[test]
fn rates_that_contradict_their_values_are_told_by_any_factor() {
    let scratch = Folder::new("rates", &[]);
    let design = runs(&[("ccw", "A", 20.0), ("cw", "A", -190.0)]);
    let folder = scratch.campaign("one", &(HEAD.to_owned() + &design));
    let problem = drawn(open(&Request::new([&folder])).unwrap(), 6);
    // An arm that swings: its rate changes between samples.
    let swinging = |factor: f64, interval: f64| {
        let mut problem = problem.clone();
        for run in &mut problem.parts[0].runs {
            run.record.edit(|samples| {
                let times: Vec<f64> = (0..samples.len()).map(|n| interval * n as f64).collect();
                let w = 3.0;
                if let Track::Captured { value, rate: Some(rate), acceleration } =
                    &mut samples.inputs[0]
                {
                    *value = times.iter().map(|t| (w * t).sin()).collect();
                    *rate = times.iter().map(|t| factor * w * (w * t).cos()).collect();
                    *acceleration = None;
                }
                samples.time = times;
            });
        }
        let found: Vec<String> = check(&problem).into_iter().map(|one| one.message).collect();
        found.join("\n")
    };
    for interval in [0.01, 0.05, 0.15, 0.4, 0.7, 1.0, 1.5] {
        assert_eq!(swinging(1.0, interval), "", "every {interval} s");
    }
    for interval in [0.01, 0.05, 0.15] {
        assert!(swinging(1.02, interval).contains("changes 0.98"), "{}", swinging(1.02, interval));
        assert!(swinging(2.0, interval).contains("changes 0.500"), "{}", swinging(2.0, interval));
        assert!(
            swinging(1000.0, interval).contains("does not change"),
            "{}",
            swinging(1000.0, interval)
        );
    }
}

#[test]
fn set_ups_that_cannot_be_are_told_before_any_fit() {
    let scratch = Folder::new("checks", &[]);
    let design = runs(&[("ccw", "A", 100.0), ("cw", "A", -100.0)]);
    let folder = scratch.campaign("one", &(HEAD.to_owned() + &design));
    let problem = drawn(open(&Request::new([&folder])).unwrap(), 6);
    let said = |change: &dyn Fn(&mut homepoint::campaign::Samples)| {
        let mut problem = problem.clone();
        for run in &mut problem.parts[0].runs {
            run.record.edit(change);
        }
        let found: Vec<String> = check(&problem).into_iter().map(|one| one.message).collect();
        found.join("\n")
    };
    assert_eq!(said(&|_| ()), "");
    let turned = said(&|samples| {
        if let Track::Captured { rate: Some(rate), .. } = &mut samples.inputs[0] {
            rate.iter_mut().for_each(|rate| *rate = -*rate);
        }
    });
    assert!(turned.contains("opposite sense of rotation"), "{turned}");
    let degrees = said(&|samples| {
        if let Track::Captured { rate: Some(rate), .. } = &mut samples.inputs[0] {
            rate.iter_mut().for_each(|rate| *rate *= std::f64::consts::PI / 180.0);
        }
    });
    assert!(degrees.contains("deg for rad"), "{degrees}");
    let swapped = said(&|samples| samples.readings.swap(0, 1));
    assert!(swapped.contains("swapped"), "{swapped}");
    let gon = said(&|samples| samples.readings[1].iter_mut().for_each(|angle| *angle /= 0.9));
    assert!(gon.contains("gon"), "{gon}");
    let elevation = said(&|samples| {
        let quarter = std::f64::consts::FRAC_PI_2;
        samples.readings[1].iter_mut().for_each(|angle| *angle = quarter - *angle);
    });
    assert!(elevation.contains("zenith angle or elevation"), "{elevation}");
    let millimetres = said(&|samples| samples.readings[2].iter_mut().for_each(|d| *d *= 1000.0));
    assert!(millimetres.contains("mm taken for m"), "{millimetres}");
    assert_eq!(millimetres.lines().count(), 1, "{millimetres}");
}

#[test]
fn what_one_run_alone_was_recorded_with_is_told_of_that_run() {
    let scratch = Folder::new("one_run", &[]);
    let whole = runs(&[("ccw", "A", 100.0), ("cw", "A", -100.0), ("slow", "A", 20.0)]);
    // Arcs of 60 degrees in opposite senses, far from each other by their delays.
    let arc = |name: &str, rate: f64| {
        format!(
            "[[runs]]\nname = \"{name}\"\nplan = {{ trigger = \"100 Hz\", duration = \"{} s\", arm_angle = {{ start = \"10 deg\", rate = \"{rate} deg/s\" }} }}\n",
            60.0 / rate.abs()
        )
    };
    let arcs = arc("ccw", 100.0) + &arc("cw", -100.0) + &arc("slow", 20.0);
    let folder = scratch.campaign("whole", &(HEAD.to_owned() + &whole));
    told_of_each(drawn(open(&Request::new([&folder])).unwrap(), 7));
    let folder = scratch.campaign("arcs", &(HEAD.replace("0.2 ms", "20 ms") + &arcs));
    let mut request = Request::new([&folder]);
    request.start =
        ["horizontal", "vertical", "distance"].map(|m| format!("{m}.delay=20 ms")).into();
    told_of_each(drawn(open(&request).unwrap(), 7));
}

/// Each run of three in turn with a mistake.
fn told_of_each(problem: Problem) {
    let said = |run: usize, change: &dyn Fn(&mut homepoint::campaign::Samples)| {
        let mut problem = problem.clone();
        problem.parts[0].runs[run].record.edit(change);
        check(&problem).into_iter().map(|one| one.message).collect::<Vec<_>>()
    };
    let names = ["ccw", "cw", "slow"];
    for (run, name) in names.iter().enumerate() {
        let words = [
            ("mm taken for m", said(run, &|s| s.readings[2].iter_mut().for_each(|d| *d *= 1000.0))),
            ("gon", said(run, &|s| s.readings[1].iter_mut().for_each(|angle| *angle /= 0.9))),
            ("swapped", said(run, &|s| s.readings.swap(0, 1))),
            ("no reading of `distance`", said(run, &|s| s.readings[2].fill(f64::NAN))),
        ];
        for (word, found) in words {
            assert_eq!(found.len(), 1, "{found:?}");
            let others = names.iter().filter(|other| *other != name);
            assert!(
                found[0].contains(word) && found[0].contains(&format!("`{name}`")),
                "{found:?}"
            );
            // The one that the others are held against may be named, too.
            let named = others.filter(|other| found[0].contains(&format!("`{other}`"))).count();
            assert!(named <= 1, "{found:?}");
        }
    }
}

/// What is done to the recorded rates of a run.
type Recorded<'a> = &'a dyn Fn(&mut homepoint::campaign::Samples);

/// The accelerations that readings of an arm miss, with delays of so many seconds.
fn missed_by(plans: &[&str], delay: f64, head: &str, recorded: Recorded<'_>) -> Option<Unrecorded> {
    let scratch = Folder::new(&format!("unrecorded_{delay}_{}", plans.concat().len()), &[]);
    let runs = plans.iter().enumerate().map(|(number, plan)| {
        format!("[[runs]]\nname = \"{number}\"\nplan = {{ trigger = \"20 Hz\", {plan} }}\n")
    });
    let folder = scratch.campaign("one", &(head.to_owned() + &runs.collect::<String>()));
    let mut request = Request::new([&folder]);
    let all = ["horizontal", "vertical", "distance"];
    request.start = all.map(|name| format!("{name}.delay={delay} s")).to_vec();
    let opened = open(&request).unwrap();
    let truth = Point::stated(&opened.problem.layout);
    let mut problem = opened.problem;
    simulate(&mut problem, &truth, 8, true);
    for run in &mut problem.parts[0].runs {
        run.record.edit(recorded);
    }
    unrecorded(&Problem::new(problem.parts), &truth)
}

/// Takes the acceleration away, and changes the rates by their number.
fn without_acceleration(
    change: impl Fn(&mut [f64], &[f64]),
) -> impl Fn(&mut homepoint::campaign::Samples) {
    move |samples| {
        if let Track::Captured { value, rate: Some(rate), acceleration } = &mut samples.inputs[0] {
            *acceleration = None;
            change(rate, value);
        }
    }
}

fn errors(seed: u64, count: usize) -> Vec<f64> {
    let mut stream = Stream(seed);
    (0..count).map(|_| stream.normal()).collect()
}

const RAMP: &str = "duration = \"20 s\", arm_angle = { start = \"10 deg\", rate = \"40 deg/s\", acceleration = \"30 deg/s^2\" }";
const STEADY: &str = "duration = \"20 s\", arm_angle = { start = \"10 deg\", rate = \"40 deg/s\" }";

#[test]
fn an_acceleration_that_readings_miss_is_told_where_delays_are_known() {
    let kept = |_: &mut homepoint::campaign::Samples| ();
    let lost = without_acceleration(|_, _| ());
    let missed = missed_by(&[RAMP, STEADY], 0.02, HEAD, &lost).unwrap();
    assert_eq!((&missed.inputs[..], &missed.run[..]), (&["arm_angle".to_owned()][..], "0"));
    // Half of 0.52 rad/s² times (20 ms)² is 0.1 mrad, or 0.12 mm at the arm's end, beside 6 urad
    // and 8 um.
    assert!((5.0..30.0).contains(&missed.most), "{missed:?}");
    assert!(missed_by(&[RAMP, STEADY], 0.02, HEAD, &kept).is_none());
    assert!(missed_by(&[RAMP, STEADY], 2e-4, HEAD, &lost).is_none());
    assert!(missed_by(&[STEADY, STEADY], 0.02, HEAD, &lost).is_none());
    // Noise that is shared by all readings along the motion covers it.
    let shaken = HEAD.replace("0.2 arcsec", "3 deg");
    assert!(missed_by(&[RAMP, STEADY], 0.02, &shaken, &lost).is_none());
}

/// Errors of the rates are no motion, however much they would change, nor are rates that are
/// differences of recorded angles.
#[test]
fn errors_of_rates_are_no_acceleration() {
    let seeds = std::cell::Cell::new(0);
    let errors = |count: usize| {
        seeds.set(seeds.get() + 1);
        errors(seeds.get(), count)
    };
    for number in 0..20 {
        let noisy = without_acceleration(|rate, _| {
            let own = errors(rate.len());
            rate.iter_mut().zip(own).for_each(|(rate, error)| *rate += 0.01 * error);
        });
        let found = missed_by(&[STEADY, STEADY], 0.02, HEAD, &noisy);
        assert!(found.is_none(), "{number}: {found:?}");
        for ahead in [0, 1] {
            let differences = without_acceleration(|rate, value| {
                let own: Vec<f64> = errors(value.len());
                let at = |k: usize| value[k] + 5e-5 * own[k];
                for k in 1..rate.len() - 1 {
                    rate[k] = (at(k + 1) - at(k - ahead)) / (0.05 * (1 + ahead) as f64);
                }
            });
            let found = missed_by(&[STEADY, STEADY], 0.02, HEAD, &differences);
            assert!(found.is_none(), "{number} {ahead}: {found:?}");
        }
    }
}

#[test]
fn what_is_stated_of_one_setup_holds_there() {
    let scratch = Folder::new("of_setups", &[]);
    let design = runs(&[("a", "near", 100.0), ("b", "far", -100.0)]);
    let folder = scratch.campaign("one", &(HEAD.to_owned() + &design));
    let mut request = Request::new([&folder]);
    request.set = vec!["position=1 m,2 m,3 m".into(), "position@far=4 m, 5 m, 6 m".into()];
    let problem = Problem::new(open(&request).unwrap().problem.parts);
    let point = Point::stated(&problem.layout);
    let of = |setup: &str| {
        let is_own = |one: &homepoint::engine::layout::Instance| {
            one.name == "position" && one.of.as_deref() == Some(setup)
        };
        let index = problem.layout.instances.iter().position(is_own).unwrap();
        point.components(&problem.layout, index)
    };
    assert_eq!((of("near"), of("far")), (vec![1.0, 2.0, 3.0], vec![4.0, 5.0, 6.0]));
    request.set = vec!["position@fat=4 m, 5 m, 6 m".into()];
    let refused = open(&request).unwrap_err();
    assert!(refused.to_string().contains("no setup `fat`"), "{refused}");
    assert_eq!(refused.0[0].help, ["did you mean `far`?"]);
    request.set = vec!["radius@far=1 m".into()];
    assert!(open(&request).unwrap_err().to_string().contains("no value of its own in each setup"));
}
