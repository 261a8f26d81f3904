//! Turns about single axes in another order, about other axes or the other way than the model has
//! them are named, with the formula to type.

use homepoint::engine::open::{Request, open};
use homepoint::estimate::calibrate::calibrate;
use homepoint::estimate::conventions::{ChangedFormula, Mistaken, mistaken};
use homepoint::library::conventions;
use homepoint::quaternion::Quaternion;

use crate::folder::Folder;
use crate::problems::Stream;

const AXES: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn turn(axis: usize, angle: f64) -> Quaternion<f64> {
    Quaternion::from_axis_angle(AXES[axis], angle)
}

/// A wrist with three angles that stops 40 times; its attitude is read to 1 mrad, `true_turns` is
/// what the angles do, the lines of `quantities` are the model's and end with `flange`.
fn wrist(true_turns: fn([f64; 3]) -> Quaternion<f64>, quantities: &str) -> Folder {
    let model = format!(
        "name = \"wrist\"\ntitle = \"Wrist\"\n[inputs]\na = {{ unit = \"rad\" }}\nb = {{ unit = \"rad\" }}\nc = {{ unit = \"rad\" }}\n\
         [parameters]\nbase = {{ kind = \"rotation\" }}\nmount = {{ kind = \"rotation\" }}\n[quantities]\n{quantities}\n\
         [measurands]\nattitude = {{ value = 'base * flange * mount', kind = \"rotation\", unit = \"rad\", sigma = \"1 mrad\" }}\n"
    );
    let campaign = "title = \"Wrist\"\nmodel = \"model.toml\"\n[[runs]]\nname = \"stops\"\ndata = \"data.csv\"\n";
    let (base, mount) = (turn(2, 1.9) * turn(0, 0.3), turn(1, 0.7) * turn(0, -0.2));
    let mut noise = Stream(11);
    let mut data =
        "a [rad],b [rad],c [rad],attitude_w [1],attitude_x [1],attitude_y [1],attitude_z [1]\n"
            .to_owned();
    for n in 0..40 {
        let n = f64::from(n);
        let [a, b, c] = [(0.9 * n).sin(), 0.6 * (1.3 * n + 0.4).sin(), 0.8 * (0.7 * n).cos()];
        let mut error = || 1e-3 * noise.normal();
        let errors = turn(0, error()) * turn(1, error()) * turn(2, error());
        let [w, x, y, z] = (base * true_turns([a, b, c]) * mount * errors).components();
        data += &format!("{a:.8},{b:.8},{c:.8},{w:.8},{x:.8},{y:.8},{z:.8}\n");
    }
    let files = [("model.toml", &*model), ("campaign.toml", campaign), ("data.csv", &*data)];
    Folder::new("wrist", &files)
}

fn found(folder: &Folder) -> Option<Mistaken> {
    let opened = open(&Request::new([&**folder])).unwrap();
    mistaken(&opened.problem, None, &conventions([]).unwrap())
}

fn z_y_x([a, b, c]: [f64; 3]) -> Quaternion<f64> {
    turn(2, a) * turn(1, b) * turn(0, c)
}

fn flange(formula: &str) -> ChangedFormula {
    let (name, formula) = ("flange".to_owned(), formula.to_owned());
    ChangedFormula { table: "quantities", name, formula }
}

#[test]
fn turns_in_the_right_order_have_nothing_mistaken() {
    let folder = wrist(z_y_x, "flange = 'rotation_z(a) * rotation_y(b) * rotation_x(c)'");
    assert!(found(&folder).is_none());
}

#[test]
fn the_order_of_three_turns_is_named() {
    let folder = wrist(z_y_x, "flange = 'rotation_x(c) * rotation_y(b) * rotation_z(a)'");
    let one = found(&folder).unwrap();
    assert_eq!(one.what[0].name, "order_of_turns", "{one:?}");
    assert_eq!(one.what[0].numbers, ["flange"]);
    assert_eq!(one.formulas, [flange("rotation_z(a) * rotation_y(b) * rotation_x(c)")]);
    assert!(one.columns.is_empty() && one.variance_factors[1] < 2.0, "{one:?}");
}

