//! What a campaign says of parameters in single setups: values, priors, faults.

use std::fs;
use std::path::Path;

use homepoint::campaign::write::write_campaign;
use homepoint::diagnose::library::wanted::Wanted;
use homepoint::diagnose::power::power;
use homepoint::diagnostic::Diagnostics;
use homepoint::engine::open::{Opened, Request, open};
use homepoint::engine::simulate::simulate;
use homepoint::engine::{Point, Problem};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::calibrate;

use crate::folder::Folder;

/// Two setups, planned.
const PLAN: &str = r#"
model = "polar_one_rotation"
[parameters]
radius = { value = "1.2 m", sigma = "1 um" }
orientation = { value = ["0.1 rad", "0.2 rad", "0.3 rad"] }
collimation.offset = { value = "1 urad" }
[setups.A]
position = { value = ["1.5 m", "0.1 m", "0.2 m"] }
[setups.B]
position = { value = ["-0.5 m", "1.9 m", "0.3 m"], start = ["-0.6 m", "1.8 m", "0.3 m"] }
orientation = { value = ["-0.4 rad", "0.2 rad", "1.3 rad"] }
[inputs]
arm_angle = { sigma = "1 urad" }
[measurands]
horizontal = { sigma = "6 urad" }
vertical = { sigma = "6 urad" }
distance = { sigma = "8 um" }
"#;

fn folder(name: &str, change: impl Fn(String) -> String) -> Folder {
    let mut text = PLAN.to_owned();
    for (setup, name, rate) in [
        ("A", "A_ccw", 5),
        ("A", "A_cw", -5),
        ("A", "A_quick", 90),
        ("B", "B_ccw", 5),
        ("B", "B_quick", -90),
    ] {
        text += &format!(
            "[[runs]]\nname = \"{name}\"\nsetup = \"{setup}\"\nplan = {{ trigger = \"5 Hz\", duration = \"72 s\", arm_angle = {{ start = \"0 deg\", rate = \"{rate} deg/s\" }} }}\n"
        );
    }
    Folder::new(name, &[("campaign.toml", &change(text))])
}

fn opened(folder: &Path, set: &[&str]) -> Result<Opened, Diagnostics> {
    let set = set.iter().map(|text| (*text).to_owned()).collect();
    open(&Request { set, ..Request::new([folder]) })
}

/// The stated value of a parameter in a setup.
fn value(problem: &Problem, name: &str, of: &str) -> Vec<f64> {
    let mut all = problem.layout.instances.iter();
    let own = all.find(|one| one.name == name && one.of.as_deref() == Some(of)).unwrap();
    own.setting.value.clone().unwrap()
}

#[test]
fn each_setup_has_its_own_place() {
    let folder = folder("place", |text| text);
    let Opened { problem, .. } = opened(&folder, &[]).unwrap();
    assert_eq!(value(&problem, "position", "A"), [1.5, 0.1, 0.2]);
    assert_eq!(value(&problem, "position", "B"), [-0.5, 1.9, 0.3]);
    assert_eq!(value(&problem, "orientation", "A"), [0.1, 0.2, 0.3]);
    assert_eq!(value(&problem, "orientation", "B"), [-0.4, 0.2, 1.3]);
    // What is said on the command line holds in all of them.
    let said = opened(&folder, &["position=1 m,2 m,3 m"]).unwrap().problem;
    assert_eq!(value(&said, "position", "A"), [1.0, 2.0, 3.0]);
    assert_eq!(value(&said, "position", "B"), [1.0, 2.0, 3.0]);
}

