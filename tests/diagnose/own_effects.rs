//! Effects of a user's own, in small static campaigns: what closes the gap is named, with values.

use std::fmt::Write as _;
use std::path::Path;

use homepoint::diagnose::budget::answer::Verdict;
use homepoint::diagnose::library::wanted::Wanted;
use homepoint::diagnose::{Diagnosis, diagnose};
use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::Options;

use crate::found::told;
use crate::stream::Stream;

/// A campaign of one run: its model, its effects (name, parameters, patch), the standard
/// uncertainties of measurands, and a log.
pub(crate) struct Campaign<'a> {
    pub(crate) model: &'a str,
    pub(crate) effects: &'a [(&'a str, &'a str, &'a str)],
    pub(crate) measurands: &'a str,
    pub(crate) log: String,
}

impl Campaign<'_> {
    pub(crate) fn diagnosed(&self) -> Diagnosis {
        let own = tempfile::tempdir().unwrap();
        self.write_to(own.path());
        diagnosed(&[own.path()])
    }

    pub(crate) fn write_to(&self, folder: &Path) {
        let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
        std::fs::create_dir_all(folder.join("effects")).unwrap();
        write("model.toml", self.model);
        for (name, parameters, patch) in self.effects {
            let text = format!(
                "name = \"{name}\"\ntitle = \"{name}\"\nacts = \"arm\"\n[parameters]\n{parameters}\n[patch]\n{patch}\n"
            );
            write(&format!("effects/{name}.toml"), &text);
        }
        write(
            "campaign.toml",
            &format!(
                "title = \"Own\"\nmodel = \"model.toml\"\n[measurands]\n{}\n[[runs]]\nname = \"one\"\nsetup = \"A\"\ndata = \"log.csv\"\n",
                self.measurands
            ),
        );
        write("log.csv", &self.log);
    }
}

fn diagnosed(folders: &[&Path]) -> Diagnosis {
    let opened = open(&Request::new(folders)).unwrap();
    diagnose(opened.problem, opened.recipes, &Wanted::default(), &Options::default()).unwrap()
}

fn names(found: &Diagnosis) -> Vec<&str> {
    let mut names: Vec<&str> = found.rows.iter().map(|row| row.name.as_str()).collect();
    names.sort_unstable();
    names
}

const MOUNT: &str = r#"
name = "mount"
title = "What a telescope misses"
[inputs]
az = { unit = "rad" }
el = { unit = "rad" }
[parameters]
index_az = { unit = "rad", scope = "rig" }
index_el = { unit = "rad", scope = "rig" }
[quantities]
off_az = 'index_az'
off_el = 'index_el'
[measurands]
d_az = { value = 'off_az', unit = "rad" }
d_el = { value = 'off_el', unit = "rad" }
"#;
const TERMS: &[(&str, &str, &str)] = &[
    (
        "tilt",
        "north = { unit = \"rad\", typical = \"60 arcsec\", scope = \"rig\" }\nwest = { unit = \"rad\", typical = \"60 arcsec\", scope = \"rig\" }",
        "off_az = 'off_az + (north * sin(az) + west * cos(az)) * tan(el)'\noff_el = 'off_el + north * cos(az) - west * sin(az)'",
    ),
    (
        "sag",
        "size = { unit = \"rad\", typical = \"30 arcsec\", scope = \"rig\" }",
        "off_el = 'off_el + size * cos(el)'",
    ),
    (
        "cone",
        "size = { unit = \"rad\", typical = \"60 arcsec\", scope = \"rig\" }",
        "off_az = 'off_az + size / cos(el)'",
    ),
    (
        "axes",
        "size = { unit = \"rad\", typical = \"30 arcsec\", scope = \"rig\" }",
        "off_az = 'off_az + size * tan(el)'",
    ),
];
const SIGMA: f64 = 1.2e-5;

/// Stars over the sky, with the collimation and the non-perpendicularity of a telescope.
fn stars([cone, axes]: [f64; 2], seed: u64) -> Diagnosis {
    let mut stream = Stream(seed);
    let mut log = String::from("az [rad],el [rad],d_az [rad],d_el [rad]\n");
    for _ in 0..110 {
        let (az, el) = (std::f64::consts::TAU * stream.uniform(), 0.35 + 0.9 * stream.uniform());
        let (north, west) = (3.1e-4, -5.9e-4);
        let d_az = 2e-4
            + (north * az.sin() + west * az.cos()) * el.tan()
            + cone / el.cos()
            + axes * el.tan()
            + SIGMA / el.cos() * stream.normal();
        let d_el = -3e-4 + north * az.cos() - west * az.sin()
            + 1.8e-4 * el.cos()
            + SIGMA * stream.normal();
        let _ = writeln!(log, "{az},{el},{d_az},{d_el}");
    }
    let measurands = "d_az = { sigma = \"12 urad / cos(el)\" }\nd_el = { sigma = \"12 urad\" }";
    Campaign { model: MOUNT, effects: TERMS, measurands, log }.diagnosed()
}

