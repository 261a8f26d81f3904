//! Roles: effects of the library on a telescope and a spindle whose names the library does not know,
//! with readings made by hand.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::fmt::Write as _;
use std::path::Path;

use homepoint::diagnostic::Source;
use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::calibrate;
use homepoint::library::Library;
use homepoint::model::Model;
use homepoint::system::testable;

use crate::folder::Folder;
use crate::problems::Stream;

const ARCSEC: f64 = TAU / 1_296_000.0;

const TELESCOPE: &str = r#"
name = "telescope"
title = "Altitude-azimuth mount"
[inputs]
star_azimuth   = { unit = "deg" }
star_elevation = { unit = "deg" }
[parameters]
azimuth_zero = { unit = "arcsec" }
[quantities]
seen = 'star_azimuth + azimuth_zero'
[measurands]
azimuth   = { value = 'seen', kind = "angle", unit = "deg", period = "360 deg" }
elevation = { value = 'star_elevation', kind = "angle", unit = "deg" }
[roles]
horizontal = "azimuth"
vertical   = "90 deg - elevation"
"#;

/// Stars over the sky, with a collimation, a tilt of the trunnion axis and an index of zeniths.
fn telescope(model: &str, [collimation, tilt, index]: [f64; 3]) -> Folder {
    let mut stream = Stream(7);
    let mut table =
        "azimuth [deg],elevation [deg],star_azimuth [deg],star_elevation [deg]\n".to_owned();
    for _ in 0..60 {
        let star = TAU * stream.uniform();
        let elevation = 0.3 + 1.1 * stream.uniform();
        let zenith = FRAC_PI_2 - elevation;
        let azimuth = star
            + 30.0 * ARCSEC
            + collimation / zenith.sin()
            + tilt * zenith.cos() / zenith.sin()
            + ARCSEC * stream.normal();
        let read = FRAC_PI_2 - (zenith + index) + ARCSEC * stream.normal();
        let cells = [azimuth, read, star, elevation].map(f64::to_degrees);
        let _ = writeln!(table, "{},{},{},{}", cells[0], cells[1], cells[2], cells[3]);
    }
    let campaign = "title = \"Stars\"\nmodel = \"model.toml\"\n[measurands]\n\
        azimuth = { sigma = \"1 arcsec\" }\nelevation = { sigma = \"1 arcsec\" }\n\
        [[runs]]\nname = \"night\"\ndata = \"stars.csv\"\n";
    let files = [("model.toml", model), ("campaign.toml", campaign), ("stars.csv", &table)];
    Folder::new("roles", &files)
}

/// The values of parameters, each with its standard uncertainty.
fn estimated(folder: &Folder, with: &[&str]) -> Vec<(String, f64, f64)> {
    let mut request = Request::new([&**folder]);
    request.with = with.iter().map(|name| (*name).to_owned()).collect();
    let opened = open(&request).unwrap();
    let fit = calibrate(opened.problem, &Options::default()).unwrap();
    assert!(fit.is_sound(), "{with:?}");
    let estimates = fit.estimates();
    let values = estimates.iter().filter_map(|one| Some((one.value?, one.sigma?)));
    estimates
        .iter()
        .zip(values)
        .map(|(one, (value, sigma))| (one.name.clone(), value, sigma))
        .collect()
}

fn found(all: &[(String, f64, f64)], name: &str, due: f64) {
    let (_, value, sigma) = all.iter().find(|(own, ..)| own == name).unwrap();
    assert!((value - due).abs() < 4.0 * sigma, "{name}: {value} ({sigma}), due {due}");
    assert!(due.abs() > 10.0 * sigma, "{name}: the test says nothing at {sigma}");
}

#[test]
fn effects_on_angles_of_zenith_act_on_elevations() {
    let due = [25.0 * ARCSEC, -14.0 * ARCSEC, 11.0 * ARCSEC];
    let folder = telescope(TELESCOPE, due);
    let all = estimated(&folder, &["collimation", "trunnion_tilt", "vertical_index"]);
    found(&all, "collimation.offset", due[0]);
    found(&all, "trunnion_tilt.tilt", due[1]);
    found(&all, "vertical_index.index_error", due[2]);
}

#[test]
fn a_spindle_in_another_sense_has_the_encoder_of_an_arm() {
    let model = r#"
name = "spindle"
title = "Spindle"
[inputs]
turns = { unit = "1" }
[parameters]
zero = { unit = "mrad" }
[measurands]
table = { value = '2 rad * pi * turns + zero', kind = "angle", unit = "rad" }
[roles]
arm_angle = '-2 rad * pi * turns'
"#;
    let (cosine, sine, mut stream) = (40e-6, -70e-6, Stream(3));
    let mut table = "table [rad],turns [1]\n".to_owned();
    for number in 0..80 {
        let turns = f64::from(number) / 40.0;
        // The arm's angle goes the other way round: so does what it is read as.
        let arm = -TAU * turns;
        let read = -(arm + cosine * arm.cos() + sine * arm.sin()) + 1e-3 + 1e-6 * stream.normal();
        let _ = writeln!(table, "{read},{turns}");
    }
    let folder = telescope(model, [0.0; 3]);
    std::fs::write(folder.join("stars.csv"), table).unwrap();
    let campaign = "title = \"Turns\"\nmodel = \"model.toml\"\n[measurands]\n\
        table = { sigma = \"1 urad\" }\n[[runs]]\nname = \"run\"\ndata = \"stars.csv\"\n";
    std::fs::write(folder.join("campaign.toml"), campaign).unwrap();
    let all = estimated(&folder, &["encoder_eccentricity"]);
    found(&all, "encoder_eccentricity.cosine", cosine);
    found(&all, "encoder_eccentricity.sine", sine);
}