/// How places are known may be said once, where each of them is stated.
#[test]
fn what_is_known_of_all_places_is_said_once() {
    let of_a = "[setups.A]\nposition = { value = [\"1.5 m\", \"0.1 m\", \"0.2 m\"] }\n";
    let known = |line: &str, lacking: &str| {
        let folder = folder("once", |text| {
            let text = text.replace(lacking, "");
            text.replacen("[parameters]", &format!("[parameters]\n{line}"), 1)
        });
        let found = opened(&folder, &[]);
        found.map(|opened| {
            let all = opened.problem.layout.instances.iter();
            let own = all.filter(|one| one.name == "position");
            own.map(|one| (one.setting.fixed, one.setting.sigma.clone())).collect::<Vec<_>>()
        })
    };
    assert_eq!(
        known("position = { fixed = true }", "\n\n\n").unwrap(),
        [(true, None), (true, None)]
    );
    let sigma = "position = { sigma = [\"1 mm\", \"1 mm\", \"2 mm\"] }";
    let expected = (false, Some(vec![1e-3, 1e-3, 2e-3]));
    assert_eq!(known(sigma, "\n\n\n").unwrap(), [expected.clone(), expected]);
    // Of A nobody states how it stands there.
    assert!(known(sigma, of_a).is_err());
}

#[test]
fn what_is_drawn_at_two_places_is_found_there_and_written_again() {
    let folder = folder("drawn", |text| text);
    let Opened { mut problem, campaigns, models, .. } = opened(&folder, &[]).unwrap();
    let stated = Point::stated(&problem.layout);
    simulate(&mut problem, &stated, 4, true);
    let written = folder.join("written");
    write_campaign(&written, &campaigns[0], &models[0], &problem.parts[0].runs).unwrap();
    let again = opened(&written, &[]).unwrap().problem;
    for name in ["position", "orientation"] {
        for setup in ["A", "B"] {
            assert_eq!(value(&again, name, setup), value(&problem, name, setup));
        }
    }
    let found = calibrate(again, &Options::default()).unwrap();
    assert!(found.is_sound());
    for (index, one) in found.problem.layout.instances.iter().enumerate() {
        if one.name == "position" {
            let truth = one.setting.value.as_ref().unwrap();
            let off = found.fit.point.values[index].iter().zip(truth).map(|(a, b)| (a - b).abs());
            assert!(off.fold(0.0, f64::max) < 5e-6, "{:?}", found.fit.point.values[index]);
        }
    }
}

/// A campaign's own model goes with it, by its name in `models/` or by its path.
#[test]
fn what_is_written_again_has_its_model_with_it() {
    let own = include_str!("../../models/polar_one_rotation.toml");
    for (named, place) in [
        ("my_tracker", "models/my_tracker.toml"),
        ("my_tracker.toml", "my_tracker.toml"),
        ("sub/my_tracker.toml", "sub/my_tracker.toml"),
    ] {
        let folder = folder("own", |text| text.replacen("polar_one_rotation", named, 1));
        let file = folder.join(place);
        fs::create_dir_all(file.parent().unwrap()).unwrap();
        fs::write(file, own.replacen("polar_one_rotation", "my_tracker", 1)).unwrap();
        let Opened { problem, campaigns, models, .. } = opened(&folder, &[]).unwrap();
        let written = folder.join("written");
        write_campaign(&written, &campaigns[0], &models[0], &problem.parts[0].runs).unwrap();
        assert_eq!(opened(&written, &[]).unwrap().models[0].name, "my_tracker", "{named}");
    }
}

/// From one place and from two a design sees differently.
#[test]
fn power_looks_from_each_place() {
    let from = |name: &str, change: fn(String) -> String| {
        let folder = folder(name, change);
        let Opened { problem, recipes, .. } = opened(&folder, &[]).unwrap();
        let point = Point::stated(&problem.layout);
        let found = power(problem, recipes, point, &Wanted::default()).unwrap();
        let size = |name: &str| {
            found.rows.iter().find(|row| row.name == name).unwrap().detectable.unwrap()
        };
        [size("trunnion_tilt"), size("distance_scale_drift")]
    };
    let two = from("two", |text| text);
    let one = from("one", |text| {
        text.replace("[\"-0.5 m\", \"1.9 m\", \"0.3 m\"]", "[\"1.5 m\", \"0.1 m\", \"0.2 m\"]")
    });
    let differ = |(two, one): (&f64, &f64)| (two / one - 1.0).abs() > 0.01;
    assert!(two.iter().zip(&one).all(differ), "{two:?} {one:?}");
}

