//! Members of effects that the model absorbs are held at zero; a family without a stated member is
//! searched for the best.

use homepoint::diagnose::evidence::members::choose;
use homepoint::engine::open::{Request, open};
use homepoint::estimate::absorbed::calibrate_holding;
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::{Calibration, calibrate};

use crate::folder::Folder;
use crate::problems::Stream;

/// An arm of two joints in a plane: its base may be turned, and so may the zero of each joint.
const ARM: &str = "name = \"arm\"\n[inputs]\nq1 = { unit = \"rad\" }\nq2 = { unit = \"rad\" }\n\
    [parameters]\nbase = { unit = \"rad\", scope = \"rig\" }\n[quantities]\nfirst = 'base + q1'\nsecond = 'first + q2'\n\
    [measurands]\nx = { value = '0.5 m * cos(first) + 0.3 m * cos(second)', unit = \"m\" }\n\
    y = { value = '0.5 m * sin(first) + 0.3 m * sin(second)', unit = \"m\" }\n";
const OFFSET: &str = "name = \"zeros\"\ntitle = \"Zeros of the joints\"\nacts = \"encoder\"\n\
    [parameters]\nj1 = { unit = \"rad\", typical = \"1 mrad\", scope = \"rig\" }\n\
    j2 = { unit = \"rad\", typical = \"1 mrad\", scope = \"rig\" }\n\
    [patch]\nq1 = 'q1 + j1'\nq2 = 'q2 + j2'\n";
const FIRST_ALONE: &str = "name = \"first_zero\"\ntitle = \"Zero of the first joint\"\nacts = \"encoder\"\n\
    [parameters]\nj1 = { unit = \"rad\", typical = \"1 mrad\", scope = \"rig\" }\n[patch]\nq1 = 'q1 + j1'\n";

fn arm(with: &str) -> Calibration {
    let mut noise = Stream(6);
    let mut text = String::from("q1 [rad],q2 [rad],x [m],y [m]\n");
    for n in 0..40 {
        let (q1, q2) = (0.1 * f64::from(n), 1.7 * (0.9 * f64::from(n)).sin());
        let (first, second) = (q1 + 0.2, q1 + 0.2 + q2 + 0.015);
        let x = 0.5 * first.cos() + 0.3 * second.cos() + 1e-4 * noise.normal();
        let y = 0.5 * first.sin() + 0.3 * second.sin() + 1e-4 * noise.normal();
        text += &format!("{q1},{q2},{x},{y}\n");
    }
    let campaign = "title = \"Arm\"\nmodel = \"arm.toml\"\n[measurands]\nx = { sigma = \"0.1 mm\" }\ny = { sigma = \"0.1 mm\" }\n\
        [[runs]]\nname = \"poses\"\ndata = \"poses.csv\"\n";
    let files = [
        ("campaign.toml", campaign),
        ("arm.toml", ARM),
        ("effects/zeros.toml", OFFSET),
        ("effects/first_zero.toml", FIRST_ALONE),
        ("poses.csv", &*text),
    ];
    let folder = Folder::new("arm", &files);
    let mut request = Request::new([&*folder]);
    request.with = vec![with.to_owned()];
    let problem = open(&request).unwrap().problem;
    assert!(!calibrate(problem.clone(), &Options::default()).unwrap().is_sound());
    calibrate_holding(problem, &request.with, &Options::default()).unwrap()
}

#[test]
fn a_zero_that_is_a_turn_of_the_base_is_held_and_the_others_are_estimated() {
    let found = arm("zeros");
    assert!(found.is_sound(), "{:?}", found.unobservable);
    let [held] = &found.held[..] else { panic!("{:?}", found.held) };
    assert_eq!(held.name, "zeros.j1");
    assert!(held.why.contains("`base`"), "{}", held.why);
    for (name, due) in [("base", 0.2), ("zeros.j2", 0.015), ("zeros.j1", 0.0)] {
        let one = found.estimates().into_iter().find(|one| one.name == name).unwrap();
        let off = (one.value.unwrap() - due).abs();
        assert!(off <= 4.0 * one.sigma.unwrap(), "{one:?}");
    }
}

#[test]
fn an_effect_of_which_nothing_would_remain_is_not_held() {
    let found = arm("first_zero");
    assert!(!found.is_sound() && found.held.is_empty());
}

const LINE: &str = "name = \"line\"\n[inputs]\nx = { unit = \"m\" }\n\
    [parameters]\nslope = { unit = \"1\", scope = \"rig\" }\nheight = { unit = \"m\", scope = \"rig\" }\n\
    [quantities]\nplace = 'x'\n[measurands]\ny = { value = 'slope * place + height', unit = \"m\" }\n";

fn wave(shape: &str) -> String {
    format!(
        "name = \"wave\"\ntitle = \"A wave\"\nacts = \"instrument\"\n\
         [parameters]\ns = {{ unit = \"m\", typical = \"1 mm\", scope = \"rig\" }}\nc = {{ unit = \"m\", typical = \"1 mm\", scope = \"rig\" }}\n\
         [shape]\nperiod = {shape}\n[patch]\ny = 'y + s * sin(2 * pi * x / period) + c * cos(2 * pi * x / period)'\n"
    )
}

