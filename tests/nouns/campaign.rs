//! Campaigns from files: what is read, and what is said of files that cannot be used.

use std::fs;
use std::io::Write as _;

use homepoint::campaign::file::CampaignFile;
use homepoint::campaign::load::{Campaign, LoadOptions};
use homepoint::campaign::{Role, Track, write};
use homepoint::diagnostic::{Diagnostics, Source};
use homepoint::model::Model;

use crate::folder::Folder;

const DEGREE: f64 = std::f64::consts::PI / 180.0;

const MODEL: &str = r#"
name  = "arm"
title = "arm"
[inputs]
arm_angle   = { unit = "deg", signal = true, period = "360 deg" }
temperature = { unit = "degC" }
[parameters]
radius = { unit = "m", scope = "rig" }
[quantities]
half = 'radius / 2'
[measurands]
horizontal = { value = 'arm_angle', kind = "angle", unit = "gon", period = "360 deg" }
distance   = { value = 'radius', unit = "mm", sigma = "10 um" }
attitude   = { value = 'rotation_z(arm_angle)', kind = "rotation", unit = "rad" }
"#;

const CAMPAIGN: &str = r#"model = "arm"
[measurands]
horizontal = { sigma = "1.5 arcsec" }
attitude = { sigma = "1 mrad" }
[[runs]]
name = "slow"
role = "reference"
data = "slow.csv"
"#;

const SLOW: &str = "# made by hand\ntime [s],arm_angle [deg],arm_angle_rate [deg/s],horizontal [gon],distance [mm]\n\
    10,350,10,1,1000\n11,0,10,,1001\n12.5,15,10,3,1002\n";

fn model() -> Model {
    Model::parse(Source::new("arm.toml", MODEL)).unwrap()
}

impl Folder {
    fn load(&self, options: &LoadOptions) -> Result<Campaign, Diagnostics> {
        CampaignFile::read(self)?.load(&model(), options)
    }
}

fn load(name: &str, campaign: &str, slow: &str) -> Result<Campaign, Diagnostics> {
    let folder = Folder::new(name, &[("campaign.toml", campaign), ("slow.csv", slow)]);
    folder.load(&LoadOptions::default())
}

/// The first message, its file's name, line and column, and help.
fn fault(name: &str, campaign: &str, slow: &str) -> (String, String, usize, usize, String) {
    let faults = load(name, campaign, slow).unwrap_err();
    let first = faults.0.first().unwrap().clone();
    let place = first.place.unwrap();
    let file = place.file.rsplit('/').next().unwrap().to_owned();
    (first.message, file, place.line, place.column, first.help.join(" "))
}

fn assert_fault(
    name: &str,
    campaign: &str,
    slow: &str,
    message: &str,
    at: (&str, usize, usize),
    help: &str,
) {
    let found = fault(name, campaign, slow);
    assert!(found.0.contains(message), "{found:?}");
    assert_eq!((found.1.as_str(), found.2, found.3), at, "{found:?}");
    assert!(found.4.contains(help), "{found:?}");
}

#[test]
fn a_campaign_is_read_in_si() {
    let campaign = load("reads", CAMPAIGN, SLOW).unwrap();
    assert_eq!(campaign.setups, ["A"]);
    let run = &campaign.runs[0];
    assert_eq!((run.name.as_str(), run.role, run.setup), ("slow", Role::Reference, 0));
    let samples = run.held();
    assert_eq!(samples.time, [10.0, 11.0, 12.5]);
    assert_eq!(samples.run_time, [0.0, 1.0, 2.5]);
    assert_eq!(samples.setup_time, [0.0, 1.0, 2.5]);
    assert_eq!(samples.rows, [3, 4, 5]);
    for (found, line) in samples.uniform_time.iter().zip([-1.0 / 12.0, 7.0 / 6.0, 29.0 / 12.0]) {
        assert!((found - line).abs() < 1e-12);
    }
    let Track::Captured { value, rate: Some(rate), acceleration: None } = &samples.inputs[0] else {
        panic!("{:?}", samples.inputs[0]);
    };
    // Unwrapped: 350, 360, 375 degrees.
    for (found, degrees) in value.iter().zip([350.0, 360.0, 375.0]) {
        assert!((found - degrees * DEGREE).abs() < 1e-12);
    }
    assert!((rate[1] - 10.0 * DEGREE).abs() < 1e-15);
    assert!(matches!(samples.inputs[1], Track::Absent), "no formula needs the temperature");
    assert!((samples.readings[0][2] - 2.7 * DEGREE).abs() < 1e-15);
    assert!(samples.readings[0][1].is_nan());
    assert!((samples.readings[1][1] - 1.001).abs() < 1e-15);
    assert!(samples.readings[2..].iter().all(|column| column.iter().all(|v| v.is_nan())));
    assert_eq!(samples.readings.len(), 6);
    assert!((campaign.measurand_sigma[0] - 1.5 * DEGREE / 3600.0).abs() < 1e-18);
    assert!((campaign.measurand_sigma[1] - 1e-5).abs() < 1e-18, "from the model");
    assert_eq!(campaign.delay_range.hull(), [-0.5, 0.5]);
    assert!(campaign.warnings.is_empty());
}

