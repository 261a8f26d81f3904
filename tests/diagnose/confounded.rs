//! Effects that the readings hardly separate, on stars of a two-axis mount: they are reported as a group
//! with the combination that is well determined, and the uncertainty allows for the other one.

use std::fmt::Write as _;
use std::fs;

use homepoint::diagnose::library::wanted::Wanted;
use homepoint::diagnose::{Diagnosis, diagnose};
use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::Options;
use homepoint::report::diagnosis_text;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use crate::found::told;
use crate::stream::Stream;

const MODEL: &str = r#"
name = "mount"
title = "Two-axis mount"
source = "spherical trigonometry"
[inputs]
star_az = { unit = "rad" }
star_el = { unit = "rad" }
[parameters]
az_zero = { unit = "rad", scope = "instrument" }
el_zero = { unit = "rad", scope = "instrument" }
[measurands]
az = { value = 'star_az + az_zero', kind = "angle", unit = "rad", period = "360 deg" }
el = { value = 'star_el + el_zero', kind = "angle", unit = "rad" }
"#;

const CAMPAIGN: &str = r#"
title = "Stars"
model = "mount.toml"
[output]
units = { angle = "mdeg" }
[measurands]
az = { sigma = "1 arcsec / cos(star_el)" }
el = { sigma = "1 arcsec" }
[[runs]]
name = "night"
data = "stars.csv"
"#;

fn effect(name: &str, formula: &str) -> String {
    format!(
        "name = \"{name}\"\ntitle = \"{name}\"\nacts = \"instrument\"\nabout = \"A pointing term.\"\n\
         [parameters]\nangle = {{ unit = \"arcsec\", typical = \"5 arcsec\", scope = \"instrument\" }}\n\
         [patch]\naz = 'az + angle * {formula}'\n"
    )
}

const ARCSEC: f64 = std::f64::consts::PI / 648_000.0;

/// Stars between 40 and 80 degrees of elevation, where the two forms are nearly one.
fn found(seed: u64, across: f64, tilt: f64) -> Diagnosis {
    let own = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(own.path().join(name), text).unwrap();
    write("mount.toml", MODEL);
    write("campaign.toml", CAMPAIGN);
    fs::create_dir(own.path().join("effects")).unwrap();
    write("effects/line_of_sight.toml", &effect("line_of_sight", "1 / cos(star_el)"));
    write("effects/elevation_axis.toml", &effect("elevation_axis", "tan(star_el)"));
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut stars = String::from("az (rad),el (rad),star_az (rad),star_el (rad)\n");
    for _ in 0..120 {
        let az = random.random_range(-3.0..3.0);
        let el: f64 = random.random_range(40.0_f64..80.0).to_radians();
        let noise: [f64; 2] = [random.sample(StandardNormal), random.sample(StandardNormal)];
        let own = across / el.cos() + tilt * el.tan() + noise[0] / el.cos();
        let (read_az, read_el) = (az + ARCSEC * own, el + ARCSEC * noise[1]);
        writeln!(stars, "{read_az},{read_el},{az},{el}").unwrap();
    }
    write("stars.csv", &stars);
    let opened = open(&Request::new([own.path()])).unwrap();
    let wanted = Wanted::default();
    diagnose(opened.problem, opened.recipes, &wanted, &Options::default()).unwrap()
}

#[test]
fn two_forms_that_are_nearly_one_are_a_group() {
    let found = found(1, 10.0, 6.0);
    let [row] = &found.rows[..] else { unreachable!("{}", told(&found)) };
    let [other] = &row.confounded[..] else { unreachable!("{}", told(&found)) };
    let mut names = [row.name.as_str(), other.name.as_str()];
    names.sort_unstable();
    assert_eq!(names, ["elevation_axis", "line_of_sight"]);
    assert!(!other.is_row && other.correlation < -0.95, "{}", other.correlation);
    // The row holds the other one's part: the combination is right within a few per cent of itself.
    let truth = |name: &str| if name == "line_of_sight" { 10.0 } else { 6.0 };
    let combined = truth(&row.name) + other.factor.unwrap() * truth(&other.name);
    let value = row.values[0].value.unwrap() / ARCSEC;
    assert!((value - combined).abs() < 1.0, "{value} for {combined}");
    // That is what is well determined of the two.
    let sum = row.well_determined.as_ref().unwrap();
    let due: f64 = sum
        .terms
        .iter()
        .map(|(by, one)| by * truth(one.parameter.split('.').next().unwrap()))
        .sum();
    let far = (sum.value / ARCSEC - due) / (sum.sigma / ARCSEC);
    assert!(far.abs() < 4.0 && sum.sigma < 0.5 * row.values[0].sigma.unwrap(), "{far} {sum:?}");
    // Apart, both are right within their uncertainties, which are far larger.
    assert_eq!(other.joint.len(), 2);
    for (size, sigma) in &other.joint {
        let effect = size.parameter.split('.').next().unwrap();
        let error = size.value - ARCSEC * truth(effect);
        assert!(error.abs() < 4.0 * sigma && *sigma > 0.3 * ARCSEC, "{error} {sigma}");
    }
    let text = diagnosis_text::text("", &found, &diagnosis_text::Asked::default());
    assert!(text.contains(&format!("{} ~ {}", row.name, other.name)), "{text}");
    assert!(text.contains(&format!("well determined: {}.angle + ", row.name)), "{text}");
    // All of it in the unit of the campaign's results.
    let lines = text.lines().filter(|line| line.contains(".angle = "));
    let units: Vec<&str> = lines.filter_map(|line| line.split(' ').next_back()).collect();
    assert_eq!(units, ["mdeg"; 4], "{text}");
}

