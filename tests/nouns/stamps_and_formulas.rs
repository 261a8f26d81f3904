//! Stamps that begin anew, columns computed from others, and which rows a range of delays needs.

use homepoint::campaign::file::CampaignFile;
use homepoint::campaign::load::Campaign;
use homepoint::campaign::loaded::LoadOptions;
use homepoint::diagnostic::{Diagnostics, Source};
use homepoint::model::Model;

use crate::folder::Folder;

const MODEL: &str = "name = \"line\"\ntitle = \"line\"\n[inputs]\nq = { unit = \"rad\", signal = true }\n\
    [parameters]\nc = { unit = \"rad\", scope = \"rig\" }\n[measurands]\n\
    x = { value = 'q + c', unit = \"deg\", sigma = \"1 mrad\" }\ny = { value = '2 * q', unit = \"deg\", sigma = \"1 mrad\" }\n\
    [delays]\ncamera = { of = [\"x\"] }\n";

/// A campaign with these lines at its top and in its run.
fn load(top: &str, run: &str, data: &str, stream: &str) -> Result<Campaign, Diagnostics> {
    load_with(&LoadOptions::default(), top, run, data, stream)
}

/// The same without bad rows.
fn load_leniently(top: &str, run: &str, data: &str, stream: &str) -> Result<Campaign, Diagnostics> {
    let options = LoadOptions { skip_bad_rows: true, ..LoadOptions::default() };
    load_with(&options, top, run, data, stream)
}

fn load_with(
    options: &LoadOptions,
    top: &str,
    run: &str,
    data: &str,
    stream: &str,
) -> Result<Campaign, Diagnostics> {
    let named = |key: &str| run.contains(&format!("{key} ="));
    let data_line = if named("data") { "" } else { "data = \"data.csv\"\n" };
    let stream_line = if named("signals") { "" } else { "signals = [\"stream.csv\"]\n" };
    let campaign = format!(
        "model = \"line.toml\"\n{top}\n[[runs]]\nname = \"one\"\n{data_line}{stream_line}{run}\n"
    );
    let files = [
        ("line.toml", MODEL),
        ("campaign.toml", &campaign),
        ("data.csv", data),
        ("stream.csv", stream),
    ];
    let folder = Folder::new("stamps", &files);
    let model = Model::parse(Source::new("line.toml", MODEL)).unwrap();
    CampaignFile::read(&folder)?.load(&model, options)
}

fn rows(head: &str, count: usize, row: impl Fn(usize) -> String) -> String {
    (0..count).fold(format!("{head}\n"), |text, n| text + &row(n) + "\n")
}

/// A stream at 100 Hz from 0 s on.
fn stream(seconds: f64) -> String {
    let angle = |n: usize| (0.02 * n as f64).sin();
    rows("time [s],q [rad]", (100.0 * seconds) as usize, |n| {
        format!("{:.2},{:.6}", 0.01 * n as f64, angle(n))
    })
}

fn numbers(campaign: &Campaign) -> String {
    let samples = campaign.runs[0].held();
    format!("{:.9?} {:.9?}", samples.time, samples.readings)
}