#[test]
fn the_member_that_fits_best_is_taken_where_none_is_stated() {
    let mut noise = Stream(8);
    let mut text = String::from("x [m],y [m]\n");
    for n in 0..500 {
        let x = 0.02 * f64::from(n);
        let y = 0.3 * x + 2.0 + 0.01 * (std::f64::consts::TAU * x / 0.73 + 0.4).sin();
        text += &format!("{x},{}\n", y + 0.002 * noise.normal());
    }
    let campaign = "title = \"Line\"\nmodel = \"line.toml\"\n[measurands]\ny = { sigma = \"2 mm\" }\n\
        [[runs]]\nname = \"run\"\ndata = \"run.csv\"\n";
    let range = "{ unit = \"m\", from = \"0.2 m\", to = \"5 m\" }";
    let list = "{ unit = \"m\", members = [\"0.5 m\", \"0.73 m\", \"1.2 m\"] }";
    for (shape, within) in [(range, 0.004), (list, 1e-12)] {
        let effect = wave(shape);
        let files = [
            ("campaign.toml", campaign),
            ("line.toml", LINE),
            ("effects/wave.toml", &*effect),
            ("run.csv", &*text),
        ];
        let folder = Folder::new("wave", &files);
        let mut request = Request::new([&*folder]);
        request.with = vec!["wave".to_owned()];
        let opened = open(&request).unwrap();
        let (problem, chosen) =
            choose(opened.problem, &opened.recipes, &request.with, &Options::default()).unwrap();
        let [one] = &chosen[..] else { panic!("{chosen:?}") };
        assert_eq!(one.name, "wave.period");
        assert!((one.value - 0.73).abs() < within, "{one:?}");
        let fit = calibrate(problem, &Options::default()).unwrap();
        assert!(fit.is_sound() && fit.variance_factor().unwrap() < 1.2);
        // What is stated stays.
        request.set = vec!["wave.period=1.2 m".to_owned()];
        let opened = open(&request).unwrap();
        let (_, chosen) =
            choose(opened.problem, &opened.recipes, &request.with, &Options::default()).unwrap();
        assert!(chosen.is_empty());
    }
}

/// A load in two of three runs, and a part of it that each run has of its own.
const PART: &str = "name = \"part\"\ntitle = \"Part of the load\"\nacts = \"instrument\"\n\
    [parameters]\nshare = { unit = \"1\", typical = \"1\", scope = \"run\" }\n[patch]\ny = 'y + share * z'\n";

fn loaded(loads: [f64; 3]) -> Calibration {
    let mut noise = Stream(9);
    let model = LINE.replace("[inputs]\n", "[inputs]\nz = { unit = \"m\" }\n");
    let mut campaign =
        "title = \"Line\"\nmodel = \"line.toml\"\n[measurands]\ny = { sigma = \"2 mm\" }\n"
            .to_owned();
    let runs = ["a", "b", "c"].map(|name| format!("{name}.csv"));
    let mut texts = Vec::new();
    for (name, load) in runs.iter().zip(loads) {
        let mut text = String::from("x [m],z [m],y [m]\n");
        for n in 0..60 {
            let (x, z) = (0.02 * f64::from(n), load * (0.7 * f64::from(n)).sin());
            text += &format!("{x},{z},{}\n", 0.3 * x + 2.0 + 0.5 * z + 0.002 * noise.normal());
        }
        texts.push(text);
        let own = &name[..1];
        campaign += &format!("[[runs]]\nname = \"{own}\"\ndata = \"{name}\"\n");
    }
    let mut files =
        vec![("campaign.toml", &*campaign), ("line.toml", &*model), ("effects/part.toml", PART)];
    files.extend(runs.iter().zip(&texts).map(|(name, text)| (&**name, &**text)));
    let folder = Folder::new("loaded", &files);
    let mut request = Request::new([&*folder]);
    request.with = vec!["part".to_owned()];
    let problem = open(&request).unwrap().problem;
    calibrate_holding(problem, &request.with, &Options::default()).unwrap()
}

#[test]
fn the_value_of_a_run_without_any_influence_of_it_is_held_beside_those_of_others() {
    let found = loaded([1.0, 0.0, 1.0]);
    assert!(found.is_sound(), "{:?}", found.unobservable);
    let [held] = &found.held[..] else { panic!("{:?}", found.held) };
    assert_eq!((held.name.as_str(), held.of.as_deref()), ("part.share", Some("b")));
    let of = |run: &str| {
        let mut all = found.estimates().into_iter();
        all.find(|one| one.name == "part.share" && one.of.as_deref() == Some(run)).unwrap()
    };
    assert!(of("b").fixed && of("b").value == Some(0.0), "{:?}", of("b"));
    for one in [of("a"), of("c")] {
        assert!((one.value.unwrap() - 0.5).abs() <= 4.0 * one.sigma.unwrap(), "{one:?}");
    }
    // Of an effect that acts in no run nothing is held.
    let nowhere = loaded([0.0; 3]);
    assert!(!nowhere.is_sound() && nowhere.held.is_empty());
}
