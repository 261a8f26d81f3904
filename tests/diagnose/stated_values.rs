//! What a campaign states of values with an uncertainty, against what the readings say.

use std::fs;
use std::path::Path;

use homepoint::diagnose::Diagnosis;
use homepoint::diagnose::budget::answer::Verdict;
use homepoint::engine::open::{Opened, Request, open};
use homepoint::estimate::batch::{Options, Outcome};
use homepoint::estimate::calibrate::{Calibration, calibrate};
use homepoint::estimate::contradicted::contradicted;
use homepoint::report::{diagnosis_text, text};

use crate::drawn;
use crate::stream::Stream;
use crate::written::diagnosed;

/// The example with a line on a setup.
pub(crate) fn with_setup(line: &str) -> (tempfile::TempDir, Opened) {
    let own = tempfile::tempdir().unwrap();
    for file in fs::read_dir(drawn::folder()).unwrap() {
        let file = file.unwrap().path();
        if file.is_file() {
            fs::copy(&file, own.path().join(file.file_name().unwrap())).unwrap();
        }
    }
    let path = own.path().join("campaign.toml");
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, text.replacen("[inputs]", &format!("{line}\n[inputs]"), 1)).unwrap();
    let opened = open(&Request::new([own.path()])).unwrap();
    (own, opened)
}

fn fitted(opened: &Opened) -> Calibration {
    calibrate(opened.problem.clone(), &Options::default()).unwrap()
}

/// The place of setup A with its standard uncertainties.
fn place(found: &Calibration) -> ([f64; 3], [f64; 3]) {
    let own = |axis: &str| {
        let all = found.estimates();
        let one = all
            .into_iter()
            .find(|one| one.name == format!("position.{axis}") && one.of.as_deref() == Some("A"));
        let one = one.unwrap();
        (one.value.unwrap(), one.sigma.unwrap())
    };
    let [x, y, z] = ["x", "y", "z"].map(own);
    ([x.0, y.0, z.0], [x.1, y.1, z.1])
}

pub(crate) fn said(at: [f64; 3], sigma: &str) -> String {
    let at = at.map(|value| format!("\"{value} m\"")).join(", ");
    format!("[setups.A]\nposition = {{ value = [{at}]{sigma} }}\n")
}

pub(crate) const SIGMA: &str = ", sigma = [\"40 um\", \"40 um\", \"40 um\"]";

/// The second way: the fit without the stated value, its difference over both uncertainties, and
/// what the sum of squares loses.
#[test]
fn a_stated_value_is_judged_as_without_it() {
    let opened = open(&Request::new([drawn::folder()])).unwrap();
    let free = fitted(&opened);
    let (at, known) = place(&free);
    for by in [1e-3, 1.4e-4] {
        let (_own, opened) = with_setup(&said([at[0] + by, at[1], at[2]], SIGMA));
        let found = fitted(&opened);
        assert!(found.is_sound());
        let expected = by / f64::hypot(40e-6, known[0]);
        let told = contradicted(&found);
        assert_eq!(!told.is_empty(), by > 5e-4, "{expected}");
        let Some(one) = told.first() else { continue };
        assert_eq!(
            (told.len(), one.estimate.name.as_str(), one.estimate.of.as_deref()),
            (1, "position.x", Some("A"))
        );
        // Beside the other two components, which are right.
        assert!((one.deviations / expected - 1.0).abs() < 0.01, "{one:?} {expected}");
        assert!((one.alone - at[0]).abs() < 2e-6, "{one:?} {at:?}");
        assert!((one.gain / (found.fit.cost - free.fit.cost) - 1.0).abs() < 1e-3, "{one:?}");
    }
}

#[test]
fn a_wrong_stated_value_is_the_place_of_a_gap() {
    let (at, _) = place(&fitted(&open(&Request::new([drawn::folder()])).unwrap()));
    let (_own, opened) = with_setup(&said([at[0], at[1] - 2e-3, at[2]], SIGMA));
    let found = drawn::run(opened.problem.clone(), &opened);
    assert_eq!(found.verdict, Verdict::Unknown, "{}", crate::found::told(&found));
    assert_eq!(found.remainder[0].place.words, "a wrong stated value of `position` of `A`");
    assert_eq!(found.contradicted[0].estimate.name, "position.y");
    let (_own, opened) = with_setup(&said(at, SIGMA));
    let found = drawn::run(opened.problem.clone(), &opened);
    assert_eq!(found.verdict, Verdict::Adequate);
    assert!(found.contradicted.is_empty());
}