#[test]
fn stamps_of_a_counter_that_begins_anew_go_on_where_it_is_stated() {
    // 7 ms apart: a counter of 16 bits begins anew after 65.536 s, 9 times in 600 s.
    let plain = |unit: &str, size: f64| {
        rows(&format!("time [{unit}],x [deg]"), 85_000, |n| {
            format!("{},{:.4}", (7.0 * n as f64) % size, 0.001 * n as f64)
        })
    };
    let right_text = plain("ms", 1e12);
    let right = load("", "", &right_text, &stream(600.0)).unwrap();
    let wrapped = plain("ms", 65_536.0);
    let stated = "data = { file = \"data.csv\", wraps = \"65536 ms\" }";
    let found = load("", stated, &wrapped, &stream(600.0)).unwrap();
    assert_eq!(numbers(&found), numbers(&right));
    assert!(found.warnings.is_empty(), "{:?}", found.warnings);
    // Two rows that came late about where the counter begins anew.
    let mut late: Vec<&str> = wrapped.lines().collect();
    late.swap(9363, 9364);
    late.swap(20_000, 20_001);
    let found = load("", stated, &late.join("\n"), &stream(600.0)).unwrap();
    assert_eq!(numbers(&found), numbers(&right));
    // A stamp that is wrong is no lap: it is reported, or left out, and the others keep their times.
    let mut bad: Vec<&str> = wrapped.lines().collect();
    bad[14_001] = "3,0";
    let bad = bad.join("\n");
    let faults = load("", stated, &bad, &stream(600.0)).unwrap_err();
    assert_eq!((faults.0.len(), faults.0[0].place.as_ref().unwrap().line), (1, 14_002), "{faults}");
    assert!(faults.to_string().contains("the stamp 0.003 s leaps"), "{faults}");
    let found = load_leniently("", stated, &bad, &stream(600.0)).unwrap();
    let mut without: Vec<&str> = right_text.lines().collect();
    without.remove(14_001);
    let without = load("", "", &without.join("\n"), &stream(600.0)).unwrap();
    assert_eq!((numbers(&found), found.skipped_count), (numbers(&without), 1));
    // What is not stated is offered, with the line to type.
    for (text, words) in [
        (wrapped, "wraps = \"65536 ms\""),
        (plain("ms", 60_000.0), "wraps = \"60 s\""),
        (plain("us", 65_536.0), "wraps = \"65536 us\""),
        (plain("us", 100_000.0), "wraps = \"100000 us\""),
    ] {
        let faults = load("", "", &text, &stream(600.0)).unwrap_err();
        assert!(faults.to_string().contains(words), "{faults}");
        assert_eq!(faults.0.len(), 1, "{faults}");
    }
    // A day of seconds that ends at midnight, in a stream.
    let at_midnight = stream(600.0).lines().enumerate().fold(String::new(), |text, (n, line)| {
        let Some((time, angle)) = line.split_once(',').filter(|_| n > 0) else {
            return format!("{line}\n");
        };
        let time: f64 = time.parse().unwrap();
        text + &format!("{:.2},{angle}\n", (time + 86_300.0) % 86_400.0)
    });
    let data = rows("time [s],x [deg]", 500, |n| format!("{},1", 86_300 + n));
    let stated = "signals = [{ file = \"stream.csv\", wraps = \"24 h\" }]";
    let found = load("", stated, &data, &at_midnight).unwrap();
    let read = found.runs[0].held().readings[0].iter().filter(|one| !one.is_nan()).count();
    assert_eq!(read, 499, "all but the first, which is at the end of the stream");
    let fault = load("", "data = { file = \"data.csv\", wraps = \"0 s\" }", &data, "").unwrap_err();
    assert!(fault.to_string().contains("wraps must be greater than zero"), "{fault}");
}

