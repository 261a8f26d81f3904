//! Clocks that are far apart: the readings' own delays agree with the joint estimate, and a search
//! finds offsets that no start is near.

use homepoint::engine::open::{Opened, Request, open};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::{Calibration, calibrate};
use homepoint::estimate::compare::compare;
use homepoint::estimate::minima::{Found, improved, others};
use homepoint::estimate::refit::calibrate_near;
use homepoint::estimate::transformation::delays_of;

use crate::folder::Folder;
use crate::problems::Stream;
use crate::problems::camera::Camera;
use crate::problems::load_cell::{DELAY, GAIN, LoadCell};
use crate::scale::{SCALE, Scales};

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

/// What came of a campaign with a search for its start: the fit, and the offset that was found.
fn searched(camera: &Camera) -> (Calibration, Option<f64>) {
    let folder = campaign(camera, "");
    let (problem, found) = improved(opened(&folder).problem);
    let fit = calibrate(problem, &Options::default()).unwrap();
    (fit, found.first().map(|found| found.offset))
}

#[test]
fn clocks_that_are_seconds_apart_are_found() {
    for offset in [1.7, -3.2] {
        let camera = Camera { delay: offset, ..Camera::default() };
        let (fit, found) = searched(&camera);
        assert!((found.unwrap() - offset).abs() < 0.1, "{offset}: {found:?}");
        assert!((delay(&fit) - offset).abs() < 1e-3, "{offset}: {}", delay(&fit));
        assert!(fit.variance_factor().unwrap() < 1.1, "{:?}", fit.variance_factor());
        for (axis, due) in ["x", "y", "z"].iter().zip(camera.lever) {
            let estimates = fit.estimates();
            let name = format!("camera_lever.{axis}");
            let one = estimates.iter().find(|one| one.name == name).unwrap();
            let off = (one.value.unwrap() - due).abs();
            assert!(off < 4.0 * one.sigma.unwrap(), "{offset} {axis}: {off}");
        }
    }
}

/// A range narrower than a step between offsets has one of them: no range of the same number at both ends.
#[test]
fn one_offset_that_was_tried_is_reported_as_one() {
    let camera = Camera { delay: -3.2, ..Camera::default() };
    let folder = campaign(&camera, "delay_range = [\"-3.21 s\", \"-3.19 s\"]");
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_homepoint"));
    let output = command.arg("calibrate").arg(&*folder).output().unwrap();
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(told.contains("tried was one offset, -3.2 s, in "), "{told}");
    assert!(!told.contains("tried were offsets"), "{told}");
}

#[test]
fn a_good_start_is_left_alone() {
    let (fit, found) = searched(&Camera::default());
    assert!(found.is_none());
    assert!(others(&fit).is_empty(), "{:?}", others(&fit));
}

/// A motion of one period: each solution a period later fits as well.
#[test]
fn what_repeats_is_ambiguous() {
    fn shaken(t: f64) -> ([f64; 3], [f64; 3]) {
        let phase = std::f64::consts::TAU * t / 1.3;
        let place = [
            0.2 * phase.sin() + 0.07 * (2.0 * phase).cos(),
            0.1 * (2.0 * phase).cos(),
            0.15 * (phase + 0.4).cos(),
        ];
        (place, [0.4 * (phase + 1.0).sin(), 0.3 * (2.0 * phase).sin(), 0.5 * phase.cos()])
    }
    let camera = Camera { motion: shaken, ..Camera::default() };
    let (fit, found) = searched(&camera);
    assert!(found.is_none());
    let found = others(&fit);
    assert!(!found.is_empty());
    for one in &found {
        let periods = (one.values[0] - one.values[1]) / 1.3;
        assert!((periods - periods.round()).abs() < 1e-2 && periods.round() != 0.0, "{periods}");
        assert!(one.chi_squared.abs() < 25.0);
    }
}

