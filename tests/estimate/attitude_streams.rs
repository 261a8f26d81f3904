//! Quaternions in streams as programs log them: of one sign, with attitudes that are no rotation,
//! and with attitudes that are confused for a while.

use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::{Estimate, calibrate};
use homepoint::quaternion::Quaternion;

use crate::problems::camera::{Camera, Pose};

/// The estimates, and what was said on the way.
fn answer(camera: &Camera, hand: &[Pose]) -> (Vec<Estimate>, Vec<String>) {
    let folder = camera.campaign("", hand, &camera.camera_poses(1));
    let opened = open(&Request::new([&*folder])).unwrap();
    let told = opened.warnings.iter().map(|one| one.message.clone()).collect();
    let fit = calibrate(opened.problem, &Options::default()).unwrap();
    assert!(fit.is_sound());
    assert!((0.9..1.1).contains(&fit.variance_factor().unwrap()), "{:?}", fit.variance_factor());
    (fit.estimates(), told)
}

fn delay(estimates: &[Estimate]) -> f64 {
    estimates.iter().find(|one| one.name == "camera.delay").unwrap().value.unwrap()
}

fn negated(q: Quaternion<f64>) -> Quaternion<f64> {
    Quaternion::from_components(q.components().map(|one| -one))
}

#[test]
fn the_sign_of_a_logged_quaternion_does_not_matter() {
    let camera = Camera::default();
    let hand = camera.hand_poses();
    let (as_it_is, told) = answer(&camera, &hand);
    assert!(told.is_empty(), "{told:?}");
    assert!((delay(&as_it_is) - camera.delay).abs() < 1e-3);
    let mut leaps = 0;
    let mut last = 1.0;
    let signed: Vec<Pose> = hand
        .iter()
        .map(|(t, place, q)| {
            let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
            leaps += usize::from(sign != last);
            last = sign;
            (*t, *place, if sign < 0.0 { negated(*q) } else { *q })
        })
        .collect();
    assert!(leaps > 2, "{leaps}");
    let (found, told) = answer(&camera, &signed);
    let [told] = &told[..] else { panic!("{told:?}") };
    assert!(told.contains(&format!("changes its sign {leaps} times")), "{told}");
    for (one, other) in found.iter().zip(&as_it_is) {
        assert!((one.value.unwrap() - other.value.unwrap()).abs() < 1e-9, "{}", one.name);
    }
}

/// Markers that are confused turn the hand by half a turn in some rows; all of them are named.
#[test]
fn attitudes_that_leap_away_and_back_are_left_out() {
    let camera = Camera::default();
    let mut hand = camera.hand_poses();
    let half = Quaternion::from_components([0.0, 0.0, 0.6, 0.8]);
    let bursts = [(300, 300), (411, 418), (700, 702), (1100, 1124), (1500, 1501)];
    for (first, last) in bursts {
        for (_, _, q) in &mut hand[first..=last] {
            *q = *q * half;
        }
    }
    for (_, _, q) in &mut hand[2000..2003] {
        *q = Quaternion::from_components([0.0; 4]);
    }
    let (found, told) = answer(&camera, &hand);
    assert!((delay(&found) - camera.delay).abs() < 1e-3, "{}", delay(&found));
    // Lines count from 1, and the first is the header.
    let rows = "leaps away and back 5 times: 39 rows left out (rows 302, 413-420, 702-704, 1102-1126, 1502-1503)";
    assert!(told.iter().any(|one| one.contains(rows)), "{told:?}");
    let empty =
        "is no rotation in 3 rows, its length is 0 or beyond 1000: left out (rows 2002-2004)";
    assert!(told.iter().any(|one| one.contains(empty)), "{told:?}");
}

/// A log that begins or ends in a burst, which comes again and again.
#[test]
fn a_log_that_begins_or_ends_with_a_wrong_attitude() {
    let camera = Camera::default();
    let half = Quaternion::from_components([0.0, 0.0, 0.6, 0.8]);
    let last = camera.hand_poses().len() - 1;
    let again: Vec<usize> = (0..last).step_by(7).collect();
    for wrong in [vec![0], vec![last], vec![0, 500, 1000, 1500], again] {
        let mut hand = camera.hand_poses();
        for at in &wrong {
            hand[*at].2 = hand[*at].2 * half;
        }
        let (found, told) = answer(&camera, &hand);
        assert!((delay(&found) - camera.delay).abs() < 1e-3, "{wrong:?}: {}", delay(&found));
        let rows = if wrong.len() == 1 { "1 row" } else { &*format!("{} rows", wrong.len()) };
        let count = format!(": {rows} left out");
        assert!(told.iter().any(|one| one.contains(&count)), "{wrong:?}: {told:?}");
    }
}

/// Other names and factors of the components make no other quaternion.
#[test]
fn components_under_other_names_are_made_continuous() {
    let camera = Camera::default();
    let mut hand = camera.hand_poses();
    hand.iter_mut().filter(|(_, _, q)| q.w < 0.0).for_each(|(_, _, q)| *q = negated(*q));
    let folder = camera.campaign("", &hand, &camera.camera_poses(1));
    let shipped = homepoint::library::embedded::MODELS.iter().find(|(name, _)| *name == "hand_eye");
    let model = shipped.unwrap().1;
    let other = "scalar = 'hand_qw'\nhand_turn = 'quaternion(1 * scalar, 2 * hand_qx / 2, hand_qy, hand_qz)'\n";
    let line = model.lines().find(|line| line.starts_with("hand_turn")).unwrap();
    std::fs::write(folder.join("other.toml"), model.replace(line, other)).unwrap();
    let path = folder.join("campaign.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replace("\"hand_eye\"", "\"other.toml\"")).unwrap();
    let opened =
        homepoint::engine::open::open(&homepoint::engine::open::Request::new([&*folder])).unwrap();
    assert!(opened.warnings.iter().any(|one| one.message.contains("made continuous")));
}

/// A hand that turns fast between few rows leaps nowhere; one that is another body from a row on
/// does, and is left as it is.
#[test]
fn a_fast_turn_is_no_leap() {
    let fast = Camera { hand: (-2.0, 22.0, 0.1), ..Camera::default() };
    let warned = |hand: &[Pose]| {
        let folder = fast.campaign("", hand, &fast.camera_poses(1));
        let opened = open(&Request::new([&*folder])).unwrap();
        opened.warnings.iter().map(|one| one.message.clone()).collect::<Vec<_>>()
    };
    let mut hand = fast.hand_poses();
    assert!(warned(&hand).is_empty(), "{:?}", warned(&hand));
    let other = Quaternion::from_components([0.0, 1.0, 0.0, 0.0]);
    hand[150..].iter_mut().for_each(|(_, _, q)| *q = *q * other);
    let told = warned(&hand);
    assert!(
        told.iter().any(|one| one.contains("leaps once and does not come back (row 152)")),
        "{told:?}"
    );
}
