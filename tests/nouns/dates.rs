//! Dates and times of day as stamps: the forms in which loggers write them, and which order day and
//! month have.

use homepoint::campaign::file::CampaignFile;
use homepoint::campaign::load::Campaign;
use homepoint::campaign::loaded::LoadOptions;
use homepoint::diagnostic::{Diagnostics, Source};
use homepoint::model::Model;

use crate::folder::Folder;

const MODEL: &str = "name = \"head\"\ntitle = \"Head\"\n[parameters]\nzero = { unit = \"rad\" }\n\
    [measurands]\npan = { value = 'zero', unit = \"rad\", sigma = \"1 mrad\" }\n";

fn load(data: &str, table: &str) -> Result<Campaign, Diagnostics> {
    let campaign = format!("model = \"head.toml\"\n[[runs]]\nname = \"one\"\ndata = {data}\n");
    let files = [("head.toml", MODEL), ("campaign.toml", campaign.as_str()), ("data.csv", table)];
    let folder = Folder::new("dates", &files);
    let model = Model::parse(Source::new("head.toml", MODEL)).unwrap();
    CampaignFile::read(&folder)?.load(&model, &LoadOptions::default())
}

/// Stamps since 1970 (s) of a table with these cells as stamps.
fn stamps(data: &str, cells: &[&str]) -> Result<Vec<f64>, String> {
    let rows = cells.iter().enumerate();
    let rows = rows.map(|(n, cell)| format!("{cell};{:.3}\n", 0.1 + n as f64));
    let table = format!("time;pan [deg]\n{}", rows.collect::<String>());
    let campaign = load(data, &table).map_err(|faults| faults.to_string())?;
    let zero = campaign.zero as f64;
    Ok(campaign.runs[0].held().time.iter().map(|time| zero + time).collect())
}

/// 2024-03-07T00:00:00, and a day.
const MARCH_7: f64 = 1_709_769_600.0;
const DAY: f64 = 86_400.0;

#[test]
fn dates_are_read_in_the_forms_in_which_loggers_write_them() {
    let of_day = 7.0 * 3600.0 + 11.0 * 60.0 + 30.125;
    for cell in [
        "2024-03-07T07:11:30.125Z",
        "2024/03/07 07:11:30,125",
        "2024.03.07 07:11:30.125",
        "07.03.2024 07:11:30,125",
        "7.3.24 7:11:30.125",
        "07-Mar-2024 07:11:30.125 AM",
        "Mar 7 2024 7:11:30.125 AM",
        "Thu Mar  7 07:11:30.125 2024",
        "7. März 2024, 07:11:30,125",
    ] {
        let later = cell.replace("11:30", "11:31");
        let found =
            stamps("\"data.csv\"", &[cell, &later]).unwrap_or_else(|fault| panic!("{fault}"));
        assert_eq!(found, [MARCH_7 + of_day, MARCH_7 + of_day + 1.0], "{cell}");
    }
    let after = stamps("\"data.csv\"", &["07.03.2024 11:59:59 AM", "07.03.2024 12:00:00 PM"]);
    assert_eq!(after.unwrap(), [MARCH_7 + DAY / 2.0 - 1.0, MARCH_7 + DAY / 2.0]);
}

#[test]
fn a_number_above_12_anywhere_says_which_one_is_the_day() {
    let column = |before: &str, after: &str| {
        let mut cells = vec![format!("{before} 23:59:59"); 1000];
        cells.iter_mut().enumerate().for_each(|(n, cell)| *cell += &format!(".{n:03}"));
        cells.push(format!("{after} 00:00:01"));
        let cells: Vec<&str> = cells.iter().map(String::as_str).collect();
        let found = stamps("\"data.csv\"", &cells).unwrap_or_else(|fault| panic!("{fault}"));
        found.last().unwrap() - 1.0
    };
    assert_eq!(column("07/03/2024", "13/03/2024"), MARCH_7 + 6.0 * DAY);
    assert_eq!(column("03/07/2024", "03/13/2024"), MARCH_7 + 6.0 * DAY);
    assert_eq!(column("3-7-24", "3-13-24"), MARCH_7 + 6.0 * DAY);
    // In one order alone it goes on from one day to the next.
    assert_eq!(column("07/03/2024", "08/03/2024"), MARCH_7 + DAY);
    assert_eq!(column("03/07/2024", "03/08/2024"), MARCH_7 + DAY);
    // One date a row may be any interval.
    let monthly = ["01/02/2024 0:00:00", "01/03/2024 0:00:00", "01/04/2024 0:00:00"];
    assert!(stamps("\"data.csv\"", &monthly).unwrap_err().contains("may be"));
}