#[test]
fn packed_data_columns_constants_and_metadata() {
    let toml = r#"title = "all"
model = "arm"
instrument = "no. 12"
rig = "bench"
effects = ["encoder_eccentricity"]
delay_range = "20 ms"
[metadata]
serial = "x1"
checked = [1, 2.5, true]
[truth]
anything = 1
[parameters]
radius = { value = "1.146 m", sigma = "20 um", scope = "setup" }
"horizontal.delay" = { value = "0 ms", fixed = true }
distance.delay = { start = "1 ms" }
[inputs]
arm_angle = { sigma = "0.2 arcsec" }
[measurands]
horizontal = { sigma = "1.5 arcsec" }
distance = { sigma = "20 um" }
attitude = { sigma = "1 mrad" }
[[runs]]
name = "one"
setup = "B"
data = "one.csv.gz"
columns = { arm_angle = "encoder [gon]", time = "clock [s]" }
inputs = { temperature = "20.1 degC" }
"#;
    let folder = Folder::new("all", &[("campaign.toml", toml)]);
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    packed
        .write_all(b"clock [s], encoder , encoder_rate [gon/s],attitude_w [1],attitude_x [1],attitude_y [1],attitude_z [1],hoizontal [gon]\n0,100,0,1.001,0,0,0,1\n1,100,0,,0,0,0,1\n")
        .unwrap();
    fs::write(folder.join("one.csv.gz"), packed.finish().unwrap()).unwrap();
    let campaign = folder.load(&LoadOptions::default()).unwrap();
    let samples = campaign.runs[0].held();
    let Track::Captured { value, rate: None, .. } = &samples.inputs[0] else { panic!() };
    assert!((value[0] - 90.0 * DEGREE).abs() < 1e-12);
    let Track::Constant(kelvin) = samples.inputs[1] else { panic!() };
    assert!((kelvin - 293.25).abs() < 1e-12);
    assert_eq!(samples.readings[2][0], 1.0, "normalised");
    assert!(samples.readings[2..].iter().all(|column| column[1].is_nan()), "partly missing");
    assert_eq!(campaign.metadata["checked"][1], 2.5);
    assert_eq!(
        (campaign.instrument.as_deref(), campaign.rig.as_deref()),
        (Some("no. 12"), Some("bench"))
    );
    assert_eq!(campaign.delay_range.hull(), [-0.02, 0.02]);
    let names: Vec<_> = campaign.parameters.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["radius", "horizontal.delay", "distance.delay"]);
    assert_eq!(campaign.parameters[1].fixed, Some(true));
    assert_eq!(campaign.parameters[0].place.as_ref().unwrap().line, 13);
    assert!((campaign.input_sigma[0].unwrap() - 0.2 * DEGREE / 3600.0).abs() < 1e-18);
    assert_eq!(campaign.input_sigma[1], None);
    let warnings: Vec<_> = campaign.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(
        warnings[0]
            .contains(":1:103: warning: the columns `encoder_rate`, `hoizontal` are not used")
            && warnings[0].contains("`hoizontal`: did you mean `horizontal`?"),
        "{warnings:?}"
    );
}

