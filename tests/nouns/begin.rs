//! Campaigns begun from logs: what is guessed can be read, and fits.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use homepoint::campaign::begin::{NamedModel, begin};
use homepoint::campaign::file::CampaignFile;
use homepoint::campaign::load::Campaign;
use homepoint::campaign::loaded::LoadOptions;
use homepoint::diagnostic::Source;
use homepoint::engine::open::{Request, open};
use homepoint::estimate::batch::Options;
use homepoint::estimate::calibrate::{Calibration, calibrate};
use homepoint::library::Library;
use homepoint::model::Model;

use crate::folder::Folder;

pub(crate) fn library() -> Vec<NamedModel> {
    let library = Library::builtin().unwrap();
    let all = library.models().iter();
    all.map(|(name, _)| ((*name).to_owned(), library.model(name, Path::new("")).unwrap())).collect()
}

/// What is begun of logs in a folder; it is read, and comes with its model's text.
pub(crate) fn begun(
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
    let begun = begin(&logs, wanted, &known, None).map_err(|faults| faults.to_string())?;
    std::fs::write(folder.join("campaign.toml"), &begun.campaign).unwrap();
    if let Some((name, text)) = &begun.table {
        std::fs::write(folder.join(name), text).unwrap();
    }
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

/// The fit of what is begun, of dead reckoning at a scale of its heading.
pub(crate) fn fitted(files: &[(&str, String)], heading_scale: Option<f64>) -> Calibration {
    let texts: Vec<(&str, &str)> =
        files.iter().map(|(name, text)| (*name, text.as_str())).collect();
    let folder = Folder::new("begin", &texts);
    let logs: Vec<(PathBuf, PathBuf)> =
        files.iter().map(|(name, _)| (folder.join(name), PathBuf::from(name))).collect();
    let begun = begin(&logs, None, &library(), heading_scale).unwrap();
    let campaign = ("campaign.toml".to_owned(), begun.campaign);
    for (name, text) in begun.model.into_iter().chain(begun.table).chain([campaign]) {
        std::fs::write(folder.join(name), text).unwrap();
    }
    let problem = open(&Request::new([&*folder])).unwrap().problem;
    calibrate(problem, &Options::default()).unwrap()
}

fn table(head: &str, every: f64, row: impl Fn(f64) -> String) -> String {
    (0..(30.0 / every) as usize).fold(format!("{head}\n"), |mut text, n| {
        writeln!(text, "{}", row(every * n as f64)).unwrap();
        text
    })
}

/// How many readings are there.
pub(crate) fn readings(campaign: &Campaign) -> usize {
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

/// Where no columns are called alike, those of one kind are compared; where there is one alone in each
/// log, a scale has both units.
#[test]
fn columns_of_one_kind_go_together() {
    let tracker = table("time [s],status,east [m],north [m]", 0.1, |t| {
        format!("{t:.1},{:.0},{:.4},{:.4}", t, 3.0 * t.sin(), t)
    });
    let path = |heads: &str| {
        table(heads, 0.02, |t| format!("{t:.2},{:.4},{:.4},{:.4}", 7.0 * t, 3.0 * t.sin(), t))
    };
    let turns = path("time [s],heading [rad],along [m],across [m]");
    let files = [("tracker.csv", tracker.clone()), ("turns.csv", turns)];
    let (text, model, _) = begun(&files, None).unwrap();
    assert!(text.contains("ref_east = { column = \"along\""), "{text}");
    assert!(model.contains("east_scale * ref_east + east_offset', unit = \"m\""), "{model}");
    let angles = table("time [s],turn [rad]", 0.02, |t| format!("{t:.2},{:.4}", 7.0 * t));
    let fault = begun(&[("tracker.csv", tracker), ("angles.csv", angles.clone())], None);
    assert!(fault.unwrap_err().contains("columns of `angles.csv`: time [s], turn [rad]"));
    // A column without a unit is of no kind, and the error states that.
    let stage = table("t_us,pos_mm,motor_temp", 0.02, |t| {
        format!("{:.0},{:.4},{:.2}", 1e6 * t, 30.0 * t.sin(), 24.0 + 0.1 * t)
    });
    let laser = |head: &str| {
        table(head, 0.1, |t| format!("{t:.2},{:.4},{:.2}", 30.0 * (t - 0.01).sin(), 20.0 - 0.1 * t))
    };
    let fault =
        begun(&[("laser.csv", laser("time [s],L,air")), ("stage.csv", stage.clone())], None);
    let fault = fault.unwrap_err();
    for words in [
        "`laser.csv` moves in: L without a unit, air without a unit",
        "`stage.csv` moves in: pos_mm in mm, motor_temp without a unit",
        "a column without a unit needs one, as `L [mm]`",
    ] {
        assert!(fault.contains(words), "{words}\n{fault}");
    }
    let files = [("laser.csv", laser("time [s],L [mm],air")), ("stage.csv", stage)];
    assert!(begun(&files, None).unwrap().0.contains("ref_l = { column = \"pos_mm\""));
    let rope = table("time [s],east [m]", 0.1, |t| format!("{t:.1},{:.4}", 3.0 * t.sin()));
    let (_, model, _) = begun(&[("rope.csv", rope), ("angles.csv", angles)], None).unwrap();
    assert!(model.contains("east_scale * ref_east + east_offset', unit = \"m\""), "{model}");
}

/// Standard uncertainties are the scatter of dense readings, however far they go; readings between which the
/// stream moves on have none to show.
#[test]
fn uncertainties_are_guessed_from_the_scatter_about_a_smooth_curve() {
    let noise = |t: f64, salt: f64| {
        let uniform = |k: f64| ((4e3 * t + 7.1 * k + salt).sin() * 43_758.545_3).rem_euclid(1.0);
        3_f64.sqrt() * ((0..4).map(|k| uniform(f64::from(k))).sum::<f64>() - 2.0)
    };
    let row = |t: f64, size: f64| {
        // Stamps are uneven, as those of an operating system.
        let at = t + 0.01 * noise(t, 5.0).clamp(-2.0, 2.0);
        let (east, turn) = (3.0 * (0.4 * at).sin(), 0.5 * (0.3 * at).cos());
        let (east, turn) =
            (east + 4e-4 * size * noise(t, 1.0), turn + 2.5e-4 * size * noise(t, 2.0));
        format!("{at:.6},{east:.6},{turn:.7}")
    };
    let head = "t_s,east [m],turn [rad]";
    let sigma = |text: &str, name: &str| {
        let (_, rest) = text.split_once(&format!("{name} = {{ sigma = \"")).unwrap();
        let (value, rest) = rest.split_once('"').unwrap();
        let why = rest.lines().next().unwrap().to_owned();
        (homepoint::units::parse_quantity(value).unwrap().0, value.to_owned(), why)
    };
    let stream = ("fast.csv", table(head, 0.01, |t| row(t, 1.0)));
    let (text, ..) =
        begun(&[("slow.csv", table(head, 0.05, |t| row(t, 1.0))), stream.clone()], None).unwrap();
    for (name, expected, unit) in [("east", 4e-4, "um"), ("turn", 2.5e-4, "urad")] {
        let (value, written, why) = sigma(&text, name);
        assert!((value / expected - 1.0).abs() < 0.2, "{name}: {written}");
        assert!(written.ends_with(unit) && why.contains("about a smooth curve"), "{written} {why}");
    }
    let sparse = table(head, 2.5, |t| row(t, 0.0));
    let logs = [("slow.csv", &*sparse), ("fast.csv", &*stream.1)];
    let folder = Folder::new("begin", &logs);
    let logs = logs.map(|(name, _)| (folder.join(name), PathBuf::from(name)));
    let text = begin(&logs, None, &library(), None).unwrap().campaign;
    assert!(text.contains("# east = { sigma = \"... m\" }   # WRITE it"), "{text}");
}

/// A steady motion has no step from row to row that is one of rounding.
#[test]
fn uncertainties_of_a_steady_motion_are_its_scatter() {
    let noise = |t: f64| {
        let uniform = |k: f64| ((4e3 * t + 7.1 * k).sin() * 43_758.545_3).rem_euclid(1.0);
        3_f64.sqrt() * ((0..4).map(|k| uniform(f64::from(k))).sum::<f64>() - 2.0)
    };
    let row = |t: f64| format!("{t:.2},{:.8},{:.8}", 0.1 * t + 1e-6 * noise(t), 0.2 * t + 2.0);
    let head = "t_s,east [m],turn [rad]";
    let files = [("slow.csv", table(head, 0.05, row)), ("fast.csv", table(head, 0.01, row))];
    let (text, ..) = begun(&files, None).unwrap();
    let (_, rest) = text.split_once("east = { sigma = \"").unwrap();
    let value = homepoint::units::parse_quantity(rest.split_once('"').unwrap().0).unwrap().0;
    assert!((5e-7..2e-6).contains(&value), "{value} {text}");
}

#[test]
fn of_four_logs_those_of_one_recording_go_together() {
    let slow = |phase: f64| {
        table("t_s,angle_rad,load", 0.1, |t| format!("{t:.1},{:.4},3", (t + phase).sin()))
    };
    let fast =
        |phase: f64| table("t_s,angle_rad", 0.01, |t| format!("{t:.2},{:.5}", (t + phase).sin()));
    let files = [
        ("a_run-1.csv", slow(0.0)),
        ("a_run-2.csv", slow(1.0)),
        ("b_run-1.csv", fast(0.0)),
        ("b_run-2.csv", fast(1.0)),
    ];
    let (text, _, _) = begun(&files, None).unwrap();
    assert!(text.contains("data = { file = \"a_run-1.csv\""), "{text}");
    assert!(text.contains("{ file = \"b_run-1.csv\""), "{text}");
    assert!(text.contains("`a_run-2.csv` and `b_run-2.csv` are of another recording"), "{text}");
}

#[test]
fn a_list_of_stars_has_no_streams() {
    let row = |n: i32| {
        let (azimuth, elevation) = (f64::from((n * 97) % 360), f64::from(20 + (n * 31) % 60));
        let read = if azimuth > 180.0 { azimuth - 360.0 } else { azimuth };
        format!(
            "{n},{:.1},{:.5},{:.5},{azimuth:.5},{elevation:.5}\n",
            70.0 * f64::from(n),
            read + 0.01,
            elevation - 0.02
        )
    };
    let head = "i,lst_s,enc_az_deg,enc_el_deg,star_az_deg,star_el_deg\n";
    let list = format!("{head}{}", (0..40).map(row).collect::<String>());
    let files = [("stars.csv", list)];
    let (text, model, campaign) = begun(&files, None).unwrap();
    assert!(!text.contains("signals") && !text.contains("delay_range"), "{text}");
    assert!(!model.contains("signal = true") && !model.contains("[delays]"), "{model}");
    assert!(model.contains("az = { value = 'ref_az + az_offset', kind = \"angle\""), "{model}");
    assert_eq!(readings(&campaign), 80);
    let found = fitted(&files, None);
    let offset = found.estimates().iter().find(|one| one.name == "az_offset").unwrap().value;
    assert!((offset.unwrap().to_degrees() - 0.01).abs() < 1e-4, "{offset:?}");
}

#[test]
fn columns_without_names_are_not_alike_by_their_numbers_and_bad_rows_are_told() {
    let slow = table("0.0 1 5", 0.1, |t| format!("{:.1} {:.4} {:.4}", t + 0.1, t.sin(), t.cos()));
    let fast = table("0.0 3 4", 0.01, |t| match (t * 100.0) as i32 {
        700 => format!("{:.2} lost 4", t + 0.01),
        _ => format!("{:.2} {:.4} 4", t + 0.01, t.cos()),
    });
    let folder = Folder::new("begin", &[("slow.txt", slow.as_str()), ("fast.txt", fast.as_str())]);
    let logs = ["slow.txt", "fast.txt"].map(|name| (folder.join(name), PathBuf::from(name)));
    let begun = begin(&logs, None, &library(), None).unwrap();
    let model = begun.model.unwrap().1;
    assert!(model.contains("No two columns are called alike"), "{model}");
    let [note] = &begun.notes[..] else { panic!("{:?}", begun.notes) };
    assert!(note.contains("`fast.txt`: 1 row has cells that are no numbers"), "{note}");
    assert!(begun.campaign.contains(note), "{}", begun.campaign);
}

/// A protocol with a row of units, in which a quote stands for seconds of arc, and a unit that is not known.
#[test]
fn units_below_the_names_may_be_quotes_and_are_named_where_they_are_not_known() {
    let model = "name = \"own\"\n[inputs]\nface = { unit = \"deg\" }\n[parameters]\nzero = { unit = \"arcsec\" }\n\
        [measurands]\nread = { value = 'zero + 0 * face', unit = \"arcsec\", sigma = \"1 arcsec\" }\n";
    let protocol = |unit: &str| {
        let rows = (0..12).map(|n| format!("{n};{};{},5;{}\n", (n * 7) % 12 * 30, n % 3, n % 4));
        format!("Protocol;;;\n\nNr;face;read;air\n;°;{unit};furlong\n{}", rows.collect::<String>())
    };
    for unit in ["\"", "\u{2033}", "''"] {
        let files = [("stops.csv", protocol(unit))];
        let text = begun_with(model, &files);
        let [(name, stops)] = &files;
        assert!(text.contains("the column `air`"), "{text}");
        let folder = Folder::new("stops", &[(*name, stops.as_str()), ("campaign.toml", &text)]);
        let model = Model::parse(Source::new("own.toml", model)).unwrap();
        let loaded = CampaignFile::read(&folder).unwrap().load(&model, &LoadOptions::default());
        let loaded = loaded.unwrap_or_else(|faults| panic!("{faults}\n{text}"));
        let second = loaded.runs[0].held().readings[0][1];
        assert!((second * 3600.0 - 1.5_f64.to_radians()).abs() < 1e-12, "{second} {text}");
    }
}

/// A text below the rows stands for no reading that is missing.
#[test]
fn rows_of_text_are_no_missing_readings() {
    let slow = table("0.0 1 5", 0.1, |t| format!("{:.1} {:.4} {:.4}", t + 0.1, t.sin(), t.cos()));
    let fast = table("0.0 3 4", 0.01, |t| format!("{:.2} {:.4} 4", t + 0.01, t.cos()));
    let fast = fast + "end of log\nfile was closed\n";
    let folder = Folder::new("begin", &[("slow.txt", slow.as_str()), ("fast.txt", fast.as_str())]);
    let logs = ["slow.txt", "fast.txt"].map(|name| (folder.join(name), PathBuf::from(name)));
    let notes = begin(&logs, None, &library(), None).unwrap().notes;
    let [note] = &notes[..] else { panic!("{notes:?}") };
    assert!(note.contains("`fast.txt`: 2 rows have no number at all, but text"), "{note}");
    assert!(note.contains("--skip-bad-rows") && !note.contains("missing ="), "{note}");
}

#[test]
fn what_cannot_be_begun_says_why() {
    let still = "time [s],x [m]\n0,1\n1,1\n2,1\n".to_owned();
    let unordered = "a,b\n3,1\n1,2\n2,1\n0,4\n".to_owned();
    for (text, words) in [
        (String::new(), "is empty"),
        (unordered.clone(), "do not say which are inputs"),
        (still.clone(), "do not say which are inputs"),
    ] {
        let fault = begun(&[("log.csv", text)], None).unwrap_err();
        assert!(fault.contains(words), "{fault}");
    }
    for (text, words) in
        [(unordered, "has no column of stamps"), (still, "no two columns that move go together")]
    {
        let fault = begun(&[("log.csv", text.clone()), ("other.csv", text)], None).unwrap_err();
        assert!(fault.contains(words), "{fault}");
    }
    let none = [(PathBuf::from("none.csv"), PathBuf::from("none.csv"))];
    let fault = begin(&none, None, &library(), None).unwrap_err().to_string();
    assert!(fault.contains("does not exist"), "{fault}");
}

#[test]
fn stamps_of_rows_that_came_late_are_stamps() {
    let log = |every: f64| {
        let text = table("", every, |t| {
            format!(
                "{}000000,{:.4},{:.4},{:.4},0,0,{:.6},{:.6}",
                (1.7e12 + 1e3 * t).round() as u64,
                t.sin(),
                t.cos(),
                0.1 * t,
                (0.2 * t).sin(),
                (0.2 * t).cos()
            )
        });
        let mut rows: Vec<String> = text.trim().lines().map(str::to_owned).collect();
        // One row in twenty comes behind the next.
        (5..rows.len() - 1).step_by(20).for_each(|row| rows.swap(row, row + 1));
        rows.join("\n")
    };
    let (campaign, _, read) =
        begun(&[("eye.csv", log(0.25)), ("hand.csv", log(0.02))], None).unwrap();
    assert!(campaign.contains("model = \"hand_eye\""), "{campaign}");
    assert!(campaign.contains("as large as ns since 1970"), "{campaign}");
    assert_eq!(read.warnings.iter().filter(|one| one.message.contains("were sorted")).count(), 2);
}

#[test]
fn columns_of_another_kind_are_no_pairs() {
    let pose = |t: f64| {
        let [w, x, y, z] = quaternion(t);
        format!("{t:.3},{:.4},{:.4},{:.4},{w:.6},{x:.6},{y:.6},{z:.6}", t.sin(), t.cos(), 0.1 * t)
    };
    let poses = table("time [s],px,py,pz,qw,qx,qy,qz", 0.02, pose);
    let waves = |t: f64| {
        format!("{t:.3},{:.4},{:.4},{:.4}", (1.1 * t).sin(), (0.9 * t).cos(), (0.7 * t).sin())
    };
    let log = |head: &str| table(head, 0.1, waves);
    // Rates of turn are no positions, whatever lets the rows be read.
    let fault = begun(&[("imu.csv", log("time [s],gx,gy,gz")), ("eye.csv", poses.clone())], None)
        .unwrap_err();
    assert!(fault.contains("no two columns that move go together"), "{fault}");
    assert!(fault.contains("columns of `imu.csv`: time [s], gx, gy, gz"), "{fault}");
    let turns = table("time [s],x [m],y [m],yaw [rad]", 0.02, waves);
    let speeds = log("time [s],vx [m/s],vy [m/s],wz [rad/s]");
    let fault = begun(&[("odometry.csv", speeds), ("eye.csv", turns)], None).unwrap_err();
    assert!(fault.contains("vx [m/s], vy [m/s], wz [rad/s]"), "{fault}");
    // East, north and up are a position.
    let files = [("receiver.csv", log("time [s],e [m],n [m],u [m]")), ("eye.csv", poses)];
    let (campaign, _, _) = begun(&files, None).unwrap();
    assert!(campaign.contains("x = { column = \"e\", unit = \"m\" },"), "{campaign}");
    // Coordinates of a plane are lengths, a heading is none.
    let odometry = log("time,x,y,theta");
    let marker = table("Frame,Time (Seconds),X,Y,Z", 0.02, |t| {
        format!("{},{}", (t / 0.02).round(), waves(t))
    });
    let (campaign, model, _) =
        begun(&[("odometry.csv", odometry), ("marker.csv", marker)], None).unwrap();
    assert!(campaign.contains("ref_x = { column = \"X\", unit = \"m\" }"), "{campaign}");
    assert!(!model.contains("theta"), "{model}");
}

/// A campaign of a model of its own, as text.
pub(crate) fn begun_with(model: &str, files: &[(&str, String)]) -> String {
    let texts: Vec<(&str, &str)> =
        files.iter().map(|(name, text)| (*name, text.as_str())).collect();
    let folder = Folder::new("begin", &texts);
    let logs: Vec<(PathBuf, PathBuf)> =
        files.iter().map(|(name, _)| (folder.join(name), PathBuf::from(name))).collect();
    let own = ("own.toml".to_owned(), Model::parse(Source::new("own.toml", model)).unwrap());
    let campaign = begin(&logs, Some(&own), &library(), None).unwrap().campaign;
    std::fs::write(folder.join("campaign.toml"), &campaign).unwrap();
    CampaignFile::read(&folder).unwrap_or_else(|faults| panic!("{faults}\n{campaign}"));
    campaign
}

#[test]
fn what_a_stated_model_lacks_is_a_line_to_fill_in() {
    let model = "name = \"own\"\ntitle = \"own\"\n[inputs]\nodo_x = { unit = \"m\", signal = true }\n\
        odo_th = { unit = \"rad\", signal = true }\n[measurands]\nx = { value = 'odo_x * cos(odo_th)', unit = \"m\" }\n";
    let waves = |t: f64| format!("{t:.3},{:.4},{:.4}", t.sin(), t.cos());
    let files = [
        ("odometry.csv", table("time,x,theta", 0.1, waves)),
        ("marker.csv", table("time,X,Z", 0.02, waves)),
    ];
    let campaign = begun_with(model, &files);
    for line in [
        "x = { column = \"x\", unit = \"m\" },   # guessed: its name; the file has no unit, CHECK `m`",
        "# odo_x = { column = \"...\", unit = \"m\" },   # WRITE its column, or leave it out: none is called so; columns of `marker.csv`: time, X, Z",
        "# odo_th = { column = \"...\", unit = \"rad\" },",
    ] {
        assert!(campaign.contains(line), "{line}\n{campaign}");
    }
    // Numbers of stops are no stamps, and rows at rest have no stream.
    let stops = table("Stop,odo_x [m],odo_th [deg],x [m]", 1.0, |t| {
        format!(
            "{},{:.3},{:.2},{:.3}",
            t + 1.0,
            (7.0 * t).sin(),
            (100.0 * t * t) % 170.0,
            (9.0 * t).cos()
        )
    });
    let campaign = begun_with(model, &[("stops.csv", stops)]);
    assert!(!campaign.contains("time") && !campaign.contains("signals"), "{campaign}");
    assert!(campaign.contains("data = "), "{campaign}");
}

/// An angle that goes on evenly from stop to stop has a unit, which is none of time.
#[test]
fn an_angle_that_is_stepped_is_no_time() {
    let model = "name = \"table\"\n[inputs]\ntable = { unit = \"rad\" }\n[parameters]\nzero = { unit = \"rad\" }\n\
                 [measurands]\nread = { value = 'table + zero', unit = \"rad\" }\n";
    let stops =
        table("table [deg],read [deg]", 0.5, |t| format!("{:.3},{:.3}", 15.0 * t, 15.0 * t + 0.1));
    let campaign = begun_with(model, &[("stops.csv", stops)]);
    assert!(!campaign.contains("time =") && !campaign.contains("signals"), "{campaign}");
}

/// A model without streams makes a table of stops of any log: even steps and a few seconds between rows
/// are no stream.
#[test]
fn a_model_without_streams_takes_its_inputs_from_the_data() {
    let model = "name = \"own\"\n[inputs]\nface = { unit = \"deg\" }\n[parameters]\nzero = { unit = \"deg\" }\n\
        [measurands]\nread = { value = 'face + zero', unit = \"deg\" }\n";
    let row = |t: f64| {
        let stop = (2.0 * t) as usize;
        format!(
            "03.11.2025;09:{:02}:{:02};{};{:.3}",
            stop / 7,
            8 * (stop % 7),
            15 * stop,
            30.0 * t + 0.1
        )
    };
    let files = [("stops.csv", table("Datum;Uhrzeit;face [deg];read [deg]", 0.5, row))];
    let text = begun_with(model, &files);
    assert!(!text.contains("signals") && !text.contains("time ="), "{text}");
    let [(name, stops)] = &files;
    let folder = Folder::new("stops", &[(*name, stops.as_str()), ("campaign.toml", &text)]);
    let model = Model::parse(Source::new("own.toml", model)).unwrap();
    let loaded = CampaignFile::read(&folder).unwrap().load(&model, &LoadOptions::default());
    let loaded = loaded.unwrap_or_else(|faults| panic!("{faults}\n{text}"));
    assert_eq!(readings(&loaded), 60, "{text}");
}

#[test]
fn names_in_a_begun_table_of_stops_are_unique() {
    let model = |value: &str| {
        format!(
            "name = \"own\"\ntitle = \"own\"\n[inputs]\nroll = {{ unit = \"deg\" }}\n[parameters]\n\
             drift = {{ unit = \"deg/s\", scope = \"setup\" }}\n[measurands]\nq = {{ value = '{value}', unit = \"deg\", sigma = \"0.1 deg\" }}\n"
        )
    };
    let stops = |head: &str| {
        (0..20).fold(format!("{head},roll,q\n"), |text, n| {
            let roll = (f64::from(n) * 37.0) % 90.0;
            format!("{text}{}.5,{roll},{:.2}\n", 20 * n, roll + 0.1)
        })
    };
    let plain = "roll + drift * 1 s";
    let timed = "roll + drift * run_time";
    for (value, head, time) in [
        (plain, "t", None),
        (timed, "t", Some("time = { column = \"t\", unit = \"s\" },")),
        // A column of that name is read: it needs its unit.
        (plain, "time", Some("time = { column = \"time\", unit = \"s\" },")),
    ] {
        let files = [("stops.csv", stops(head))];
        let text = begun_with(&model(value), &files);
        assert_eq!(text.matches("time = {").count(), usize::from(time.is_some()), "{text}");
        assert!(time.is_none_or(|time| text.contains(time)), "{text}");
        assert!(text.contains("roll = { column = \"roll\", unit = \"deg\" },"), "{text}");
        let [(name, stops)] = &files;
        let folder = Folder::new("stops", &[(*name, stops.as_str()), ("campaign.toml", &text)]);
        let model = Model::parse(Source::new("own.toml", model(value))).unwrap();
        let loaded = CampaignFile::read(&folder).unwrap().load(&model, &LoadOptions::default());
        let loaded = loaded.unwrap_or_else(|faults| panic!("{faults}\n{text}"));
        assert_eq!(readings(&loaded), 20, "{text}");
    }
}

/// Of a stated model a column of another name is the reading that is alone of its kind, a repeated header
/// is no text, and what has the columns of the stream may be of a simulator.
#[test]
fn a_stated_model_takes_the_only_columns_of_their_kind() {
    let model = "name = \"cell\"\n[inputs]\nload = { unit = \"kg\", signal = true }\ntemp = { unit = \"K\", signal = true }\n\
        [parameters]\nzero = { unit = \"g\" }\n[measurands]\nweight = { value = 'load + zero', unit = \"g\" }\n";
    let plc = table("time [s];Last [kg];Temp [degC]", 0.05, |t| {
        format!("{t:.2};{:.4};{:.3}", 1.0 + (0.7 * t).sin(), 20.0 + 0.01 * t)
    });
    let weight = |t: f64| format!("{t:.2};{:.2}", 1000.0 + 1000.0 * (0.7 * t).sin());
    let scale = table("time [s];Gewicht [g]", 0.1, weight);
    let middle = scale.len() / 2 + scale[scale.len() / 2..].find('\n').unwrap() + 1;
    let (first, second) = scale.split_at(middle);
    let scale = format!("{first}time [s];Gewicht [g]\n{second}");
    let files = [("scale.csv", scale), ("plc.csv", plc.clone()), ("plc_2.csv", plc)];
    let found = begun_with(model, &files);
    let column = "weight = { column = \"Gewicht\", unit = \"g\" },   # guessed: the only column";
    for due in
        [column, "load = { column = \"Last\"", "temp = { column = \"Temp\"", "weight = { sigma = "]
    {
        assert!(found.contains(due), "{due}: {found}");
    }
    assert!(!found.contains("--skip-bad-rows"), "{found}");
    assert!(found.contains("`plc_2.csv` with the columns of `plc.csv`"), "{found}");
    assert!(found.contains("docs/simulated-sensitivities.md"), "{found}");
}

/// An input that is no signal may stand beside the readings, as a strength beside each range; a blank in a
/// column's name is an underscore of the model's.
#[test]
fn an_input_that_is_sampled_with_the_readings_is_a_column_of_the_data() {
    let model = "name = \"radar\"\n[inputs]\neast = { unit = \"m\", signal = true }\nsnr = { unit = \"1\" }\n\
        [parameters]\noffset = { unit = \"m\" }\n[measurands]\nslant_range = { value = 'east + offset', unit = \"m\" }\n";
    let gnss = table("time [s],east [m]", 0.05, |t| format!("{t:.2},{:.4}", 9.0 * (0.7 * t).sin()));
    let radar = table("time [s],slant range [m],snr [1]", 0.1, |t| {
        format!("{t:.2},{:.3},{:.1}", 4.0 + 9.0 * (0.7 * t).sin(), 30.0 + (3.0 * t).cos())
    });
    let found = begun_with(model, &[("radar.csv", radar), ("gnss.csv", gnss)]);
    assert!(found.contains("slant_range = { column = \"slant range\""), "{found}");
    assert!(!found.contains("WRITE its column") && !found.contains("unused"), "{found}");
}