/// A reading of a square says nothing of the sign of its root.
#[test]
fn a_mirrored_sign_is_ambiguous() {
    let scales = Scales::new();
    let model = SCALE.replace("value = 'a'", "value = 'a * a / (1 m)'");
    let start = "a = { start = \"1 m\" }";
    let sigma = "x = { sigma = \"1 mm\" }";
    let mut found = Vec::new();
    for (name, head) in [("started", start), ("open", "")] {
        let folder = scales.written(name, &model, "", head, sigma, "m", &[0.25, 0.251, 0.249]);
        let problem = open(&Request::new([folder])).unwrap().problem;
        let mut problem = problem;
        if name == "open" {
            // From zero, where the square is flat, no fit goes anywhere.
            problem.layout.instances[0].setting.start = Some(vec![1.0]);
            let fit = calibrate(problem.clone(), &Options::default()).unwrap();
            problem.layout.instances[0].setting.start = None;
            found.extend(others(&Calibration { problem, ..fit }));
        } else {
            let fit = calibrate(problem, &Options::default()).unwrap();
            assert!(others(&fit).is_empty(), "a start that is stated says which");
        }
    }
    let [one] = &found[..] else { panic!("{found:?}") };
    assert!((one.values[0] + 0.5).abs() < 1e-3 && (one.values[1] - 0.5).abs() < 1e-3);
    assert!(one.chi_squared.abs() < 1e-6);
}

/// A mirror that turns with one period: where its clock had to be looked for, other periods fit alike.
fn mirror(delay: f64, head: &str) -> Folder {
    let angle = |t: f64| 0.5 * (std::f64::consts::TAU * t / 4.0).sin();
    let mut stream = crate::problems::Stream(9);
    let mut log = "time [s],angle [rad]\n".to_owned();
    (0..1600).for_each(|n| {
        log += &format!("{:.3},{:.8}\n", 0.025 * f64::from(n), angle(0.025 * f64::from(n)))
    });
    let mut data = "time [s],y [rad]\n".to_owned();
    for n in 0..250 {
        let t = 5.0 + 0.1 * f64::from(n);
        let y = 1.1 * angle(t + delay) + 1e-4 * stream.normal();
        data += &format!("{t:.3},{y:.8}\n");
    }
    let model = "name = \"mirror\"\ntitle = \"Mirror\"\n[inputs]\nangle = { unit = \"rad\", signal = true }\n\
        [parameters]\nscale = { unit = \"1\", start = \"1\" }\n[measurands]\n\
        y = { value = 'scale * angle', unit = \"rad\", sigma = \"100 urad\" }\n";
    let campaign = format!(
        "title = \"Mirror\"\nmodel = \"model.toml\"\n{head}\n[[runs]]\nname = \"run\"\ndata = \"data.csv\"\nsignals = [\"log.csv\"]\n"
    );
    Folder::new(
        "mirror",
        &[
            ("model.toml", model),
            ("campaign.toml", &campaign),
            ("log.csv", &log),
            ("data.csv", &data),
        ],
    )
}

/// A start that the search found is nobody's statement: the solution stays ambiguous.
#[test]
fn what_repeats_is_ambiguous_where_its_start_was_looked_for() {
    let folder = mirror(1.63, "delay_range = [\"0.5 s\", \"9 s\"]");
    let (problem, found) = improved(opened(&folder).problem);
    assert_eq!(found.len(), 1);
    let fit = calibrate(problem, &Options::default()).unwrap();
    let value = fit.estimates().iter().find(|one| one.name == "y.delay").unwrap().value.unwrap();
    let all: Vec<f64> = others(&fit).iter().map(|one| one.values[0]).chain([value]).collect();
    for due in [1.63, 5.63] {
        assert!(all.iter().any(|one| (one - due).abs() < 1e-3), "{due}: {all:?}");
    }
    assert!(all.iter().all(|one| (0.4..9.1).contains(one)), "{all:?}");
}