#[test]
fn faults_of_the_campaign_file() {
    let with = |from: &str, to: &str| CAMPAIGN.replace(from, to);
    let at = |line, column| ("campaign.toml", line, column);
    assert_fault(
        "f1",
        &with("role =", "rolle ="),
        SLOW,
        "unknown key `rolle`",
        at(7, 1),
        "did you mean `role`?",
    );
    assert_fault(
        "f2",
        &with("\"reference\"", "\"referenz\""),
        SLOW,
        "unknown role",
        at(7, 8),
        "did you mean `reference`?",
    );
    assert_fault(
        "f3",
        &with("1.5 arcsec", "0 arcsec"),
        SLOW,
        "sigma of `horizontal` must be greater than zero",
        at(3, 24),
        "",
    );
    assert_fault(
        "f4",
        &with("1.5 arcsec", "1.5 mm"),
        SLOW,
        "`mm` is not a unit of sigma",
        at(3, 24),
        "such as `gon`",
    );
    assert_fault("f5", &with("1.5 arcsec", "1.5 arcsex"), SLOW, "arcsex", at(3, 29), "");
    assert_fault(
        "f6",
        &with("\"1.5 arcsec\"", "1.5"),
        SLOW,
        "`1.5` has no unit",
        at(3, 24),
        "in quotes",
    );
    assert_fault(
        "f7",
        &with("horizontal =", "horizontl ="),
        SLOW,
        "unknown measurand `horizontl`",
        at(3, 1),
        "did you mean `horizontal`?",
    );
    assert_fault(
        "f8",
        &with("horizontal = { sigma = \"1.5 arcsec\" }", ""),
        SLOW,
        "uncertainty of `horizontal` is not stated",
        at(1, 1),
        "[measurands]",
    );
    assert_fault("f9", "model = \"arm\"\n", SLOW, "has no run", at(1, 1), "[[runs]]");
    assert_fault(
        "f10",
        &format!("{CAMPAIGN}[[runs]]\nname = \"slow\"\ndata = \"slow.csv\"\n"),
        SLOW,
        "two runs are called `slow`",
        at(10, 8),
        "line 6",
    );
    assert_fault(
        "f11",
        &with("data = \"slow.csv\"", ""),
        SLOW,
        "neither data nor a plan",
        at(6, 8),
        "data =",
    );
    assert_fault(
        "f12",
        &with("\"slow.csv\"", "\"fast.csv\""),
        SLOW,
        "does not exist",
        at(8, 8),
        "folder",
    );
    assert_fault("f13", &with("model = \"arm\"", ""), SLOW, "names no model", at(1, 1), "model =");
    assert_fault("f14", &with("[measurands]", "[measurands"), SLOW, "", at(2, 12), "");
    assert_fault(
        "f15",
        &format!("{CAMPAIGN}columns = {{ arm_angel = \"x [deg]\" }}\n"),
        SLOW,
        "`arm_angel`",
        at(9, 13),
        "did you mean `arm_angle`?",
    );
    assert_fault(
        "f16",
        &format!("{CAMPAIGN}columns = {{ arm_angle = \"x [deg]\" }}\n"),
        SLOW,
        "has a column `x`",
        at(9, 13),
        "columns found: time, arm_angle",
    );
    assert_fault(
        "f16b",
        &format!("{CAMPAIGN}columns = {{ arm_angle = \"q [deg]\", distance = \"q\" }}\n"),
        SLOW,
        "`arm_angle` and `distance` name the same column, `q`",
        at(9, 36),
        "keep the entry that it is",
    );
    assert_fault(
        "f17",
        &format!("{CAMPAIGN}inputs = {{ arm_angle = \"3 deg\" }}\n"),
        SLOW,
        "`arm_angle` twice",
        at(6, 8),
        "keep one",
    );
    assert_fault(
        "f18",
        &with(
            "[measurands]",
            "[parameters]\nradius = { value = \"1 m\", sigma = \"0 m\" }\n[measurands]",
        ),
        SLOW,
        "sigma of `radius`",
        at(3, 35),
        "fixed = true",
    );
    assert_fault(
        "f19",
        &with("[measurands]", "[inputs]\ntemperature = { sigma = \"1 degC\" }\n[measurands]"),
        SLOW,
        "is a difference",
        at(3, 25),
        "K",
    );
    let missing = CampaignFile::read(std::path::Path::new("/nowhere/at/all")).unwrap_err();
    assert!(missing.to_string().contains("does not exist"), "{missing}");
}

