//! Files as loggers write them: separators, decimal commas, headers behind `#` or none at all.

use homepoint::campaign::file::CampaignFile;
use homepoint::campaign::load::Campaign;
use homepoint::campaign::loaded::LoadOptions;
use homepoint::diagnostic::{Diagnostics, Source};
use homepoint::model::Model;

use crate::folder::Folder;

const MODEL: &str = "name = \"line\"\ntitle = \"line\"\n[inputs]\nq = { unit = \"m\", signal = true }\n\
    [parameters]\nc = { unit = \"m\", scope = \"rig\" }\n[measurands]\n\
    x = { value = 'q + c', unit = \"m\", sigma = \"1 mm\" }\n";

/// A campaign of one run whose data stand in `data.csv`, with these lines of the run.
fn load(run: &str, data: impl AsRef<[u8]>) -> Result<Campaign, Diagnostics> {
    let run =
        if run.contains("data =") { run.to_owned() } else { format!("data = \"data.csv\"\n{run}") };
    let campaign = format!("model = \"line.toml\"\n[[runs]]\nname = \"one\"\n{run}\n");
    let folder = Folder::new("forms", &[("line.toml", MODEL), ("campaign.toml", &campaign)]);
    std::fs::write(folder.join("data.csv"), data).unwrap();
    let model = Model::parse(Source::new("line.toml", MODEL)).unwrap();
    CampaignFile::read(&folder)?.load(&model, &LoadOptions::default())
}

/// Times, inputs and readings of the run.
fn numbers(campaign: &Campaign) -> String {
    let samples = campaign.runs[0].held();
    format!("{:?} {:?} {:?}", samples.time, samples.inputs, samples.readings)
}

const PLAIN: &str =
    "time [s],q [m],q_rate [m/s],x [m]\n0,1.5,0.25,2.5\n0.5,-1e-3,0.25,\n1,3,0.5,4.125\n";

fn plain() -> String {
    numbers(&load("", PLAIN).unwrap())
}

#[test]
fn separators_and_decimals_of_all_kinds_give_the_same_numbers() {
    let comma = |text: &str, by: &str| text.replace(',', by);
    let german = PLAIN.replace(',', ";").replace('.', ",");
    let tabs = comma(PLAIN, "\t");
    let aligned = PLAIN.replace("0.25,\n", "0.25,nan\n").replace(',', "   ").replace("\n", " \n  ");
    let missing = "data = { file = \"data.csv\", missing = \"nan\" }";
    for (run, text) in [
        ("", comma(PLAIN, ";")),
        ("", tabs.clone()),
        ("", tabs.replace('.', ",")),
        ("", german.clone()),
        ("", german.replace('\n', "\r\n")),
        ("", format!("\u{feff}{german}")),
        ("", PLAIN.replace('[', "(").replace(']', ")")),
        ("", PLAIN.replace(" [", "[")),
        ("", PLAIN.replace("x [m]", "\"x [m]\"").replace("2.5\n", "\"2.5\"\n")),
        // A separator at the end of each line, of all but the header, of the header alone.
        ("", PLAIN.replace('\n', ",\n")),
        ("", PLAIN.replace('\n', ",\n").replace("[m],\n", "[m]\n")),
        ("", PLAIN.replace("x [m]\n", "x [m],\n")),
        ("", format!("#{PLAIN}")),
        ("", format!("% {PLAIN}")),
        ("", format!("# a log, of something\n#\n# {PLAIN}")),
        (missing, aligned.clone()),
        (missing, format!("# {aligned}")),
        (missing, aligned.replace('.', ",")),
        (missing, PLAIN.replace("0.25,\n", "0.25,nan\n")),
        // A word in capitals or not, a number however it is written.
        (missing, PLAIN.replace("0.25,\n", "0.25,NaN\n")),
        (
            "data = { file = \"data.csv\", missing = \"-1\" }",
            PLAIN.replace("0.25,\n", "0.25,-1.000\n"),
        ),
        (
            "data = { file = \"data.csv\", missing = [\"none\", \"-1.0\"] }",
            german.replace("0,25;\n", "0,25;-1,00\n"),
        ),
        (
            "data = { file = \"data.csv\", missing = [\"none\", \"-999\"] }",
            PLAIN.replace("0.25,\n", "0.25,-999\n"),
        ),
        (
            "data = { file = \"data.csv\", separator = \";\", decimal = \",\", header = true }",
            german,
        ),
        ("data = { file = \"data.csv\", separator = \"\\t\" }", tabs),
    ] {
        let found = load(run, &text).unwrap_or_else(|faults| panic!("{text}\n{faults}"));
        assert_eq!(numbers(&found), plain(), "{text}");
        assert!(found.warnings.is_empty(), "{text}\n{:?}", found.warnings);
    }
}

