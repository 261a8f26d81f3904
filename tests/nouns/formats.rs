//! Formats by name: logs of poses as other programs write them, read without a word in the campaign.

use std::fmt::Write as _;

use homepoint::campaign::file::CampaignFile;
use homepoint::campaign::formats::FORMATS;
use homepoint::campaign::load::Campaign;
use homepoint::campaign::loaded::LoadOptions;
use homepoint::diagnostic::{Diagnostics, Source};
use homepoint::model::Model;

use crate::folder::Folder;

const MODEL: &str = "name = \"poses\"\ntitle = \"poses\"\n[inputs]\n\
    arm_x = { unit = \"m\", signal = true }\narm_y = { unit = \"m\", signal = true }\narm_z = { unit = \"m\", signal = true }\n\
    a = { unit = \"1\", signal = true }\nb = { unit = \"1\", signal = true }\nc = { unit = \"1\", signal = true }\nd = { unit = \"1\", signal = true }\n\
    [quantities]\nturned = 'quaternion(a, b, c, d)'\n[measurands]\n\
    x = { value = 'arm_x', unit = \"mm\", sigma = \"1 mm\" }\ny = { value = 'arm_y', unit = \"mm\", sigma = \"1 mm\" }\n\
    z = { value = 'arm_z', unit = \"mm\", sigma = \"1 mm\" }\n\
    attitude = { value = 'turned', kind = \"rotation\", unit = \"rad\", sigma = \"1 mrad\" }\n";

/// A pose: stamp (s), position (m), quaternion w x y z.
type Pose = (f64, [f64; 3], [f64; 4]);

fn pose(t: f64) -> Pose {
    let (half, tilt) = (0.3 * t.sin(), 0.4 * (1.3 * t).cos());
    let quaternion = [half.cos(), half.sin() * tilt.sin(), 0.0, half.sin() * tilt.cos()];
    (1.4e9 + t, [t.sin(), 0.2 * t, -1.5 + t.cos()], quaternion)
}

fn table(header: &str, every: f64, row: impl Fn(Pose) -> String) -> String {
    (0..(20.0 / every) as usize).fold(header.to_owned(), |mut text, n| {
        writeln!(text, "{}", row(pose(every * n as f64))).unwrap();
        text
    })
}

fn plain(every: f64, names: &str) -> String {
    table(&format!("{names}\n"), every, |(t, [x, y, z], [w, i, j, k])| {
        format!("{t:.3},{x:.6},{y:.6},{z:.6},{w:.6},{i:.6},{j:.6},{k:.6}")
    })
}

/// Poses as TUM has them, stamps in a unit of which there are so many in a second.
fn tum(every: f64, header: &str, by: &str, stamps: impl Fn(f64) -> String) -> String {
    table(header, every, |(t, [x, y, z], [w, i, j, k])| {
        [x, y, z, i, j, k, w].iter().fold(stamps(t), |text, value| format!("{text}{by}{value:.6}"))
    })
}

fn asl(every: f64, header: &str) -> String {
    table(header, every, |(t, [x, y, z], [w, i, j, k])| {
        let ns = (t * 1e3).round() as u64 * 1_000_000;
        format!("{ns}, {x:.6}, {y:.6}, {z:.6}, {w:.6}, {i:.6}, {j:.6}, {k:.6}, 0.0")
    })
}

const ASL: &str = "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z [], v_RS_R_x [m s^-1]\n";

fn load(run: &str, data: &str, stream: &str) -> Result<Campaign, Diagnostics> {
    let campaign = format!("model = \"poses.toml\"\n[[runs]]\nname = \"one\"\n{run}\n");
    let files = [
        ("poses.toml", MODEL),
        ("campaign.toml", &campaign),
        ("data.txt", data),
        ("stream.csv", stream),
    ];
    let folder = Folder::new("formats", &files);
    let model = Model::parse(Source::new("poses.toml", MODEL)).unwrap();
    CampaignFile::read(&folder)?.load(&model, &LoadOptions::default())
}

const RUN: &str = "data = \"data.txt\"\nsignals = [\"stream.csv\"]";

/// Times since the first, inputs at them and readings of the run.
fn numbers(campaign: &Campaign) -> Vec<Vec<f64>> {
    let samples = campaign.runs[0].held();
    let time = &samples.time;
    let input = |track: &homepoint::campaign::Track| {
        (0..time.len()).map(|n| track.at(n, time[n], 0.0_f64, 0)).collect()
    };
    let first = time.iter().map(|t| t - time[0]).collect();
    let inputs = samples.inputs.iter().map(input);
    [first].into_iter().chain(inputs).chain(samples.readings.iter().cloned()).collect()
}