/// A delay that is stated wrong is as an effect that delays: both are told.
#[test]
#[ignore = "a known wrong answer: docs/diagnosis-evidence.md"]
fn a_wrong_stated_value_that_an_effect_takes_up_is_told_with_it() {
    let (_own, opened) = with_radius(
        "radius = { value = \"1.15 m\", sigma = \"1 um\" }\n\"horizontal.delay\" = { value = \"0 us\", sigma = \"1 us\" }",
    );
    let nominal = fitted(&opened);
    let found = drawn::run(opened.problem.clone(), &opened);
    assert_eq!(found.verdict, Verdict::Explained);
    let [one] = &found.contradicted[..] else { panic!("{}", crate::found::told(&found)) };
    assert_eq!(&*one.parameter, "horizontal.delay");
    assert_eq!(one.alone, contradicted(&nominal)[0].alone);
    let text = diagnosis_text::text("", &found, &diagnosis_text::Asked::default());
    assert!(text.contains("or by a stated value that is wrong"), "{text}");
    let at = |words: &str| text.find(words).unwrap_or_else(|| panic!("{words}: {text}"));
    assert!(at("`horizontal.delay` is stated as 0.0 ± 1.0 µs") < at("if what is stated is right"));
    let mut places = found.remainder.iter().map(|one| &*one.place.words);
    assert!(places.any(|words| words == "a wrong stated value of `horizontal.delay`"));
}

/// The example with another line in the place of its radius.
fn with_radius(line: &str) -> (tempfile::TempDir, Opened) {
    let (own, _) = with_setup("");
    let path = own.path().join("campaign.toml");
    let text = fs::read_to_string(&path).unwrap();
    let right = "radius = { value = \"1.15 m\", sigma = \"1 um\" }";
    assert!(text.contains(right));
    fs::write(&path, text.replacen(right, line, 1)).unwrap();
    let opened = open(&Request::new([own.path()])).unwrap();
    (own, opened)
}

/// What is no solution has no uncertainties.
#[test]
fn what_did_not_settle_is_shown_without_uncertainties() {
    let (_own, opened) = with_radius("radius = { value = \"1.15 mm\", fixed = true }");
    let result = fitted(&opened);
    assert_eq!(result.fit.outcome, Outcome::IterationLimit);
    let told = text::calibration("", &result);
    assert!(told.contains("where it stopped") && !told.contains("u (k=1)"), "{told}");
    let settled = text::calibration("", &fitted(&with_setup("").1));
    assert!(!settled.contains("where it stopped") && settled.contains("u (k=1)"), "{settled}");
}

/// A length in the wrong unit, or a place with its sign wrong, bends everything: it alone is told,
/// however sure the campaign is of it, and no reading is blamed.
#[test]
fn a_value_that_is_wrong_altogether_is_told_alone() {
    for line in [
        "radius = { value = \"1.15 mm\", sigma = \"1 um\" }",
        "radius = { value = \"1.15 mm\", fixed = true }",
        "radius = { value = \"115 m\", sigma = \"1 um\" }",
    ] {
        let (_own, opened) = with_radius(line);
        let found = drawn::run(opened.problem.clone(), &opened);
        assert_eq!(found.verdict, Verdict::Unknown, "{line}");
        let [one] = &found.contradicted[..] else { panic!("{line}: {:?}", found.contradicted) };
        assert_eq!((&*one.parameter, one.estimate.of.as_deref()), ("radius", None), "{line}");
        assert!((one.alone - 1.15).abs() < 5e-6, "{line}: {}", one.alone);
        assert_eq!(found.remainder[0].place.words, "a wrong stated value of `radius`", "{line}");
        let text = diagnosis_text::text("", &found, &diagnosis_text::Asked::default());
        assert!(text.contains("`radius` is stated as") && !text.contains("left out"), "{text}");
    }
    let (at, _) = place(&fitted(&with_setup("").1));
    let (_own, opened) = with_setup(&said([-at[0], at[1], at[2]], SIGMA));
    let found = drawn::run(opened.problem.clone(), &opened);
    let [one] = &found.contradicted[..] else { panic!("{:?}", found.contradicted) };
    assert_eq!((&*one.estimate.name, one.estimate.of.as_deref()), ("position.x", Some("A")));
    assert!((one.alone - at[0]).abs() < 2e-5, "{} {}", one.alone, at[0]);
}