#[test]
fn a_column_may_be_a_formula_of_others_with_their_units() {
    let head = "time [s],elevation [deg],turns [turn],y [deg]";
    let data =
        rows(head, 20, |n| format!("{},{},{},{}", n, 2 * n, n, if n == 3 { "" } else { "5" }));
    let plain = rows("time [s],x [deg],y [deg]", 20, |n| {
        format!("{n},{},{}", 90 - 2 * n, if n == 3 { "" } else { "5" })
    });
    let right = load("", "", &plain, &stream(30.0)).unwrap();
    for run in [
        "columns = { x = \"90 deg - elevation\" }",
        "columns = { x = { formula = \"100 gon - elevation\" } }",
        "columns = { x = 'atan2(cos(elevation), sin(elevation))' }",
        "columns = { x = \"90 deg - up\", up = { column = 2, unit = \"deg\" } }",
        "data = { file = \"data.csv\", columns = { x = \"90 deg - up\", up = \"elevation\" } }",
    ] {
        let found = load("", run, &data, &stream(30.0)).unwrap_or_else(|f| panic!("{run}\n{f}"));
        assert_eq!(numbers(&found), numbers(&right), "{run}");
    }
    // A name that the model has, too; rows out of order; a missing reading.
    let own = data
        .replace("elevation", "x")
        .replace("\n7,14,7,5", "")
        .replace("\n9,18", "\n9,18,9,5\n7,14");
    let own = own.replace("9,18,9,5\n7,14,9,5", "9,18,9,5\n7,14,7,5");
    let found = load("", "columns = { x = \"90 deg - x\" }", &own, &stream(30.0)).unwrap();
    assert_eq!(numbers(&found), numbers(&right));
    let missing = data.replace("\n5,10,", "\n5,,");
    let found =
        load("", "columns = { x = \"90 deg - elevation\" }", &missing, &stream(30.0)).unwrap();
    assert!(found.runs[0].held().readings[0][5].is_nan());
    // A column that is called like a formula is that column.
    let odd = plain.replace("x [deg]", "90-elevation [deg]");
    let found = load("", "columns = { x = \"90-elevation\" }", &odd, &stream(30.0)).unwrap();
    assert_eq!(numbers(&found), numbers(&right));
    for (run, words) in [
        ("columns = { x = \"90 - elevation\" }", "`90` has no unit beside an angle"),
        ("columns = { x = \"2 * 3 + elevation / (1 deg)\" }", ""),
        ("columns = { x = \"1 m - elevation\" }", "a length"),
        ("columns = { x = \"90 deg - elevatoin\" }", "has a column `90 deg - elevatoin`"),
        ("columns = { x = { formula = \"90 deg -\" } }", ""),
        (
            "columns = { x = { formula = \"90 deg - elevation\", unit = \"deg\" } }",
            "neither column nor unit",
        ),
        (
            "columns = { x = { formula = '[elevation, elevation, elevation]' } }",
            "a vector of plain numbers",
        ),
        ("columns = { x = '1 deg / (turns / (1 turn) - 4)' }", "no value here"),
        ("columns = { time = \"time + 1 s\" }", "has a column `time + 1 s`"),
        ("columns = { time = { formula = \"time + 1 s\" } }", "the time is a column"),
    ] {
        match load("", run, &data, &stream(30.0)) {
            Err(faults) => assert!(faults.to_string().contains(words), "{run}\n{faults}"),
            Ok(_) => assert!(words.is_empty(), "{run}"),
        }
    }
}

/// Of clocks that are two hours apart, and of leap seconds, the range to write is proposed; with it the
/// samples are read.
#[test]
fn clocks_that_are_far_apart_have_a_range_of_delays_proposed() {
    for (apart, zone, range) in [
        (7200.0, true, "delay_range = [\"-7205 s\", \"-7195 s\"]"),
        (-5400.0, true, "delay_range = [\"5395 s\", \"5405 s\"]"),
        (137.0, false, "delay_range = [\"-142 s\", \"-132 s\"]"),
    ] {
        let data =
            rows("time [s],x [deg],y [deg]", 400, |n| format!("{:.1},1,1", apart + 0.1 * n as f64));
        let fault = load("", "", &data, &stream(40.0)).unwrap_err().to_string();
        assert!(fault.contains(range) && fault.contains("a time zone?") == zone, "{fault}");
        let read = load(range, "", &data, &stream(60.0)).unwrap();
        let there = read.runs[0].held().readings[0].iter().filter(|x| !x.is_nan()).count();
        assert!(there > 300, "{there}");
    }
}

