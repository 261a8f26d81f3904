//! Conventions that were mistaken in logs of known motion are named, with what to type; where the
//! model itself is wrong none is.

use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::calibrate;
use homepoint::estimate::conventions::{Mistaken, mistaken};
use homepoint::estimate::minima::improved;
use homepoint::library::conventions;

use crate::folder::Folder;
use crate::problems::Stream;
use crate::problems::camera::Camera;
use crate::problems::load_cell::LoadCell;

/// Gives the columns of a table other heads.
fn renamed(folder: &Folder, table: &str, heads: &[(&str, &str)]) {
    let path = folder.join(table);
    let text = std::fs::read_to_string(&path).unwrap();
    let (head, rows) = text.split_once('\n').unwrap();
    let own = |name: &str| {
        let bare = name.split(' ').next().unwrap();
        let other = heads.iter().find(|(from, _)| *from == bare);
        other.map_or(name.to_owned(), |(from, to)| name.replace(from, to))
    };
    let head: Vec<String> = head.split(',').map(own).collect();
    std::fs::write(path, format!("{}\n{rows}", head.join(","))).unwrap();
}

/// Changes the numbers of a column.
pub(crate) fn changed(
    folder: &Folder,
    table: &str,
    column: &str,
    mut change: impl FnMut(f64) -> f64,
) {
    let path = folder.join(table);
    let text = std::fs::read_to_string(&path).unwrap();
    let (head, rows) = text.split_once('\n').unwrap();
    let at = head.split(',').position(|name| name.split(' ').next() == Some(column)).unwrap();
    let mut all = format!("{head}\n");
    for row in rows.lines() {
        let mut cells: Vec<String> = row.split(',').map(str::to_owned).collect();
        cells[at] = change(cells[at].parse().unwrap()).to_string();
        all.push_str(&format!("{}\n", cells.join(",")));
    }
    std::fs::write(path, all).unwrap();
}

pub(crate) fn found(folder: &Folder) -> Option<Mistaken> {
    let opened = open(&Request::new([&**folder])).unwrap();
    mistaken(&opened.problem, None, &conventions([]).unwrap())
}

pub(crate) fn names(found: &Mistaken) -> Vec<&str> {
    found.what.iter().chain(&found.alike).map(|one| one.name.as_str()).collect()
}

/// One stop in 24 was taken for another one, which bends every fit.
#[test]
fn a_convention_is_identified_beside_an_outlier() {
    let folder = Camera::default().stops(24, 3);
    let mut row = 0;
    changed(&folder, "stops.csv", "x", |value| {
        row += 1;
        if row == 9 { value + 0.8 } else { value }
    });
    changed(&folder, "stops.csv", "attitude_x", |value| -value);
    changed(&folder, "stops.csv", "attitude_y", |value| -value);
    changed(&folder, "stops.csv", "attitude_z", |value| -value);
    let found = found(&folder).unwrap();
    assert!(names(&found).contains(&"quaternion_inverse"), "{found:?}");
}

#[test]
fn right_logs_have_no_convention_mistaken() {
    assert!(found(&Camera::default().stops(24, 3)).is_none());
}

#[test]
fn the_order_of_components_is_named_for_the_readings_and_for_the_rig() {
    let folder = Camera::default().stops(24, 3);
    let last = ["w", "x", "y", "z"];
    let heads: Vec<(String, String)> = (0..4)
        .map(|at| {
            (format!("attitude_{}", ["x", "y", "z", "w"][at]), format!("attitude_{}", last[at]))
        })
        .collect();
    let heads: Vec<(&str, &str)> = heads.iter().map(|(a, b)| (a.as_str(), b.as_str())).collect();
    renamed(&folder, "stops.csv", &heads);
    let one = found(&folder).unwrap();
    assert!(names(&one).contains(&"quaternion_scalar_last"), "{one:?}");
    assert!(one.variance_factors[1] < 2.0, "{one:?}");
    let columns = &one.columns;
    assert!(columns.contains(&("attitude_w".to_owned(), "attitude_z".to_owned())), "{columns:?}");
}