#[test]
fn faults_of_the_data() {
    let with = |from: &str, to: &str| SLOW.replace(from, to);
    let at = |line, column| ("slow.csv", line, column);
    assert_fault(
        "d1",
        CAMPAIGN,
        &with("horizontal [gon]", "horizontal [gom]"),
        "gom",
        at(2, 61),
        "",
    );
    assert_fault(
        "d2",
        CAMPAIGN,
        &with("horizontal [gon]", "horizontal [mm]"),
        "`mm` is not a unit of `horizontal`",
        at(2, 61),
        "gon",
    );
    assert_fault(
        "d3",
        CAMPAIGN,
        &with("horizontal [gon]", "horizontal"),
        "has no unit",
        at(2, 49),
        "horizontal [gon]",
    );
    assert_fault(
        "d4",
        CAMPAIGN,
        &with("distance [mm]", "horizontal [gon]"),
        "`horizontal` is here twice",
        at(2, 66),
        "",
    );
    assert_fault(
        "d5",
        CAMPAIGN,
        &with("11,0,10,,1001", "11,0,10,,1001,4"),
        "expected 5 cells as in the header, found 6",
        at(4, 1),
        "--skip-bad-rows",
    );
    assert_fault(
        "d6",
        CAMPAIGN,
        &with("1001", "inf"),
        "`inf` in column `distance` is not finite",
        at(4, 10),
        "empty",
    );
    assert_fault(
        "d7",
        CAMPAIGN,
        &with("1001", "NaN"),
        "`NaN` in column `distance` is not a number",
        at(4, 10),
        "empty",
    );
    assert_fault("d8", CAMPAIGN, &with("1001", "1,5e"), "expected 5 cells", at(4, 1), "");
    assert_fault("d9", CAMPAIGN, &with("1001", "12 mm"), "found `12 mm`", at(4, 10), "");
    assert_fault("d10", CAMPAIGN, &with("1001", "1e999"), "is not finite", at(4, 10), "");
    assert_fault(
        "d11",
        CAMPAIGN,
        &with("11,0", "1e9,0"),
        "the time 1000000000 s is far from all others",
        at(4, 1),
        "--skip-bad-rows",
    );
    assert_fault("d12", CAMPAIGN, &with("11,", ","), "the row has no time", at(4, 1), "");
    assert_fault("d13", CAMPAIGN, "1,2,3\n4,5,6\n", "no header row", at(1, 1), "time [s]");
    assert_fault("d14", CAMPAIGN, "# nothing\n", "no header row", at(1, 1), "");
    assert_fault(
        "d15",
        CAMPAIGN,
        "time [s],arm_angle [deg],horizontal [gon]\n",
        "no rows",
        at(1, 1),
        "",
    );
    assert_fault(
        "d16",
        CAMPAIGN,
        "time [s];arm_angle [deg];horizontal [gon]\n1;2;3|4\n",
        "expected a number in column `horizontal`, found `3|4`",
        at(2, 5),
        "",
    );
    assert_fault(
        "d17",
        CAMPAIGN,
        "time [s],angle [deg],horizontal [gon]\n1,2,3\n",
        "no column `arm_angle`",
        ("campaign.toml", 6, 8),
        "columns found: time, angle, horizontal",
    );
    assert_fault(
        "d18",
        CAMPAIGN,
        "time [s],arm_angle [deg]\n1,2\n",
        "holds no reading",
        ("campaign.toml", 8, 8),
        "horizontal, distance, attitude_w",
    );
    assert_fault(
        "d19",
        CAMPAIGN,
        "arm_angle [deg],arm_angle_rate [deg/s],distance [m]\n1,2,3\n",
        "no column `time [s]`",
        ("campaign.toml", 8, 8),
        "",
    );
    assert_fault(
        "d20",
        CAMPAIGN,
        "arm_angle [deg],attitude_w [1],attitude_x [1],attitude_y [1],attitude_z [1]\n1,1,0,0,0\n1, 1.2,0,0,0\n",
        "norm 1.2000",
        at(3, 4),
        "",
    );
    assert_fault(
        "d21",
        CAMPAIGN,
        "arm_angle [deg],attitude_w [1],attitude_x [1]\n1,1,0\n",
        "2 of the four columns of `attitude`",
        ("campaign.toml", 8, 8),
        "attitude_z",
    );
    let wide = format!("{SLOW}\u{fffd}");
    let folder = Folder::new("utf", &[("campaign.toml", CAMPAIGN), ("slow.csv", &wide)]);
    fs::write(folder.join("slow.csv"), [SLOW.as_bytes(), b"13,1,\xff,1,1\n"].concat()).unwrap();
    let faults = folder.load(&LoadOptions::default()).unwrap_err();
    assert!(
        faults.to_string().contains("slow.csv:6:6: error: the file is not UTF-8 here"),
        "{faults}"
    );
    let many = format!("{SLOW}{}", "13,x,x,x,x\n".repeat(1000));
    let faults = load("many", CAMPAIGN, &many).unwrap_err();
    assert_eq!(faults.0.len(), 4, "{faults}");
    let first = &faults.0[0].message;
    assert!(first.ends_with("found `x` (1000 rows like this, to line 1005)"), "{first}");
}

#[test]
fn bad_rows_can_be_skipped() {
    let slow = format!("{SLOW}13,16,10,x,1\n14,17,10\n1,1,1,1,1\n15,30,10,4,1003\n");
    let folder = Folder::new("skip", &[("campaign.toml", CAMPAIGN), ("slow.csv", &slow)]);
    let options = LoadOptions { skip_bad_rows: true, ..LoadOptions::default() };
    let campaign = folder.load(&options).unwrap();
    assert_eq!(campaign.runs[0].held().rows, [3, 4, 5, 9]);
    let skipped: Vec<_> = campaign.skipped.iter().map(|row| row.row).collect();
    assert_eq!(skipped, [6, 7, 8]);
    assert!(campaign.skipped[0].reason.contains("expected a number"));
    assert_eq!(campaign.skipped_count, 3);
}

#[test]
fn samples_without_an_input_are_left_out_and_counted() {
    let campaign = load("lacks", CAMPAIGN, &SLOW.replace("12.5,15,10", "12.5,,10")).unwrap();
    let samples = campaign.runs[0].held();
    assert!(samples.readings.iter().all(|column| column[2].is_nan()));
    assert_eq!(samples.len(), 3, "the sample keeps its number");
    assert!(samples.inputs[0].at(2, 12.5, 0.0_f64, 0).is_finite());
    assert_eq!((campaign.left_out[0].samples, campaign.left_out[0].run.as_str()), (1, "slow"));
}

