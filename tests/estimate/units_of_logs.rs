//! Units that logs have under other heads: any of the kind that is stated, two mistakes of one number,
//! and uncertainties in another unit.

use homepoint::convention::Convention;
use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::calibrate;
use homepoint::estimate::conventions::mistaken;
use homepoint::library::conventions;

use crate::conventions::{found, names};
use crate::folder::Folder;
use crate::problems::Stream;

/// A rotor whose speed is read beside an encoder.
fn rotor(read: impl Fn(f64) -> f64, sigma: &str) -> Folder {
    let model = "name = \"rotor\"\ntitle = \"Rotor\"\n\
        [inputs]\nangle = { unit = \"rad\", signal = true, smooth = \"0.5 s\" }\n\
        [measurands]\nspeed = { value = 'rate(angle)', unit = \"rad/s\" }\n";
    let campaign = format!(
        "title = \"Rotor\"\nmodel = \"model.toml\"\n[measurands]\nspeed = {{ sigma = \"{sigma}\" }}\n\
         [[runs]]\nname = \"run\"\ndata = \"run.csv\"\nsignals = [\"angle.csv\"]\n"
    );
    let mut random = Stream(29);
    let mut angle = "time [s],angle [rad]\n".to_owned();
    let mut own = "time [s],speed [rad/s]\n".to_owned();
    for i in 0..3000 {
        let t = 0.02 * f64::from(i);
        angle.push_str(&format!("{t:.2},{:.7}\n", 1.4 * t + 2.0 * (0.3 * t).sin()));
        if i % 5 == 0 && (100..2900).contains(&i) {
            let speed = 1.4 + 0.6 * (0.3 * (t - 0.17)).cos() + 0.002 * random.normal();
            own.push_str(&format!("{t:.2},{:.6}\n", read(speed)));
        }
    }
    let files = [("model.toml", model), ("campaign.toml", &campaign)];
    let files = files.into_iter().chain([("run.csv", &*own), ("angle.csv", &*angle)]);
    Folder::new("rotor", &files.collect::<Vec<_>>())
}

/// No file has the factor of revolutions per minute.
#[test]
fn a_unit_that_the_table_has_is_named() {
    let one = found(&rotor(|speed| speed * 60.0 / std::f64::consts::TAU, "2 mrad/s")).unwrap();
    assert_eq!(names(&one), ["rpm for rad/s"], "{one:?}");
    assert!(one.variance_factors[1] < 2.0, "{one:?}");
}

/// A factor of 1.944 is not half, which leaves 3 % of it.
#[test]
fn a_factor_beside_which_another_one_fits_better_is_not_named() {
    let halved: Vec<Convention> =
        conventions([]).unwrap().into_iter().filter(|one| one.name == "halved").collect();
    assert_eq!(halved.len(), 1);
    let of = |factor: f64| {
        let folder = rotor(|speed| speed * factor, "2 mrad/s");
        let problem = open(&Request::new([&*folder])).unwrap().problem;
        mistaken(&problem, None, &halved)
    };
    assert_eq!(names(&of(2.0).unwrap()), ["halved"]);
    assert!(of(1.944).is_none(), "{:?}", of(1.944));
}

/// A total station over known targets; `read` makes what the log has (deg) of the horizontal angle and
/// the elevation (rad).
fn station(period: &str, read: impl Fn(f64, f64) -> [f64; 2]) -> Folder {
    let model = format!(
        "name = \"station\"\ntitle = \"Station\"\n\
         [inputs]\ne = {{ unit = \"m\" }}\nn = {{ unit = \"m\" }}\nu = {{ unit = \"m\" }}\n\
         [parameters]\nswing = {{ unit = \"rad\" }}\nposition = {{ kind = \"vector\", unit = \"m\" }}\n\
         [quantities]\npoint = 'rotate(rotation_z(swing), [e, n, u] - position)'\n\
         [measurands]\n\
         horizontal = {{ value = 'atan2(point.y, point.x)', kind = \"angle\", unit = \"deg\"{period} }}\n\
         vertical = {{ value = 'atan2(hypot(point.x, point.y), point.z)', kind = \"angle\", unit = \"deg\" }}\n\
         distance = {{ value = 'norm(point)', unit = \"m\" }}\n"
    );
    let campaign = "title = \"Targets\"\nmodel = \"model.toml\"\n[measurands]\n\
        horizontal = { sigma = \"0.1 mrad\" }\nvertical = { sigma = \"0.1 mrad\" }\ndistance = { sigma = \"1 mm\" }\n\
        [[runs]]\nname = \"hall\"\ndata = \"hall.csv\"\n";
    let mut random = Stream(37);
    let mut table = "e [m],n [m],u [m],horizontal [deg],vertical [deg],distance [m]\n".to_owned();
    for _ in 0..40 {
        let [e, n, u] = [40.0, 40.0, 12.0].map(|size| size * (random.uniform() - 0.5));
        let [x, y, z] = [e - 1.7, n + 3.2, u - 1.1];
        let (sin, cos) = 0.6_f64.sin_cos();
        let [x, y] = [cos * x - sin * y, sin * x + cos * y];
        let mut noise = || 1e-4 * random.normal();
        let [horizontal, elevation] = [y.atan2(x) + noise(), z.atan2(x.hypot(y)) + noise()];
        let distance = (x * x + y * y + z * z).sqrt() + 10.0 * noise();
        let [horizontal, vertical] = read(horizontal, elevation);
        table.push_str(&format!(
            "{e:.4},{n:.4},{u:.4},{horizontal:.5},{vertical:.5},{distance:.4}\n"
        ));
    }
    let files = [("model.toml", &*model), ("campaign.toml", campaign), ("hall.csv", &table)];
    Folder::new("station", &files)
}

