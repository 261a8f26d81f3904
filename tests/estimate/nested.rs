//! A larger model that ends above a smaller one is begun again; a delay outside its range is no
//! result.

use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::{calibrate, calibrate_from, finish};
use homepoint::estimate::nested::against_nominal;
use homepoint::estimate::refused::{Refused, outside_streams};

use crate::folder::Folder;
use crate::problems::Stream;
use crate::problems::camera::Camera;

const MODEL: &str = "name = \"wave\"\n[inputs]\nx = { unit = \"m\" }\n\
    [parameters]\npitch = { unit = \"1/m\", scope = \"rig\" }\n[quantities]\nplace = 'x'\n\
    [measurands]\ny = { value = 'sin(pitch * place)', unit = \"1\" }\n";
const EFFECT: &str = "name = \"lift\"\ntitle = \"The zero of y\"\nacts = \"instrument\"\n\
    [parameters]\nby = { unit = \"1\", typical = \"0.1\", scope = \"rig\" }\n[patch]\ny = 'y + by'\n";

#[test]
fn a_fit_with_an_effect_that_ends_above_the_one_without_starts_there() {
    let mut noise = Stream(2);
    let mut text = String::from("x [m],y [1]\n");
    for at in 0..200 {
        let x = 0.1 * f64::from(at);
        text += &format!("{x},{}\n", (1.3 * x).sin() + 0.02 + 0.01 * noise.normal());
    }
    let campaign = "title = \"Wave\"\nmodel = \"wave.toml\"\n[parameters]\npitch = { start = \"1.31 1/m\" }\n\
        [measurands]\ny = { sigma = \"0.01\" }\n[[runs]]\nname = \"run\"\ndata = \"run.csv\"\n";
    let files = [
        ("campaign.toml", campaign),
        ("wave.toml", MODEL),
        ("effects/lift.toml", EFFECT),
        ("run.csv", &*text),
    ];
    let folder = Folder::new("wave", &files);
    let mut request = Request::new([&*folder]);
    request.with = vec!["lift".to_owned()];
    let problem = open(&request).unwrap().problem;
    let mut astray = homepoint::engine::Point::start(&problem.layout);
    let rate = problem.layout.instances.iter().position(|one| one.name == "pitch").unwrap();
    astray.values[rate][0] = 2.4;
    let lost = calibrate_from(problem, astray, &Options::default()).unwrap();
    assert!(lost.variance_factor().unwrap() > 1000.0);
    let found = against_nominal(lost, &request.with, &Options::default()).unwrap();
    assert!(found.is_sound() && found.variance_factor().unwrap() < 1.5);
    let by = found.estimates().into_iter().find(|one| one.name == "lift.by").unwrap();
    assert!((by.value.unwrap() - 0.02).abs() < 5.0 * by.sigma.unwrap(), "{by:?}");
}

#[test]
fn a_delay_outside_the_stated_range_is_no_result() {
    let camera = Camera { delay: 0.13, ..Camera::default() };
    let campaign =
        |head: &str| camera.campaign(head, &camera.hand_poses(), &camera.camera_poses(4));
    let fit = |head: &str| {
        let folder = campaign(head);
        calibrate(open(&Request::new([&*folder])).unwrap().problem, &Options::default()).unwrap()
    };
    let found = fit("delay_range = \"0.1 s\"");
    assert!(!found.is_sound());
    let [Refused::OutsideRange { delay, value, range }] = &found.refused[..] else {
        panic!("{:?}", found.refused)
    };
    assert_eq!((&**delay, *range), ("camera.delay", [-0.1, 0.1]));
    assert!((value - 0.13).abs() < 1e-3, "{value}");
    assert!(fit("delay_range = \"0.2 s\"").is_sound());
    assert!(fit("").is_sound(), "what nobody stated is no range");
    // A stated range counts where it equals the default one, and for the delay that it names.
    let far = Camera { delay: 0.56, ..Camera::default() };
    let far = |head: &str| {
        let folder = far.campaign(head, &far.hand_poses(), &far.camera_poses(4));
        calibrate(open(&Request::new([&*folder])).unwrap().problem, &Options::default()).unwrap()
    };
    for head in ["delay_range = \"0.5 s\"", "delay_range = { camera = \"0.4 s\" }"] {
        let found = far(head).refused;
        assert!(matches!(found[..], [Refused::OutsideRange { .. }]), "{head}: {found:?}");
    }
    assert!(far("").is_sound());
}

#[test]
fn a_delay_at_which_most_readings_lie_outside_their_streams_is_no_result() {
    let camera = Camera::default();
    let folder = camera.campaign("", &camera.hand_poses(), &camera.camera_poses(4));
    let problem = open(&Request::new([&*folder])).unwrap().problem;
    let fit = calibrate(problem.clone(), &Options::default()).unwrap();
    let delay = problem.layout.instances.iter().position(|one| one.name == "camera.delay").unwrap();
    let at = |value: f64| {
        let mut point = fit.fit.point.clone();
        point.values[delay][0] = value;
        outside_streams(&problem, &point)
    };
    assert_eq!(at(0.3), Vec::new());
    let some = (1..1000).map(|tenths| at(0.1 * f64::from(tenths))).find(|found| !found.is_empty());
    let some = some.unwrap();
    assert!(some.len() == 1 && !some[0].is_most() && some[0].counts[0] > 0, "{some:?}");
    let most = at(1e3);
    assert!(most.len() == 1 && most[0].is_most() && most[0].delay == "camera.delay", "{most:?}");
    let mut moved = fit.fit.clone();
    moved.point.values[delay][0] = 1e3;
    let found = finish(problem, moved, Vec::new(), Vec::new()).unwrap();
    assert_eq!(found.refused, vec![Refused::OutsideStreams(most[0].clone())]);
    assert!(!found.is_sound());
}