/// The row alone is there: its value is right, and the other one widens its uncertainty.
#[test]
fn the_uncertainty_allows_for_a_near_alias() {
    let found = found(2, 15.0, 0.0);
    let [row] = &found.rows[..] else { unreachable!("{}", told(&found)) };
    let sigma = row.values[0].sigma.unwrap();
    let explained = found.explained.as_ref().unwrap().estimates();
    let alone = explained.iter().find(|one| one.name == row.values[0].name).unwrap();
    assert!(sigma > 1.2 * alone.sigma.unwrap(), "{sigma} {:?}", alone.sigma);
    let truth =
        if row.name == "line_of_sight" { 15.0 } else { 15.0 / row.confounded[0].factor.unwrap() };
    let error = row.values[0].value.unwrap() - ARCSEC * truth;
    assert!(error.abs() < 4.0 * sigma, "{error} {sigma}");
}

/// What an alias outside the fit may be changes the values of all rows, not of the one alone whose
/// form is nearly its own: the base of a rover whose wheels may both be off.
#[test]
fn an_alias_of_one_row_widens_the_values_of_others() {
    let own = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(own.path().join(name), text).unwrap();
    write(
        "model.toml",
        "name = \"rover\"\ntitle = \"Rover\"\n[inputs]\nleft = { unit = \"m\" }\nright = { unit = \"m\" }\n\
         [quantities]\nway_left = 'left'\nway_right = 'right'\ntrack = '0.3 m'\n[measurands]\n\
         heading = { value = '(way_right - way_left) / track', unit = \"rad\" }\n\
         path = { value = '(way_right + way_left) / 2', unit = \"m\" }\n",
    );
    write(
        "campaign.toml",
        "title = \"Rover\"\nmodel = \"model.toml\"\n[measurands]\nheading = { sigma = \"2 mrad\" }\n\
         path = { sigma = \"2 mm\" }\n[[runs]]\nname = \"floor\"\ndata = \"log.csv\"\n",
    );
    fs::create_dir(own.path().join("effects")).unwrap();
    for (name, of) in [("wheel_left", "way_left"), ("wheel_right", "way_right"), ("base", "track")]
    {
        write(
            &format!("effects/{name}.toml"),
            &format!(
                "name = \"{name}\"\ntitle = \"{name}\"\nacts = \"encoder\"\n[parameters]\n\
                 scale = {{ unit = \"1\", typical = \"0.005\", scope = \"rig\" }}\n\
                 [patch]\n{of} = '{of} * (1 + scale)'\n"
            ),
        );
    }
    let mut random = Stream(5);
    let mut log = "left [m],right [m],heading [rad],path [m]\n".to_owned();
    for i in 0..48 {
        let way = 1.0 + 2.0 * random.uniform();
        let turn = if i % 8 == 0 { -0.6 } else { 0.6 } * (0.2 + random.uniform());
        let (left, right) = (way - 0.5 * turn, way + 0.5 * turn);
        let [real_left, real_right] = [left * 1.0004, right * (1.0 - 0.0045)];
        let heading = (real_right - real_left) / (0.3 * 1.02) + 2e-3 * random.normal();
        let path = 0.5 * (real_left + real_right) + 2e-3 * random.normal();
        log.push_str(&format!("{left:.4},{right:.4},{heading:.5},{path:.5}\n"));
    }
    write("log.csv", &log);
    let opened = open(&Request::new([own.path()])).unwrap();
    let found =
        diagnose(opened.problem, opened.recipes, &Wanted::default(), &Options::default()).unwrap();
    let explained = found.explained.as_ref().unwrap().estimates();
    for row in &found.rows {
        let alone = explained.iter().find(|one| one.name == row.values[0].name).unwrap();
        let ratio = row.values[0].sigma.unwrap() / alone.sigma.unwrap();
        assert!(ratio > 1.1, "{} {ratio}: {}", row.name, told(&found));
    }
    assert_eq!(found.rows.len(), 2, "{}", told(&found));
}
