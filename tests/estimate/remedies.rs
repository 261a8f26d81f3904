//! Remedies for what is not determined: each that is printed does what it says.

use homepoint::engine::open::{Request, open};
use homepoint::engine::simulate::simulate;
use homepoint::engine::{Point, Problem};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::{Calibration, calibrate};

use super::components::flat;
use crate::folder::Folder;
use crate::problems::camera::Camera;

fn fit(folder: &Folder) -> Calibration {
    calibrate(open(&Request::new([&**folder])).unwrap().problem, &Options::default()).unwrap()
}

fn campaign(camera: &Camera, head: &str) -> Folder {
    camera.campaign(head, &camera.hand_poses(), &camera.camera_poses(11))
}

/// Flat ground: a ramp or a tape helps, the opposite sense does not, and neither does a tape of
/// what is known.
#[test]
fn on_flat_ground_a_tilt_or_a_height_is_the_remedy() {
    let found = fit(&campaign(&flat(), ""));
    let [open] = &found.unobservable[..] else { panic!("{:?}", found.unobservable) };
    assert!(open.remedy.contains("tilted by 20 deg about its x or y axis"), "{}", open.remedy);
    assert!(open.remedy.contains("`camera_lever.z`"), "{}", open.remedy);
    assert!(!open.remedy.contains("opposite sense"), "{}", open.remedy);
    assert!(!open.remedy.contains("camera_lever.x"), "{}", open.remedy);
    // A ramp: the same motion, tilted for a while.
    let motion = |t: f64| {
        let (place, turn) = (flat().motion)(t);
        (place, [0.0, if t > 10.0 { 0.35 } else { 0.0 }, turn[2]])
    };
    let ramp = fit(&campaign(&Camera { motion, camera: (0.0, 9.0, 0.05), ..flat() }, ""));
    assert!(!ramp.is_sound());
    let still = Camera { motion, ..flat() };
    let ramp =
        fit(&campaign(&still, "[parameters]\ncamera.delay = { value = \"13 ms\", fixed = true }"));
    assert!(ramp.is_sound(), "{:?}", ramp.unobservable);
}

/// A scale whose zero and whose load are alike while the mass on it is the same.
const SCALE: &str = "name = \"scale\"\n[inputs]\nmass = { unit = \"kg\" }\nturned = { unit = \"rad\" }\n\
    [parameters]\nzero = { unit = \"N\", scope = \"rig\" }\ngain = { unit = \"N/kg\", scope = \"rig\" }\n\
    [measurands]\nload = { value = 'zero + gain * mass', unit = \"N\" }\n";

fn scale(masses: &str) -> Calibration {
    let campaign = "title = \"Scale\"\nmodel = \"scale.toml\"\n[measurands]\nload = { sigma = \"0.1 N\" }\n\
         [parameters]\nzero = { start = \"1 N\" }\ngain = { start = \"9.8 N/kg\" }\n\
         [[runs]]\nname = \"a\"\ndata = \"a.csv\"\n";
    let files = [("campaign.toml", campaign), ("scale.toml", SCALE), ("a.csv", masses)];
    let folder = Folder::new("scale", &files);
    fit(&folder)
}

#[test]
fn another_mass_is_the_remedy_where_one_mass_was_weighed() {
    let same = "mass [kg],turned [rad],load [N]\n2,0,20.6\n2,0,20.5\n2,0,20.7\n2,0,20.6\n";
    let found = scale(same);
    let [open] = &found.unobservable[..] else { panic!("{:?}", found.unobservable) };
    assert!(open.remedy.contains("in which `mass` takes other values"), "{}", open.remedy);
    // The other input is the same all along, too, and does nothing.
    assert!(!open.remedy.contains("turned"), "{}", open.remedy);
    assert!(open.remedy.contains("one of `zero`, `gain`"), "{}", open.remedy);
    let other = "mass [kg],turned [rad],load [N]\n2,0,20.6\n2,0,20.5\n3,0,30.4\n3,0,30.4\n";
    assert!(scale(other).is_sound());
}

/// Each parameter that a remedy names is stated in turn: with it nothing is open.
#[test]
fn every_value_that_is_named_determines_the_direction() {
    let camera = flat();
    let plain = fit(&campaign(&camera, ""));
    let remedy = &plain.unobservable[0].remedy;
    let (_, names) = remedy.split_once("one of ").unwrap();
    let (names, _) = names.split_once(" or set it fixed").unwrap();
    let names: Vec<&str> = names.split(", ").map(|name| name.trim_matches('`')).collect();
    assert!(names.len() >= 2, "{remedy}");
    for name in names {
        let folder = campaign(&camera, "");
        let mut request = Request::new([&*folder]);
        request.set = vec![format!("{name}=0.1 m ~ 1 mm")];
        let found = calibrate(open(&request).unwrap().problem, &Options::default()).unwrap();
        assert!(found.is_sound(), "{name}: {:?}", found.unobservable);
    }
}

