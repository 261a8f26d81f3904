//! Clocks that are far apart: the readings' own delays agree with the joint estimate, and a search
//! finds offsets that no start is near.

use homepoint::engine::open::{Opened, Request, open};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::{Calibration, calibrate};
use homepoint::estimate::compare::compare;
use homepoint::estimate::transformation::delays_of;

use crate::folder::Folder;
use crate::problems::camera::Camera;

fn opened(folder: &Folder) -> Opened {
    open(&Request::new([&**folder])).unwrap()
}

fn campaign(camera: &Camera, head: &str) -> Folder {
    camera.campaign(head, &camera.hand_poses(), &camera.camera_poses(5))
}

fn delay(fit: &Calibration) -> f64 {
    fit.estimates().iter().find(|one| one.name == "camera.delay").unwrap().value.unwrap()
}

/// From zero Newton's iteration would end at other moments at which the hand is in the same place.
#[test]
fn own_delays_start_at_the_joint_one() {
    for offset in [0.013, -0.31, 0.44] {
        let camera = Camera { delay: offset, ..Camera::default() };
        let folder = campaign(&camera, "");
        let problem = opened(&folder).problem;
        let fit = calibrate(problem.clone(), &Options::default()).unwrap();
        assert!((delay(&fit) - offset).abs() < 1e-3, "{offset}: {}", delay(&fit));
        let (_, found) = delays_of(&problem, &fit, 0);
        for one in &found.measurands {
            assert!((one.mean.unwrap() - offset).abs() < 2e-3, "{offset}: {:?}", one.mean);
            assert!(one.failed * 20 < one.readings, "{offset}: {} failed", one.failed);
        }
        for one in compare(&fit, 0, &found.measurands) {
            assert!(one.normalised().unwrap().abs() < 5.0, "{offset}: {one:?}");
        }
    }
}