#[test]
fn rows_that_repeat_the_one_before_are_left_out() {
    // The same time with another reading is no repetition; a row without reading is one.
    let more = "12.5,15,10,3,1002\n12.5,15,10,3,1003\n13,20,10,,\n13,20,10,,\n";
    let campaign = load("repeat", CAMPAIGN, &(SLOW.to_owned() + more)).unwrap();
    let warning = &campaign.warnings[0];
    let words = "`slow.csv`: 2 rows that repeat another one, stamp and values, were left out";
    assert_eq!(warning.message, words);
    assert!(load("no-repeat", CAMPAIGN, SLOW).unwrap().warnings.is_empty());
    // Across the blocks in which a long file is read.
    let mut long = SLOW.to_owned();
    for i in 0..20_000 {
        long += &format!("{},15,10,3,1002\n", 13 + i);
    }
    let twice: String = long
        .lines()
        .map(|line| format!("{line}\n{}\n", if line.starts_with('1') { line } else { "# again" }))
        .collect();
    let campaign = load("repeat-long", CAMPAIGN, &twice).unwrap();
    let told = campaign.warnings[0].message.clone();
    let due = long.lines().filter(|line| line.starts_with('1')).count();
    assert!(told.contains(&format!("{due} rows that repeat another one")), "{told}");
    let once = load("once", CAMPAIGN, &long).unwrap();
    assert_eq!(campaign.runs[0].held().time, once.runs[0].held().time);
}

/// Runs of a setup come one after the other: where their times say otherwise somebody should look.
#[test]
fn runs_that_overlap_are_told() {
    let told = |data: &str, text: &str| {
        let second = format!("{CAMPAIGN}[[runs]]\nname = \"again\"\ndata = \"{data}\"\n");
        let files = [("campaign.toml", second.as_str()), ("slow.csv", SLOW), ("other.csv", text)];
        let folder = Folder::new(&format!("overlap-{data}-{}", text.len()), &files);
        let file = CampaignFile::read(&folder).unwrap();
        let read = file.load(&model(), &LoadOptions::default()).unwrap();
        read.warnings.iter().map(|one| one.message.clone()).collect::<Vec<_>>().join("\n")
    };
    assert!(told("slow.csv", SLOW).contains("read the same file"));
    assert!(told("other.csv", SLOW).contains("runs `slow` and `again` of setup"));
    let before = SLOW.replace("10,350", "7,350").replace("11,0", "8,0").replace("12.5,15", "9,15");
    assert!(!told("other.csv", &before).contains("overlap"));
}

#[test]
fn streams_are_smoothed_unwrapped_and_kept_off_their_ends() {
    let toml = CAMPAIGN
        .replace("data =", "signals = [\"joints.csv\"]\ndata =")
        .replace("[measurands]", "[inputs]\narm_angle = { smooth = \"50 ms\" }\n[measurands]");
    let start = 1.7e9;
    let mut joints = "time [s],arm_angle [deg],note\n".to_owned();
    for i in 0..1000 {
        let t = f64::from(i) * 0.01;
        let angle = 300.0 + 40.0 * t + 10.0 * t.sin();
        joints += &format!("{:.3},{:.6},hello\n", start + t, angle % 360.0);
    }
    let mut slow = "time [s],distance [m]\n".to_owned();
    for i in 0..100 {
        slow += &format!("{:.3},1\n", start + f64::from(i) * 0.1);
    }
    let files = [("campaign.toml", toml.as_str()), ("slow.csv", &slow), ("joints.csv", &joints)];
    let folder = Folder::new("stream", &files);
    let campaign = folder.load(&LoadOptions::default()).unwrap();
    let samples = campaign.runs[0].held();
    for t in [2.0_f64, 5.0, 8.0] {
        let moment = start - campaign.zero as f64 + t;
        let at = |order| samples.inputs[0].at(0, moment, 0.0_f64, order) / DEGREE;
        assert!((at(0) - (300.0 + 40.0 * t + 10.0 * t.sin())).abs() < 1e-3);
        assert!((at(1) - (40.0 + 10.0 * t.cos())).abs() < 1e-2);
        assert!((at(2) + 10.0 * t.sin()).abs() < 0.1);
    }
    let used = samples.readings[1].iter().filter(|value| !value.is_nan()).count();
    assert_eq!((samples.len(), used), (100, 90), "0.5 s at each end");
    assert_eq!(campaign.left_out[0].samples, 10);
    assert!(campaign.warnings[0].message.contains("`note`"));
    let wide = LoadOptions { delay_range: Some(3.0), ..LoadOptions::default() };
    let fault = folder.load(&wide).unwrap_err().0[0].clone();
    assert!(fault.message.contains("60 of 100 samples of run `slow` lie outside"), "{fault}");
    assert_eq!(fault.place.unwrap().line, 10);
}