/// Draws and fits a planned campaign.
fn drawn(text: &str, files: &[(&str, &str)]) -> Calibration {
    drawn_with(text, files, None)
}

/// The same with a value stated on the command line.
fn drawn_with(text: &str, files: &[(&str, &str)], set: Option<&str>) -> Calibration {
    let mut all = vec![("campaign.toml", text)];
    all.extend_from_slice(files);
    let folder = Folder::new("remedies", &all);
    let mut request = Request::new([&*folder]);
    request.set = set.into_iter().map(str::to_owned).collect();
    let mut problem = open(&request).unwrap().problem;
    let truth = Point::start(&problem.layout);
    simulate(&mut problem, &truth, 4, true);
    calibrate(Problem::new(problem.parts), &Options::default()).unwrap()
}

/// A parameter that no reading notices is not said to need a run that changes nothing.
#[test]
fn no_run_is_named_for_what_no_input_reaches() {
    let model = "name = \"line\"\n[inputs]\nx = { unit = \"m\", signal = true }\n\
        [parameters]\na = { unit = \"1\", scope = \"rig\" }\nb = { unit = \"m\", scope = \"rig\" }\n\
        c = { unit = \"m\", scope = \"rig\" }\n\
        [measurands]\nread = { value = 'a * x + b + c', unit = \"m\" }\n";
    let text = "title = \"Line\"\nmodel = \"line.toml\"\n\
        [parameters]\nread.delay = { value = \"0 s\", fixed = true }\na = { start = \"1\" }\n\
        [measurands]\nread = { sigma = \"1 mm\" }\n\
        [[runs]]\nname = \"run\"\nplan = { trigger = \"10 Hz\", duration = \"20 s\", x = { start = \"0 m\", rate = \"0.1 m/s\" } }\n";
    let found = drawn(text, &[("line.toml", model)]);
    let [open] = &found.unobservable[..] else { panic!("{:?}", found.unobservable) };
    assert_eq!(open.remedy, "state a value with its sigma for one of `b`, `c` or set it fixed");
}

/// A delay of what moves too slowly for it to show is unseen by itself: no other parameter is named
/// with it, and each line that is printed determines the others.
#[test]
fn a_delay_that_hardly_shows_is_stated_by_the_line_that_is_printed() {
    let model = "name = \"line\"\n[inputs]\nx = { unit = \"m\", signal = true }\n\
        [parameters]\na = { unit = \"1\", scope = \"rig\" }\nb = { unit = \"m\", scope = \"rig\" }\n\
        [measurands]\nread = { value = 'a * x + b', unit = \"m\" }\n";
    let mut text = "title = \"Line\"\nmodel = \"line.toml\"\n[parameters]\na = { start = \"1\" }\n\
        [measurands]\nread = { sigma = \"50 mm\" }\n"
        .to_owned();
    for (name, start, rate) in [("there", "0 m", "0.01 m/s"), ("back", "0.22 m", "-0.01 m/s")] {
        text += &format!(
            "[[runs]]\nname = \"{name}\"\nplan = {{ trigger = \"10 Hz\", duration = \"20 s\", x = {{ start = \"{start}\", rate = \"{rate}\" }} }}\n"
        );
    }
    let files = [("line.toml", model)];
    let found = drawn(&text, &files);
    let [open] = &found.unobservable[..] else { panic!("{:?}", found.unobservable) };
    assert!(
        open.words.starts_with("a change of `read.delay` cannot be told from noise"),
        "{}",
        open.words
    );
    let of: Vec<&str> = open.direction.iter().map(|one| one.0.as_str()).collect();
    assert_eq!(of, ["read.delay"]);
    let lines: Vec<String> = open
        .remedy
        .split('`')
        .filter_map(|part| Some(part.strip_prefix("--set ")?.replace('"', "")))
        .collect();
    assert_eq!(lines, ["read.delay=0 s~0.01 s", "read.delay=0 s"], "{}", open.remedy);
    for line in lines {
        let found = drawn_with(&text, &files, Some(&line));
        assert!(found.is_sound(), "{line}: {:?}", found.unobservable);
    }
}