#[test]
fn a_mirrored_axis_and_swapped_columns_are_named() {
    let folder = Camera::default().stops(24, 3);
    changed(&folder, "stops.csv", "y", |value| -value);
    let one = found(&folder).unwrap();
    assert!(names(&one).contains(&"mirrored_y"), "{one:?}");
    let folder = Camera::default().stops(24, 3);
    renamed(&folder, "stops.csv", &[("x", "z"), ("z", "x")]);
    let one = found(&folder).unwrap();
    assert!(names(&one).contains(&"swapped_x_z"), "{one:?}");
}

#[test]
fn an_inverse_pose_of_the_hand_is_named() {
    let folder = Camera::default().stops(24, 3);
    for column in ["hand_qx", "hand_qy", "hand_qz"] {
        changed(&folder, "stops.csv", column, |value| -value);
    }
    let one = found(&folder).unwrap();
    assert!(names(&one).contains(&"quaternion_inverse"), "{one:?}");
    assert_eq!(one.what[0].numbers, ["hand_qw", "hand_qx", "hand_qy", "hand_qz"]);
}

/// Streams are changed as curves: linear formulas keep their rates.
#[test]
fn a_moving_hand_with_an_inverse_pose_is_named() {
    let camera = Camera::default();
    let folder = camera.campaign("", &camera.hand_poses(), &camera.camera_poses(4));
    assert!(found(&folder).is_none());
    for column in ["hand_qx", "hand_qy", "hand_qz"] {
        changed(&folder, "hand.csv", column, |value| -value);
    }
    let one = found(&folder).unwrap();
    assert!(names(&one).contains(&"quaternion_inverse"), "{one:?}");
    assert!(one.variance_factors[1] < 2.0, "{one:?}");
}

/// As game engines write poses: M p and M R M with one axis mirrored. Fitted rotations absorb all of M
/// but its sign, so that negated positions set it right; of the two logs the readings are changed.
#[test]
fn a_left_handed_frame_is_named_with_what_depends_on_the_choice() {
    let camera = Camera::default();
    let folder = camera.campaign("", &camera.hand_poses(), &camera.camera_poses(4));
    for column in ["y", "attitude_x", "attitude_z"] {
        changed(&folder, "camera.csv", column, |value| -value);
    }
    let one = found(&folder).unwrap();
    assert_eq!(one.what[0].name, "left_handed", "{one:?}");
    assert_eq!(one.what[0].numbers, ["x", "y", "z"]);
    assert!(one.variance_factors[1] < 2.0, "{one:?}");
    let [other] = &one.alike[..] else { panic!("{one:?}") };
    assert_eq!(other.numbers, ["hand_x", "hand_y", "hand_z"]);
    assert!(other.opposite.contains(&"camera_lever".to_owned()), "{other:?}");
    let text = homepoint::report::conventions::text(Some(&one));
    assert!(text.contains("`camera_lever` have the other sign"), "{text}");
    assert!(text.contains("columns = { x = \"-x\", y = \"-y\", z = \"-z\" }"), "{text}");
}

/// A search for the clock's offset is misled by a sign: through the program, the sign is named.
#[test]
fn a_search_for_the_clock_hides_no_convention() {
    let camera = Camera::default();
    let folder = camera.campaign("", &camera.hand_poses(), &camera.camera_poses(4));
    changed(&folder, "camera.csv", "x", |value| -value);
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_homepoint"));
    let output = command.arg("calibrate").arg(&*folder).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("(`mirrored_x`)"), "{text}");
    // What is to be typed is typed: with it the model fits.
    let line = text.lines().find_map(|line| line.strip_prefix("To use it, write in [[runs]]: "));
    let path = folder.join("campaign.toml");
    let campaign = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, format!("{campaign}{}\n", line.unwrap())).unwrap();
    let opened = open(&Request::new([&*folder])).unwrap();
    let fit =
        homepoint::estimate::calibrate::calibrate(opened.problem, &Default::default()).unwrap();
    assert!(fit.variance_factor().unwrap() < 1.3, "{:?}", fit.variance_factor());
}