/// Cells between commas, those with decimal commas in quotes, as spreadsheets write them.
#[test]
fn decimal_commas_between_commas_stand_in_quotes() {
    let quoted: String = PLAIN
        .lines()
        .map(|line| {
            let cell = |cell: &str| match cell.contains('.') && !cell.contains('[') {
                true => format!("\"{}\"", cell.replace('.', ",")),
                false => cell.to_owned(),
            };
            line.split(',').map(cell).collect::<Vec<_>>().join(",") + "\n"
        })
        .collect();
    assert!(quoted.contains("\"1,5\""), "{quoted}");
    assert_eq!(numbers(&load("", &quoted).unwrap()), plain(), "{quoted}");
    // Thousands or decimals? Stated, they are decimals.
    let thousands = "time [s],q [m],q_rate [m/s],x [m]\n0,\"1,500\",0,\"2,500\"\n1,\"1,500\",0,1\n";
    let fault = load("", thousands).unwrap_err().to_string();
    assert!(fault.contains("thousands or decimals?"), "{fault}");
    let stated = "data = { file = \"data.csv\", separator = \",\", decimal = \",\" }";
    assert!(numbers(&load(stated, thousands).unwrap()).contains("2.5"));
    // Unquoted they are cells of their own.
    let fault = load(stated, "time [s],q [m],q_rate [m/s],x [m]\n0,1,5,0,2\n").unwrap_err();
    assert!(fault.to_string().contains("expected 4 cells"), "{fault}");
}

#[test]
fn the_unit_that_is_offered_is_that_of_the_name() {
    let bare = "time [s],q,q_rate [m/s],x_mm\n0,1.5,0.25,2500\n";
    let words = "columns = { q = { unit = \"m\" }, x = \"x_mm\" }";
    let fault = load(words, bare).unwrap_err().to_string();
    assert!(fault.contains("write `x_mm [mm]`"), "{fault}");
}

#[test]
fn columns_of_a_file_without_header_are_named_by_number() {
    let rows = PLAIN.split_once('\n').unwrap().1;
    let words =
        "columns = { time = \"1 [s]\", q = \"2 [m]\", q_rate = \"3 [m/s]\", x = \"4 [m]\" }";
    let numbered = "columns = { time = { column = 1, unit = \"s\" }, q = { column = 2, unit = \"m\" }, \
        q_rate = { column = 3, unit = \"m/s\" }, x = { column = 4, unit = \"m\" } }";
    for text in
        [rows.to_owned(), rows.replace(',', ";"), format!("# four columns of numbers\n{rows}")]
    {
        for run in [words, numbered] {
            assert_eq!(numbers(&load(run, &text).unwrap()), plain(), "{run}\n{text}");
            let own = format!("data = {{ file = \"data.csv\", {run} }}");
            assert_eq!(numbers(&load(&own, &text).unwrap()), plain(), "{own}\n{text}");
        }
    }
    let fault = load("", rows).unwrap_err().to_string();
    assert!(fault.contains("data.csv:1:1: error: the file has no header row"), "{fault}");
    assert!(fault.contains("columns = { time = { column = 1, unit = \"s\" } }"), "{fault}");
    let fault = load(&words.replace("4 [m]", "5 [m]"), rows).unwrap_err().to_string();
    assert!(fault.contains("no file of run `one` has a column `5`"), "{fault}");
    // In a file with names digits are a name, not a number.
    let fault = load("columns = { x = \"2 [m]\" }", PLAIN).unwrap_err().to_string();
    assert!(fault.contains("has a column `2`"), "{fault}");
}