#[test]
fn each_campaign_has_its_own_clock() {
    let cameras = [(2.3, 5), (-0.02, 6)].map(|(delay, _)| Camera { delay, ..Camera::default() });
    let folders = cameras.each_ref().map(|camera| campaign(camera, ""));
    let request = Request::new(folders.iter().map(|folder| folder.to_path_buf()));
    let (problem, found) = improved(open(&request).unwrap().problem);
    assert_eq!(found.len(), 1, "{found:?}");
    let fit = calibrate(problem, &Options::default()).unwrap();
    let delays: Vec<f64> = fit
        .estimates()
        .iter()
        .filter(|one| one.name == "camera.delay")
        .map(|one| one.value.unwrap())
        .collect();
    assert_eq!(delays.len(), 2);
    for (found, camera) in delays.iter().zip(&cameras) {
        assert!((found - camera.delay).abs() < 2e-3, "{delays:?}");
    }
}

/// Readings that are not of this motion at all: no start is taken over a few of them.
#[test]
fn a_fit_of_a_few_samples_is_no_start() {
    let folder = mirror(0.0, "");
    let path = folder.join("data.csv");
    let text = std::fs::read_to_string(&path).unwrap();
    let (head, rows) = text.split_once('\n').unwrap();
    let mut stream = crate::problems::Stream(2);
    let mut walk = 0.0;
    let mut all = format!("{head}\n");
    for row in rows.lines() {
        walk += 0.05 * stream.normal();
        all += &format!("{},{walk:.6}\n", row.split(',').next().unwrap());
    }
    std::fs::write(path, all).unwrap();
    let (problem, found) = improved(opened(&folder).problem);
    let enough = found.iter().all(|one| one.left_out * 10 <= 250);
    assert!(enough && problem.reading_count() >= 225, "{found:?}");
}

/// Whatever is held or put in later starts where the search ended.
#[test]
fn problems_made_anew_of_the_same_data_start_where_the_search_ended() {
    let camera = Camera { delay: 1.7, ..Camera::default() };
    let (problem, found) = improved(opened(&campaign(&camera, "")).problem);
    assert_eq!(found.len(), 1);
    let again = homepoint::engine::Problem::new(problem.parts.clone());
    let fit = calibrate(again, &Options::default()).unwrap();
    assert!((delay(&fit) - 1.7).abs() < 2e-3, "{}", delay(&fit));
}

/// Clocks of two runs are tried one after the other, each without the samples of the other run, whose
/// inputs are streams with a stated uncertainty.
#[test]
fn clocks_of_runs_over_streams_with_a_stated_uncertainty_are_tried() {
    let mut random = Stream(8);
    let at = |t: f64| (0.9 * t).sin() + 0.3 * (2.3 * t).cos();
    let mut files = vec![
        (
            "model.toml".to_owned(),
            "name = \"m\"\ntitle = \"Slide\"\n[inputs]\nx = { unit = \"m\", signal = true }\n\
             [parameters]\nzero = { unit = \"m\" }\n\
             [measurands]\ny = { value = 'x + zero', unit = \"m\", sigma = \"1 mm\" }\n"
                .to_owned(),
        ),
        (
            "campaign.toml".to_owned(),
            "title = \"Two\"\nmodel = \"model.toml\"\n[parameters]\n\"y.delay\" = { scope = \"run\" }\n\
             [inputs]\nx = { sigma = \"0.1 mm\" }\n\
             [[runs]]\nname = \"a\"\ndata = \"a.csv\"\nsignals = [\"a_x.csv\"]\n\
             [[runs]]\nname = \"b\"\ndata = \"b.csv\"\nsignals = [\"b_x.csv\"]\n"
                .to_owned(),
        ),
    ];
    for (run, first) in [("a", 0.0), ("b", 100.0)] {
        let (mut x, mut y) = ("time [s],x [m]\n".to_owned(), "time [s],y [m]\n".to_owned());
        for i in 0..2000 {
            let t = first + 0.02 * f64::from(i);
            x.push_str(&format!("{t:.2},{:.6}\n", at(t) + 1e-4 * random.normal()));
            if i % 5 == 0 && (50..1950).contains(&i) {
                y.push_str(&format!("{t:.2},{:.6}\n", at(t - 0.02) + 1e-3 * random.normal()));
            }
        }
        files.extend([(format!("{run}_x.csv"), x), (format!("{run}.csv"), y)]);
    }
    let files: Vec<(&str, &str)> = files.iter().map(|(a, b)| (a.as_str(), b.as_str())).collect();
    let folder = Folder::new("clocks_of_runs", &files);
    let (problem, _) = improved(opened(&folder).problem);
    let fit = calibrate(problem, &Options::default()).unwrap();
    assert!(others(&fit).is_empty());
    let all: Vec<f64> = fit
        .estimates()
        .iter()
        .filter(|one| one.name == "y.delay")
        .map(|one| one.value.unwrap())
        .collect();
    assert!(all.len() == 2 && all.iter().all(|one| (one + 0.02).abs() < 1e-3), "{all:?}");
}

