//! Minima at which an angle has another value: readings that repeat within a turn of it.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use homepoint::engine::open::{Request, open};
use homepoint::estimate::calibrate::{Calibration, calibrate};
use homepoint::estimate::minima::{Other, others};
use homepoint::report::minima::text;

use crate::folder::Folder;
use crate::problems::Stream;

/// 200 readings of a formula over an angle that goes from -1 to 2 rad.
fn fitted(parameters: &str, reading: &str, read: impl Fn(f64) -> f64, sigma: f64) -> Calibration {
    let unit = if reading.contains("\"rad\"") { "rad" } else { "1" };
    let model = format!(
        "name = \"angle\"\ntitle = \"Angle\"\n[inputs]\nq = {{ unit = \"rad\" }}\n[parameters]\n{parameters}\n[measurands]\n\
         r = {{ {reading}, sigma = \"{sigma} {unit}\" }}\n"
    );
    let campaign = "title = \"Angle\"\nmodel = \"model.toml\"\n[[runs]]\nname = \"one\"\ndata = \"data.csv\"\n";
    let mut noise = Stream(11);
    let mut data = format!("q [rad],r [{unit}]\n");
    for n in 0..200 {
        let q = -1.0 + 3.0 * f64::from(n) / 199.0;
        data += &format!("{q:.6},{:.6}\n", read(q) + sigma * noise.normal());
    }
    let files = [("model.toml", &*model), ("campaign.toml", campaign), ("data.csv", &*data)];
    let folder = Folder::new("angle", &files);
    calibrate(open(&Request::new([&*folder])).unwrap().problem, &Default::default()).unwrap()
}

/// An encoder that turns so many times for a turn of the joint.
fn geared(gear: f64) -> Vec<f64> {
    let reading = format!(
        "value = '{gear} * (q + zero)', kind = \"angle\", unit = \"rad\", period = \"360 deg\""
    );
    let fit = fitted(
        "zero = { unit = \"rad\" }",
        &reading,
        |q| (gear * (q + 0.37)).rem_euclid(TAU),
        3e-3,
    );
    let found = others(&fit);
    assert!(found.iter().all(|one| one.chi_squared.abs() < 1.0), "{found:?}");
    found.iter().map(|one| one.values[0] - one.values[1]).collect()
}

#[test]
fn the_zero_of_an_encoder_before_a_gear_is_known_modulo_a_part_of_a_turn() {
    for gear in [3.0, 10.0, 50.0] {
        let found = geared(gear);
        let [below, above] = found[..] else { panic!("{found:?}") };
        let step = TAU / gear;
        assert!((below.abs() - step).abs() < 1e-3 && (below + above).abs() < 1e-3, "{found:?}");
    }
    // Half a turn to either side is one value.
    let found = geared(2.0);
    assert!(found.len() == 1 && (found[0].abs() - PI).abs() < 1e-3, "{found:?}");
}

#[test]
fn a_whole_turn_is_the_same_value() {
    assert!(geared(1.0).is_empty());
    let parameters = "phase = { unit = \"rad\" }\nlevel = { unit = \"1\" }";
    let reading = "value = 'level + cos(q - phase)', unit = \"1\"";
    let fit = fitted(parameters, reading, |q| 0.2 + (q - 0.65).cos(), 0.01);
    assert!(others(&fit).is_empty(), "{:?}", others(&fit));
}

/// Light behind a polariser: a gain of the other sign goes with an axis that is turned by a quarter.
fn polariser(start: &str) -> (Vec<Other>, String) {
    let parameters = format!(
        "axis = {{ unit = \"rad\" }}\ndark = {{ unit = \"1\" }}\ngain = {{ unit = \"1\"{start} }}"
    );
    let reading = "value = 'dark + gain * cos(q - axis)^2', unit = \"1\"";
    let fit = fitted(&parameters, reading, |q| 0.2 + 0.9 * (q - 0.65).cos().powi(2), 0.01);
    let found = others(&fit);
    let text = text(&fit, &found);
    (found, text)
}