/// Where a half of a transformation is stated, the other half starts where it fits to that.
#[test]
fn a_stated_half_of_a_transformation_leaves_the_other_its_start() {
    let opened = open(&Request::new([Path::new(&drawn::folder())])).unwrap();
    let free = fitted(&opened);
    let index = |name: &str| {
        let mut all = free.problem.layout.instances.iter();
        all.position(|one| one.name == name && one.of.as_deref() == Some("A")).unwrap()
    };
    for name in ["position", "orientation"] {
        let at = free.fit.point.components(&free.problem.layout, index(name));
        let unit = if name == "position" { "m" } else { "rad" };
        let at: Vec<String> = at.iter().map(|value| format!("\"{value} {unit}\"")).collect();
        for how in ["value", "start"] {
            let line = format!("[setups.A]\n{name} = {{ {how} = [{}] }}\n", at.join(", "));
            let (_own, opened) = with_setup(&line);
            let found = fitted(&opened);
            assert!((found.fit.cost / free.fit.cost - 1.0).abs() < 1e-6, "{line}");
            let (own, _) = place(&found);
            let off = own.iter().zip(place(&free).0).map(|(a, b)| (a - b).abs());
            assert!(off.fold(0.0, f64::max) < 1e-7, "{line}: {own:?}");
        }
    }
}

/// A cone beam scanner: three beads turn before a panel on an axis that rises twice a turn. Distance
/// of the source, radii and heights are one scale, of which the readings say nothing.
fn scanner(sigma: &str) -> Diagnosis {
    let model = "name = \"scanner\"\ntitle = \"Scanner\"\n[inputs]\narm_angle = { unit = \"rad\" }\n\
         [parameters]\nradius = { unit = \"m\", scope = \"run\", start = \"30 mm\" }\nphase = { unit = \"rad\", scope = \"run\" }\n\
         height = { unit = \"m\", scope = \"run\" }\nsource = { unit = \"m\", scope = \"rig\", value = \"410 mm\", sigma = \"SIGMA\" }\n\
         centre_u = { unit = \"1\", scope = \"rig\", start = \"512\" }\ncentre_v = { unit = \"1\", scope = \"rig\", start = \"512\" }\n\
         [quantities]\narm_turn = 'rotation_z(arm_angle)'\nbead = 'rotate(rotation_z(phase), [radius, 0, 0]) + [0, 0, height]'\n\
         target = 'rotate(arm_turn, bead)'\n\
         [measurands]\nu = { value = 'centre_u + 6734.7 * target.y / (source + target.x)', unit = \"1\" }\n\
         v = { value = 'centre_v + 6734.7 * target.z / (source + target.x)', unit = \"1\" }\n";
    let mut campaign = "title = \"Scanner\"\nmodel = \"model.toml\"\n[measurands]\nu = { sigma = \"0.05\" }\nv = { sigma = \"0.05\" }\n".to_owned();
    let mut files = vec![("model.toml".to_owned(), model.replace("SIGMA", sigma))];
    let mut random = Stream(3);
    for (name, radius, phase, height) in
        [("low", 0.030, 0.3, -0.02), ("middle", 0.034, 1.9, 0.003), ("high", 0.027, -2.0, 0.024)]
    {
        campaign += &format!("[[runs]]\nname = \"{name}\"\ndata = \"{name}.csv\"\n");
        let mut log = "arm_angle [deg],u [1],v [1]\n".to_owned();
        for degrees in (0..360).step_by(4) {
            let angle = f64::from(degrees).to_radians();
            let (y, x) = (angle + phase).sin_cos();
            let z = height + 4.5e-6 * (2.0 * angle).cos() - 3e-6 * (2.0 * angle).sin();
            let far = 0.41 + radius * x;
            let u = 500.0 + 6734.7 * radius * y / far + 0.05 * random.normal();
            let v = 520.0 + 6734.7 * z / far + 0.05 * random.normal();
            log += &format!("{degrees},{u:.4},{v:.4}\n");
        }
        files.push((format!("{name}.csv"), log));
    }
    files.push(("campaign.toml".to_owned(), campaign));
    diagnosed(&files)
}