/// Turns may be quantities of their own, with constants, among other factors.
#[test]
fn the_order_of_named_turns_is_named() {
    let quantities = "yaw_turn = 'rotation_z(a + 20 deg)'\npitch = 'b'\npitch_turn = 'rotation_y(pitch)'\n\
        flange = 'turn([0.1, 0, 0]) * yaw_turn * rotation_x(c) * pitch_turn * turn([0, 0.1, 0])'";
    let folder =
        wrist(|[a, b, c]| turn(2, a + 20_f64.to_radians()) * turn(1, b) * turn(0, c), quantities);
    let one = found(&folder).unwrap();
    let due = "turn([0.1, 0, 0]) * yaw_turn * pitch_turn * rotation_x(c) * turn([0, 0.1, 0])";
    assert_eq!(one.formulas, [flange(due)], "{one:?}");
}

fn names(found: &Mistaken) -> Vec<&str> {
    found.what.iter().chain(&found.alike).map(|one| one.name.as_str()).collect()
}

/// Other frames of base and mount exchange axes: then columns that are swapped fit as well.
#[test]
fn the_order_of_two_turns_is_named() {
    let folder =
        wrist(|[a, b, _]| turn(2, a) * turn(1, b), "flange = 'rotation_y(b) * rotation_z(a)'");
    let one = found(&folder).unwrap();
    assert!(names(&one).contains(&"order_of_turns"), "{one:?}");
    assert!(one.variance_factors[1] < 2.0, "{one:?}");
}

#[test]
fn angles_about_other_axes_are_named() {
    let folder = wrist(z_y_x, "flange = 'rotation_x(a) * rotation_y(b) * rotation_z(c)'");
    let one = found(&folder).unwrap();
    assert!(names(&one).contains(&"axes_of_turns"), "{one:?}");
    assert!(one.variance_factors[1] < 2.0, "{one:?}");
}

#[test]
fn the_inverse_of_turns_is_named() {
    let inverse = |[a, b, c]: [f64; 3]| turn(0, -c) * turn(1, -b) * turn(2, -a);
    let folder = wrist(inverse, "flange = 'rotation_z(a) * rotation_y(b) * rotation_x(c)'");
    let one = found(&folder).unwrap();
    assert!(names(&one).contains(&"inverse_turns"), "{one:?}");
    assert!(one.variance_factors[1] < 2.0, "{one:?}");
}

/// The angles that some robots write are the components of a rotation vector.
#[test]
fn a_rotation_vector_is_named() {
    let by_vector = |[a, b, c]: [f64; 3]| {
        let angle = (a * a + b * b + c * c).sqrt();
        Quaternion::from_axis_angle([c / angle, b / angle, a / angle], angle)
    };
    let folder = wrist(by_vector, "flange = 'rotation_z(a) * rotation_y(b) * rotation_x(c)'");
    let one = found(&folder).unwrap();
    assert_eq!(one.what[0].name, "rotation_vector", "{one:?}");
    assert_eq!(one.formulas, [flange("turn([c, b, a])")]);
    assert!(one.variance_factors[1] < 2.0, "{one:?}");
}

/// The program prints the formula; with it the model fits.
#[test]
fn the_formula_that_is_printed_mends_the_model() {
    let folder = wrist(z_y_x, "flange = 'rotation_x(c) * rotation_y(b) * rotation_z(a)'");
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_homepoint"));
    let output = command.arg("calibrate").arg(&*folder).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let lead = "To use it, write in [quantities] of the model, as the formula of `flange`: ";
    let formula = text.lines().find_map(|line| line.strip_prefix(lead));
    let formula = formula.unwrap_or_else(|| panic!("{text}"));
    assert!(!text.contains("columns = {"), "{text}");
    let path = folder.join("model.toml");
    let model = std::fs::read_to_string(&path).unwrap();
    let lines = model.lines().map(|line| match line.starts_with("flange = ") {
        true => format!("flange = {formula}\n"),
        false => format!("{line}\n"),
    });
    std::fs::write(&path, lines.collect::<String>()).unwrap();
    let problem = open(&Request::new([&*folder])).unwrap().problem;
    let fit = calibrate(problem, &Default::default()).unwrap();
    assert!(fit.variance_factor().unwrap() < 1.3, "{:?}", fit.variance_factor());
}
