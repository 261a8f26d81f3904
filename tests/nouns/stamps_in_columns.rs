//! Stamps in several columns: seconds and their decimals, a date and a time of day.

use std::path::{Path, PathBuf};

use homepoint::campaign::begin::begin;
use homepoint::campaign::file::CampaignFile;
use homepoint::campaign::load::Campaign;
use homepoint::campaign::loaded::LoadOptions;
use homepoint::diagnostic::{Diagnostics, Source};
use homepoint::library::Library;
use homepoint::model::Model;

use crate::folder::Folder;

const MODEL: &str = "name = \"antenna\"\ntitle = \"antenna\"\n[inputs]\n\
    px = { unit = \"m\", signal = true }\npy = { unit = \"m\", signal = true }\npz = { unit = \"m\", signal = true }\n\
    [measurands]\n\
    e = { value = 'px', unit = \"m\", sigma = \"1 mm\" }\nn = { value = 'py', unit = \"m\", sigma = \"1 mm\" }\n\
    u = { value = 'pz', unit = \"m\", sigma = \"1 mm\" }\n";

/// Seconds from 1970 to 2025-03-26T12:00:00.
const NOON: u64 = 1_742_990_400;

fn load(run: &str, data: &str, stream: &str) -> Result<Campaign, Diagnostics> {
    let campaign = format!("model = \"antenna.toml\"\n[[runs]]\nname = \"one\"\n{run}\n");
    let files = [
        ("antenna.toml", MODEL),
        ("campaign.toml", &campaign),
        ("data.csv", data),
        ("stream.csv", stream),
    ];
    let folder = Folder::new("stamps-in-columns", &files);
    let model = Model::parse(Source::new("antenna.toml", MODEL)).unwrap();
    CampaignFile::read(&folder)?.load(&model, &LoadOptions::default())
}

/// Rows of a recorder: nanoseconds since 1970 of each, and its number.
fn rows(head: &str, count: u64, row: impl Fn(u64, u64) -> String) -> String {
    (0..count).fold(head.to_owned(), |text, n| {
        text + &row(NOON * 1_000_000_000 + n * 230_000_017, n) + "\n"
    })
}

fn stream() -> String {
    rows("time [ns],px [m],py [m],pz [m]\n", 400, |ns, n| format!("{ns},{n},{},1", 2 * n))
}

/// Times and readings, bit by bit.
fn bits(campaign: &Campaign) -> Vec<Vec<u64>> {
    let samples = campaign.runs[0].held();
    let columns = [samples.time.clone()].into_iter().chain(samples.readings.iter().cloned());
    columns.map(|column| column.iter().map(|value| value.to_bits()).collect()).collect()
}

fn clock(ns: u64, blank: &str) -> String {
    let of_day = ns / 1_000_000_000 % 86_400;
    let (hour, minute, second) = (of_day / 3600, of_day / 60 % 60, of_day % 60);
    format!("2025/03/26{blank}{hour:02}:{minute:02}:{second:02}.{:09}", ns % 1_000_000_000)
}

const SIGNALS: &str = "signals = [\"stream.csv\"]";

#[test]
fn columns_of_a_list_are_added_with_all_of_their_digits() {
    let single = rows("time [ns],e [m],n [m],u [m]\n", 300, |ns, n| format!("{ns},{n},0,1"));
    let right =
        bits(&load(&format!("data = \"data.csv\"\n{SIGNALS}"), &single, &stream()).unwrap());
    let two =
        |ns: u64, n: u64| format!("{},{},cam0,{n},0,1", ns / 1_000_000_000, ns % 1_000_000_000);
    let plain = rows("", 300, two);
    let named = rows("sec,nanosec,frame,e [m],n [m],u [m]\n", 300, two);
    let with_units = named.replace("sec,nanosec", "sec [s],nanosec [ns]");
    let by_number =
        "columns = { time = [\"1 [s]\", \"2 [ns]\"], e = \"4 [m]\", n = \"5 [m]\", u = \"6 [m]\" }";
    let mut late: Vec<&str> = plain.lines().collect();
    late.swap(17, 18);
    for (columns, data) in [
        (by_number, plain.as_str()),
        (by_number, &late.join("\n")),
        (
            "header = false, columns = { time = [{ column = 2, unit = \"ns\" }, \"1 [s]\"], e = \"4 [m]\", n = \"5 [m]\", u = \"6 [m]\" }",
            &plain,
        ),
        ("columns = { time = [\"sec [s]\", \"nanosec [ns]\"] }", &named),
        ("columns = { time = [\"sec\", \"nanosec\"] }", &with_units),
    ] {
        let run = format!("data = {{ file = \"data.csv\", {columns} }}\n{SIGNALS}");
        let found = load(&run, data, &stream()).unwrap_or_else(|faults| panic!("{run}\n{faults}"));
        assert_eq!(bits(&found), right, "{run}");
    }
    // A part that is missing.
    let run = format!("data = {{ file = \"data.csv\", {by_number} }}\n{SIGNALS}");
    let missing = plain.replacen(",0,cam0,0", ",,cam0,0", 1);
    let fault = load(&run, &missing, &stream()).unwrap_err().to_string();
    assert!(fault.contains("the row has no time"), "{fault}");
}