#[test]
fn gaps_of_a_stream_and_turns_without_a_period_are_told() {
    let toml = CAMPAIGN
        .replace("data =", "signals = [\"joints.csv\"]\ndata =")
        .replace("[measurands]", "[inputs]\narm_angle = { smooth = \"50 ms\" }\n[measurands]");
    // 200 degrees in each gap: only the way before it tells how many turns.
    let mut joints = "time [s],arm_angle [deg]\n".to_owned();
    for i in (0..1000).filter(|i| !(300..600).contains(i)) {
        let t = f64::from(i) * 0.01;
        joints += &format!("{t:.3},{:.6}\n", (300.0 + 70.0 * t).rem_euclid(360.0));
    }
    let mut slow = "time [s],distance [m]\n".to_owned();
    for i in 0..100 {
        slow += &format!("{:.3},1\n", f64::from(i) * 0.1);
    }
    let files = [("campaign.toml", toml.as_str()), ("slow.csv", &slow), ("joints.csv", &joints)];
    let folder = Folder::new("gap", &files);
    let campaign = folder.load(&LoadOptions::default()).unwrap();
    let samples = campaign.runs[0].held();
    let angle = samples.inputs[0].at(0, 8.0, 0.0_f64, 0) / DEGREE;
    assert!((angle - 860.0).abs() < 1e-3, "{angle}");
    let used: Vec<f64> = samples
        .time
        .iter()
        .zip(&samples.readings[1])
        .filter(|(_, read)| !read.is_nan())
        .map(|(t, _)| *t)
        .collect();
    assert!(
        used.iter().all(|t| (0.5..=2.491).contains(t) || (6.5..=9.491).contains(t)),
        "{used:?}"
    );
    assert_eq!((used.len(), campaign.left_out[0].samples), (50, 50));
    assert!(campaign.left_out[0].why.contains("a gap"), "{}", campaign.left_out[0].why);
    assert!(campaign.warnings.is_empty());

    let without = MODEL.replace(", period = \"360 deg\" }\ntemp", " }\ntemp");
    assert_ne!(without, MODEL);
    let model = Model::parse(Source::new("arm.toml", without)).unwrap();
    let read = CampaignFile::read(&folder).unwrap().load(&model, &LoadOptions::default());
    let warning = read.unwrap().warnings.remove(0);
    assert!(
        warning.message.contains(
            "run `slow`: the stream of `arm_angle` jumps by more than half a turn at 0.850 s"
        ),
        "{warning}"
    );
    assert!(warning.help.join("").contains("period = \"360 deg\""), "{warning}");
}

#[test]
fn plans_have_exact_motions() {
    let toml = CAMPAIGN.replace(
        "data = \"slow.csv\"",
        r#"plan = [
  { trigger = "10 Hz", duration = "2 s", arm_angle = { start = "5 deg", rate = "2 deg/s", acceleration = "1 deg/s^2" } },
  { trigger = "5 Hz", duration = "1 s" },
]
inputs = { temperature = "300 K" }
[[runs]]
name = "next"
plan = { trigger = "40 Hz", duration = "43.6 s", arm_angle = [{ start = "0 deg", rate = "-190 deg/s", duration = "3.6 s" }, { rate = "0 deg/s" }] }"#,
    );
    let campaign = load("plan", &toml, "").unwrap();
    let samples = campaign.runs[0].held();
    assert_eq!(samples.len(), 25);
    assert!(
        samples
            .readings
            .iter()
            .all(|column| column.iter().all(|v| v.is_nan()) && column.len() == 25)
    );
    let at = |index: usize, order| samples.inputs[0].at(index, 0.0, 0.0_f64, order) / DEGREE;
    assert!(
        (at(10, 0) - 7.5).abs() < 1e-9
            && (at(10, 1) - 3.0).abs() < 1e-9
            && (at(10, 2) - 1.0).abs() < 1e-9
    );
    // The second leg goes on at 11 deg and 4 deg/s.
    assert!((samples.time[21] - 2.2).abs() < 1e-12);
    assert!(
        (at(21, 0) - 11.8).abs() < 1e-9 && (at(21, 1) - 4.0).abs() < 1e-9 && at(21, 2).abs() < 1e-9
    );
    let next = campaign.runs[1].held();
    assert_eq!(next.len(), 1744);
    assert!(next.time[0] > samples.time[24] && next.setup_time[0] > 2.9);
    let turned = next.inputs[0].at(1743, 0.0, 0.0_f64, 0) / DEGREE;
    assert!((turned + 190.0 * 3.6).abs() < 1e-9, "{turned}");
    let at = |line, column| ("campaign.toml", line, column);
    let plan = |plan: &str| CAMPAIGN.replace("data = \"slow.csv\"", plan);
    assert_fault(
        "p1",
        &plan("plan = { trigger = \"40 Hz\" }"),
        "",
        "no `duration`",
        at(8, 8),
        "plan =",
    );
    assert_fault(
        "p2",
        &plan("plan = { trigger = \"40 s\", duration = \"1 s\" }"),
        "",
        "`s` is not a unit of trigger",
        at(8, 20),
        "",
    );
    assert_fault(
        "p3",
        &plan("plan = { trigger = \"4 Hz\", duration = \"1 s\", arm = \"1 deg\" }"),
        "",
        "unknown input `arm`",
        at(8, 46),
        "",
    );
    assert_fault(
        "p4",
        &plan(
            "plan = { trigger = \"4 Hz\", duration = \"1 s\", arm_angle = { start = \"1 deg\", rate = \"1 m/s\" } }",
        ),
        "",
        "`m/s` is not a unit of the rate",
        at(8, 84),
        "deg/s",
    );
    assert_fault(
        "p5",
        &plan("plan = { trigger = \"4 Hz\", duration = \"1 s\" }"),
        "",
        "does not say `arm_angle`",
        at(6, 8),
        "inputs",
    );
    assert_fault(
        "p6",
        &plan("plan = { trigger = \"1e9 Hz\", duration = \"9 h\" }"),
        "",
        "more than",
        at(8, 8),
        "",
    );
}