/// Both angles in gon, and the vertical one an elevation; with and without the period that one of them
/// has.
#[test]
fn a_unit_of_all_angles_is_named_with_the_sense_of_one() {
    for period in [", period = \"360 deg\"", ""] {
        let gon = |angle: f64| angle.to_degrees() / 0.9;
        let one = found(&station(period, |horizontal, elevation| [horizontal, elevation].map(gon)));
        let one = one.unwrap();
        let of = |name: &str| one.columns.iter().find(|own| own.0 == name).unwrap().1.as_str();
        assert_eq!(of("horizontal"), "horizontal * 0.9", "{one:?}");
        assert_eq!(of("vertical"), "90 deg - vertical * 0.9", "{one:?}");
        assert!(one.variance_factors[1] < 2.0, "{one:?}");
    }
}

/// An angle of 0 to 360 degrees without its period is in no other convention.
#[test]
fn a_period_that_is_missing_is_no_convention() {
    let folder = station("", |horizontal, elevation| {
        [horizontal.to_degrees().rem_euclid(360.0), 90.0 - elevation.to_degrees()]
    });
    let found = found(&folder);
    assert!(found.is_none(), "{found:?}");
}

/// What is plausible is judged with the noise that is found, where the stated one is of another unit.
#[test]
fn uncertainties_in_another_unit_leave_a_delay_determined() {
    let fitted = |sigma: &str| {
        let folder = rotor(|speed| speed, sigma);
        calibrate(open(&Request::new([&*folder])).unwrap().problem, &Options::default()).unwrap()
    };
    let right = fitted("2 mrad/s");
    assert!(right.is_sound());
    let wrong = fitted("2 rad/s");
    assert!(wrong.is_sound(), "{:?}", wrong.unobservable);
    let text = homepoint::report::text::calibration("", &wrong);
    assert!(text.contains("in another unit perhaps"), "{text}");
}

/// A table and a reading of it, whose header states units or not; the campaign states radians.
fn table_in_degrees(heads: &str) -> Folder {
    let model = "name = \"table\"\n[inputs]\ntilt = { unit = \"rad\" }\n[parameters]\nzero = { unit = \"rad\" }\n\
        [measurands]\nread = { value = 'tilt + zero', unit = \"rad\" }\n";
    let campaign = "model = \"model.toml\"\n[measurands]\nread = { sigma = \"1 mrad\" }\n[[runs]]\nname = \"one\"\n\
        data = { file = \"stops.csv\", columns = { tilt = { column = \"tilt\", unit = \"rad\" }, read = { column = \"read\", unit = \"rad\" } } }\n";
    let mut random = Stream(3);
    let rows = (0..60).fold(format!("{heads}\n"), |text, row| {
        let tilt = f64::from(row) - 30.0;
        format!("{text}{tilt:.4},{:.6}\n", tilt.to_radians() + 0.2 + 1e-3 * random.normal())
    });
    Folder::new(
        "table",
        &[("model.toml", model), ("campaign.toml", campaign), ("stops.csv", &rows)],
    )
}

/// Another unit of a column is to be typed as a unit, which fits; beside a header that states one, which no
/// campaign contradicts, as a formula.
#[test]
fn another_unit_is_typed_as_a_unit() {
    let line = |folder: &Folder| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_homepoint"));
        let output = command.arg("calibrate").arg(&**folder).output().unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        let line = text.lines().find(|line| line.starts_with("To use it, write"));
        line.unwrap_or_else(|| panic!("{text}")).split_once("columns = ").unwrap().1.to_owned()
    };
    let folder = table_in_degrees("tilt,read");
    assert_eq!(line(&folder), "{ tilt = { column = \"tilt\", unit = \"deg\" } }");
    let path = folder.join("campaign.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    let right = text.replace("\"tilt\", unit = \"rad\"", "\"tilt\", unit = \"deg\"");
    std::fs::write(&path, right).unwrap();
    let problem = open(&Request::new([&*folder])).unwrap().problem;
    assert!(calibrate(problem, &Options::default()).unwrap().variance_factor().unwrap() < 1.5);
    let folder = table_in_degrees("tilt [rad],read [rad]");
    assert!(line(&folder).contains("tilt = \"tilt_as_read * pi / 180\""));
}