/// Where the campaign calls columns otherwise, what is to be typed does so, too, and goes with what is
/// there.
#[test]
fn what_is_to_be_typed_keeps_the_columns_that_are_there() {
    let camera = Camera::default();
    let folder = camera.campaign("", &camera.hand_poses(), &camera.camera_poses(4));
    changed(&folder, "camera.csv", "x", |value| -value);
    let heads = [("x", "east"), ("y", "north"), ("z", "up")];
    renamed(&folder, "camera.csv", &heads);
    let path = folder.join("campaign.toml");
    let campaign = std::fs::read_to_string(&path).unwrap();
    let kept = "y = \"north [m]\", z = { column = \"up\", unit = \"m\" }";
    let columns = format!("columns = {{ x = \"east [m]\", {kept} }}\n");
    std::fs::write(&path, format!("{campaign}{columns}")).unwrap();
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_homepoint"));
    let output = command.arg("calibrate").arg(&*folder).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let line = text.lines().find(|line| line.starts_with("To use it, write among the `columns`"));
    let (_, line) = line.unwrap_or_else(|| panic!("{text}")).split_once("columns = { ").unwrap();
    assert_eq!(line, "x_as_read = \"east [m]\", x = \"-x_as_read\" }", "{text}");
    std::fs::write(&path, format!("{campaign}columns = {{ {kept}, {line}\n")).unwrap();
    let opened = open(&Request::new([&*folder])).unwrap();
    let fit =
        homepoint::estimate::calibrate::calibrate(opened.problem, &Default::default()).unwrap();
    assert!(fit.variance_factor().unwrap() < 1.3, "{:?}", fit.variance_factor());
}

/// Campaigns of models whose readings are called alike but whose inputs differ are not read alike.
#[test]
fn campaigns_of_unlike_models_have_no_convention() {
    let camera = Camera::default();
    let (first, second) = (camera.stops(12, 3), camera.stops(12, 4));
    let model = homepoint::library::embedded::MODELS
        .iter()
        .find(|(name, _)| *name == "hand_eye")
        .unwrap()
        .1;
    let other = model.replace("[parameters]", "spare = { unit = \"m\" }\n[parameters]");
    std::fs::write(second.join("other.toml"), other).unwrap();
    let path = second.join("campaign.toml");
    let text = std::fs::read_to_string(&path).unwrap().replace("\"hand_eye\"", "\"other.toml\"");
    std::fs::write(path, text).unwrap();
    changed(&first, "stops.csv", "y", |value| -value);
    let opened = open(&Request::new([first.to_path_buf(), second.to_path_buf()])).unwrap();
    assert!(mistaken(&opened.problem, None, &conventions([]).unwrap()).is_none());
}

/// A model that lacks an effect fits badly, too: that is no convention.
#[test]
fn a_bad_model_has_no_convention_mistaken() {
    let folder = Camera::default().stops(40, 3);
    let mut stop = 0.0;
    changed(&folder, "stops.csv", "z", |value| {
        stop += 1.0;
        value + 0.05 * f64::sin(0.7 * stop)
    });
    assert!(found(&folder).is_none(), "{:?}", found(&folder));
}

