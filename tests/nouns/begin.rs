//! Campaigns begun from logs: what is guessed can be read, and fits.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use homepoint::campaign::begin::{NamedModel, begin};
use homepoint::campaign::file::CampaignFile;
use homepoint::campaign::load::Campaign;
use homepoint::campaign::loaded::LoadOptions;
use homepoint::diagnostic::Source;
use homepoint::library::Library;
use homepoint::model::Model;

use crate::folder::Folder;

fn library() -> Vec<NamedModel> {
    let library = Library::builtin().unwrap();
    let all = library.models().iter();
    all.map(|(name, _)| ((*name).to_owned(), library.model(name, Path::new("")).unwrap())).collect()
}

/// What is begun of logs in a folder; it is read, and comes with its model's text.
fn begun(
    files: &[(&str, String)],
    model: Option<&str>,
) -> Result<(String, String, Campaign), String> {
    let texts: Vec<(&str, &str)> =
        files.iter().map(|(name, text)| (*name, text.as_str())).collect();
    let folder = Folder::new("begin", &texts);
    let logs: Vec<(PathBuf, PathBuf)> =
        files.iter().map(|(name, _)| (folder.join(name), PathBuf::from(name))).collect();
    let known = library();
    let wanted = model.map(|name| known.iter().find(|(own, _)| own == name).unwrap());
    let begun = begin(&logs, wanted, &known).map_err(|faults| faults.to_string())?;
    std::fs::write(folder.join("campaign.toml"), &begun.campaign).unwrap();
    let file = CampaignFile::read(&folder).unwrap_or_else(|f| panic!("{f}\n{}", begun.campaign));
    let (text, model) = match begun.model {
        Some((name, text)) => {
            let model = Model::parse(Source::new(name, text.as_str()));
            (text.clone(), model.unwrap_or_else(|faults| panic!("{faults}\n{text}")))
        }
        None => {
            let own = known.into_iter().find(|(own, _)| *own == file.model.text).unwrap();
            (String::new(), own.1)
        }
    };
    let campaign = file.load(&model, &LoadOptions::default());
    let campaign = campaign.unwrap_or_else(|faults| panic!("{faults}\n{}", begun.campaign));
    Ok((begun.campaign, text, campaign))
}

fn table(head: &str, every: f64, row: impl Fn(f64) -> String) -> String {
    (0..(30.0 / every) as usize).fold(format!("{head}\n"), |mut text, n| {
        writeln!(text, "{}", row(every * n as f64)).unwrap();
        text
    })
}

/// How many readings are there.
fn readings(campaign: &Campaign) -> usize {
    let all = &campaign.runs[0].held().readings;
    all.iter().flatten().filter(|reading| !reading.is_nan()).count()
}

fn quaternion(t: f64) -> [f64; 4] {
    let (half, tilt) = (0.3 * t.sin(), 0.4 * (1.3 * t).cos());
    [half.cos(), half.sin() * tilt.sin(), 0.0, half.sin() * tilt.cos()]
}

#[test]
fn poses_of_two_logs_are_those_of_the_hand_and_the_eye() {
    let pose = |t: f64, by: &str| {
        let [w, x, y, z] = quaternion(t);
        let all = [t.sin(), 0.3 * t.cos(), -1.5 + 0.1 * t, x, y, z, w];
        all.iter().fold(String::new(), |text, value| format!("{text}{by}{value:.6}"))
    };
    let tum = |every: f64| {
        let rows = table("# poses", every, |t| format!("{:.3}{}", 1.4e9 + t, pose(t, " ")));
        ("estimate.txt", rows)
    };
    let named = |every: f64| {
        let head = "stamp_ms,pos_x_m,pos_y_m,pos_z_m,quat_x,quat_y,quat_z,quat_w,battery";
        ("log.csv", table(head, every, |t| format!("{}{},12.5", 1000.0 * t + 1.4e12, pose(t, ","))))
    };
    for (files, data) in
        [([tum(0.2), named(0.02)], "estimate.txt"), ([tum(0.02), named(0.2)], "log.csv")]
    {
        let (text, _, campaign) = begun(&files, None).unwrap();
        assert!(text.contains("model = \"hand_eye\""), "{text}");
        assert!(text.contains(&format!("data = {{ file = \"{data}\"")), "{text}");
        assert!(text.contains("unit = \"ms\"") && text.contains("guessed"), "{text}");
        assert!(readings(&campaign) > 7 * 130, "{text}");
        let stated = begun(&files, Some("hand_eye")).unwrap().0;
        assert_eq!(stated, text);
    }
}

