//! Rows that are not in the order of time, and one log that is data and stream at once.

use homepoint::campaign::file::CampaignFile;
use homepoint::campaign::load::Campaign;
use homepoint::campaign::loaded::LoadOptions;
use homepoint::diagnostic::{Diagnostics, Source};
use homepoint::model::Model;

use crate::folder::Folder;

const MODEL: &str = "name = \"line\"\ntitle = \"line\"\n[inputs]\nq = { unit = \"m\", signal = true }\n\
    [parameters]\nc = { unit = \"m\", scope = \"rig\" }\n[measurands]\nx = { value = 'q + c', unit = \"m\" }\n";
const CAMPAIGN: &str = "model = \"line.toml\"\n[measurands]\nx = { sigma = \"1 mm\" }\n\
    [[runs]]\nname = \"one\"\ndata = \"data.csv\"\nsignals = [\"stream.csv\"]\n";

fn load(campaign: &str, data: &str, stream: &str, skip: bool) -> Result<Campaign, Diagnostics> {
    let files = [
        ("line.toml", MODEL),
        ("campaign.toml", campaign),
        ("data.csv", data),
        ("stream.csv", stream),
    ];
    let folder = Folder::new("order", &files);
    let options = LoadOptions { skip_bad_rows: skip, ..LoadOptions::default() };
    let model = Model::parse(Source::new("line.toml", MODEL)).unwrap();
    CampaignFile::read(&folder)?.load(&model, &options)
}

/// Rows `number, x`, each at its time.
fn rows(head: &str, numbers: impl Iterator<Item = usize>) -> String {
    let row = |n: usize| format!("{:.2},{:.4}\n", 0.01 * n as f64, (0.02 * n as f64).sin());
    format!("{head}\n{}", numbers.map(row).collect::<String>())
}

/// Two writers: the rows of one come 7 rows late.
fn interleaved(count: usize) -> impl Iterator<Item = usize> {
    (0..count + 14).flat_map(move |n| {
        let early = (n < count && n % 2 == 0).then_some(n);
        let late = n.checked_sub(14).filter(|n| n % 2 == 1);
        early.into_iter().chain(late)
    })
}

fn said(campaign: &Campaign) -> Vec<String> {
    campaign.warnings.iter().map(|one| one.message.clone()).collect()
}

#[test]
fn interleaved_rows_of_data_and_streams_are_sorted_with_one_warning_a_file() {
    // More rows than one block has: the first block of the data is in order.
    let count = 30_000;
    let in_order = 0..14_000;
    let data = || in_order.clone().chain(interleaved(count).filter(|n| *n >= 14_000));
    for skip in [false, true] {
        let stream = rows("time [s],q [m]", interleaved(count));
        let found = load(CAMPAIGN, &rows("time [s],x [m]", data()), &stream, skip).unwrap();
        let straight = rows("time [s],q [m]", 0..count);
        let right = load(CAMPAIGN, &rows("time [s],x [m]", 0..count), &straight, skip).unwrap();
        let (found_run, right_run) = (found.runs[0].held(), right.runs[0].held());
        assert_eq!(found_run.time, right_run.time);
        assert_eq!(format!("{:?}", found_run.readings), format!("{:?}", right_run.readings));
        assert_eq!((found.skipped_count, said(&right).len()), (0, 0));
        let said = said(&found);
        assert_eq!(said.len(), 2, "{said:?}");
        assert!(said.iter().any(|one| one.contains("`data.csv`: time goes back")), "{said:?}");
        assert!(said.iter().all(|one| one.contains("the rows were sorted by time")), "{said:?}");
    }
}

#[test]
fn rows_that_repeat_another_one_are_left_out_once_the_rows_are_sorted() {
    let stream = rows("time [s],q [m]", 0..400);
    let data = rows("time [s],x [m]", (0..300).chain([120, 121]).chain(300..400));
    let found = load(CAMPAIGN, &data, &stream, false).unwrap();
    assert_eq!(found.runs[0].held().time.len(), 400);
    let told = said(&found);
    let words = "`data.csv`: 2 rows that repeat another one, stamp and values, were left out";
    assert!(told.iter().any(|one| one == words), "{told:?}");
    // The same of a file in order, over its blocks; and of a stream.
    let count = 20_000;
    let twice = |n: usize| std::iter::repeat_n(n, 1 + usize::from(n % 3 == 1));
    let data = rows("time [s],x [m]", (0..count).flat_map(twice));
    let stream = rows("time [s],q [m]", (0..count).flat_map(twice));
    let found = load(CAMPAIGN, &data, &stream, false).unwrap();
    assert_eq!(found.runs[0].held().time.len(), count);
    let told = said(&found);
    for file in ["data.csv", "stream.csv"] {
        let words = format!("`{file}`: 6667 rows that repeat another one");
        assert!(told.iter().any(|one| one.starts_with(&words)), "{told:?}");
    }
    // Of the same stamp, but another value; and without values.
    let head = "time [s],x [m]\n1,0\n1.01,1\n1.01,2\n1.02,\n1.02,\n1.03,1\n";
    let found = load(CAMPAIGN, head, &rows("time [s],q [m]", 0..400), false).unwrap();
    assert_eq!(found.runs[0].held().time.len(), 6);
    assert!(said(&found).iter().all(|one| !one.contains("repeat")), "{:?}", said(&found));
}