/// What a load cell gives, of which the gain starts far off: a step in the delay is as many times too
/// long as the gain starts too small.
fn weighed(cell: &LoadCell) -> (Calibration, Vec<Found>) {
    let folder = tempfile::tempdir().unwrap();
    cell.written(folder.path());
    let problem = open(&Request::new([folder.path()])).unwrap().problem;
    let (problem, found) = improved(problem);
    (calibrate(problem, &Options::default()).unwrap(), found)
}

fn value(fit: &Calibration, name: &str) -> f64 {
    fit.estimates().iter().find(|one| one.name == name).unwrap().value.unwrap()
}

#[test]
fn a_gain_that_starts_far_off_takes_no_delay_along() {
    for start in [1e3, 1e4, 1e5, 1e6] {
        let (fit, _) = weighed(&LoadCell { start, seed: 3, ..LoadCell::default() });
        assert!((value(&fit, "raw.delay") - DELAY).abs() < 1e-3, "{start}");
        assert!((value(&fit, "gain") / GAIN - 1.0).abs() < 1e-3, "{start}");
        assert!(fit.variance_factor().unwrap() < 1.3, "{start}");
    }
}

/// Where both sums of squares are those of wrong readings, and neither is far better, the rest is compared.
#[test]
fn wrong_readings_do_not_hide_a_start_that_fits_far_better() {
    let mut compared = Vec::new();
    for start in [1e3, 1e4, 1e5, 1e6] {
        let (fit, found) = weighed(&LoadCell { start, seed: 3, wrong: 0.022 });
        assert!((value(&fit, "raw.delay") - DELAY).abs() < 0.1, "{start}");
        assert!(fit.variance_factor().unwrap() > 1e3, "{start}");
        compared.extend(found.iter().filter_map(|found| found.most));
    }
    assert!(!compared.is_empty());
    for [before, after] in compared {
        assert!(5.0 * after.powi(2) < before.powi(2), "{before} {after}");
    }
}

/// From its start a fit ends in another period of the motion.
#[test]
fn a_fit_of_nearly_the_same_readings_ends_no_worse() {
    let folder = tempfile::tempdir().unwrap();
    LoadCell { start: 1e5, seed: 3, ..LoadCell::default() }.written(folder.path());
    let problem = open(&Request::new([folder.path()])).unwrap().problem;
    let options = Options::default();
    let whole = calibrate(improved(problem.clone()).0, &options).unwrap();
    let mut rest = problem;
    rest.leave_out_samples(|count| std::iter::once(count / 2..count / 2 + 40).collect());
    let alone = calibrate(rest.clone(), &options).unwrap();
    assert!((value(&alone, "raw.delay") - DELAY).abs() > 1.0, "the fit is not led astray");
    let fit = calibrate_near(rest, &whole.fit.point, &options).unwrap();
    assert!((value(&fit, "raw.delay") - DELAY).abs() < 1e-3, "{}", value(&fit, "raw.delay"));
}