/// Of opposite signs neither explains anything without the other; of the same sign the readings vary
/// by nothing but the effects, and are no covariates.
#[test]
fn two_terms_that_nearly_cancel_are_named_together() {
    for (values, seed) in [([4.8e-4, -4.0e-4], 5), ([4.5e-4, 3.5e-4], 6)] {
        let found = stars(values, seed);
        assert_eq!(names(&found), ["axes", "cone", "sag", "tilt"], "{}", told(&found));
        assert_eq!(found.verdict, Verdict::Explained, "{}", told(&found));
        for (name, value) in [("cone", values[0]), ("axes", values[1])] {
            let row = found.rows.iter().find(|row| row.name == name).unwrap();
            let far = (row.values[0].value.unwrap() - value) / row.values[0].sigma.unwrap();
            assert!(far.abs() < 4.0, "{name}: {far} u, {}", told(&found));
        }
    }
}

const SLIDE: &str = r#"
name = "slide"
title = "A carriage against a glass scale"
[inputs]
sent = { unit = "m" }
side = { unit = "1" }
[parameters]
zero = { unit = "m", scope = "rig" }
[quantities]
place = 'sent'
[measurands]
scale = { value = 'place + zero', unit = "m" }
"#;
const LOST_MOTION: &[(&str, &str, &str)] = &[(
    "lost_motion",
    "size = { unit = \"m\", typical = \"10 um\", scope = \"rig\" }",
    "place = 'place - 0.5 * size * side'",
)];

/// A log of places in any order, each from one side; `lost` says how much motion is lost there.
fn slide(seed: u64, lost: &dyn Fn(f64) -> f64, outliers: &[(usize, f64)]) -> Diagnosis {
    slid(seed, lost, outliers).diagnosed()
}

fn slid(seed: u64, lost: &dyn Fn(f64) -> f64, outliers: &[(usize, f64)]) -> Campaign<'static> {
    let mut stream = Stream(seed);
    let mut log = String::from("sent [m],side [1],scale [m]\n");
    for row in 0..240 {
        let sent = 0.6 * stream.uniform();
        let side = if stream.uniform() < 0.5 { -1.0 } else { 1.0 };
        let far = outliers.iter().find(|one| one.0 == row).map_or(0.0, |one| one.1);
        let scale = sent + 4e-5 - 0.5 * lost(sent) * side + 2e-6 * stream.normal() + far;
        let _ = writeln!(log, "{sent},{side},{scale:.9}");
    }
    let measurands = "scale = { sigma = \"2 um\" }";
    Campaign { model: SLIDE, effects: LOST_MOTION, measurands, log }
}

/// Effects lie beside a campaign: those beside the second are tried as those beside the first.
#[test]
fn an_effect_beside_the_second_campaign_is_named() {
    let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    Campaign { effects: &[], ..slid(10, &|_| 0.0, &[]) }.write_to(folders[0].path());
    slid(11, &|_| 2e-5, &[]).write_to(folders[1].path());
    let found = diagnosed(&folders.each_ref().map(|folder| folder.path()));
    assert_eq!(names(&found), ["lost_motion"], "{}", told(&found));
}

/// Offset and scale of a distance, of opposite signs, of the library: a cyclic error with a long unit
/// length does much of what both do. Where they are not named one smooth error over the distance is
/// about as good. Without trying the two at once where one imitator enters: 28.
#[test]
fn two_terms_that_an_imitator_stands_for_are_named() {
    let mut both = 0;
    for seed in 0..40 {
        let mut random = Stream(seed);
        let mut log = "tape [m],range [m]\n".to_owned();
        for _ in 0..24 {
            let tape = 2.0 + 78.0 * random.uniform();
            for _ in 0..8 {
                let range = tape * (1.0 + 420e-6) - 0.018 + 0.006 * random.normal();
                writeln!(log, "{tape:.4},{range:.4}").unwrap();
            }
        }
        let model = "name = \"lidar\"\ntitle = \"Lidar and tape\"\n[inputs]\ntape = { unit = \"m\" }\n\
                     [roles]\ndistance = \"range\"\n[measurands]\nrange = { value = 'tape', unit = \"m\" }";
        let measurands = "range = { sigma = \"6 mm\" }";
        let found = Campaign { model, effects: &[], measurands, log }.diagnosed();
        both += usize::from(names(&found) == ["distance_offset", "distance_scale"]);
    }
    assert!(both >= 31, "{both} of 40");
}