/// A reading of which the model says nothing but a constant fits better the smaller its numbers are
/// made, but no better beside its own scatter; an outlier of another reading changes nothing about that.
#[test]
fn numbers_that_are_made_smaller_are_no_convention_beside_an_outlier() {
    let model = "name = \"sky\"\ntitle = \"A mount\"\n[inputs]\naz = { unit = \"rad\" }\n[parameters]\nzero = { unit = \"rad\", scope = \"rig\" }\nlevel = { unit = \"rad\", scope = \"rig\" }\n[measurands]\nd_az = { value = 'zero', unit = \"rad\" }\nd_el = { value = 'level', unit = \"rad\" }\n";
    let campaign = "title = \"Sky\"\nmodel = \"sky.toml\"\n[measurands]\nd_az = { sigma = \"10 urad\" }\nd_el = { sigma = \"10 urad\" }\n[[runs]]\nname = \"night\"\ndata = \"log.csv\"\n";
    let mut random = Stream(3);
    let mut log = "az [rad],d_az [rad],d_el [rad]\n".to_owned();
    for star in 0..300 {
        let az = std::f64::consts::TAU * random.uniform();
        let wrong = if [40, 200].contains(&star) { 5e-4 } else { 0.0 };
        let d_az = 1e-4 + 5e-5 * (3.0 * az).sin() + 1e-5 * random.normal() + wrong;
        let d_el = 2e-4 + 1e-5 * random.normal() - wrong;
        log.push_str(&format!("{az:.9},{d_az:.9},{d_el:.9}\n"));
    }
    let files = [("sky.toml", model), ("campaign.toml", campaign), ("log.csv", log.as_str())];
    let folder = Folder::new("shrunk", &files);
    assert!(found(&folder).is_none(), "{:?}", found(&folder));
}

#[test]
fn every_convention_of_the_library_is_read() {
    let all = conventions([]).unwrap();
    assert!(all.len() > 30);
    assert!(all.iter().all(|one| one.formulas.len() == one.form.components().len()));
}

/// A force sensor whose axes are turned against the flange: forces and torques together.
#[test]
fn a_sensor_that_is_turned_as_a_whole_is_named() {
    let model = "name = \"payload\"\ntitle = \"Payload\"\n\
        [inputs]\na = { unit = \"rad\" }\nb = { unit = \"rad\" }\n\
        [parameters]\nmass = { unit = \"kg\" }\ncentre = { kind = \"vector\", unit = \"m\" }\n\
        zero = { kind = \"vector\", unit = \"N\" }\n\
        [quantities]\nflange = 'rotation_z(a) * rotation_y(b)'\n\
        weight = 'rotate(inverse(flange), [0 N, 0 N, -mass * 9.81 m/s^2])'\n\
        level = 'rotate(inverse(flange), [0 N, -mass * 9.81 m/s^2, 0 N])'\n\
        force = 'weight + level + zero'\ntorque = 'cross(centre, weight + level)'\n\
        [measurands]\nfx = { value = 'force.x', unit = \"N\" }\nfy = { value = 'force.y', unit = \"N\" }\n\
        fz = { value = 'force.z', unit = \"N\" }\ntx = { value = 'torque.x', unit = \"N m\" }\n\
        ty = { value = 'torque.y', unit = \"N m\" }\ntz = { value = 'torque.z', unit = \"N m\" }\n";
    let mut campaign = "title = \"Poses\"\nmodel = \"model.toml\"\n[measurands]\n".to_owned();
    for (name, sigma) in [("f", "0.1 N"), ("t", "5 mN m")] {
        for axis in ["x", "y", "z"] {
            campaign.push_str(&format!("{name}{axis} = {{ sigma = \"{sigma}\" }}\n"));
        }
    }
    campaign.push_str("[[runs]]\nname = \"poses\"\ndata = \"poses.csv\"\n");
    let mut random = Stream(5);
    let mut table = "a [rad],b [rad],fx [N],fy [N],fz [N],tx [N m],ty [N m],tz [N m]\n".to_owned();
    for _ in 0..40 {
        let [a, b] = [0, 1].map(|_| 5.0 * random.uniform() - 2.5);
        // Down and across in the flange's frame, 2.1 kg.
        let of = |[x, y, z]: [f64; 3]| {
            let (x, y) = (x * a.cos() + y * a.sin(), y * a.cos() - x * a.sin());
            [x * b.cos() - z * b.sin(), y, z * b.cos() + x * b.sin()]
        };
        let w = of([0.0, -2.1 * 9.81, -2.1 * 9.81]);
        let c = [0.02, -0.01, 0.07];
        let force = [w[0] + 1.2, w[1] - 0.4, w[2] + 2.5].map(|f| f + 0.1 * random.normal());
        let torque =
            [c[1] * w[2] - c[2] * w[1], c[2] * w[0] - c[0] * w[2], c[0] * w[1] - c[1] * w[0]]
                .map(|t| t + 0.005 * random.normal());
        // The sensor's x is the flange's y.
        let cells = [a, b, force[1], -force[0], force[2], torque[1], -torque[0], torque[2]];
        let cells: Vec<String> = cells.iter().map(|one| format!("{one:.5}")).collect();
        table.push_str(&format!("{}\n", cells.join(",")));
    }
    let files =
        [("model.toml", model), ("campaign.toml", campaign.as_str()), ("poses.csv", &table)];
    let one = found(&Folder::new("turned_sensor", &files)).unwrap();
    assert_eq!(one.what[0].name, "turned_90_about_z", "{one:?}");
    assert_eq!(one.what[0].numbers, ["fx", "fy", "fz", "tx", "ty", "tz"], "{one:?}");
    assert!(one.variance_factors[1] < 2.0, "{one:?}");
}