/// Values that sum to zero are moved along contrasts: where they start makes no difference.
#[test]
fn a_start_of_values_that_sum_to_zero_moves_no_delay() {
    let folder = folder("start", |text| text);
    let delays = |start: Option<&str>| {
        let mut text = fs::read_to_string(folder.join("campaign.toml")).unwrap();
        if let Some(start) = start {
            let said =
                format!("[parameters]\ngate_delay_per_setup.gate = {{ start = \"{start}\" }}\n");
            text = text.replacen("[parameters]\n", &said, 1);
        }
        fs::write(folder.join("campaign.toml"), text).unwrap();
        let with = vec!["gate_delay_per_setup".to_owned()];
        let mut problem = open(&Request { with, ..Request::new([&folder]) }).unwrap().problem;
        let stated = Point::stated(&problem.layout);
        let mut zero = stated.clone();
        for (index, one) in problem.layout.instances.iter().enumerate() {
            if one.name == "gate_delay_per_setup.gate" {
                zero.values[index][0] = 0.0;
            }
        }
        simulate(&mut problem, &zero, 4, true);
        let found = calibrate(problem, &Options::default()).unwrap();
        let named =
            |name: &str| found.problem.layout.instances.iter().position(|one| one.name == name);
        let delay = found.fit.point.values[named("distance.delay").unwrap()][0];
        let gates = found.problem.layout.instances.iter().zip(&found.fit.point.values);
        let gates = gates.filter(|(one, _)| one.name == "gate_delay_per_setup.gate");
        (delay, gates.map(|(_, value)| value[0]).sum::<f64>())
    };
    let (own, sum) = delays(None);
    let (other, other_sum) = delays(Some("100 us"));
    assert!(
        (own - other).abs() < 1e-9 && sum.abs() < 1e-12 && other_sum.abs() < 1e-12,
        "{own} {other} {sum} {other_sum}"
    );
}

#[test]
fn faults_of_setups() {
    for (name, from, to, message, help) in [
        ("name", "[setups.B]", "[setups.Bb]", "unknown setup `Bb`", "did you mean `B`?"),
        (
            "scope",
            "[setups.B]\n",
            "[setups.B]\nradius = { value = \"1.3 m\" }\n",
            "`radius` has no value of its own in each setup",
            "state it in [parameters]",
        ),
        (
            "delay",
            "[setups.B]\n",
            "[setups.B]\nvertical.delay = { scope = \"setup\" }\n",
            "`scope` and `sum` of `vertical.delay` hold for all setups",
            "state them in [parameters]",
        ),
        (
            "constant",
            "[setups.B]\n",
            "[setups.B]\nsampling_grid.period = { value = \"20 us\", fixed = true }\n",
            "`sampling_grid.period` is a constant of an effect",
            "state it in [parameters]",
        ),
        (
            "contrast",
            "[setups.B]\n",
            "[setups.B]\ngate_delay_per_setup.gate = { start = \"20 us\" }\n",
            "the values of `gate_delay_per_setup.gate` sum to zero over the setups",
            "none of them can be stated alone",
        ),
        ("dimension", "\"-0.5 m\", \"1.9 m\"", "\"-0.5 s\", \"1.9 m\"", "`s`", ""),
        (
            "unknown",
            "[setups.B]\n",
            "[setups.B]\npositoin = { value = \"1 m\" }\n",
            "there is no parameter `positoin`",
            "did you mean `position`?",
        ),
        (
            "twice",
            "[setups.B]\n",
            "[setups.B]\norientation = { start = [\"0 rad\", \"0 rad\", \"0 rad\"] }\n",
            "duplicate key",
            "",
        ),
    ] {
        let folder = folder(name, |text| text.replacen(from, to, 1));
        let with = ["sampling_grid", "gate_delay_per_setup"];
        let with = if ["constant", "contrast"].contains(&name) { &with[..] } else { &[] };
        let with = with.iter().map(|name| (*name).to_owned()).collect();
        let faults = open(&Request { with, ..Request::new([&folder]) }).unwrap_err();
        let found = faults.0[0].clone();
        assert!(found.message.contains(message), "{name}: {found}");
        assert!(found.help.join(" ").contains(help), "{name}: {found}");
        assert!(found.place.is_some(), "{name}: {found}");
    }
}