#[test]
fn roles_that_cannot_be_are_refused_with_their_place() {
    let (model, _) = TELESCOPE.split_once("[roles]").unwrap();
    let cases = [
        ("vertical = \"pi\"", "a role is a name of the model"),
        ("vertical = \"0 * elevation\"", "does not change with `elevation`"),
        ("vertical = \"elevation / 0\"", "does not change with `elevation`"),
        ("vertical = \"sin(elevation)\"", "cannot be turned round"),
        ("vertical = \"elevation - azimuth\"", "does not change with"),
        ("vertical = \"elevation + elevation\"", "cannot be turned round"),
        ("vertical = \"altitude\"", "`altitude`"),
        ("vertical = \"90 - elevation\"", "`90` has no unit beside an angle"),
        ("azimuth = \"elevation\"", "already taken in [measurands]"),
        (
            "elevation_without_role = \"azimuth\"\nvertical = \"90 deg - elevation\"",
            "is taken, but this role needs it",
        ),
        (
            "vertical_a = \"1 rad - azimuth\"\n[heads]\na = { vertical = \"90 deg - elevation\" }",
            "is taken, but this role needs it",
        ),
    ];
    for (roles, says) in cases {
        let text = format!("{model}[roles]\n{roles}\n");
        let found = homepoint::model::Model::parse(Source::new("model.toml", text)).err();
        let messages = found.map(|faults| faults.messages()).unwrap_or_default();
        assert!(messages.contains(says), "{roles}: {messages}");
    }
}

#[test]
fn the_library_says_which_roles_would_let_more_be_tested() {
    let (model, _) = TELESCOPE.split_once("[roles]").unwrap();
    let folder = telescope(model, [0.0; 3]);
    let opened = open(&Request::new([&*folder])).unwrap();
    let of = |recipe: &homepoint::engine::open::Recipe| {
        testable(&recipe.model, recipe.library.effects(), &recipe.overrides, &shipped())
    };
    let without = of(&opened.recipes[0]);
    let lacks = without.lacking.iter().find(|one| one.names == ["horizontal", "vertical"]).unwrap();
    assert!(lacks.effects.contains(&"collimation".to_owned()));
    let folder = telescope(TELESCOPE, [0.0; 3]);
    let with = of(&open(&Request::new([&*folder])).unwrap().recipes[0]);
    assert!(lacks.effects.iter().all(|name| with.effects.contains(name)), "{:?}", with.effects);
    assert_eq!(with.of, without.of);
}

/// The models of the library.
fn shipped() -> Vec<Model> {
    let library = Library::builtin().unwrap();
    let all = library.models().iter();
    all.map(|(name, _)| library.model(name, Path::new("")).unwrap()).collect()
}

/// Six angles without a role are the joints of an arm before a reading of lengths is two angles.
#[test]
fn the_roles_that_a_model_has_inputs_for_come_first() {
    let inputs: String = (1..=6).map(|k| format!("A{k} = {{ unit = \"rad\" }}\n")).collect();
    let sum = (1..=6).map(|k| format!("A{k}")).collect::<Vec<_>>().join(" + ");
    let text = format!(
        "name = \"arm\"\n[inputs]\n{inputs}[measurands]\nx = {{ value = '1 m * cos({sum})', unit = \"m\" }}\n"
    );
    let model = Model::parse(Source::new("arm.toml", text)).unwrap();
    let library = Library::builtin().unwrap();
    let found = testable(&model, library.effects(), &[], &shipped());
    let place = |names: &[&str]| found.lacking.iter().position(|one| one.names == names);
    let joints = place(&["q1", "q2", "q3", "q4", "q5", "q6"]).unwrap();
    assert_eq!(found.lacking[joints].effects, ["joint_compliance", "joint_offset"]);
    assert!(joints < place(&["horizontal", "vertical"]).unwrap(), "{:?}", found.lacking);
}

/// A scale under a belt has no length and no angle, of which a distance or a turn could be made.
#[test]
fn roles_are_offered_where_a_model_has_their_dimension() {
    let text = "name = \"cell\"\n[inputs]\nload = { unit = \"kg\" }\ntemp = { unit = \"K\" }\nbelt = { unit = \"m/s\" }\n\
        [parameters]\ngain = { unit = \"1\", scope = \"rig\" }\n[quantities]\npull = '[gain * load, 0 kg, 0 kg]'\n\
        [measurands]\nweight = { value = 'pull.x', unit = \"g\" }\n";
    let offered = |text: &str| {
        let model = Model::parse(Source::new("cell.toml", text.to_owned())).unwrap();
        let found = testable(&model, Library::builtin().unwrap().effects(), &[], &shipped());
        found.lacking.into_iter().flat_map(|one| one.names).collect::<Vec<_>>()
    };
    assert_eq!(offered(text), [""; 0]);
    // With an angle, roles of angles and turns; with a length, those of lengths.
    let with_angle =
        offered(&text.replace("[parameters]", "tilt = { unit = \"deg\" }\n[parameters]"));
    let has = |all: &[String], name: &str| all.iter().any(|one| one == name);
    assert!(has(&with_angle, "arm_angle") && !has(&with_angle, "distance"), "{with_angle:?}");
    let with_length =
        offered(&text.replace("[parameters]", "way = { unit = \"mm\" }\n[parameters]"));
    assert!(has(&with_length, "distance") && !has(&with_length, "arm_angle"), "{with_length:?}");
}
