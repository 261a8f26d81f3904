//! Lines before the header of a table, as measuring programs write them: passed over where the header
//! is seen behind them, or stated.

use std::fs;
use std::path::PathBuf;

use homepoint::campaign::begin::begin;
use homepoint::campaign::file::CampaignFile;
use homepoint::campaign::load::Campaign;
use homepoint::campaign::loaded::LoadOptions;
use homepoint::diagnostic::{Diagnostics, Source};
use homepoint::model::Model;

use crate::folder::Folder;

const MODEL: &str = "name = \"head\"\ntitle = \"Head\"\n[parameters]\nzero = { unit = \"rad\" }\n\
    [measurands]\npan = { value = 'zero', unit = \"rad\", sigma = \"1 mrad\" }\n\
    tilt = { value = 'zero', unit = \"rad\", sigma = \"1 mrad\" }\n";

/// A table of stamps and two angles with something before its rows.
fn table(before: &str, separator: &str) -> String {
    let row = |n: usize| [0.5 * n as f64, 0.25 + n as f64, 0.125 - n as f64];
    let rows = (0..30).map(|n| row(n).map(|cell| format!("{cell:.3}")).join(separator) + "\n");
    before.to_owned() + &rows.collect::<String>()
}

fn load(data: &str, table: &str) -> Result<Campaign, Diagnostics> {
    let campaign = format!("model = \"head.toml\"\n[[runs]]\nname = \"one\"\ndata = {data}\n");
    let files = [("head.toml", MODEL), ("campaign.toml", campaign.as_str()), ("data.csv", table)];
    let folder = Folder::new("preambles", &files);
    let model = Model::parse(Source::new("head.toml", MODEL)).unwrap();
    CampaignFile::read(&folder)?.load(&model, &LoadOptions::default())
}

/// Stamps and readings (SI) of a campaign.
fn numbers(campaign: &Campaign) -> Vec<[f64; 3]> {
    let mut all = Vec::new();
    campaign.runs[0].record.walk(|stretch| {
        let samples = stretch.samples;
        for at in stretch.range() {
            let [pan, tilt] = [0, 1].map(|column| samples.readings[column][at]);
            all.push([samples.time[at], pan, tilt]);
        }
    });
    all
}

const HEADER: &str = "time [s],pan [deg],tilt [deg]\n";

/// Forms of exports: what comes before the rows, what separates cells, and the line of the header.
const FORMS: [(&str, &str, usize); 7] = [
    ("Pan and tilt, Tuesday\ntime [s],pan [deg],tilt [deg]\n", ",", 2),
    ("Pan and tilt\n\n\ntime [s],pan [deg],tilt [deg]\n", ",", 4),
    ("Device,PT-9\nRate,100\nMade,2024-03-07\ntime [s],pan [deg],tilt [deg]\n", ",", 4),
    ("Device,PT-9,\nRate,100,\n,,\ntime [s],pan [deg],tilt [deg]\n", ",", 4),
    ("NO_OF_FRAMES\t30\nMARKERS\tpan\ttilt\ntime [s]\tpan [deg]\ttilt [deg]\n", "\t", 3),
    ("Joints\n100\ntime,pan,tilt\ns,deg,deg\n", ",", 3),
    (
        "Format Version,1.23,Take,A,Rate,100.0,Length,mm\n\n,Joint,Joint\n,one,two\n,\"1A\",\"2B\"\ntime [s],pan [deg],tilt [deg]\n",
        ",",
        6,
    ),
];

#[test]
fn lines_before_the_header_are_passed_over() {
    let due = numbers(&load("\"data.csv\"", &table(HEADER, ",")).unwrap());
    assert_eq!(due.len(), 30);
    for (before, separator, line) in FORMS {
        let text = table(before, separator);
        let stated = format!("{{ file = \"data.csv\", header = {line} }}");
        for data in ["\"data.csv\"", &stated] {
            let found = load(data, &text).map_err(|faults| format!("{before}: {faults:?}"));
            assert_eq!(numbers(&found.unwrap()), due, "{data}: {before}");
        }
    }
}

