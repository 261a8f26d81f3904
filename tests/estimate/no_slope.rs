//! Parameters that no reading follows where a fit begins, because derivatives cancel there: they come in
//! once others have moved, and do not hold these back.

use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::{Calibration, calibrate};

use crate::folder::Folder;
use crate::problems::Stream;

/// A telescope off the centre of its dome, whose azimuth is read: a height above the centre shows where
/// the telescope is off to a side, too. `parameters` and `off` make the offset (m).
fn dome(parameters: &str, off: &str) -> Calibration {
    let model = format!(
        "name = \"dome\"\ntitle = \"Dome\"\n[inputs]\naz = {{ unit = \"rad\" }}\nalt = {{ unit = \"rad\" }}\n\
        [parameters]\n{parameters}\nzero = {{ unit = \"rad\" }}\n[quantities]\n\
        sight = '[cos(alt) * cos(az), cos(alt) * sin(az), sin(alt)]'\n{off}\n\
        along = 'dot(off, sight)'\nway = 'sqrt(along^2 + (1.85 m)^2 - dot(off, off)) - along'\n\
        slit = 'off + way * sight'\n[measurands]\ndome = {{ value = 'atan2(slit.y, slit.x) + zero', \
        kind = \"angle\", unit = \"rad\", period = \"360 deg\" }}\n"
    );
    let campaign = "title = \"Dome\"\nmodel = \"model.toml\"\n[measurands]\ndome = { sigma = \"0.35 deg\" }\n\
        [[runs]]\nname = \"slews\"\ndata = \"slews.csv\"\n";
    let mut table = "az [deg],alt [deg],dome [deg]\n".to_owned();
    let mut random = Stream(17);
    for _ in 0..120 {
        let [az, alt] = [360.0 * random.uniform(), 18.0 + 60.0 * random.uniform()];
        let (a, h) = (f64::to_radians(az), f64::to_radians(alt));
        let sight = [h.cos() * a.cos(), h.cos() * a.sin(), h.sin()];
        let off = [0.14, -0.09, 0.31];
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let along = dot(off, sight);
        let way = (along * along + 1.85 * 1.85 - dot(off, off)).sqrt() - along;
        let (x, y) = (off[0] + way * sight[0], off[1] + way * sight[1]);
        let read = y.atan2(x).to_degrees() + 3.1 + 0.35 * random.normal();
        table.push_str(&format!("{az:.9},{alt:.9},{:.3}\n", read.rem_euclid(360.0)));
    }
    let files =
        [("model.toml", model.as_str()), ("campaign.toml", campaign), ("slews.csv", &table)];
    let folder = Folder::new("dome", &files);
    let problem = open(&Request::new([&*folder])).unwrap().problem;
    calibrate(problem, &Options::default()).unwrap()
}

#[test]
fn a_height_without_slope_at_the_start_is_determined() {
    let numbers = "north = { unit = \"1\" }\neast = { unit = \"1\" }\n";
    let parts = "off = '[north * (1.85 m), east * (1.85 m), up]'";
    let forms = [
        ("off = { kind = \"vector\", unit = \"m\" }".to_owned(), String::new()),
        (format!("{numbers}up = {{ unit = \"m\" }}"), parts.to_owned()),
        (format!("{numbers}up = {{ unit = \"1\" }}"), parts.replace("up]", "up * (1.85 m)]")),
    ];
    for (parameters, off) in forms {
        let found = dome(&parameters, &off);
        assert!(found.is_sound(), "{parameters}: {:?} {:?}", found.fit.outcome, found.unobservable);
        assert!(found.variance_factor().unwrap() < 1.5, "{parameters}");
        let up = &found.estimates()[2];
        let (value, sigma) = (up.value.unwrap(), up.sigma.unwrap());
        let right = if up.name == "up" && up.unit == "1" { 0.31 / 1.85 } else { 0.31 };
        assert!((value - right).abs() < 4.0 * sigma && sigma < 0.2 * right, "{up:?}");
    }
}

/// An unknown in a unit 1e15 times too small for its readings is no rounding.
#[test]
fn a_column_that_is_short_by_its_unit_is_kept() {
    let model = "name = \"line\"\ntitle = \"Line\"\n[inputs]\nu = { unit = \"1\" }\n\
        [parameters]\nzero = { unit = \"1\" }\nslope = { unit = \"1\" }\n\
        [measurands]\ny = { value = 'zero + 1e-15 * slope * u', unit = \"1\" }\n";
    let campaign = "title = \"Line\"\nmodel = \"model.toml\"\n[measurands]\ny = { sigma = \"0.001\" }\n\
        [[runs]]\nname = \"line\"\ndata = \"line.csv\"\n";
    let mut table = "u [1],y [1]\n".to_owned();
    for i in 0..40 {
        let (u, error) = (f64::from(i), 1e-3 * f64::from(i * 7 % 3 - 1));
        table.push_str(&format!("{u},{:.6}\n", 2.0 + 0.3 * u + error));
    }
    let files = [("model.toml", model), ("campaign.toml", campaign), ("line.csv", &table)];
    let folder = Folder::new("short", &files);
    let problem = open(&Request::new([&*folder])).unwrap().problem;
    let found = calibrate(problem, &Options::default()).unwrap();
    assert!(found.is_sound(), "{:?}", found.unobservable);
    let slope = found.estimates()[1].value.unwrap();
    assert!((slope / 3e14 - 1.0).abs() < 1e-3, "{slope}");
}