#[test]
fn a_date_and_the_time_of_day_beside_it_are_one_stamp() {
    let single = rows("time [ns],e [m],n [m],u [m]\n", 300, |ns, n| format!("{ns},{n},0,1"));
    let right =
        bits(&load(&format!("data = \"data.csv\"\n{SIGNALS}"), &single, &stream()).unwrap());
    let with = |head: &str, by: &str| {
        rows(head, 300, |ns, n| format!("{}{by}{n}{by}0{by}1", clock(ns, by)))
    };
    let hyphens = with("day,at,e [m],n [m],u [m]\n", ",").replace('/', "-");
    for (columns, data) in [
        ("columns = { time = \"day\" }", with("day,at,e [m],n [m],u [m]\n", ",")),
        ("columns = { time = \"at\" }", hyphens.clone()),
        ("columns = { time = [\"day\", \"at\"] }", hyphens),
        ("separator = \",\"", with("date,time,e [m],n [m],u [m]\n", ",")),
        ("separator = \" \"", with("time e [m] n [m] u [m]\n", " ")),
        ("columns = { time = \"1\", e = \"3 [m]\", n = \"4 [m]\", u = \"5 [m]\" }", with("", " ")),
        // In one cell.
        (
            "separator = \",\"",
            rows("time,e [m],n [m],u [m]\n", 300, |ns, n| format!("{},{n},0,1", clock(ns, " "))),
        ),
    ] {
        let run = format!("data = {{ file = \"data.csv\", {columns} }}\n{SIGNALS}");
        let found = load(&run, &data, &stream()).unwrap_or_else(|faults| panic!("{run}\n{faults}"));
        assert_eq!(bits(&found), right, "{run}");
    }
    let alone =
        with("time,e [m],n [m],u [m]\n", ",").replace(" ", "").replace(",12:00:00.000000000", "");
    let fault = load(&format!("data = \"data.csv\"\n{SIGNALS}"), &alone, &stream()).unwrap_err();
    assert!(fault.to_string().contains("name the column of the time of day, too"), "{fault}");
}

/// Positions as RTKLIB writes them.
fn receiver() -> String {
    let head = "% program   : RTKPOST\n% (e/n/u-baseline=WGS84,Q=1:fix)\n%  GPST                  e-baseline(m)  n-baseline(m)  u-baseline(m)   Q  ns   sde(m)  age(s)\n";
    rows(head, 300, |ns, n| {
        format!(
            "{}   {n}.5000  -{n}.2500   {:.4}   1   9   0.0069   0.20",
            clock(ns, " "),
            (n as f64).sin()
        )
    })
}

/// Poses as ROS 2 writes them.
fn poses(every: u64) -> String {
    let count = 1200 / every;
    rows("", count, |_, n| {
        let (ns, turn) =
            (NOON * 1_000_000_000 + n * every * 110_000_017, 0.01 * (n * every) as f64);
        let (sec, nanosec) = (ns / 1_000_000_000, ns % 1_000_000_000);
        format!(
            "{sec},{nanosec},map,{:.6},{:.6},{:.6},0.0,0.0,{:.6},{:.6}",
            turn.sin(),
            turn.cos(),
            0.5 + 0.1 * (2.0 * turn).cos(),
            turn.sin(),
            turn.cos()
        )
    })
}