/// The line that is stated counts, not what looks like a header.
#[test]
fn a_stated_header_is_in_its_line() {
    let text = table("time [s],tilt [deg],pan [deg]\ntime [s],pan [deg],tilt [deg]\n", ",");
    let due = numbers(&load("\"data.csv\"", &table(HEADER, ",")).unwrap());
    let second = load("{ file = \"data.csv\", header = 2 }", &text).unwrap();
    assert_eq!(numbers(&second), due);
    // More lines than are looked through.
    let far = table(&("setting = on\n".repeat(300) + HEADER), ",");
    let stated = load("{ file = \"data.csv\", header = 301 }", &far).unwrap();
    assert_eq!(numbers(&stated), due);
}

#[test]
fn what_is_no_header_row_is_refused() {
    let text = table(&format!("Title\n\n{HEADER}"), ",");
    let message = |header: &str, text: &str| {
        let data = format!("{{ file = \"data.csv\", header = {header} }}");
        load(&data, text).unwrap_err().0[0].message.clone()
    };
    for header in ["0", "-3", "5000"] {
        assert_eq!(message(header, &text), "there is no such line for a header row", "{header}");
    }
    assert_eq!(
        message("\"first\"", &text),
        "expected true, false or the number of its line, found a text"
    );
    for header in ["2", "900"] {
        assert_eq!(message(header, &text), format!("there is no header row in line {header}"));
    }
    for (header, text) in [("3", ""), ("3", "Title\nA\n"), ("2", "Title\nA\n"), ("1", "Title\n")] {
        assert!(load(&format!("{{ file = \"data.csv\", header = {header} }}"), text).is_err());
        assert!(load("\"data.csv\"", text).is_err(), "{text}");
    }
}

/// A row behind the header that holds neither numbers nor units is a bad row, as ever.
#[test]
fn of_two_rows_of_names_the_first_is_the_header() {
    let text = table(&format!("{HEADER}sec,degrees,degrees\n"), ",");
    let fault = load("\"data.csv\"", &text).unwrap_err().0.swap_remove(0);
    assert_eq!(fault.place.unwrap().line, 2, "{}", fault.message);
}

/// No reading is passed over: words among the first rows are bad rows, also where they look like
/// another header.
#[test]
fn words_among_the_first_rows_hide_no_row() {
    let rows = table("", ",");
    let (first, rest) = rows.split_at(rows.match_indices('\n').nth(2).unwrap().0 + 1);
    for (before, behind, line) in [
        (HEADER, "off,off,off\noff,off,off\n", 5),
        (HEADER, "time [s],pan [deg],tilt [mdeg]\n", 5),
        ("", HEADER, 4),
    ] {
        let text = format!("{before}{first}{behind}{rest}");
        let data = match before {
            "" => {
                "{ file = \"data.csv\", columns = { time = { column = 1, unit = \"s\" }, pan = { column = 2, unit = \"deg\" }, tilt = { column = 3, unit = \"deg\" } } }"
            }
            _ => "\"data.csv\"",
        };
        let fault = load(data, &text).unwrap_err().0.swap_remove(0);
        assert_eq!(fault.place.unwrap().line, line, "{}: {text}", fault.message);
    }
    let text = format!("{HEADER}off,off,off\n-,-,-\n{rows}");
    let fault = load("\"data.csv\"", &text).unwrap_err().0.swap_remove(0);
    assert_eq!(fault.place.unwrap().line, 2, "{}", fault.message);
}

