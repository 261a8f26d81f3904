//! Campaigns begun from poses in a plane: columns by their names, and paths of dead reckoning.

use std::path::PathBuf;

use homepoint::campaign::begin::begin;
use homepoint::estimate::linear_range::beyond_range;

use crate::begin::{begun, fitted, library, readings};
use crate::folder::Folder;

/// A path of dead reckoning: it begins at zero, its turns are 2 % too large, 0.2 rad at its end, its
/// distances 1 % too long.
fn reckoned() -> [(&'static str, String); 2] {
    let course = |t: f64| 0.4 + 0.3 * t + 1.5 * (0.5 * t).sin();
    let steps = 3000;
    let (mut path, mut truth) = (vec![(0.0, 0.0, 0.0)], vec![(2.0, 1.0, 0.4)]);
    for n in 0..steps {
        let (from, to) = (course(0.01 * n as f64), course(0.01 * (n + 1) as f64));
        let (way, middle) = (0.003, 0.5 * (from + to));
        let (x, y, heading) = truth[n];
        truth.push((x + way * middle.cos(), y + way * middle.sin(), heading + to - from));
        let (x, y, heading) = path[n];
        let turned = 1.02 * (to - from);
        let middle = heading + 0.5 * turned;
        path.push((x + 1.01 * way * middle.cos(), y + 1.01 * way * middle.sin(), heading + turned));
    }
    let log = |all: &[(f64, f64, f64)], every: usize| {
        let rows = all.iter().enumerate().step_by(every).map(|(n, (x, y, heading))| {
            format!("{:.2},{x:.6},{y:.6},{heading:.7}\n", 0.01 * n as f64)
        });
        format!("t_s,x_m,y_m,th_rad\n{}", rows.collect::<String>())
    };
    [("wheels.csv", log(&path, 5)), ("cameras.csv", log(&truth, 1))]
}

#[test]
fn the_scales_of_a_path_of_dead_reckoning_are_estimated() {
    let files = reckoned();
    let (text, model, campaign) = begun(&files, None).unwrap();
    assert!(text.contains("data = { file = \"wheels.csv\""), "{text}");
    assert!(model.contains("heading_scale") && model.contains("integral over the way"), "{model}");
    assert!(readings(&campaign) > 3 * 500);
    let found = fitted(&files, None);
    // The frame is that at the first pose: the path begins at its origin.
    let (sin, cos) = 0.4_f64.sin_cos();
    for (name, known) in [
        ("heading_scale", 0.02),
        ("distance_scale", 0.01),
        ("lever_left", 0.0),
        ("lever_forward", 0.0),
        ("heading_offset", 0.0),
        ("frame_turn", -0.4),
        ("frame_x", -1.01 * (2.0 * cos + sin)),
        ("frame_y", -1.01 * (cos - 2.0 * sin)),
    ] {
        let estimates = found.estimates();
        let value = estimates.iter().find(|one| one.name == name).unwrap().value.unwrap();
        assert!((value - known).abs() < 3e-4, "{name}: {value}");
    }
    assert_eq!(beyond_range(&found.problem, &found.estimates()), []);
    // A bend that was computed at another scale is computed again at the value that is found.
    let far = fitted(&files, Some(0.0));
    let far = &beyond_range(&far.problem, &far.estimates())[0];
    let again = far.simulate_at.unwrap();
    assert!(far.parameter == "heading_scale" && (again - 0.02).abs() < 1e-3, "{far:?}");
    let near = fitted(&files, Some(again));
    assert_eq!(beyond_range(&near.problem, &near.estimates()), []);
    // Neither noise nor rows that are lost at the start change that.
    for start in ["0.000050,-0.000020,", "0.020000,0.001000,"] {
        let near =
            files.clone().map(|(name, text)| (name, text.replace("0.000000,0.000000,", start)));
        assert!(begun(&near, None).unwrap().1.contains("heading_scale"), "{start}");
    }
    // A path that does not begin at zero is none.
    let shifted = files.map(|(name, text)| (name, text.replace("0.000000,0.000000,", "1,1,")));
    assert!(!begun(&shifted, None).unwrap().1.contains("heading_scale"));
}

/// A pose in a plane stands among other columns, under other names, and beside an axis that hardly moves.
#[test]
fn poses_in_a_plane_are_known_beside_other_columns_and_by_other_names() {
    let [(_, wheels), (_, cameras)] = reckoned();
    let rows = |text: &str, head: &str, row: &dyn Fn(&[&str], usize) -> String| {
        let rows = text.lines().skip(1).enumerate();
        let rows = rows.map(|(n, line)| row(&line.split(',').collect::<Vec<_>>(), n) + "\n");
        format!("{head}\n{}", rows.collect::<String>())
    };
    let height = |n: usize| 0.1 + 0.001 * (0.3 * n as f64).sin();
    let flat = |cells: &[&str], _: usize| cells.join(",");
    let upright = |cells: &[&str], n: usize| {
        let [t, x, y, heading] = cells else { panic!("{cells:?}") };
        format!("{t},{n},{x},{y},{:.5},{heading}", height(n))
    };
    // Motion capture with the second axis upwards: forward is z, to the left x.
    let sideways = |cells: &[&str], n: usize| {
        let [t, x, y, heading] = cells else { panic!("{cells:?}") };
        format!("{t},{n},{y},{:.5},{x},{heading}", height(n))
    };
    let tilting = |cells: &[&str], n: usize| {
        let [t, x, y, heading] = cells else { panic!("{cells:?}") };
        format!("{t},{x},{y},{:.5},{:.5},{heading}", 0.01 * height(3 * n), 0.02 * height(n))
    };
    type Row<'a> = &'a dyn Fn(&[&str], usize) -> String;
    let variants: [(&str, Row<'_>, &str, Row<'_>, &str); 4] = [
        (
            "t_s,px,py,theta_rad",
            &flat,
            "t_s,Frame,x_m,y_m,z_m,yaw_rad",
            &upright,
            r#""Frame", "z_m""#,
        ),
        (
            "t_s,odom.pos_x [m],odom.pos_y [m],odom.yaw [rad]",
            &flat,
            "t_s,Frame,Robot X (m),Robot Y (m),Robot Z (m),Robot Yaw (rad)",
            &upright,
            r#""Frame", "Robot Z""#,
        ),
        (
            "t_s,x [m],y [m],psi [rad]",
            &flat,
            "t_s,Frame,x [m],y [m],z [m],heading [rad]",
            &sideways,
            r#""Frame", "y""#,
        ),
        // Of the three angles of a vehicle psi is the heading.
        (
            "t_s,x_m,y_m,theta_rad",
            &flat,
            "t_s,x_m,y_m,phi_rad,theta_rad,psi_rad",
            &tilting,
            r#""phi_rad", "theta_rad""#,
        ),
    ];
    for (own, of_wheels, other, of_cameras, unused) in variants {
        let files = [
            ("wheels.csv", rows(&wheels, own, of_wheels)),
            ("cameras.csv", rows(&cameras, other, of_cameras)),
        ];
        let (text, model, campaign) = begun(&files, None).unwrap();
        assert!(model.contains("heading_scale"), "{other}\n{text}\n{model}");
        assert!(text.contains(&format!("unused = [{unused}],   # the model takes")), "{text}");
        assert!(readings(&campaign) > 3 * 500, "{text}");
        let scale =
            fitted(&files, None).estimates().into_iter().find(|one| one.name == "heading_scale");
        let scale = scale.unwrap().value.unwrap();
        assert!((scale - 0.02).abs() < 1e-3, "{other}: {scale}");
    }
    // A pose that is not used is reported with the reason.
    let unturned = |cells: &[&str], _: usize| cells[..3].join(",");
    let files = [("wheels.csv", wheels), ("cameras.csv", rows(&cameras, "t_s,x_m,y_m", &unturned))];
    let (text, model, _) = begun(&files, None).unwrap();
    assert!(model.contains("x_scale"), "{model}");
    let why =
        "poses of `wheels.csv` are not used: `cameras.csv` has no pose in a plane, for no column";
    assert!(text.contains(why), "{text}");
}

/// A scale that cannot be, and one of logs that are no path of dead reckoning.
#[test]
fn a_scale_that_no_heading_has_is_refused() {
    let texts = reckoned();
    let texts: Vec<(&str, &str)> =
        texts.iter().map(|(name, text)| (*name, text.as_str())).collect();
    let folder = Folder::new("scales", &texts);
    let logs: Vec<(PathBuf, PathBuf)> =
        texts.iter().map(|(name, _)| (folder.join(name), PathBuf::from(name))).collect();
    for scale in [f64::NAN, f64::INFINITY, -1.0, 1e300, -0.6] {
        let fault = begin(&logs, None, &library(), Some(scale)).unwrap_err().to_string();
        assert!(fault.contains("must be between -0.5 and 1"), "{scale}: {fault}");
    }
    assert!(begin(&logs, None, &library(), Some(-0.02)).unwrap().table.is_some());
}