/// A gain that starts far off leads a fit astray, so that a convention seems to be mistaken; from where
/// the search for a start led none is.
#[test]
fn no_convention_is_mistaken_where_the_fit_is_right() {
    let folder = tempfile::tempdir().unwrap();
    for start in [1e4, 1e5] {
        LoadCell { start, seed: 3, ..LoadCell::default() }.written(folder.path());
        let problem = open(&Request::new([folder.path()])).unwrap().problem;
        let fit = calibrate(improved(problem.clone()).0, &Options::default()).unwrap();
        let all = conventions([]).unwrap();
        assert!(mistaken(&problem, None, &all).is_some(), "{start}: the fit is not led astray");
        let found = mistaken(&problem, Some(&fit.fit.point), &all);
        assert!(found.is_none(), "{start}: {found:?}");
    }
}

/// A depth in inches explains a pressure in psi only where the stated density is wrong by far: it is no
/// alternative to the unit that fits as stated.
#[test]
fn a_convention_that_contradicts_a_stated_value_is_no_alternative() {
    let mut random = Stream(17);
    let mut log = "depth [m],pressure [bar]\n".to_owned();
    for row in 0..120 {
        let depth = 0.4 * f64::from(row) + random.uniform();
        let pressure = 0.013 + 1027.0 * 9.81e-5 * depth + 0.002 * random.normal();
        log.push_str(&format!("{depth:.3},{:.4}\n", pressure * 14.503_773_8));
    }
    let files = [
        (
            "campaign.toml",
            "title = \"Depth\"\nmodel = \"probe.toml\"\n[measurands]\npressure = { sigma = \"4 mbar\" }\n\
             [[runs]]\nname = \"cast\"\ndata = \"log.csv\"\n",
        ),
        (
            "probe.toml",
            "name = \"probe\"\ntitle = \"Probe\"\n[inputs]\ndepth = { unit = \"m\" }\n[parameters]\n\
             density = { unit = \"kg/m^3\", value = \"1027 kg/m^3\", sigma = \"2 kg/m^3\" }\n\
             offset = { unit = \"Pa\" }\n[measurands]\n\
             pressure = { value = 'density * 9.81 m/s^2 * depth + offset', unit = \"Pa\" }\n",
        ),
        ("log.csv", log.as_str()),
    ];
    let found = found(&Folder::new("psi", &files)).unwrap();
    assert_eq!(names(&found), ["psi for bar"]);
    assert!(found.variance_factors[1] < 4.0, "{:?}", found.variance_factors);
}
