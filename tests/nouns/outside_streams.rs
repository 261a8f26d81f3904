//! Runs whose samples lie outside their streams, and inputs without a column: what the message
//! proposes works when it is pasted.

use homepoint::engine::open::{Request, open};

use crate::folder::Folder;

const MODEL: &str = "name = \"rail\"\ntitle = \"Rail\"\n[inputs]\nplace = { unit = \"m\", signal = true }\n\
     [parameters]\nzero = { unit = \"m\" }\n[measurands]\nx = { value = 'place + zero', unit = \"m\", sigma = \"1 mm\" }\n";

/// A run's entry, its samples and its stream: names, headers, from when to when (in the numbers of the
/// files, of which a second has so many).
struct Run<'a> {
    entry: &'a str,
    data: (&'a str, &'a str),
    stream: (&'a str, &'a str),
    from: f64,
    parts: [f64; 2],
}

impl Default for Run<'_> {
    fn default() -> Self {
        let (data, stream) = (("a.csv", "time [s],x [m]"), ("plc.csv", "time [s],place [m]"));
        let entry = "name = \"a\"\ndata = \"a.csv\"\nsignals = [\"plc.csv\"]";
        Self { entry, data, stream, from: 0.0, parts: [1.0, 1.0] }
    }
}

fn written(runs: &[Run<'_>]) -> Folder {
    let mut campaign = "model = \"model.toml\"\n".to_owned();
    let mut files = vec![("model.toml".to_owned(), MODEL.to_owned())];
    for one in runs {
        campaign += &format!("[[runs]]\n{}\n", one.entry);
        let rows = |header: &str, parts: f64, from: f64, count: usize| {
            let row = |n: usize| {
                let time = from + 0.1 * n as f64;
                format!("{:.6},{:.6}\n", time * parts, (0.7 * time).sin())
            };
            format!("{header}\n{}", (0..count).map(row).collect::<String>())
        };
        let data = rows(one.data.1, one.parts[0], one.from + 2.0, 560);
        files.push((one.data.0.to_owned(), data));
        files.push((one.stream.0.to_owned(), rows(one.stream.1, one.parts[1], one.from, 600)));
    }
    files.push(("campaign.toml".to_owned(), campaign));
    let files: Vec<(&str, &str)> =
        files.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
    Folder::new("outside", &files)
}

/// The faults of the campaign; none where it can be read.
fn faults(folder: &Folder) -> String {
    open(&Request::new([&**folder])).err().map_or_else(String::new, |error| error.to_string())
}

/// Replaces a part of a file.
fn edit(folder: &Folder, file: &str, from: &str, to: &str) {
    let path = folder.join(file);
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.contains(from), "{text}");
    std::fs::write(path, text.replacen(from, to, 1)).unwrap();
}

#[test]
fn a_header_with_another_unit_of_time_is_named_with_what_it_must_be() {
    // Seconds under `[ms]`, in the stream and in the data.
    let (stream, data) = (("plc.csv", "time [ms],place [m]"), ("a.csv", "time [ms],x [m]"));
    for (run, file) in
        [(Run { stream, ..Run::default() }, "plc.csv"), (Run { data, ..Run::default() }, "a.csv")]
    {
        let folder = written(&[run]);
        let due = format!(
            "are the times of `{file}` in s, not in ms? write `time [s]` in the header of `{file}`"
        );
        let found = faults(&folder);
        assert!(found.contains(&due), "{found}");
        edit(&folder, file, "time [ms]", "time [s]");
        assert_eq!(faults(&folder), "");
    }
    // Milliseconds under `[s]`.
    let folder = written(&[Run { from: 200.0, parts: [1.0, 1e3], ..Run::default() }]);
    let found = faults(&folder);
    assert!(found.contains("are the times of `plc.csv` in ms? write `time [ms]` in"), "{found}");
    edit(&folder, "plc.csv", "time [s]", "time [ms]");
    assert_eq!(faults(&folder), "");
}

/// Milliseconds under `[s]` in the stream of samples near its beginning: all of them lie within it.
#[test]
fn a_stream_that_lasts_a_thousand_times_as_long_is_doubtful() {
    let warnings = |folder: &Folder| {
        let found = open(&Request::new([&**folder])).unwrap().warnings;
        let texts = found.into_iter().map(|one| format!("{} {}", one.message, one.help.join(" ")));
        texts.collect::<String>()
    };
    let folder = written(&[Run { from: 0.0, parts: [1.0, 1e3], ..Run::default() }]);
    let found = warnings(&folder);
    assert!(found.contains("are the times of `plc.csv` in ms? write `time [ms]` in"), "{found}");
    edit(&folder, "plc.csv", "time [s]", "time [ms]");
    assert!(!warnings(&folder).contains("are the times of"));
    // A log of the whole day, in a run of which samples were taken, may last as long.
    let day = |from: f64, spacing: f64| {
        let rows = (0..600).map(|n| format!("{:.3},0.5\n", from + spacing * f64::from(n)));
        let folder = written(&[Run { from: 0.0, ..Run::default() }]);
        let stream = format!("time [s],place [m]\n{}", rows.collect::<String>());
        std::fs::write(folder.join("plc.csv"), stream).unwrap();
        warnings(&folder)
    };
    assert!(!day(-30_000.0, 100.0).contains("are the times of"));
}