#[test]
fn an_order_that_nothing_decides_is_stated() {
    let cells = ["07/03/2024 12:00:00", "07/03/2024 12:00:01", "07/03/2024 12:00:02"];
    let fault = stamps("\"data.csv\"", &cells).unwrap_err();
    for words in [
        "data.csv:2:1: error: the date `07/03/2024` may be 2024-03-07 (day/month/year) or 2024-07-03 (month/day/year)",
        "no date of the column decides",
        "dates = \"day/month/year\" or dates = \"month/day/year\"",
    ] {
        assert!(fault.contains(words), "{fault}");
    }
    let stated = |order: &str| {
        let data = format!("{{ file = \"data.csv\", dates = \"{order}\" }}");
        stamps(&data, &cells).map(|found| found[0] - DAY / 2.0)
    };
    assert_eq!(stated("day/month/year"), Ok(MARCH_7));
    assert_eq!(stated("month/day/year"), Ok(MARCH_7 + 118.0 * DAY));
    let fault = stated("year/month/day").unwrap_err();
    assert!(fault.contains("found `07/03/2024 12:00:00`"), "{fault}");
    let fault = stated("dmy").unwrap_err();
    assert!(fault.contains("`dmy` is not an order of dates"), "{fault}");
    // Two digits of the year, which may come first.
    let short = stamps("\"data.csv\"", &["07/03/04 12:00:00", "07/03/04 12:00:01"]).unwrap_err();
    assert!(short.contains("or 2007-03-04 (year/month/day)"), "{short}");
}

#[test]
fn what_is_no_date_is_said_with_the_forms_that_are_read() {
    for cell in ["7 Brumaire 2024 12:00:00", "07.03.2024 25:00:00", "30.02.2024 12:00:00", "noon"] {
        let fault = stamps("\"data.csv\"", &[cell]).unwrap_err();
        let words =
            format!("expected a number, a date or a time of day in column `time`, found `{cell}`");
        assert!(
            fault.contains(&words) && fault.contains("dates are read as `2026-11-28`"),
            "{fault}"
        );
    }
    let fault = stamps("\"data.csv\"", &["07.03.2024 12:00:00", "gap"]).unwrap_err();
    assert!(fault.contains("found `gap`") && fault.contains("dates are read as"), "{fault}");
    // A number is one, and needs its unit.
    let fault = stamps("\"data.csv\"", &["1.5", "2.5"]).unwrap_err();
    assert!(fault.contains("the column `time` has no unit"), "{fault}");
}

#[test]
fn a_date_and_a_time_of_day_of_two_columns_are_one_stamp() {
    let rows = |date: &str| {
        let row = |n: u32| format!("{n};{date};07:11:{:02},5;{n},25\n", 30 + n);
        format!("Nr;Datum;Uhrzeit;pan [deg]\n{}", (0..9).map(row).collect::<String>())
    };
    for date in ["07.03.2024", "07-Mar-2024", "2024/03/07"] {
        for columns in ["time = [\"Datum\", \"Uhrzeit\"]", "time = \"Datum\""] {
            let data = format!("{{ file = \"data.csv\", columns = {{ {columns} }} }}");
            let found = load(&data, &rows(date)).unwrap_or_else(|faults| panic!("{faults}"));
            let time = found.zero as f64 + found.runs[0].held().time[1];
            assert_eq!(time, MARCH_7 + 7.0 * 3600.0 + 11.0 * 60.0 + 31.5, "{date} {columns}");
        }
    }
    // The time of day before the date, and columns between.
    let text = "clock,pan [deg],day\n07:00:00,1,07.03.2024\n07:00:01,2,07.03.2024\n";
    let data = "{ file = \"data.csv\", columns = { time = [\"day\", \"clock\"] } }";
    let found = load(data, text).unwrap_or_else(|faults| panic!("{faults}"));
    assert_eq!(found.zero as f64 + found.runs[0].held().time[0], MARCH_7 + 7.0 * 3600.0);
}

#[test]
fn a_day_that_the_calendar_does_not_have_is_no_date() {
    for cell in ["31.02.2025 10:00:01", "2025-02-30 10:00:01"] {
        let fault = stamps("\"data.csv\"", &["28.02.2025 10:00:00", cell]).unwrap_err();
        assert!(fault.contains("there is no such date"), "{cell}: {fault}");
    }
}

/// A count at a known rate: its unit is the time from one to the next.
#[test]
fn a_count_at_a_known_rate_is_a_stamp() {
    let text = "Frame,pan [deg]\n1,0.5\n2,1.5\n5,2.5\n";
    for time in ["\"Frame [10 ms]\"", "{ column = \"Frame\", unit = \"10 ms\" }"] {
        let data = format!("{{ file = \"data.csv\", columns = {{ time = {time} }} }}");
        let found = load(&data, text).unwrap_or_else(|faults| panic!("{faults}"));
        let off = found.runs[0].held().time.iter().zip([0.01, 0.02, 0.05]);
        assert!(off.clone().all(|(own, due)| (own - due).abs() < 1e-12), "{off:?}");
    }
    for word in ["time = \"Frame [-10 ms]\"", "time = \"Frame [10 mm]\"", "pan = \"pan [2 deg]\""] {
        let data = format!("{{ file = \"data.csv\", columns = {{ {word} }} }}");
        let fault = load(&data, text).unwrap_err().to_string();
        assert!(
            fault.contains("the end of the unit") || fault.contains("expected a unit"),
            "{word} {fault}"
        );
    }
}