#[test]
fn receivers_and_robots_need_no_word_in_the_campaign() {
    let run = format!("data = \"data.csv\"\n{SIGNALS}");
    let found = load(&run, &receiver(), &stream()).unwrap();
    let samples = found.runs[0].held();
    let single = rows("time [ns],e [m],n [m],u [m]\n", 300, |ns, _| format!("{ns},0,0,0"));
    let right = load(&run, &single, &stream()).unwrap();
    assert_eq!(samples.time, right.runs[0].held().time);
    assert_eq!((samples.readings[0][7], samples.readings[1][7]), (7.5, -7.25));
    let told = found.recognised.join("\n");
    assert!(told.contains("in the format `rtklib`"), "{told}");
    // A robot's poses as the stream.
    let found = load(&run, &receiver(), &poses(1)).unwrap();
    let told = found.recognised.join("\n");
    assert!(told.contains("`stream.csv`: in the format `ros2_pose`, stamps in s"), "{told}");
}

/// The same with names, those of the stamps as stated.
fn with_names(stamps: &str) -> String {
    format!("{stamps},frame,px [m],py [m],pz [m],qx [],qy [],qz [],qw []\n{}", poses(4))
}

#[test]
fn campaigns_are_begun_from_stamps_in_two_columns() {
    let library = Library::builtin().unwrap();
    let model = |name: &str| library.model(name, Path::new("")).unwrap();
    let known = library.models();
    let known: Vec<_> = known.iter().map(|(name, _)| ((*name).to_owned(), model(name))).collect();
    for (data, stream, words) in [
        (
            poses(4),
            poses(1),
            "time = [{ column = 1, unit = \"s\" }, { column = 2, unit = \"ns\" }],",
        ),
        (receiver(), poses(1), "time = { column = \"GPST\" },"),
        (receiver().replace('%', "#"), poses(1), "x = { column = \"e-baseline\", unit = \"m\" },"),
        (
            with_names("time [s],time_nanos [ns]"),
            poses(1),
            "time = [{ column = \"time\", unit = \"s\" }, { column = \"time_nanos\", unit = \"ns\" }],",
        ),
        (
            with_names("stamp_s,stamp_ns"),
            poses(1),
            "time = [{ column = \"stamp_s\", unit = \"s\" }, { column = \"stamp_ns\", unit = \"ns\" }],",
        ),
    ] {
        let folder = Folder::new("begun-stamps", &[("data.txt", &data), ("stream.txt", &stream)]);
        let named = |name: &str| (folder.join(name), PathBuf::from(name));
        let begun = begin(&[named("data.txt"), named("stream.txt")], None, &known, None).unwrap();
        assert!(begun.campaign.contains(words), "{}", begun.campaign);
        std::fs::write(folder.join("campaign.toml"), &begun.campaign).unwrap();
        let file = CampaignFile::read(&folder).unwrap();
        let model = library.model(&file.model.text, &folder).unwrap();
        file.load(&model, &LoadOptions::default()).unwrap_or_else(|faults| panic!("{faults}"));
    }
}

#[test]
fn a_wrong_list_of_columns_is_said_where_it_stands() {
    let data =
        rows("sec [s],nanosec,e [m],n [m],u [m]\n", 3, |_, n| format!("{},0,{n},0,1", NOON + n));
    for (columns, words) in [
        ("time = []", "the list of columns is empty"),
        ("time = [\"sec\", \"sec\"]", "the list has the column `sec` twice"),
        ("time = [\"sec\", [\"nanosec\"]]", "a list in a list"),
        ("time = [\"sec\", { unit = \"ns\" }]", "no column is named here"),
        ("time = [\"sec\", \"nanosec [m]\"]", "`m` is not a unit of `time`"),
        ("e = [\"e\", \"n\"]", "write a formula: e = \"a + b\""),
        ("time = [\"sec\", \"e\"], e = \"e [m]\"", "`time` and `e` name the same column"),
        ("time = { formula = \"sec + nanosec\" }", "time = [\"sec [s]\", \"nanosec [ns]\"]"),
        // To state one unit alone would drop the other column.
        (
            "time = [\"sec\", \"nanosec\"]",
            "give each part of the list its unit: time = [\"sec\", \"nanosec [ns]\"]",
        ),
        (
            "time = [\"sec [s]\", { column = 2 }]",
            "give each part of the list its unit: time = [\"sec [s]\", { column = 2 }]",
        ),
        (
            "time = [\"sec [s]\", { column = 1, unit = \"s\" }]",
            "the list has the column `sec` twice",
        ),
        (
            "time = [\"sec [s]\", \"nanosec [ns]\"], e = { column = 2, unit = \"m\" }",
            "`time` and `e` name the same column, `nanosec`",
        ),
        (
            "time = [\"sec [s]\", \"nanosec [ns]\"], e = \"2 * nanosec\"",
            "`time` and `e` name the same column, `nanosec`",
        ),
    ] {
        let run = format!("data = {{ file = \"data.csv\", columns = {{ {columns} }} }}\n{SIGNALS}");
        let fault = load(&run, &data, &stream()).unwrap_err().to_string();
        assert!(fault.contains(words), "{columns}\n{fault}");
    }
}

