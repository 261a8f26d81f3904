//! Columns of angles in degrees, minutes and seconds.

use homepoint::campaign::file::CampaignFile;
use homepoint::campaign::load::LoadOptions;
use homepoint::diagnostic::{Diagnostics, Source};
use homepoint::model::Model;

use crate::folder::Folder;

const MODEL: &str = "name = \"dome\"\ntitle = \"dome\"\n[inputs]\nstar = { unit = \"deg\" }\nheight = { unit = \"m\" }\n\
    [parameters]\nc = { unit = \"rad\", scope = \"rig\" }\n[measurands]\n\
    az = { value = 'star + c', unit = \"deg\", sigma = \"1 arcsec\" }\n";

/// The readings (rad) of a run with these lines whose data are this table.
fn readings(run: &str, table: &str) -> Result<Vec<f64>, Diagnostics> {
    let campaign = format!("model = \"dome.toml\"\n[[runs]]\nname = \"one\"\n{run}\n");
    let files = [("dome.toml", MODEL), ("campaign.toml", &*campaign), ("data.csv", table)];
    let folder = Folder::new("sexagesimal", &files);
    let model = Model::parse(Source::new("dome.toml", MODEL))?;
    let campaign = CampaignFile::read(&folder)?.load(&model, &LoadOptions::default())?;
    Ok(campaign.runs[0].held().readings[0].clone())
}

const DATA: &str = "data = \"data.csv\"";

#[test]
fn degrees_minutes_and_seconds_are_an_angle() {
    let due = readings(DATA, "star [deg],az [deg]\n94.5,-0.5125\n10,10.5\n").unwrap();
    for (run, table) in [
        (DATA, "star [dms],az\n094:30:00,-00:30:45\n10:00:00.0,10:30:00\n"),
        (DATA, "star [deg],az [deg]\n094 30 00,-0 30 45\n10.0,10.5\n"),
        (DATA, "star [°]\taz\n094°30'00.0\"\t-00°30'45\"\n10°00'00\"\t10°30'00\"\n"),
        (DATA, "star,az\n94d30m0s,-0d30m45s\n10d0m0s,10d30m0s\n"),
        (DATA, "star,az\n\"94°30'00\"\"\",\"-00°30'45\"\"\"\n\"10°00'00\"\"\",\"10°30'00\"\"\"\n"),
        (DATA, "star;az\n94:30:00,0;-0:30:45,0\n10:00:00,0;10:30:00,0\n"),
        (
            "data = { file = \"data.csv\", columns = { az = \"60 deg - zenith\" } }",
            "star,zenith\n94:30:00,60:30:45\n10:00:00,49:30:00\n",
        ),
    ] {
        let found = readings(run, table).unwrap_or_else(|faults| panic!("{table}{faults}"));
        let first = (found[0] - due[0]).abs();
        assert!(
            first < 1e-12 && found.iter().zip(&due).all(|(a, b)| (a - b).abs() < 1e-12),
            "{table}{found:?}"
        );
    }
}

#[test]
fn other_cells_and_units_are_refused() {
    for (table, words) in [
        ("star [deg],az [gon]\n94.5,94:30:00\n", "its unit is `gon`"),
        ("star [deg],az [h]\n94.5,12:30:00\n", "hours of angle are not read"),
        ("star [deg],az [deg]\n94.5,94:30:00\n94.5,94:60:00\n", "minutes and seconds below 60"),
        ("star [deg],az [deg]\n94.5,94:30:00\n94.5,N94\n", "minutes and seconds below 60"),
        (
            "star [deg],az [deg],height [m]\n94.5,94:30:00,1:10:20\n",
            "expected a number in column `height`",
        ),
    ] {
        let fault = readings(DATA, table).unwrap_err().to_string();
        assert!(fault.contains(words), "{table}{fault}");
    }
}