/// Logs that were put together repeat their header row; another header is a fault.
#[test]
fn lines_that_repeat_the_header_row_are_passed_over() {
    let stream = rows("time [s],q [m]", 0..400);
    let both = |second: &str| {
        let (first, rest) = ("time [s],x [m]\n1,0\n1.01,1\n", "1.02,1\n1.03,1\n");
        load(CAMPAIGN, &format!("{first}{second}\n{rest}"), &stream, false)
    };
    let found = both("time [s],x [m]").unwrap();
    assert_eq!(found.runs[0].held().time.len(), 4);
    let words = "`data.csv`: line 4 repeats the header row and was passed over";
    assert!(said(&found).iter().any(|one| one == words), "{:?}", said(&found));
    assert!(both("time [s],x [mm]").is_err());
}

#[test]
fn a_clock_that_was_set_and_a_counter_that_wraps_are_one_error_with_the_row() {
    let stream = rows("time [s],q [m]", 0..400);
    let data = |time: &dyn Fn(usize) -> f64, unit: &str| {
        let rows: String = (0..400).map(|n| format!("{:.3},0\n", time(n))).collect();
        format!("time [{unit}],x [m]\n{rows}")
    };
    let set = data(&|n| 0.01 * n as f64 - if n < 200 { 0.0 } else { 0.5 }, "s");
    let twice = data(&|n| 0.01 * n as f64 - 0.5 * (n / 150) as f64, "s");
    let wraps = data(&|n| (n * 700 % 65_536) as f64, "ms");
    for skip in [false, true] {
        let faults = load(CAMPAIGN, &set, &stream, skip).unwrap_err();
        assert_eq!((faults.0.len(), faults.0[0].place.as_ref().unwrap().line), (1, 202));
        assert!(faults.to_string().contains("time goes back once, here by 0.490000 s"), "{faults}");
        let faults = load(CAMPAIGN, &twice, &stream, skip).unwrap_err();
        assert!(faults.to_string().contains("time goes back 2 times, here by"), "{faults}");
        assert_eq!((faults.0.len(), faults.0[0].place.as_ref().unwrap().line), (1, 152));
        let faults = load(CAMPAIGN, &wraps, &stream, skip).unwrap_err();
        assert!(faults.to_string().contains("wraps = \"65536 ms\""), "{faults}");
    }
}

/// Rows that were written twice are no readings of another moment: none of them is to be kept.
#[test]
fn rows_that_were_written_twice_are_named_with_those_that_they_repeat() {
    let straight = rows("time [s],q [m]", 0..400);
    let pasted = || (0..140).chain(100..140).chain(140..400);
    let whole = || (0..400).chain(0..400);
    let of_data = |numbers: Box<dyn Iterator<Item = usize>>| {
        load(CAMPAIGN, &rows("time [s],x [m]", numbers), &straight, false).unwrap_err()
    };
    let faults = of_data(Box::new(pasted()));
    let words = "rows 142 to 181 repeat rows 102 to 141, stamps and values";
    assert!(faults.to_string().contains(words), "{faults}");
    assert_eq!((faults.0.len(), faults.0[0].place.as_ref().unwrap().line), (1, 142));
    assert!(faults.0[0].help[0].contains("delete rows 142 to 181"), "{faults}");
    let faults = of_data(Box::new(whole()));
    assert!(faults.to_string().contains("rows 402 to 801 repeat rows 2 to 401"), "{faults}");
    let stream = rows("time [s],q [m]", pasted());
    let faults = load(CAMPAIGN, &rows("time [s],x [m]", 0..400), &stream, false).unwrap_err();
    assert!(faults.to_string().contains(words), "{faults}");
}