#[test]
fn a_unit_may_be_stated_where_the_file_has_none() {
    let bare = "t,q,q_rate,x_mm\n0,1.5,0.25,2500\n0.5,-1e-3,0.25,\n1,3,0.5,4125\n";
    let words = "columns = { time = \"t [s]\", q = { unit = \"m\" }, q_rate = { unit = \"m/s\" }, \
        x = { column = \"x_mm\", unit = \"mm\" } }";
    assert_eq!(numbers(&load(words, bare).unwrap()), plain());
    // What nobody knows may be written in brackets.
    let odd = bare.replace("x_mm", "x_mm [millimetres]");
    assert_eq!(numbers(&load(words, &odd).unwrap()), plain());
    let fault = load(&words.replace("q = { unit = \"m\" }, ", ""), bare).unwrap_err().to_string();
    assert!(fault.contains("the column `q` has no unit"), "{fault}");
    assert!(fault.contains("columns = { q = { column = \"q\", unit = \"m\" } }"), "{fault}");
    let fault = load(words, bare.replace("x_mm", "x_mm [m]")).unwrap_err().to_string();
    assert!(fault.contains("says that `x_mm` is in `mm`, the file says `m`"), "{fault}");
    let fault = load(&words.replace("\"mm\"", "\"ms\""), bare).unwrap_err().to_string();
    assert!(fault.contains("`ms` is not a unit of `x`"), "{fault}");
    // A name that ends in a unit is none of a unit.
    let fault = load("columns = { x = \"x_mm\" }", bare).unwrap_err().to_string();
    assert!(fault.contains("the column `x_mm` has no unit"), "{fault}");
}

#[test]
fn a_column_that_is_there_twice_is_chosen_by_its_number() {
    let twice = PLAIN.replace("x [m]\n", "x [m],x [m],,\n").replace("2.5\n", "2.5,7,,\n");
    let twice = twice.replace("0.25,\n", "0.25,,8,,\n").replace("4.125\n", "4.125,9,,\n");
    let fault = load("", &twice).unwrap_err().to_string();
    assert!(fault.contains("the column `x` is here twice"), "{fault}");
    assert!(fault.contains("columns = { x = { column = 4 } }"), "{fault}");
    let found = load("columns = { x = { column = 4 } }", &twice).unwrap();
    assert_eq!(numbers(&found), plain());
    // Nobody wants these.
    let others = PLAIN.replace("x [m]\n", "x [m],a,a\n").replace("2.5\n", "2.5,1,1\n");
    let others = others.replace("0.25,\n", "0.25,,1,1\n").replace("4.125\n", "4.125,1,1\n");
    assert_eq!(numbers(&load("", &others).unwrap()), plain());
}

/// An error, or the right numbers.
#[test]
fn hostile_files_give_errors() {
    let rows: String = (0..100).map(|n| format!("{n},1,1,1\n")).collect();
    let head = "time [s],q [m],q_rate [m/s],x [m]\n";
    let files: Vec<(Vec<u8>, &str)> = vec![
        (Vec::new(), "no header row"),
        (b"\n\n\r\n".to_vec(), "no header row"),
        (b"# nothing\n".to_vec(), "no header row"),
        (head.as_bytes().to_vec(), "no rows"),
        (b"\x00\xff\x00\xfe".repeat(5000), "bytes that are no text"),
        (b"\0".repeat(5000), "bytes that are no text"),
        (b"PK\x03\x04\x14\0\x06\0\x08\0\0\0!".repeat(9), "an Excel workbook (.xlsx)"),
        (b"\x7fELF\x02\x01\x01\0\0\0".to_vec(), "it is a program"),
        ("{\"time\": 0, \"x\": 1}\n".repeat(9).into_bytes(), "it is JSON"),
        // Decimals of two kinds, in either order; thousands.
        (b"time [s];q [m];q_rate [m/s];x [m]\n0;1,5;1;1\n1;1.5;1;1\n".to_vec(), "decimal commas"),
        (b"time [s];q [m];q_rate [m/s];x [m]\n0;1.5;1;1\n1;1,500;1;1\n".to_vec(), "decimal points"),
        (b"time [s];q [m];q_rate [m/s];x [m]\n0;1,000.5;1;1\n".to_vec(), "expected a number"),
        // Rows with other separators than the header, and than each other.
        (format!("{head}{rows}100;1;1;1\n").into_bytes(), "expected 4 cells"),
        (format!("{head}{}", rows.replacen(",1", " 1", 40)).into_bytes(), "expected 4 cells"),
        (format!("{head}{}", rows.replace("50,1", "50,1,1")).into_bytes(), "found 5"),
        (format!("{head}{rows}{}", "NaN,1,1,1\n".repeat(30)).into_bytes(), "(30 rows"),
        (format!("{head}{rows}{}", "200,inf,x,1\n".repeat(30)).into_bytes(), "(30 rows"),
        (format!("time [s],1,q_rate [m/s],x [m]\n{rows}").into_bytes(), "no header row"),
        (format!("{head}{rows}").replace('\n', "\r").into_bytes(), ""),
    ];
    for (bytes, words) in files {
        let text = String::from_utf8_lossy(&bytes[..bytes.len().min(80)]).into_owned();
        let faults = load("", &bytes).err().unwrap_or_else(|| panic!("{text}"));
        assert!(faults.to_string().contains(words), "{text}\n{faults}");
        assert!(faults.0.len() <= 3, "{text}\n{faults}");
    }
    for (run, words) in [
        ("data = { file = \"data.csv\", separator = \"|\" }", "`|` is not a separator"),
        ("data = { file = \"data.csv\", decimal = \";\" }", "`;` is not a decimal"),
        (
            "data = { file = \"data.csv\", separator = \",\", decimal = \",\" }",
            "have decimal commas, this one has a point",
        ),
        ("data = { separator = \",\" }", "the file has no name"),
        ("data = { file = \"data.csv\", haeder = true }", "did you mean `header`?"),
        ("columns = { x = { column = 0 } }", "not the number of a column"),
        ("columns = { x = {} }", "neither a column nor a unit"),
        ("columns = { x = { column = \"x\", unit = \"furlong\" } }", "furlong"),
    ] {
        let fault = load(run, PLAIN).unwrap_err().to_string();
        assert!(fault.contains(words), "{run}\n{fault}");
    }
}

