//! One component of a vector stated by itself: fixed, known with a sigma, bounded, started.

use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::{Calibration, Estimate, calibrate};

use crate::folder::Folder;
use crate::problems::camera::{Camera, wandering};

/// A hand that turns about the vertical alone, as on a car: heights of lever and frame are alike.
pub(crate) fn flat() -> Camera {
    let motion = |t| {
        let (place, turn) = wandering(t);
        (place, [0.0, 0.0, turn[2]])
    };
    Camera { motion, ..Camera::default() }
}

fn folder(head: &str) -> Folder {
    let camera = flat();
    camera.campaign(head, &camera.hand_poses(), &camera.camera_poses(11))
}

fn fit(request: &Request) -> Calibration {
    calibrate(open(request).unwrap().problem, &Options::default()).unwrap()
}

fn one(fit: &Calibration, name: &str) -> Estimate {
    fit.estimates().into_iter().find(|one| one.name == name).unwrap()
}

fn refused(head: &str, set: &[&str]) -> String {
    let folder = folder(head);
    let mut request = Request::new([&*folder]);
    request.set = set.iter().map(|said| (*said).to_owned()).collect();
    open(&request).unwrap_err().to_string()
}

#[test]
fn a_height_by_tape_determines_what_flat_ground_leaves_open() {
    let plain = folder("");
    let open = fit(&Request::new([&*plain]));
    assert!(!open.is_sound());
    assert!(one(&open, "camera_lever.z").value.is_none());
    let heads = [
        "[parameters]\ncamera_lever = { z = { value = \"108 mm\", sigma = \"4 mm\" } }",
        "[parameters]\n\"camera_lever.z\" = { value = \"108 mm\", sigma = \"4 mm\" }",
        "[parameters]\ncamera_lever = { plausible = \"1 m\", z = { value = \"108 mm\", U = \"8 mm\", k = 2 } }",
    ];
    for head in heads {
        let folder = folder(head);
        let fit = fit(&Request::new([&*folder]));
        assert!(fit.is_sound(), "{head}");
        let z = one(&fit, "camera_lever.z");
        // Readings say nothing of it: it is as it was stated.
        assert!((z.value.unwrap() - 0.108).abs() < 1e-6, "{z:?}");
        assert!((z.sigma.unwrap() - 0.004).abs() < 1e-6, "{z:?}");
        for (name, due) in [("camera_lever.x", 0.07), ("camera_lever.y", -0.03)] {
            let one = one(&fit, name);
            assert!((one.value.unwrap() - due).abs() < 4.0 * one.sigma.unwrap(), "{one:?}");
        }
    }
}

#[test]
fn on_the_command_line_a_value_is_fixed_stated_or_a_start() {
    let folder = folder("");
    let mut request = Request::new([&*folder]);
    request.set = vec!["camera_lever.z=108 mm".to_owned()];
    let fixed = fit(&request);
    assert!(fixed.is_sound());
    let z = one(&fixed, "camera_lever.z");
    assert_eq!((z.value, z.sigma, z.fixed), (Some(0.108), Some(0.0), true));
    assert_eq!(fixed.unknowns(), 12);
    request.set = vec!["camera_lever.z=108 mm ~ 4 mm".to_owned()];
    let stated = fit(&request);
    let z = one(&stated, "camera_lever.z");
    assert!(!z.fixed && (z.sigma.unwrap() - 0.004).abs() < 1e-6);
    assert_eq!(stated.unknowns(), 13);
    request.set = vec!["camera_lever=70 mm, -30 mm, 108 mm".to_owned()];
    let whole = fit(&request);
    assert!(whole.is_sound() && one(&whole, "camera_lever.x").fixed);
    request.set = Vec::new();
    request.start = vec!["camera_lever.z=108 mm".to_owned()];
    let started = fit(&request);
    assert!(!started.is_sound(), "a start states nothing");
    // What the command line says of all counts over what the file says of one.
    let taped = self::folder(
        "[parameters]\ncamera_lever = { z = { value = \"108 mm\", sigma = \"4 mm\" } }",
    );
    let mut request = Request::new([&*taped]);
    request.set = vec!["camera_lever=70 mm, -30 mm, 90 mm".to_owned()];
    assert_eq!(one(&fit(&request), "camera_lever.z").value, Some(0.09));
}

#[test]
fn one_component_has_bounds() {
    let folder = folder(
        "[parameters]\ncamera_lever = { x = { upper = \"50 mm\" }, z = { value = \"110 mm\", fixed = true } }",
    );
    let fit = fit(&Request::new([&*folder]));
    let x = one(&fit, "camera_lever.x");
    assert_eq!((x.value, x.bound.map(|bound| bound.word())), (Some(0.05), Some("upper")));
    assert!(one(&fit, "camera_lever.y").bound.is_none());
}

#[test]
fn what_cannot_be_said_of_one_component_is_refused_with_what_to_do() {
    for (head, set, said) in [
        ("", &["orientation.z=0.1 rad"][..], "a rotation is stated as a whole"),
        ("", &["camera_lever.w=1 mm"], "there is no parameter `camera_lever.w`"),
        ("", &["camera_lever.z=1 mm, 2 mm, 3 mm"], "must be one quantity"),
        ("", &["camera_lever.z=1 rad"], "must be a quantity like `m`"),
        ("", &["camera_lever=1 mm, 2 mm ~ 1 mm, 3 mm"], "some components have a sigma"),
        (
            "[parameters]\ncamera_lever = { z = { fixed = true } }",
            &[],
            "`camera_lever.z` is fixed, but at no stated value",
        ),
        (
            "[parameters]\ncamera_lever = { z = { sigma = \"1 mm\" } }",
            &[],
            "`camera_lever.z` has a standard uncertainty, but no value",
        ),
        (
            "[parameters]\ncamera_lever = { z = { lower = \"2 mm\", upper = \"1 mm\" } }",
            &[],
            "`lower` must be below `upper`",
        ),
        (
            "[parameters]\ncamera_lever = { z = { scope = \"run\" } }",
            &[],
            "holds for all components",
        ),
    ] {
        let told = refused(head, set);
        assert!(told.contains(said), "{head} {set:?}: {told}");
    }
}