/// What shows in no reading, such as a time where nothing moves, has no part in prices.
#[test]
fn an_effect_that_shows_in_no_reading_changes_nothing() {
    let mut random = Stream(0);
    let mut log = "tape [m],range [m]\n".to_owned();
    for _ in 0..120 {
        let tape = 2.0 + 78.0 * random.uniform();
        writeln!(log, "{tape:.4},{:.4}", tape * (1.0 + 420e-6) + 0.006 * random.normal()).unwrap();
    }
    let model = "name = \"lidar\"\ntitle = \"Lidar and tape\"\n[inputs]\ntape = { unit = \"m\" }\n\
                 [roles]\ndistance = \"range\"\n[measurands]\nrange = { value = 'tape', unit = \"m\" }";
    let measurands = "range = { sigma = \"6 mm\" }";
    let of = |effects: &[(&str, &str, &str)]| {
        let found = Campaign { model, effects, measurands, log: log.clone() }.diagnosed();
        let row = |row: &homepoint::diagnose::budget::answer::Row| {
            (row.name.clone(), row.ln_bayes.to_bits(), row.posterior.to_bits())
        };
        found.rows.iter().map(row).collect::<Vec<_>>()
    };
    let late = "late = { unit = \"s\", typical = \"1 ms\", scope = \"rig\" }";
    let without = of(&[]);
    assert_eq!(without.iter().map(|row| row.0.as_str()).collect::<Vec<_>>(), ["distance_scale"]);
    assert_eq!(without, of(&[("late_reading", late, "t = 't + late'")]));
}

/// Motion is lost at a worn place: no covariate has it, but what neighbours have in common is neither
/// noise nor outliers.
#[test]
fn an_error_over_two_inputs_together_is_a_remainder() {
    let worn = |sent: f64| 9e-6 + 9e-5 * (-((sent - 0.25) / 0.035).powi(2)).exp();
    let found = slide(7, &worn, &[]);
    assert_eq!(found.verdict, Verdict::PartlyExplained, "{}", told(&found));
    assert!(found.remainder.iter().any(|one| one.place.covariate == "inputs"), "{}", told(&found));
    assert!(found.left_out.readings.len() < 5, "{}", told(&found));
    let even = slide(8, &|_| 2e-5, &[]);
    assert_eq!((even.verdict, names(&even)), (Verdict::Explained, vec!["lost_motion"]));
    assert!(even.remainder.is_empty() && even.left_out.is_empty(), "{}", told(&even));
}

/// Thrust above a floor: an error over the height is found, and what goes with height and speed together
/// is left of it, no noise.
#[test]
fn an_error_over_two_inputs_together_is_told_beside_one_over_one_of_them() {
    let model = "name = \"rotor\"\ntitle = \"Rotor\"\n[inputs]\nspeed = { unit = \"1/s\" }\nheight = { unit = \"m\" }\n\
        [parameters]\nk = { unit = \"N s^2\" }\n[measurands]\nthrust = { value = 'k * speed^2', unit = \"N\" }";
    let mut random = Stream(41);
    let mut log = "speed [1/s],height [m],thrust [N]\n".to_owned();
    for _ in 0..600 {
        let (speed, height) = (50.0 + 100.0 * random.uniform(), 0.05 + 0.6 * random.uniform());
        let near = 1.0 + 0.12 * (-height / 0.15_f64).exp();
        let thrust = 2e-4 * speed.powi(2) * near + 0.01 * random.normal();
        writeln!(log, "{speed:.4},{height:.4},{thrust:.5}").unwrap();
    }
    let measurands = "thrust = { sigma = \"10 mN\" }";
    let found = Campaign { model, effects: &[], measurands, log }.diagnosed();
    assert_eq!(found.verdict, Verdict::Unknown, "{}", told(&found));
    let covariates: Vec<&str> =
        found.remainder.iter().map(|one| one.place.covariate.as_str()).collect();
    assert_eq!(covariates[0], "height", "{}", told(&found));
    let both = "speed and height together";
    let together = found.remainder.iter().find(|one| one.place.covariate == both);
    let together = together.unwrap_or_else(|| panic!("{}", told(&found)));
    let (rms, _) = together.rms.as_ref().unwrap();
    assert!((0.01..0.1).contains(rms) && (0.02..0.5).contains(&together.share), "{together:?}");
}

/// One reading that is far out is left out alone, and no good one with it.
#[test]
fn a_single_outlier_is_left_out() {
    for size in [8e-5, 4e-4] {
        let found = slide(9, &|_| 2e-5, &[(101, size)]);
        assert_eq!(names(&found), ["lost_motion"], "{}", told(&found));
        let rows: Vec<usize> = found.left_out.readings.iter().map(|one| one.row).collect();
        assert_eq!(rows, [103], "{}", told(&found));
        assert!(found.levels.is_empty(), "{}", told(&found));
    }
}

