//! Minima at which a rotation is another one: the two poses of a flat target.

use homepoint::engine::open::{Request, open};
use homepoint::estimate::calibrate::{Calibration, calibrate};
use homepoint::estimate::minima::others;
use homepoint::report::minima::text;

use crate::folder::Folder;
use crate::problems::Stream;

/// A flat plate of four lamps in a camera that looks along its first axis: so large and so far away
/// (m), tilted by 0.5 rad. Two angles are read with 0.3 mrad, three times.
fn plate(size: f64, distance: f64, facing: &str) -> Calibration {
    let model = format!(
        "name = \"plate\"\ntitle = \"Plate\"\n[inputs]\nright = {{ unit = \"m\" }}\nup = {{ unit = \"m\" }}\n\
         [parameters]\nfacing = {{ kind = \"rotation\", scope = \"setup\"{facing} }}\n\
         place = {{ kind = \"vector\", unit = \"m\", scope = \"setup\", start = [\"{distance} m\", \"0 m\", \"0 m\"] }}\n\
         [quantities]\nlamp = 'place + rotate(facing, [0, right, up])'\n\
         [measurands]\nleft = {{ value = 'lamp.y / lamp.x', unit = \"rad\", sigma = \"0.3 mrad\" }}\n\
         above = {{ value = 'lamp.z / lamp.x', unit = \"rad\", sigma = \"0.3 mrad\" }}\n"
    );
    let campaign = "title = \"Plate\"\nmodel = \"model.toml\"\n[[runs]]\nname = \"view\"\ndata = \"data.csv\"\n";
    let mut noise = Stream(17);
    let mut data = "right [m],up [m],left [rad],above [rad]\n".to_owned();
    let (sin, cos) = 0.5_f64.sin_cos();
    for _ in 0..3 {
        for (right, up) in [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)] {
            let (right, up) = (0.5 * size * right, 0.5 * size * up);
            // Turned about the vertical: x = distance - right sin, y = right cos.
            let x = distance - right * sin;
            let read = |y: f64, noise: &mut Stream| y / x + 0.3e-3 * noise.normal();
            let (left, above) = (read(right * cos, &mut noise), read(up, &mut noise));
            data += &format!("{right},{up},{left:.7},{above:.7}\n");
        }
    }
    let files = [("model.toml", &*model), ("campaign.toml", campaign), ("data.csv", &*data)];
    let folder = Folder::new("plate", &files);
    calibrate(open(&Request::new([&*folder])).unwrap().problem, &Default::default()).unwrap()
}

#[test]
fn the_two_poses_of_a_small_flat_target_are_named() {
    let fit = plate(0.2, 6.0, "");
    let found = others(&fit);
    let [other] = &found[..] else { panic!("{found:?}") };
    let one = &fit.problem.layout.instances[other.instance];
    assert_eq!((one.name.as_str(), other.component), ("facing", 2));
    // One is the other in a mirror that stands square to the line of sight.
    let [there, here] = other.values;
    assert!((there + here).abs() < 0.15 && (there.abs() - 0.5).abs() < 0.15, "{:?}", other.values);
    assert!(other.chi_squared.abs() < 25.0, "{}", other.chi_squared);
    assert!(text(&fit, &found).contains("The solution is ambiguous: beside `facing.z@A`"));
}

#[test]
fn perspective_decides_where_the_target_is_large() {
    assert!(others(&plate(2.0, 6.0, "")).is_empty());
}

#[test]
fn a_start_near_the_estimate_decides() {
    let estimate = plate(0.2, 6.0, "");
    let at = estimate.estimates().iter().find(|one| one.name == "facing.z").unwrap().value.unwrap();
    let start = format!(", start = [\"0 rad\", \"0 rad\", \"{} rad\"]", at * 1.1);
    assert!(others(&plate(0.2, 6.0, &start)).is_empty());
}

/// A value that is stated, if with an uncertainty of 10 degrees, excludes the other pose itself.
#[test]
fn a_stated_value_decides() {
    let known = ", value = [\"0 rad\", \"0 rad\", \"0.5 rad\"], sigma = [\"10 deg\", \"10 deg\", \"10 deg\"]";
    assert!(others(&plate(0.2, 6.0, known)).is_empty());
}