#[test]
fn a_sign_alone_and_a_file_without_rows_say_what_to_write() {
    let stream = rows("time [s],q [m]", 0..400);
    let campaign = CAMPAIGN.replace(
        "\"data.csv\"",
        "{ file = \"data.csv\", columns = { x = { column = \"Ist\", unit = \"m\" } } }",
    );
    let said = |data: &str| load(&campaign, data, &stream, false).unwrap_err().0.remove(0);
    let fault = said("time [s],Ist\n1,+\n2,1\n");
    assert!(fault.help[0].contains("1 for `+` and -1 for `-`"), "{fault:?}");
    let fault = said("Report;\nPart;A\ntime [s];Ist\n");
    assert!(fault.help.iter().any(|help| help.contains("no row of the file holds a number")));
    let fault = said("% time,Ist\n");
    assert!(fault.message.contains("all of its lines are comments"), "{fault:?}");
}

/// A column that is there without a number in it is no column that is not there.
#[test]
fn a_column_without_readings_is_warned_of() {
    let model = MODEL.to_owned() + "y = { value = 'q - c', unit = \"m\", sigma = \"1 mm\" }\n";
    let data: String = (0..300).map(|n| format!("{:.2},{n},nan\n", 0.01 * f64::from(n))).collect();
    let campaign = CAMPAIGN.replace("\"data.csv\"", "{ file = \"data.csv\", missing = [\"nan\"] }");
    let files = [
        ("line.toml", model.as_str()),
        ("campaign.toml", campaign.as_str()),
        ("data.csv", &format!("time [s],x [m],y [m]\n{data}")),
        ("stream.csv", &rows("time [s],q [m]", 0..400)),
    ];
    let folder = Folder::new("empty", &files);
    let model = Model::parse(Source::new("line.toml", model.as_str())).unwrap();
    let found = CampaignFile::read(&folder).unwrap().load(&model, &LoadOptions::default()).unwrap();
    let words = "run `one`: all readings of `y` are missing in `data.csv`";
    assert!(said(&found).iter().any(|one| one == words), "{:?}", said(&found));
    // Nor is it where no column has one.
    let empty: String = (0..300).map(|n| format!("{:.2},\n", 0.01 * f64::from(n))).collect();
    let stream = rows("time [s],q [m]", 0..400);
    let found = load(CAMPAIGN, &format!("time [s],x [m]\n{empty}"), &stream, false).unwrap();
    let words = "run `one`: all readings of `x` are missing in `data.csv`";
    assert!(said(&found).iter().any(|one| one == words), "{:?}", said(&found));
}

/// A fault says what to write, or which file to look at.
#[test]
fn faults_of_logs_have_a_remedy() {
    let stream = rows("time [s],q [m]", 0..400);
    let data = rows("time [s],x [m]", 0..300);
    let of = |data: &str, stream: &str| {
        load(CAMPAIGN, data, stream, false).map(|_| ()).unwrap_err().to_string()
    };
    let found = of(&data.replace("time [s],x [m]", "time,x\ns,pounds"), &stream);
    assert!(found.contains("the row below has an unknown unit `pounds`"), "{found}");
    let thousands = "time [s];x [m]\n0,0;1,5\n0,1;1.512,0\n0,2;1,7\n";
    let found = of(thousands, &stream);
    assert!(found.contains("write it without separators of thousands: `1512,0`"), "{found}");
    let empty: String = (0..400).map(|n| format!("{:.2},\n", 0.01 * f64::from(n))).collect();
    let found = of(&data, &format!("time [s],q [m]\n{empty}"));
    assert!(found.contains("no row of the file has a number in the column of `q`"), "{found}");
}

#[test]
fn one_log_is_data_and_stream_at_once() {
    let log: String = (0..400)
        .map(|n| {
            let (time, sent) = (0.01 * f64::from(n), (0.02 * f64::from(n)).sin());
            // Readings come more often than positions are sent.
            let sent = if n % 3 == 0 { format!("{sent:.5}") } else { String::new() };
            format!("{time:.2},{sent},{:.5},0\n", 0.5 * time)
        })
        .collect();
    let log = format!("time [s],q [m],x [m],other\n{log}");
    let one = CAMPAIGN.replace("signals = [\"stream.csv\"]", "signals = [\"./data.csv\"]");
    let found = load(&one, &log, "", false).unwrap();
    // The same of two files.
    let cut = |keep: usize| {
        let line = |line: &str| {
            let cells: Vec<&str> = line.split(',').collect();
            format!("{},{}\n", cells[0], cells[keep])
        };
        log.lines().map(line).collect::<String>()
    };
    let right = load(CAMPAIGN, &cut(2), &cut(1), false).unwrap();
    let text = |campaign: &Campaign| format!("{:?}", campaign.runs[0].held());
    assert_eq!(text(&found), text(&right));
    let said = said(&found);
    assert_eq!(said.len(), 1, "{said:?}");
    assert!(said[0].contains("the column `other` is not used"), "{said:?}");
}
