//! Minima at which a component of a vector has another value: each is named by itself, what must
//! change together as one.

use homepoint::engine::open::{Request, open};
use homepoint::estimate::calibrate::{Calibration, calibrate};
use homepoint::estimate::minima::others;
use homepoint::report::minima::{json, text};

use crate::folder::Folder;
use crate::problems::Stream;

/// Height (m) of the plane from which ranges are taken, and the anchors.
const PLANE: f64 = 0.42;
const ANCHORS: [[f64; 3]; 3] = [[-3.6, 2.9, 2.35], [3.9, 2.4, 2.62], [0.7, -3.7, 1.9]];

/// Ranges from 150 points to three anchors; the points' heights vary by `relief` (m).
fn anchors(relief: f64, parameters: &str) -> Calibration {
    let each = |line: &dyn Fn(&str) -> String| ["a", "b", "c"].map(line).concat();
    let model = format!(
        "name = \"anchors\"\ntitle = \"Anchors\"\n[inputs]\neast = {{ unit = \"m\" }}\nnorth = {{ unit = \"m\" }}\nup = {{ unit = \"m\" }}\n\
         [parameters]\n{}[measurands]\n{}",
        each(&|k| format!("anchor_{k} = {{ kind = \"vector\", unit = \"m\", scope = \"rig\" }}\n")),
        each(&|k| format!(
            "range_{k} = {{ value = 'norm(anchor_{k} - [east, north, up])', unit = \"m\", sigma = \"20 mm\" }}\n"
        )),
    );
    let campaign = format!(
        "title = \"Anchors\"\nmodel = \"model.toml\"\n[parameters]\n{parameters}\n[[runs]]\nname = \"floor\"\ndata = \"data.csv\"\n"
    );
    let mut noise = Stream(3);
    let mut data = "east [m],north [m],up [m],range_a [m],range_b [m],range_c [m]\n".to_owned();
    for n in 0..150 {
        let n = f64::from(n);
        let place = [
            2.0 * (0.37 * n).sin(),
            1.5 * (0.23 * n + 0.5).cos(),
            PLANE + relief * (0.7 * n).sin(),
        ];
        let ranges = ANCHORS.map(|anchor| {
            let square: f64 = anchor.iter().zip(place).map(|(a, p)| (a - p).powi(2)).sum();
            format!(",{:.5}", square.sqrt() + 0.02 * noise.normal())
        });
        data += &format!("{:.5},{:.5},{:.5}{}\n", place[0], place[1], place[2], ranges.concat());
    }
    let files = [("model.toml", &*model), ("campaign.toml", &*campaign), ("data.csv", &*data)];
    let folder = Folder::new("anchors", &files);
    calibrate(open(&Request::new([&*folder])).unwrap().problem, &Default::default()).unwrap()
}

/// Where the anchors are in plan; heights are open but for those that `of_c` states.
fn in_plan(of_c: &str) -> String {
    format!(
        "anchor_a = {{ x = {{ start = \"-4 m\" }}, y = {{ start = \"3 m\" }} }}\nanchor_b = {{ x = {{ start = \"4 m\" }}, y = {{ start = \"3 m\" }} }}\n\
         anchor_c = {{ x = {{ start = \"1 m\" }}, y = {{ start = \"-4 m\" }}{of_c} }}"
    )
}

#[test]
fn heights_of_anchors_over_a_plane_are_ambiguous_each_by_itself() {
    let fit = anchors(0.0, &in_plan(""));
    let found = others(&fit);
    assert_eq!(found.len(), 3, "{found:?}");
    for (one, anchor) in found.iter().zip(ANCHORS) {
        assert_eq!(one.component, 2);
        assert!((one.values[0] + one.values[1] - 2.0 * PLANE).abs() < 1e-3, "{one:?}");
        assert!(one.values.iter().any(|value| (value - anchor[2]).abs() < 0.1), "{one:?}");
        assert!(one.chi_squared.abs() < 1.0 && one.with.is_empty(), "{one:?}");
    }
    let text = text(&fit, &found);
    assert!(text.contains("ambiguous in 3 parameters, in each by itself"), "{text}");
    assert!(text.contains("  `anchor_c.z` = "), "{text}");
    assert_eq!(json(&fit, &found)["other_minima"][1]["parameter"], "anchor_b.z");
}

#[test]
fn a_height_of_which_a_start_is_stated_is_not_asked_for() {
    let found = others(&anchors(0.0, &in_plan(", z = { start = \"2 m\" }")));
    assert_eq!(found.len(), 2, "{found:?}");
}

#[test]
fn points_at_many_heights_leave_no_other_minimum() {
    let found = others(&anchors(0.4, &in_plan("")));
    assert!(found.is_empty(), "{found:?}");
}

/// A square gives the first, a product with it the second: both change their signs or none does.
#[test]
fn values_that_change_together_are_one_minimum() {
    let model = "name = \"product\"\ntitle = \"Product\"\n[inputs]\nload = { unit = \"1\" }\n[parameters]\n\
        a = { unit = \"m\" }\nv = { kind = \"vector\", unit = \"m\" }\n[measurands]\n\
        x = { value = 'load * a * a / (1 m)', unit = \"m\", sigma = \"1 mm\" }\n\
        y = { value = 'a * v.x / (1 m) + v.y + load * v.z', unit = \"m\", sigma = \"1 mm\" }\n\
        z = { value = 'v.y - load * load * v.z', unit = \"m\", sigma = \"1 mm\" }\n";
    let campaign = "title = \"Product\"\nmodel = \"model.toml\"\n[[runs]]\nname = \"one\"\ndata = \"data.csv\"\n";
    let mut noise = Stream(5);
    let mut data = "load [1],x [m],y [m],z [m]\n".to_owned();
    for n in 1..60 {
        let load = 0.05 * f64::from(n);
        let [x, y, z] = [load * 0.25, 0.5 * 0.8 + 0.3 + load * 0.2, 0.3 - load * load * 0.2]
            .map(|value| value + 1e-3 * noise.normal());
        data += &format!("{load},{x:.6},{y:.6},{z:.6}\n");
    }
    let files = [("model.toml", model), ("campaign.toml", campaign), ("data.csv", &*data)];
    let folder = Folder::new("product", &files);
    let mut problem = open(&Request::new([&*folder])).unwrap().problem;
    let at = |problem: &homepoint::engine::Problem, name: &str| {
        problem.layout.instances.iter().position(|one| one.name == name).unwrap()
    };
    // From zero, where the square is flat, no fit goes anywhere.
    let a = at(&problem, "a");
    problem.layout.instances[a].setting.start = Some(vec![1.0]);
    let mut fit = calibrate(problem, &Default::default()).unwrap();
    fit.problem.layout.instances[a].setting.start = None;
    let found = others(&fit);
    let [one] = &found[..] else { panic!("{found:?}") };
    assert!(one.instance == a && (one.values[0] + 0.5).abs() < 1e-2, "{one:?}");
    let [(v, 0, value)] = one.with[..] else { panic!("{one:?}") };
    assert!(v == at(&fit.problem, "v") && (value + 0.8).abs() < 1e-2, "{one:?}");
    assert!(text(&fit, &found).contains(" with `v.x` = -"), "{}", text(&fit, &found));
}