#[test]
fn a_stamp_has_one_date_and_one_time_of_day() {
    let moment = |ns: u64| clock(ns, "T");
    let day = |ns: u64| clock(ns, "T")[..10].to_owned();
    let of_day = |ns: u64| clock(ns, "T")[11..].to_owned();
    type Part<'a> = &'a dyn Fn(u64) -> String;
    let parts: [(&str, Part<'_>, Part<'_>); 4] = [
        ("two moments", &moment, &moment),
        ("a moment and a date", &moment, &day),
        ("two dates", &day, &day),
        ("two times of day", &of_day, &of_day),
    ];
    for (case, first, second) in parts {
        let head = "a,b,e [m],n [m],u [m]\n";
        let data = rows(head, 3, |ns, n| format!("{},{},{n},0,1", first(ns), second(ns)));
        let run = format!(
            "data = {{ file = \"data.csv\", columns = {{ time = [\"a\", \"b\"] }} }}\n{SIGNALS}"
        );
        let fault = load(&run, &data, &stream()).unwrap_err().to_string();
        let words = "column `b` has a second date or time of day of the stamp";
        assert!(fault.contains(words), "{case}\n{fault}");
    }
}

#[test]
fn stamps_of_another_zone_are_refused() {
    let run = format!("data = \"data.csv\"\n{SIGNALS}");
    for name in ["JST", "jst"] {
        let data = receiver().replace("GPST", name);
        let fault = load(&run, &data, &stream()).unwrap_err().to_string();
        assert!(fault.contains(&format!("stamps in `{name}` are 9 h ahead of UTC")), "{fault}");
    }
}

#[test]
fn cells_that_are_no_times_are_refused_as_such() {
    let data = rows("time [ns],e [m],n [m],u [m]\n", 3, |ns, _| format!("{ns},-5°C,0,1"));
    let fault = load(&format!("data = \"data.csv\"\n{SIGNALS}"), &data, &stream()).unwrap_err();
    let fault = fault.to_string();
    assert!(fault.contains("expected a number in column `e`, found `-5°C`"), "{fault}");
}

#[test]
fn one_cause_is_one_error() {
    let two = |ns: u64, n: u64| format!("{},{},{n},0,1", ns / 1_000_000_000, ns % 1_000_000_000);
    let (data, named) = (rows("", 3, two), rows("sec,nanosec,e [m],n [m],u [m]\n", 3, two));
    let of_stream = rows("", 400, two);
    let columns = |time: &str, names: [&str; 3]| {
        let [x, y, z] = names;
        format!("columns = {{ {time}, {x} = \"3 [m]\", {y} = \"4 [m]\", {z} = \"5 [m]\" }}")
    };
    let formula = "time = \"sec + nanosec\", sec = \"1 [s]\", nanosec = \"2 [ns]\"";
    let list = "time = [\"1 [s]\", \"2 [ns]\"]";
    let (own, inputs) = (["e", "n", "u"], ["px", "py", "pz"]);
    let run = |of_data: &str, of_stream: &str| {
        format!(
            "data = {{ file = \"data.csv\", {of_data} }}\nsignals = [{{ file = \"stream.csv\", {of_stream} }}]"
        )
    };
    for (run, data, count, words) in [
        (
            run(&columns(formula, own), &columns(formula, inputs)),
            &data,
            2,
            "the time is a column, not a formula: name it",
        ),
        (
            run(&columns(list, own), &columns("time = \"9 [s]\"", inputs)),
            &data,
            1,
            "`stream.csv` has no column `9`",
        ),
        (
            run(
                &columns(list, own),
                "columns = { px = \"3 [m]\", py = \"4 [m]\", pz = \"5 [m]\" }",
            ),
            &data,
            1,
            "the stream `stream.csv` has no column `time [s]`",
        ),
        (
            run("columns = { time = \"1 [s]\" }", &columns(list, inputs)),
            &named,
            1,
            "say `header = false` beside `file`",
        ),
    ] {
        let faults = load(&run, data, &of_stream).unwrap_err();
        assert!(faults.to_string().contains(words), "{run}\n{faults}");
        assert_eq!(faults.0.len(), count, "{run}\n{faults}");
    }
}