fn assert_same(found: &Campaign, right: &Campaign, what: &str) {
    let (found, right) = (numbers(found), numbers(right));
    for (column, (found, right)) in found.iter().zip(&right).enumerate() {
        assert_eq!(found.len(), right.len(), "{what}");
        for (a, b) in found.iter().zip(right) {
            assert!((a - b).abs() < 2e-6 || (a.is_nan() && b.is_nan()), "{what} {column}: {a} {b}");
        }
    }
}

#[test]
fn poses_in_known_formats_need_no_word_in_the_campaign() {
    let data = plain(
        0.25,
        "time [s],x [m],y [m],z [m],attitude_w [1],attitude_x [1],attitude_y [1],attitude_z [1]",
    );
    let stream = plain(0.05, "time [s],arm_x [m],arm_y [m],arm_z [m],a [1],b [1],c [1],d [1]");
    let right = load(RUN, &data, &stream).unwrap();
    let seconds = |t: f64| format!("{t:.3}");
    let nanoseconds = |t: f64| format!("{}000000.000000", (t * 1e3).round());
    let microseconds = |t: f64| format!("{}000", (t * 1e3).round());
    let names = "# ground truth of a flight\n# timestamp tx ty tz qx qy qz qw\n";
    let ros = |every: f64| {
        let header = "%time,field.header.seq,field.header.stamp,field.header.frame_id,field.pose.pose.position.x,field.pose.pose.position.y,field.pose.pose.position.z,field.pose.pose.orientation.x,field.pose.pose.orientation.y,field.pose.pose.orientation.z,field.pose.pose.orientation.w\n";
        table(header, every, |(t, [x, y, z], [w, i, j, k])| {
            let ns = (t * 1e3).round() as u64 * 1_000_000;
            format!("{},7,{ns},world,{x:.6},{y:.6},{z:.6},{i:.6},{j:.6},{k:.6},{w:.6}", ns + 1000)
        })
    };
    for (what, data, stream) in [
        ("tum", tum(0.25, "", " ", seconds), tum(0.05, "", " ", seconds)),
        ("tum, names", tum(0.25, names, " ", seconds), tum(0.05, "# by me\n", "\t", seconds)),
        ("tum, ns and us", tum(0.25, "", " ", nanoseconds), tum(0.05, "", ",", microseconds)),
        ("asl", asl(0.25, ASL), asl(0.05, ASL)),
        ("asl, ns", asl(0.25, &ASL.replace("timestamp", "timestamp [ns]")), asl(0.05, ASL)),
        ("tum and asl", tum(0.25, "", " ", seconds), asl(0.05, ASL)),
        ("ros", ros(0.25), ros(0.05)),
        ("asl and plain", asl(0.25, ASL), stream.clone()),
    ] {
        let found = load(RUN, &data, &stream).unwrap_or_else(|faults| panic!("{what}: {faults}"));
        assert_same(&found, &right, what);
        let told = found.recognised.join("\n");
        assert!(told.contains("`data.txt`: in the format"), "{what}: {told}");
    }
}

#[test]
fn a_format_may_be_stated_and_a_file_in_another_one_is_refused() {
    let seconds = |t: f64| format!("{t:.3}");
    let stream = asl(0.05, ASL);
    let stated = RUN.replace("\"data.txt\"", "{ file = \"data.txt\", format = \"tum\" }");
    let right = load(RUN, &tum(0.25, "", " ", seconds), &stream).unwrap();
    let found = load(&stated, &tum(0.25, "", " ", seconds), &stream).unwrap();
    assert_same(&found, &right, "stated");
    // Of a format that is stated the order counts, whatever a comment says.
    let prose = tum(0.25, "# eight words that are no names of columns\n", " ", seconds);
    assert_same(&load(&stated, &prose, &stream).unwrap(), &right, "prose");
    let fault = load(&stated, "1 2 3\n4 5 6\n", &stream).unwrap_err().to_string();
    assert!(fault.contains("data.txt:1:1: error: the file is not in the format `tum`"), "{fault}");
    let fault = load(&stated.replace("tum", "tumm"), "1 2 3\n", &stream).unwrap_err().to_string();
    assert!(fault.contains("unknown format `tumm`") && fault.contains("`tum`"), "{fault}");
    // Eight numbers a row that are no poses are nothing.
    let numbers = tum(0.25, "", " ", seconds).replace(" -1.5", " -1.5 ").replace(" 0.9", " 2.9");
    let fault = load(RUN, &numbers, &stream).unwrap_err().to_string();
    assert!(fault.contains("no header row"), "{fault}");
}