/// LabVIEW writes a column of remarks behind the values; rows without a remark end before it. A row
/// that ends before a value is a fault.
#[test]
fn remarks_behind_the_values_need_not_be_there() {
    let due = numbers(&load("\"data.csv\"", &table(HEADER, ",")).unwrap());
    let before = "LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\t\t\t\n\
                  time [s]\tpan [deg]\ttilt [deg]\tComment\n";
    let text = table(before, "\t");
    let (head, rows) = text.split_at(before.len());
    let first = rows.split_once('\n').unwrap();
    let with_remark = format!("{head}{}\tramp off\n{}", first.0, first.1);
    assert_eq!(numbers(&load("\"data.csv\"", &with_remark).unwrap()), due);
    let cut = text.trim_end().rsplit_once('\t').unwrap().0.to_owned() + "\n";
    assert!(load("\"data.csv\"", &cut).is_err());
}

/// A table that begins with its header or its rows has no lines before it.
#[test]
fn rows_of_a_table_without_preamble_are_all_there() {
    let due = numbers(&load("\"data.csv\"", &table(HEADER, ",")).unwrap());
    let gone = HEADER.to_owned() + "0.000,,\n";
    let first = numbers(
        &load("\"data.csv\"", &table(&gone, ",").replacen("0.000,0.250,0.125\n", "", 1)).unwrap(),
    );
    assert_eq!(first[1..], due[1..]);
    assert_eq!((first.len(), first[0][0]), (30, 0.0));
}

/// A campaign that is begun from such a file finds its columns, and loads.
#[test]
fn a_campaign_begun_from_an_export_has_its_columns() {
    let own = ("head.toml".to_owned(), Model::parse(Source::new("head.toml", MODEL)).unwrap());
    for (before, separator, _) in FORMS {
        let text = table(before, separator);
        let folder = Folder::new("begun", &[("head.toml", MODEL), ("data.csv", &text)]);
        let log = (folder.join("data.csv"), PathBuf::from("data.csv"));
        let begun = begin(&[log], Some(&own), &[], None).unwrap().campaign;
        fs::write(folder.join("campaign.toml"), &begun).unwrap();
        let file = CampaignFile::read(&folder).unwrap();
        let loaded = file.load(&own.1, &LoadOptions::default());
        assert_eq!(numbers(&loaded.unwrap_or_else(|_| panic!("{begun}"))).len(), 30, "{begun}");
    }
}

/// Settings of a recorder that are as wide as the rows, with numbers in all but the first cell.
#[test]
fn settings_with_numbers_are_no_rows() {
    let before = "Measurement\t\nVersion\t2\nDate\t2026/11/28\n***End***\t\n\t\nChannels\t2\t\nSamples\t30\t30\n\
        X0\t0.0E+0\t0.0E+0\nDelta_X\t0.5\t0.5\n***End***\t\t\n";
    let text = table(&format!("{before}{}", HEADER.replace(',', "\t")), "\t");
    let due = numbers(&load("\"data.csv\"", &table(HEADER, ",")).unwrap());
    let found = load("\"data.csv\"", &text).unwrap_or_else(|faults| panic!("{faults}"));
    assert_eq!(numbers(&found), due);
}

/// Where the header is in another line than it seems, the faults say how to state its line.
#[test]
fn a_header_in_another_line_is_offered() {
    let text = table(&format!("a title\n{HEADER}"), ",").replacen("0.250,", "x,", 1);
    let text = text.replacen("0.125\n", "0.125,what, a note\n", 1);
    let words = "columns = { pan = \"angle [deg]\" }";
    let stated = format!("{{ file = \"data.csv\", {words} }}");
    for data in ["\"data.csv\"", &stated] {
        let fault = load(data, &text).unwrap_err().to_string();
        assert!(fault.contains("write its number beside `file`, as `header = 4`"), "{fault}");
        assert!(fault.contains("`header = false` where there are none"), "{fault}");
    }
    let fault = load("\"data.csv\"", &table("", ",")).unwrap_err().to_string();
    assert!(fault.contains("header = false, columns = {"), "{fault}");
}