#[test]
fn what_is_written_reads_the_same() {
    let toml = CAMPAIGN.replace("[measurands]", "[parameters]\n\"radius\" = { value = \"1.146 m\", sigma = \"20 um\", scope = \"run\" }\nposition = { start = [\"1 m\", \"0 m\", \"2 m\"] }\n[inputs]\narm_angle = { smooth = \"0.3 s\" }\n[metadata]\n\"odd key\" = { a = [1, \"b\\n\"] }\n[measurands]")
        + "[[runs]]\nname = \"a/b\"\ndata = \"fast.csv\"\nsignals = [\"joints.csv\"]\ncolumns = { arm_angle = \"q [rad]\", distance = \"d [m]\" }\ninputs = { temperature = \"21 degC\" }\n";
    let joints: String = (0..400)
        .map(|i| format!("{},{}\n", f64::from(i) * 0.01, (f64::from(i) * 0.02).sin()))
        .collect();
    let files = [
        ("campaign.toml", toml.as_str()),
        ("slow.csv", SLOW),
        ("fast.csv", "time [s],d [m]\n1,1.1\n1.5,1.2\n2,1.3\n"),
        ("joints.csv", &format!("time [s],q [rad]\n{joints}")),
    ];
    let folder = Folder::new("write", &files);
    let first = folder.load(&LoadOptions::default()).unwrap();
    let out = folder.join("deep/out");
    write::write_campaign(&out, &first, &model(), &first.runs).unwrap();
    let second = CampaignFile::read(&out).unwrap().load(&model(), &LoadOptions::default()).unwrap();
    assert_eq!(first.metadata, second.metadata);
    let Track::Logged(spline) = &second.runs[1].record.inputs()[0] else { panic!() };
    assert!((spline.time_constant() - 0.3 / std::f64::consts::TAU).abs() < 1e-12, "smooth is kept");
    assert_eq!(first.parameters.len(), second.parameters.len());
    assert_eq!(first.parameters[1].start, second.parameters[1].start);
    assert_eq!(first.parameters[0].scope, second.parameters[0].scope);
    for (a, b) in first.measurand_sigma.iter().zip(&second.measurand_sigma) {
        assert!((a / b - 1.0).abs() < 1e-14);
    }
    for (a, b) in first.runs.iter().zip(&second.runs) {
        assert_eq!(
            (&a.name, a.role, a.held().time.clone()),
            (&b.name, b.role, b.held().time.clone())
        );
        for (a, b) in a.held().readings.iter().flatten().zip(b.held().readings.iter().flatten()) {
            assert!((a.is_nan() && b.is_nan()) || (a - b).abs() <= 1e-15 * a.abs());
        }
        for order in 0..3 {
            for (x, y) in a.held().inputs.iter().zip(&b.held().inputs) {
                let x: f64 = x.at(1, a.held().time[1], 0.01, order);
                let y: f64 = y.at(1, a.held().time[1], 0.01, order);
                assert!((x.is_nan() && y.is_nan()) || (x - y).abs() <= 1e-14 * x.abs(), "{x} {y}");
            }
        }
    }
    let names: Vec<_> = fs::read_dir(&out).unwrap().map(|f| f.unwrap().file_name()).collect();
    assert_eq!(names.len(), 4, "no part of a file is left: {names:?}");
}