#[test]
fn an_axis_and_a_gain_of_either_sign_are_ambiguous_together() {
    let (found, text) = polariser("");
    let [below, above] = &found[..] else { panic!("{found:?}") };
    for one in [below, above] {
        let far = (one.values[0] - one.values[1]).abs();
        assert!((far - FRAC_PI_2).abs() < 1e-3 && one.with.len() == 2, "{one:?}");
    }
    assert!(text.contains("`axis` = ") && text.contains(" with `gain` = "), "{text}");
}

#[test]
fn a_start_of_the_gain_states_its_sign() {
    let (found, text) = polariser(", start = \"0.5\"");
    let [one] = &found[..] else { panic!("{found:?}") };
    let far = (one.values[0] - one.values[1]).abs();
    assert!((far - PI).abs() < 1e-3 && one.with.is_empty(), "{text}");
}

/// Azimuth and elevation of one direction have two pairs of values.
#[test]
fn the_other_angles_of_the_same_direction_are_no_other_minimum() {
    let parameters = "bearing = { unit = \"rad\" }\nslope = { unit = \"rad\" }";
    let reading = "value = 'cos(slope) * cos(q - bearing) + sin(slope) * q', unit = \"1\"";
    let read = |q: f64| 0.2_f64.cos() * (q - 0.65).cos() + 0.2_f64.sin() * q;
    let fit = fitted(parameters, reading, read, 0.01);
    assert!(others(&fit).is_empty(), "{:?}", others(&fit));
}

/// An anchor above or below the plane of its ranges, and an encoder whose zero each run has anew.
#[test]
fn angles_of_many_runs_are_one_parameter_and_hide_no_other() {
    let model = "name = \"ranger\"\ntitle = \"Ranger\"\n[inputs]\nx = { unit = \"m\" }\ny = { unit = \"m\" }\nz = { unit = \"m\" }\nq = { unit = \"rad\" }\n\
                 [parameters]\nheight = { unit = \"m\" }\nzero = { unit = \"rad\", scope = \"run\" }\n\
                 [measurands]\nr = { value = 'sqrt(x^2 + y^2 + (height - z)^2)', unit = \"m\", sigma = \"1 mm\" }\n\
                 s = { value = 'sin(3 * (q + zero))', unit = \"1\", sigma = \"0.01 1\" }\n";
    let mut noise = Stream(5);
    let mut campaign = String::from("title = \"R\"\nmodel = \"model.toml\"\n");
    let mut tables = Vec::new();
    for run in 0..70 {
        campaign += &format!("[[runs]]\nname = \"{run}\"\ndata = \"{run}.csv\"\n");
        let zero = 0.03 * noise.normal();
        let mut data = String::from("x [m],y [m],z [m],q [rad],r [m],s [1]\n");
        for _ in 0..8 {
            let [x, y, q] = [0, 1, 2].map(|_| noise.normal());
            let z = 3e-5 * noise.normal();
            let r = (x * x + y * y + (2.5 - z).powi(2)).sqrt() + 1e-3 * noise.normal();
            let s = (3.0 * (q + zero)).sin() + 0.01 * noise.normal();
            data += &format!("{x},{y},{z},{q},{r:.6},{s:.6}\n");
        }
        tables.push((format!("{run}.csv"), data));
    }
    let mut files = vec![("model.toml", model), ("campaign.toml", &campaign)];
    files.extend(tables.iter().map(|(name, data)| (name.as_str(), data.as_str())));
    let folder = Folder::new("ranger", &files);
    let fit = calibrate(open(&Request::new([&*folder])).unwrap().problem, &Default::default());
    let fit = fit.unwrap();
    let found = others(&fit);
    let mut names: Vec<&str> =
        found.iter().map(|one| fit.problem.layout.instances[one.instance].name.as_str()).collect();
    names.dedup();
    assert_eq!(names.len(), 2, "{found:?}");
    assert!(names.contains(&"height") && names.contains(&"zero"), "{found:?}");
    let text = text(&fit, &found);
    assert!(text.contains("of the 70 values of `zero` one was tried"), "{text}");
}
