//! Campaigns that were recorded or simulated elsewhere; skipped where their data are not at hand.
#![expect(clippy::print_stderr, reason = "a skipped test says so")]

use std::fs;
use std::path::{Path, PathBuf};

use homepoint::campaign::file::CampaignFile;
use homepoint::campaign::load::{Campaign, LoadOptions};
use homepoint::campaign::spline::{Smoothing, Spline};
use homepoint::campaign::{Role, Track};
use homepoint::diagnostic::Source;
use homepoint::model::Model;

fn data(name: &str) -> Option<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let found = ["../shared/data", "../../shared/data"].map(|to| root.join(to).join(name));
    let found = found.into_iter().find(|path| path.exists());
    if found.is_none() {
        eprintln!("skipped: the data `{name}` are not here");
    }
    found
}

fn model(name: &str) -> Model {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("models").join(format!("{name}.toml"));
    Model::parse(Source::new(name, fs::read_to_string(path).unwrap())).unwrap()
}

fn load(file: CampaignFile) -> Campaign {
    let model = model(&file.model.text);
    file.load(&model, &LoadOptions::default()).unwrap()
}

#[test]
fn every_practice_campaign_reads() {
    let Some(folder) = data("practice") else { return };
    let mut count = 0;
    for entry in fs::read_dir(folder).unwrap() {
        let campaign = load(CampaignFile::read(&entry.unwrap().path()).unwrap());
        assert!(campaign.left_out.is_empty() && campaign.skipped.is_empty());
        assert!(campaign.warnings.is_empty(), "{:?}", campaign.warnings);
        for run in &campaign.runs {
            assert!(run.record.inputs().iter().all(Track::moves), "{}", run.name);
        }
        count += 1;
    }
    assert!(count >= 12, "{count}");
}

#[test]
fn a_practice_campaign_in_full() {
    let Some(folder) = data("practice/clean_full") else { return };
    let campaign = load(CampaignFile::read(&folder).unwrap());
    assert_eq!((campaign.runs.len(), campaign.setups.len()), (40, 4));
    assert_eq!(campaign.runs.iter().filter(|run| run.role == Role::Reference).count(), 8);
    let run = campaign.runs.iter().find(|run| run.name == "A_ccw50_platform-30").unwrap();
    let samples = run.held();
    assert!((samples.setup_time[0] - 331.56).abs() < 1e-9);
    let degrees = |order| samples.inputs[1].at(1, 0.0, 0.0_f64, order).to_degrees();
    assert!((degrees(0) + 11.399_990_8).abs() < 1e-9 && (degrees(1) + 30.0).abs() < 1e-9);
    assert!((samples.readings[2][1] - 1.833754).abs() < 1e-12);
}

#[test]
fn joint_streams_give_an_acceleration_only_when_smoothed() {
    let Some(folder) = data("ur5_lasertracker/lan10") else { return };
    let campaign = load(CampaignFile::read(&folder).unwrap());
    let samples = campaign.runs[0].held();
    assert_eq!(samples.len(), 200);
    let Track::Logged(spline) = &samples.inputs[0] else {
        return assert!(samples.inputs[0].moves());
    };
    // The model says smooth = "0.2 s": oscillations of that period come out half as large.
    assert!((spline.time_constant() - 0.2 / std::f64::consts::TAU).abs() < 1e-12);
    // Raw values of q1, for other amounts of smoothing.
    let text = fs::read_to_string(folder.join("joints.csv")).unwrap();
    let rows: Vec<(f64, f64)> = text
        .lines()
        .skip(1)
        .map(|line| {
            let mut cells = line.split(',').map(|cell| cell.parse::<f64>().unwrap());
            (cells.next().unwrap(), cells.next().unwrap())
        })
        .collect();
    let (times, values): (Vec<f64>, Vec<f64>) = rows.into_iter().unzip();
    let acceleration = |smoothing| {
        let spline = Spline::fit(&times, &values, smoothing).unwrap();
        let sum: f64 =
            (0..1800).map(|i| spline.at(1.0 + f64::from(i) * 0.01, 0.0_f64, 2).powi(2)).sum();
        (sum / 1800.0).sqrt()
    };
    let [coarse, stated, finer, raw] = [1.2, 0.2, 0.1, 1e-6]
        .map(|period| acceleration(Smoothing::TimeConstant(period / std::f64::consts::TAU)));
    // A plateau about the stated amount; beyond it the motion is lost, without it all is noise.
    assert!((stated / finer - 1.0).abs() < 0.02, "{stated} {finer}");
    assert!(coarse < 0.95 * stated && raw > 20.0 * stated, "{coarse} {raw}");
}

#[test]
fn a_hand_eye_stream() {
    let Some(folder) = data("eth_hand_eye") else { return };
    let toml = "model = \"hand_eye\"\n[measurands]\nx = { sigma = \"5 mm\" }\ny = { sigma = \"5 mm\" }\nz = { sigma = \"5 mm\" }\n\
        attitude = { sigma = \"5 mrad\" }\n[[runs]]\nname = \"hand\"\ndata = \"camera.csv\"\nsignals = [\"hand.csv\"]\n";
    let campaign = load(CampaignFile::parse(&folder.join("campaign.toml"), toml).unwrap());
    let samples = campaign.runs[0].held();
    assert_eq!(samples.len(), 1703);
    let used = samples.readings[0].iter().filter(|value| !value.is_nan()).count();
    // The hand's stream starts 0.5 s after the camera's; half a second is kept from its ends.
    assert_eq!(used + campaign.left_out[0].samples, 1703);
    assert!(used > 1650 && used < 1703, "{used}");
    for row in 0..samples.len() {
        let norm: f64 = samples.readings[3..7].iter().map(|column| column[row].powi(2)).sum();
        assert!(norm.is_nan() || (norm - 1.0).abs() < 1e-12);
    }
}