#[test]
fn poses_in_a_plane_get_a_model_of_their_own() {
    let head = |ending: &str| format!("t_s,x_{ending},y_{ending},yaw_deg,volts");
    let row = |t: f64, scale: f64| {
        let heading = 40.0 * (0.2 * t).sin();
        format!("{t:.2},{:.3},{:.3},{heading:.3},12", scale * t.sin(), scale * 0.2 * t)
    };
    let slow = table(&head("mm").replace(',', ";"), 0.1, |t| row(t, 1e3).replace(',', ";"));
    let fast = table(&head("m"), 0.02, |t| row(t, 1.0));
    let (text, model, campaign) = begun(&[("fast.csv", fast), ("slow.csv", slow)], None).unwrap();
    assert!(text.contains("x = { column = \"x_mm\", unit = \"mm\" }"), "{text}");
    assert!(text.contains("ref_heading = { column = \"yaw_deg\", unit = \"deg\" }"), "{text}");
    assert!(model.contains("planar_pose"), "{model}");
    assert!(readings(&campaign) > 3 * 280, "{text}");
    let y = campaign.runs[0].held().readings[1][150];
    assert!((y - 3.0).abs() < 1e-6, "{y}");
}

#[test]
fn other_columns_go_in_pairs() {
    // Two logs, no words of units; a counter of milliseconds.
    let encoder = table("ms,axis,load", 0.1, |t| format!("{:.0},{:.4},{:.2}", 1e3 * t, t.sin(), t));
    let drive = table("ms\taxis", 0.01, |t| format!("{:.0}\t{:.4}", 1e3 * t, t.sin()));
    let files = [("encoder.csv", encoder), ("drive.tsv", drive)];
    let (text, model, campaign) = begun(&files, None).unwrap();
    assert!(text.contains("ref_axis = { column = \"axis\""), "{text}");
    assert!(model.contains("axis_scale * ref_axis + axis_offset"), "{model}");
    let time = campaign.runs[0].held().time[10];
    assert!((time - 1.0).abs() < 1e-12 && readings(&campaign) > 280, "{time} {text}");
    // One log of what was sent and what came.
    let log = table("time [s],q_sent [rad],q [rad],mode", 0.01, |t| {
        format!("{t:.2},{:.5},{:.5},auto", t.sin(), (t - 0.05).sin())
    });
    let (text, model, campaign) = begun(&[("echo.csv", log)], None).unwrap();
    assert!(model.contains("q_scale * ref_q + q_offset"), "{text}\n{model}");
    assert!(readings(&campaign) > 2000, "{text}");
}

#[test]
fn what_cannot_be_begun_says_why() {
    let still = "time [s],x [m]\n0,1\n1,1\n2,1\n".to_owned();
    let unordered = "a,b\n3,1\n1,2\n2,1\n0,4\n".to_owned();
    for (text, words) in [
        (String::new(), "holds no table of text"),
        (unordered, "has no column of stamps"),
        (still, "no two columns that move go together"),
    ] {
        let fault = begun(&[("log.csv", text)], None).unwrap_err();
        assert!(fault.contains(words), "{fault}");
    }
    let none = [(PathBuf::from("none.csv"), PathBuf::from("none.csv"))];
    let fault = begin(&none, None, &library()).unwrap_err().to_string();
    assert!(fault.contains("does not exist"), "{fault}");
}