/// With a row in the fit the derivative by the distance has a part that is the product of both, which
/// the radii and heights do not follow. In the place of the row it is no evidence of a wrong value.
#[test]
fn a_stated_value_that_no_reading_decides_is_no_rival_of_a_row() {
    for sigma in ["0.2 mm", "2 mm"] {
        let found = scanner(sigma);
        let told = crate::found::told(&found);
        assert_eq!(found.verdict, Verdict::Explained, "{told}");
        let [row] = &found.rows[..] else { panic!("{told}") };
        assert_eq!(row.name, "axial_runout_second", "{told}");
        assert_eq!(row.unmodelled_alias, None, "{told}");
        assert!(row.posterior > 0.999, "{} {told}", row.posterior);
    }
}

const STATION: &str = r#"
name = "station"
title = "A station beside a rail"
[inputs]
rail = { unit = "m" }
[parameters]
place = { kind = "vector", unit = "m", scope = "rig" }
[quantities]
point = '[rail, 0 m, 0 m] - place'
[measurands]
range = { value = 'norm(point)', unit = "m" }
azimuth = { value = 'atan2(point.y, point.x)', kind = "angle", unit = "rad" }
slope = { value = 'atan2(point.z, hypot(point.x, point.y))', kind = "angle", unit = "rad" }
"#;

/// Readings of the station by a rail, and a campaign that states its height off by a number of metres.
fn station(seed: u64, off: f64, how: &str) -> Diagnosis {
    let mut stream = Stream(seed);
    let mut log = String::from("rail [m],range [m],azimuth [rad],slope [rad]\n");
    for row in 0..600 {
        let rail = 2.0 + 8.0 * f64::from(row) / 599.0;
        let (x, y, z): (f64, f64, f64) = (rail - 0.3, -0.2, 1.0);
        let range = x.hypot(y).hypot(z) + 1e-3 * stream.normal();
        let azimuth = y.atan2(x) + 3e-4 * stream.normal();
        let slope = z.atan2(x.hypot(y)) + 3e-4 * stream.normal();
        log += &format!("{rail},{range},{azimuth},{slope}\n");
    }
    let campaign = format!(
        "title = \"Station\"\nmodel = \"model.toml\"\n[parameters]\nplace = {{ z = {{ value = \"{} m\", {how} }} }}\n\
         [measurands]\nrange = {{ sigma = \"1 mm\" }}\nazimuth = {{ sigma = \"0.3 mrad\" }}\nslope = {{ sigma = \"0.3 mrad\" }}\n\
         [[runs]]\nname = \"one\"\nsetup = \"A\"\ndata = \"log.csv\"\n",
        -1.0 + off
    );
    let files = [("model.toml", STATION), ("log.csv", &log), ("campaign.toml", &campaign)];
    diagnosed(&files.map(|(name, text)| (name.to_owned(), text.to_owned())))
}

/// A component that a campaign fixes has no uncertainty that could speak: the readings do, and it is no
/// change at the first row that is left.
#[test]
fn a_fixed_component_that_is_wrong_is_named_with_what_it_is_off() {
    for (seed, off) in [(1, 0.02), (2, -0.05), (3, 0.1)] {
        let found = station(seed, off, "fixed = true");
        assert_eq!(found.verdict, Verdict::Unknown);
        let first = &found.remainder[0];
        let log = found.log.join("\n");
        assert_eq!(first.place.stated(), Some("place.z"), "{}: {log}", first.place.words);
        let change = first.change.as_ref().map_or(f64::NAN, |one| one.value);
        assert!((change / -off - 1.0).abs() < 0.15, "{change} for {off}: {log}");
    }
}

/// Another value in the only run is that in all readings: what is stated is wrong, and nothing changed.
#[test]
fn a_stated_value_that_the_only_run_contradicts_is_no_change_in_that_run() {
    for (seed, off) in [(1, 0.02), (2, -0.05), (3, 0.1)] {
        let found = station(seed, off, "sigma = \"1 mm\"");
        assert_eq!(found.verdict, Verdict::Unknown, "{}", crate::found::told(&found));
        let [only] = &found.remainder[..] else { panic!("{}", crate::found::told(&found)) };
        assert_eq!(only.place.words, "a wrong stated value of `place`");
        assert_eq!(found.contradicted[0].estimate.name, "place.z");
    }
}

/// Of one stated component four standard deviations are contradicted, three are not.
#[test]
fn a_single_stated_value_is_contradicted_at_one_in_a_thousand() {
    for (off, is_contradicted) in [(-0.044, true), (0.044, true), (0.025, false)] {
        let found = station(1, off, "sigma = \"1 cm\"");
        assert_eq!(found.verdict, Verdict::Adequate, "{off}");
        assert_eq!(!found.contradicted.is_empty(), is_contradicted, "{off}");
    }
}