#[test]
fn stamps_since_1970_in_another_unit_than_stated_are_refused() {
    let head = "time [s],x [mm],y [mm],z [mm]\n";
    let rows = |stamp: &dyn Fn(usize) -> String| {
        (0..40).fold(head.to_owned(), |text, n| format!("{text}{},1,2,3\n", stamp(n)))
    };
    let stream = asl(0.05, ASL);
    for (digits, unit) in [("000", "ms"), ("000000", "us"), ("000000000", "ns")] {
        let data = rows(&|n| format!("{}{digits}", 1_400_000_001 + n / 4));
        let fault = load(RUN, &data, &stream).unwrap_err().to_string();
        let words = format!("count in {unit} since 1970, not in `s`");
        assert!(fault.contains("data.txt:1:1") && fault.contains(&words), "{fault}");
        let right = data.replace("time [s]", &format!("time [{unit}]"));
        assert!(load(RUN, &right, &stream).is_ok());
        let bare = load(RUN, &data.replace("time [s]", "time"), &stream).unwrap_err().to_string();
        assert!(bare.contains(&format!("write `time [{unit}]`")), "{bare}");
    }
}

#[test]
fn every_format_is_a_row_of_the_page() {
    let page = include_str!("../../docs/files-as-they-are.md");
    for format in FORMATS {
        assert!(page.contains(&format!("| `{}` |", format.name)), "{}", format.name);
    }
}

/// Nanoseconds of nineteen digits in data and stream: what is between two stamps is exact.
#[test]
fn stamps_of_nineteen_digits_keep_them() {
    let stamp = |n: usize| 1_403_715_524_907_143_168_u64 + 5_000_003 * n as u64;
    let rows = |head: &str, from: usize, count: usize| {
        (from..from + count).fold(format!("{head}\n"), |text, n| {
            format!("{text}{},{:.6},0,0,1,0,0,0\n", stamp(n), (0.01 * n as f64).sin())
        })
    };
    let stream = rows("time [ns],arm_x [m],arm_y [m],arm_z [m],a [1],b [1],c [1],d [1]", 0, 3000);
    let names =
        "time [ns],x [m],y [m],z [m],attitude_w [1],attitude_x [1],attitude_y [1],attitude_z [1]";
    let campaign = load(RUN, &rows(names, 500, 1000), &stream).unwrap();
    let samples = campaign.runs[0].held();
    for (n, time) in samples.time.iter().enumerate() {
        let exact = (stamp(500 + n) - 1_403_000_000_000_000_000) as f64 / 1e9;
        assert_eq!(time + (campaign.zero - 1_403_000_000) as f64, exact, "{n}");
    }
    let seconds = |ns: u64| format!("{}.{:09}", ns / 1_000_000_000, ns % 1_000_000_000);
    // What is written is read the same.
    let model = Model::parse(Source::new("poses.toml", MODEL)).unwrap();
    let files =
        [("poses.toml", MODEL), ("stream.csv", &stream), ("data.txt", &rows(names, 500, 1000))];
    let folder = Folder::new("digits", &files);
    let text = format!("model = \"poses.toml\"\n[[runs]]\nname = \"one\"\n{RUN}\n");
    std::fs::write(folder.join("campaign.toml"), text).unwrap();
    let first = CampaignFile::read(&folder).unwrap().load(&model, &LoadOptions::default()).unwrap();
    let out = folder.join("out");
    homepoint::campaign::write::write_campaign(&out, &first, &model, &first.runs).unwrap();
    let written = std::fs::read_to_string(out.join("one.csv")).unwrap();
    assert!(
        written.lines().nth(3).unwrap().starts_with(&seconds(stamp(502))),
        "{}",
        &written[..300]
    );
    let second = CampaignFile::read(&out).unwrap().load(&model, &LoadOptions::default()).unwrap();
    assert_eq!(second.runs[0].held().time, first.runs[0].held().time);
}