#[test]
fn a_range_of_delays_leaves_out_the_rows_that_it_cannot_use() {
    // Data from 0 to 100 s, a stream from 0 to 60 s.
    let data = rows("time [s],x [deg],y [deg]", 1000, |n| format!("{:.1},1,1", 0.1 * n as f64));
    let read = |top: &str| {
        let found = load(top, "", &data, &stream(60.0)).unwrap();
        let count = |column: usize| {
            let samples = found.runs[0].held();
            let all = samples.time.iter().zip(&samples.readings[column]);
            let read: Vec<f64> = all.filter(|(_, x)| !x.is_nan()).map(|(t, _)| *t).collect();
            [read.first().copied(), read.last().copied()]
                .map(|t| (10.0 * t.unwrap()).round() / 10.0)
        };
        [count(0), count(1)]
    };
    let fault = load("", "", &data, &stream(40.0)).unwrap_err().to_string();
    assert!(fault.contains("lie outside its streams"), "{fault}");
    assert!(!fault.contains("clocks"), "{fault}");
    assert_eq!(read("delay_range = \"1 s\""), [[1.0, 58.9]; 2]);
    assert_eq!(read("delay_range = [\"-8 s\", \"-4 s\"]"), [[8.0, 63.9]; 2]);
    assert_eq!(read("delay_range = [\"0 s\", \"500 ms\"]"), [[0.0, 59.4]; 2]);
    let named = read("delay_range = { camera = [\"-8 s\", \"-4 s\"], \"y.delay\" = \"2 s\" }");
    assert_eq!(named, [[8.0, 63.9], [2.0, 57.9]]);
    let found = load("delay_range = [\"-8 s\", \"-4 s\"]", "", &data, &stream(60.0)).unwrap();
    let why = &found.left_out[0].why;
    assert!(why.contains("from -8.000 s to -4.000 s") && why.contains("delay_range"), "{why}");
    for (top, words) in [
        ("delay_range = [\"-4 s\", \"-8 s\"]", "not in order"),
        ("delay_range = [\"4 s\"]", "two ends"),
        ("delay_range = [\"-4 m\", \"8 m\"]", "`m` is not a unit"),
        ("delay_range = { x = \"2 s\" }", "unknown delay `x`"),
        ("delay_range = { camra = \"2 s\" }", "did you mean `camera`?"),
    ] {
        let fault = load(top, "", &data, &stream(60.0)).unwrap_err().to_string();
        assert!(fault.contains(words), "{top}\n{fault}");
    }
}

#[test]
fn a_clock_that_was_set_forward_is_told_where_no_rows_are_lost() {
    let data = |by: f64| {
        rows("time [s],x [deg]", 2000, |n| {
            format!("{:.4},1", 1.0 + 0.01 * n as f64 + if n < 900 { 0.0 } else { by })
        })
    };
    let told = |by: f64, stream: &str| {
        let found = load("", "", &data(by), stream).unwrap();
        found.warnings.iter().map(|one| one.message.clone()).collect::<Vec<_>>().join("\n")
    };
    let found = told(0.083, &stream(30.0));
    assert!(
        found.contains("run `one`: `data.csv`: time jumps by 0.093000 s at row 902"),
        "{found}"
    );
    assert_eq!(found.lines().count(), 1);
    assert_eq!(told(0.08, &stream(30.0)), "", "rows were lost");
    // The stream has the same pause.
    let paused = stream(30.0).lines().enumerate().fold(String::new(), |text, (n, line)| {
        let Some((time, angle)) = line.split_once(',').filter(|_| n > 1000) else {
            return text + line + "\n";
        };
        text + &format!("{:.4},{angle}\n", time.parse::<f64>().unwrap() + 0.083)
    });
    assert_eq!(told(0.083, &paused), "");
    let found = told(0.0, &paused);
    assert!(found.contains("`stream.csv`: time jumps by 0.093000 s at row 1002"), "{found}");
}

#[test]
fn a_count_that_begins_anew_is_offered_its_period() {
    let model = MODEL.replace("q = { unit = \"rad\"", "q = { unit = \"count\"");
    let encoder = |size: f64| {
        rows("time [s],q [count]", 3000, |n| {
            format!("{:.2},{}", 0.01 * n as f64, (40.0 * n as f64) % size)
        })
    };
    let data = rows("time [s],x [deg]", 200, |n| format!("{:.1},1", 1.0 + 0.1 * n as f64));
    let told = |inputs: &str, stream: &str| {
        let campaign = format!(
            "model = \"line.toml\"\n{inputs}\n[[runs]]\nname = \"one\"\ndata = \"data.csv\"\nsignals = [\"stream.csv\"]\n"
        );
        let files = [
            ("line.toml", model.as_str()),
            ("campaign.toml", &campaign),
            ("data.csv", &data),
            ("stream.csv", stream),
        ];
        let folder = Folder::new("counts", &files);
        let model = Model::parse(Source::new("line.toml", model.as_str())).unwrap();
        let file = CampaignFile::read(&folder).unwrap();
        let found = file.load(&model, &LoadOptions::default()).unwrap();
        found.warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
    };
    let found = told("", &encoder(65_536.0));
    assert!(found.contains("`[inputs] q = { period = \"65536 count\" }`"), "{found}");
    assert_eq!(told("[inputs]\nq = { period = \"65536 count\" }", &encoder(65_536.0)), "");
    assert_eq!(told("", &encoder(1e9)), "");
}