/// A term of a mount that acts on one angle alone (noncentrality 8 to 12), beside a wave of the other one
/// that no file has: what remains there says nothing against it.
#[test]
fn a_remainder_in_another_reading_is_no_objection_to_a_small_cause() {
    let mut random = Stream(31);
    let mut log = "az [rad],el [rad],d_az [rad],d_el [rad]\n".to_owned();
    for _ in 0..120 {
        let [az, el] = [std::f64::consts::TAU * random.uniform(), 0.3 + 1.0 * random.uniform()];
        let noise = [0, 1].map(|_| 1e-4 * random.normal());
        let d_az = 2e-4 - 4.0e-4 * el.sin() + noise[0];
        let d_el = -1e-4 + 8e-4 * (7.0 * el).sin() + noise[1];
        writeln!(log, "{az:.6},{el:.6},{d_az:.8},{d_el:.8}").unwrap();
    }
    let campaign = Campaign {
        model: "name = \"mount\"\ntitle = \"Mount\"\n[inputs]\naz = { unit = \"rad\" }\nel = { unit = \"rad\" }\n\
                [parameters]\naz_zero = { unit = \"rad\" }\nel_zero = { unit = \"rad\" }\n[measurands]\n\
                d_az = { value = 'az_zero', unit = \"rad\" }\nd_el = { value = 'el_zero', unit = \"rad\" }",
        effects: &[(
            "npae",
            "angle = { unit = \"rad\", typical = \"200 urad\", scope = \"instrument\" }",
            "d_az = 'd_az + angle * sin(el)'",
        )],
        measurands: "d_az = { sigma = \"100 urad\" }\nd_el = { sigma = \"100 urad\" }",
        log,
    };
    let found = campaign.diagnosed();
    assert_eq!(names(&found), ["npae"], "{}", told(&found));
    assert_eq!(found.verdict, Verdict::PartlyExplained, "{}", told(&found));
    let noncentrality = found.rows[0].gain.noncentrality();
    assert!((8.0..12.0).contains(&noncentrality), "{noncentrality}");
}

/// An input that effects alone use is no joint of an arm: its own error would change readings through
/// these effects, and take their place.
#[test]
fn errors_of_an_input_that_effects_alone_use_take_no_effects_place() {
    let mut random = Stream(14);
    let mut log = "x [mm],temp [K],beam [mm],sense [1],laser [mm]\n".to_owned();
    for i in 0..108 {
        let (pass, place) = (i / 18, i % 18);
        let (x, sense) = if pass % 2 == 0 { (place, 1.0) } else { (17 - place, -1.0) };
        let (x, temp) = (50.0 * f64::from(x), 293.15 + 4.0 * f64::from(i) / 108.0);
        let beam = 100.0 * f64::from(pass % 3);
        let warm = temp - 293.15;
        let laser = x * (1.0 + 9e-6 * warm + 5e-6) - 2.5e-3 * warm + 0.5e-3 * random.normal();
        writeln!(log, "{x:.1},{temp:.3},{beam:.1},{sense:.0},{laser:.5}").unwrap();
    }
    let found = Campaign {
        model: "name = \"axis\"\ntitle = \"Axis\"\n[inputs]\nx = { unit = \"m\" }\n\
                temp = { unit = \"K\" }\nbeam = { unit = \"m\" }\nsense = { unit = \"1\" }\n\
                [parameters]\nzero = { unit = \"m\", scope = \"rig\" }\n[quantities]\n\
                place = 'x + zero'\n[measurands]\nlaser = { value = 'place', unit = \"m\" }\n",
        effects: &[
            (
                "expansion",
                "alpha = { unit = \"1/K\", typical = \"10 ppm/K\" }",
                "place = 'place + x * alpha * (temp - 293.15 K)'",
            ),
            (
                "creep",
                "of_zero = { unit = \"m/K\", typical = \"1 um/K\" }",
                "place = 'place + of_zero * (temp - 293.15 K)'",
            ),
            ("scale", "k = { unit = \"1\", typical = \"5 ppm\" }", "place = 'place + x * k'"),
        ],
        measurands: "laser = { sigma = \"0.4 um\" }",
        log,
    };
    let found = found.diagnosed();
    assert_eq!(names(&found), ["creep", "expansion", "scale"], "{}", told(&found));
    assert_eq!(found.verdict, Verdict::Explained, "{}", told(&found));
    assert!(found.levels.iter().all(|one| one.factor < 2.0), "{}", told(&found));
}