/// A log in ms under `[s]` that is a part of the stream, at its beginning or within it.
#[test]
fn whole_numbers_that_would_be_within_the_stream_are_in_ms() {
    for first in [0, 1000, 20_000] {
        let folder = written(&[Run::default()]);
        let row = |n: i32| format!("{},{:.6}\n", first + 100 * n, f64::from(n).sin());
        let rows: String = (0..150).map(row).collect();
        std::fs::write(folder.join("a.csv"), format!("time [s],x [m]\n{rows}")).unwrap();
        let found = faults(&folder);
        assert!(found.contains("in ms the whole numbers of `a.csv` would be times"), "{found}");
        edit(&folder, "a.csv", "time [s]", "time [ms]");
        assert_eq!(faults(&folder), "");
        // Seconds of a clock that is far ahead.
        let row =
            |n: i32| format!("{:.1},{:.6}\n", 3000.0 + 0.1 * f64::from(n), f64::from(n).sin());
        let rows: String = (0..150).map(row).collect();
        std::fs::write(folder.join("a.csv"), format!("time [s],x [m]\n{rows}")).unwrap();
        let found = faults(&folder);
        assert!(found.contains("write delay_range") && !found.contains("in ms"), "{found}");
    }
}

#[test]
fn a_unit_that_the_campaign_states_is_corrected_for_one_file() {
    let stream = ("plc.csv", "t,place [m]");
    let stated = "signals = [{ file = \"plc.csv\", columns = { time = \"t [s]\" } }]";
    let entry = format!("name = \"a\"\ndata = \"a.csv\"\n{stated}");
    let folder =
        written(&[Run { stream, entry: &entry, from: 200.0, parts: [1.0, 1e3], ..Run::default() }]);
    let found = faults(&folder);
    let line = "signals = [{ file = \"plc.csv\", columns = { time = \"t [ms]\" } }]";
    assert!(found.contains(line), "{found}");
    edit(&folder, "campaign.toml", stated, line);
    assert_eq!(faults(&folder), "");
    // Beside the run it would count for the data, too, whose header is right.
    edit(
        &folder,
        "campaign.toml",
        line,
        "signals = [\"plc.csv\"]\ncolumns = { time = \"time [ms]\" }",
    );
    let found = faults(&folder);
    assert!(found.contains("beside a run counts for its data and all its streams"), "{found}");
    assert!(!found.contains("convert the column"), "{found}");
}

#[test]
fn the_stream_of_another_run_is_named() {
    let run = |name: &str, stream: &str| {
        format!("name = \"{name}\"\ndata = \"{name}.csv\"\nsignals = [\"{stream}\"]")
    };
    let files = [("a.csv", "plc_a.csv"), ("b.csv", "plc_b.csv")];
    let of = |streams: [&str; 2]| {
        let entries = [run("a", streams[0]), run("b", streams[1])];
        let each = [0, 1].map(|k| Run {
            entry: &entries[k],
            data: (files[k].0, "time [s],x [m]"),
            stream: (files[k].1, "time [s],place [m]"),
            from: 200.0 * k as f64,
            ..Run::default()
        });
        faults(&written(&each))
    };
    assert_eq!(of(["plc_a.csv", "plc_b.csv"]), "");
    let found = of(["plc_b.csv", "plc_a.csv"]);
    assert!(found.contains("`plc_a.csv` of run `b` covers these samples"), "{found}");
    assert!(found.contains("`plc_b.csv` of run `a` covers these samples"), "{found}");
    assert!(!found.contains("write delay_range"), "{found}");
    let found = of(["plc_a.csv", "plc_a.csv"]);
    let due = "`plc_a.csv` is given for run `a`, too, and covers its samples";
    assert!(found.contains(due) && !found.contains("write delay_range"), "{found}");
}

#[test]
fn a_misspelt_column_of_a_stream_is_found_for_an_input() {
    let folder = written(&[Run { stream: ("plc.csv", "time [s],plcae [m]"), ..Run::default() }]);
    let found = faults(&folder);
    assert!(found.contains("run `a` has no column `place`"), "{found}");
    assert!(found.contains("did you mean `plcae` in `plc.csv`?"), "{found}");
    assert!(found.contains("time, x in `a.csv`; time, plcae in `plc.csv`"), "{found}");
    let line = "columns = { place = \"plcae\" }";
    assert!(found.contains(line), "{found}");
    edit(&folder, "campaign.toml", "signals =", &format!("{line}\nsignals ="));
    assert_eq!(faults(&folder), "");
}

#[test]
fn stamps_since_1970_in_a_larger_unit_than_stated_are_named_beside_others() {
    let entry = "name = \"a\"\ndata = { file = \"a.csv\", columns = { time = \"t [ns]\" } }\nsignals = [\"plc.csv\"]";
    let stream = ("plc.csv", "time [ns],place [m]");
    let (data, from) = (("a.csv", "t,x [m]"), 1.7e9);
    let folder = written(&[Run { entry, data, stream, from, parts: [1e6, 1e9] }]);
    let found = faults(&folder);
    let due = "stamps as large as those of `a.csv` count in us since 1970, not in `ns`: ";
    let line = "data = { file = \"a.csv\", columns = { time = \"t [us]\" } }";
    assert!(found.contains(due) && found.contains(line), "{found}");
    assert!(!found.contains("write delay_range"), "{found}");
    edit(&folder, "campaign.toml", "t [ns]", "t [us]");
    assert_eq!(faults(&folder), "");
}