/// UTF-16 with its mark, and single bytes for what UTF-8 has none.
#[test]
fn other_encodings_are_read() {
    let text = PLAIN.replace("x [m]", "x [m],\"Größe [°C]\"").replace('\n', ",1\n");
    let text = text.replacen("]\",1\n", "]\"\n", 1);
    let due = numbers(&load("", text.as_bytes()).unwrap());
    let marked = format!("\u{feff}{text}");
    let single = text.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect();
    let low = marked.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let high = marked.encode_utf16().flat_map(u16::to_be_bytes).collect();
    let all: [(Vec<u8>, &str); 3] = [(single, "Windows-1252"), (low, "UTF-16"), (high, "UTF-16")];
    for (bytes, encoding) in all {
        let found = load("", &bytes).unwrap_or_else(|faults| panic!("{encoding}: {faults}"));
        assert_eq!(numbers(&found), due, "{encoding}");
        assert_eq!(found.recognised, [format!("`data.csv`: {encoding}")]);
    }
}

#[test]
fn what_is_unusual_in_a_file_is_said() {
    let told = |text: &str| load("", text).unwrap().recognised.join("; ");
    assert_eq!(told(PLAIN), "");
    let german = PLAIN.replace(',', ";").replace('.', ",");
    assert_eq!(told(&german), "`data.csv`: cells between semicolons, decimal commas");
    assert_eq!(told(&format!("#{PLAIN}")), "`data.csv`: the comment in line 1 as header row");
}

/// Dates in the column of stamps, and units in a row of their own.
#[test]
fn dates_and_rows_of_units_are_read() {
    let dated = |t: f64| format!("2025-03-26T{:02}:00:{:06.3}Z", 12, t);
    let plain = "time [s],q [m],q_rate [m/s],x [mm]\n";
    let rows = |time: &dyn Fn(f64) -> String, head: &str| {
        let row = |n: i32| format!("{},{n},0,{}\n", time(0.25 * f64::from(n)), 10 * n);
        format!("{head}{}", (0..8).map(row).collect::<String>())
    };
    let right = load("", rows(&|t| format!("{}", 1_742_990_400.0 + t), plain)).unwrap();
    let bare = "time,q,q_rate,x\n,m,m/s,mm\n";
    let units = plain.replace(" [s]", "");
    for head in [bare, &*units, plain] {
        let found = load("", rows(&dated, head)).unwrap_or_else(|faults| panic!("{head}{faults}"));
        assert_eq!(numbers(&found), numbers(&right), "{head}");
    }
    let found = load("", rows(&|t| t.to_string(), "time,q,q_rate,x\n[s],[m],[m/s],[mm]\n"));
    assert_eq!(
        numbers(&found.unwrap()),
        numbers(&load("", rows(&|t| t.to_string(), plain)).unwrap())
    );
    let fault = load("", rows(&dated, plain).replace("00:00.500Z", "0:99Z")).unwrap_err();
    assert!(fault.to_string().contains("expected a number in column `time`"), "{fault}");
}