#[test]
fn faults_far_down_a_long_file_are_told_at_their_place() {
    let mut slow = String::from(
        "time [s],arm_angle [deg],arm_angle_rate [deg/s],horizontal [gon],distance [mm]\n",
    );
    for row in 0..40_000 {
        let distance = if row == 34_998 { "1o00" } else { "1000" };
        slow += &format!("{row},{},10,1.25,{distance}\n", row * 10);
    }
    assert_fault("far", CAMPAIGN, &slow, "found `1o00`", ("slow.csv", 35_000, 22), "--skip-bad");
    let folder = Folder::new("far_packed", &[("campaign.toml", CAMPAIGN)]);
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    packed.write_all(slow.as_bytes()).unwrap();
    let packed = packed.finish().unwrap();
    fs::write(folder.join("slow.csv"), &packed).unwrap();
    let faults = folder.load(&LoadOptions::default()).unwrap_err();
    let place = faults.0[0].place.clone().unwrap();
    assert_eq!((place.line, place.column, faults.0.len()), (35_000, 22, 1));
    for memory in [0, u64::MAX] {
        let options = LoadOptions { skip_bad_rows: true, memory, ..LoadOptions::default() };
        let campaign = folder.load(&options).unwrap();
        assert_eq!(campaign.skipped.iter().map(|row| row.row).collect::<Vec<_>>(), [35_000]);
        let record = &campaign.runs[0].record;
        assert_eq!((record.len(), record.is_spilled()), (39_999, memory == 0));
        assert_eq!((record.row(34_997), record.row(34_998)), (34_999, 35_001));
    }
    // Half of a packed file is told where it is named.
    fs::write(folder.join("slow.csv"), &packed[..packed.len() / 2]).unwrap();
    let faults = folder.load(&LoadOptions::default()).unwrap_err();
    assert!(faults.0[0].message.contains("cannot be unpacked"), "{faults}");
    assert_eq!(faults.0[0].place.as_ref().unwrap().line, 8);
}

/// One stamp that is far ahead is the row that is bad, not all that come after it.
#[test]
fn a_stamp_far_ahead_costs_one_row() {
    let mut slow =
        String::from("time [s],arm_angle [deg],arm_angle_rate [deg/s],horizontal [gon]\n");
    let stamp = |row: usize| if row == 20_000 { 1e9 } else { row as f64 };
    (0..40_000).for_each(|row| slow += &format!("{},{row},10,1.25\n", stamp(row)));
    let folder = Folder::new("ahead", &[("campaign.toml", CAMPAIGN), ("slow.csv", &slow)]);
    for memory in [0, u64::MAX] {
        let options = LoadOptions { skip_bad_rows: true, memory, ..LoadOptions::default() };
        let campaign = folder.load(&options).unwrap();
        assert_eq!(campaign.skipped.iter().map(|row| row.row).collect::<Vec<_>>(), [20_002]);
        assert!(campaign.skipped[0].reason.contains("is far from all others"));
        assert_eq!(campaign.runs[0].record.len(), 39_999);
    }
}

#[test]
fn of_very_many_bad_rows_all_are_counted_and_some_are_listed() {
    let mut slow =
        String::from("time [s],arm_angle [deg],arm_angle_rate [deg/s],horizontal [gon]\n");
    (0..30_000).for_each(|row| slow += &format!("{row},x,10,1.25\n{row},0,10,1.25\n"));
    let folder = Folder::new("many_bad", &[("campaign.toml", CAMPAIGN), ("slow.csv", &slow)]);
    let options = LoadOptions { skip_bad_rows: true, ..LoadOptions::default() };
    let campaign = folder.load(&options).unwrap();
    assert_eq!((campaign.skipped.len(), campaign.skipped_count), (10_000, 30_000));
    assert_eq!(campaign.runs[0].record.len(), 30_000);
}

#[test]
fn a_column_may_be_an_inputs_rate_and_a_reading_at_once() {
    let text = MODEL.replace(
        "[measurands]",
        "[measurands]\narm_angle_rate = { value = 'rate(arm_angle)', unit = \"deg/s\", sigma = \"1 deg/s\" }",
    );
    let model = Model::parse(Source::new("arm.toml", text)).unwrap();
    let folder = Folder::new("both", &[("campaign.toml", CAMPAIGN), ("slow.csv", SLOW)]);
    let campaign =
        CampaignFile::read(&folder).unwrap().load(&model, &LoadOptions::default()).unwrap();
    let samples = campaign.runs[0].held();
    let Track::Captured { rate: Some(rate), .. } = &samples.inputs[0] else {
        panic!("{:?}", samples.inputs[0]);
    };
    assert_eq!((rate, rate.len()), (&samples.readings[0], 3));
}

#[test]
fn a_run_without_any_reading_is_told_beside_others() {
    let empty = "time [s],arm_angle [deg],horizontal [gon]\n20,10,\n21,20,\n";
    let two = CAMPAIGN.to_owned() + "[[runs]]\nname = \"empty\"\ndata = \"empty.csv\"\n";
    let files = [("campaign.toml", two.as_str()), ("slow.csv", SLOW), ("empty.csv", empty)];
    let campaign = Folder::new("empty", &files).load(&LoadOptions::default()).unwrap();
    let told: Vec<_> = campaign.warnings.iter().map(ToString::to_string).collect();
    let of_it = |one: &&String| one.contains("run `empty` has no reading at all");
    assert_eq!(told.iter().filter(of_it).count(), 1, "{told:?}");
    assert!(told.iter().any(|one| one.contains("campaign.toml:10")), "{told:?}");
}
