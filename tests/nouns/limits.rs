//! Large and long input: what is refused for its size, and that effort grows with length alone.

use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::time::{Duration, Instant};

use homepoint::campaign::file::{CampaignFile, MOST_BYTES};
use homepoint::campaign::load::LoadOptions;
use homepoint::diagnostic::{Diagnostics, Source};
use homepoint::model::Model;

/// Longer than anything here takes, also where nothing is optimised; a square takes minutes.
const LONG: Duration = Duration::from_secs(20);
/// No message is longer (bytes), its help and excerpt apart.
const LONGEST: usize = 5000;

fn model() -> Model {
    let text = "name = \"m\"\ntitle = \"m\"\n[inputs]\nq = { unit = \"m\" }\n[measurands]\n\
        x = { value = 'q', unit = \"m\", sigma = \"1 mm\" }\n";
    Model::parse(Source::new("m.toml", text)).unwrap()
}

/// The faults or warnings of a campaign with a table.
fn read(campaign: &[u8], table: &[u8]) -> Result<Diagnostics, Diagnostics> {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("campaign.toml"), campaign).unwrap();
    fs::write(folder.path().join("run.csv"), table).unwrap();
    let file = CampaignFile::read(folder.path())?;
    Ok(Diagnostics(file.load(&model(), &LoadOptions::default())?.warnings))
}

const CAMPAIGN: &str = "model = \"m\"\n[[runs]]\nname = \"run\"\ndata = \"run.csv\"\n";

fn packed(bytes: &[u8]) -> Vec<u8> {
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    packed.write_all(bytes).unwrap();
    packed.finish().unwrap()
}

fn all_short(found: &Diagnostics) {
    for one in &found.0 {
        let parts = one.help.iter().chain([&one.message, &one.label]);
        parts.for_each(|part| assert!(part.len() <= LONGEST, "{} bytes", part.len()));
        assert!(one.place.as_ref().is_none_or(|place| place.excerpt().len() <= MOST_BYTES));
    }
}

#[test]
fn a_campaign_has_a_largest_size() {
    let comment = format!("{CAMPAIGN}#{}\n", "x".repeat(MOST_BYTES - CAMPAIGN.len() - 2));
    assert_eq!(comment.len(), MOST_BYTES);
    let table = b"q [m],x [m]\n1,1\n";
    assert!(read(comment.as_bytes(), table).is_ok());
    assert!(read(&packed(comment.as_bytes()), table).is_ok());
    let longer = format!("{comment}\n");
    let bomb = packed(&vec![b'\n'; 64 << 20]);
    for bytes in [longer.as_bytes(), &packed(longer.as_bytes()), &bomb] {
        let fault = read(bytes, table).unwrap_err().to_string();
        assert!(fault.contains("is longer than 1048576 bytes"), "{fault}");
    }
}

#[test]
fn a_campaign_in_one_line_costs_its_length() {
    // 20,000 good runs of no data, and as many of no form.
    let runs: String = (0..20_000).fold(String::new(), |mut text, n| {
        write!(text, "{{name=\"r{n}\",data=\"r\"}},").unwrap();
        text
    });
    let one_line = format!("model = \"m\"\nruns = [{runs}]\n");
    let wrong = one_line.replace("data=", "dota=");
    let unknown: String = (0..40_000).fold(String::new(), |mut text, n| {
        writeln!(text, "key{n} = 1").unwrap();
        text
    });
    let parameters: String = (0..40_000).fold("[parameters]\n".to_owned(), |mut text, n| {
        writeln!(text, "p{n}={{fixed=true}}").unwrap();
        text
    });
    for (text, message) in [
        (one_line, "does not exist"),
        (wrong, "unknown key `dota`"),
        (format!("{unknown}{CAMPAIGN}"), "unknown key `key0`"),
        (format!("{CAMPAIGN}{parameters}"), ""),
    ] {
        let begin = Instant::now();
        let found = match read(text.as_bytes(), b"q [m],x [m]\n1,1\n") {
            Ok(found) | Err(found) => found,
        };
        assert!(begin.elapsed() < LONG, "{message}: {:?}", begin.elapsed());
        assert!(found.0.len() <= 51, "{message}: {} messages", found.0.len());
        if !message.is_empty() {
            assert!(found.0[0].message.contains(message), "{}", found.0[0]);
            let last = &found.0[50].message;
            assert!(last.starts_with("there are ") && last.ends_with("than these"), "{last}");
        }
        all_short(&found);
    }
}

#[test]
fn places_of_one_file_share_its_text() {
    let line = "x".repeat(1 << 20);
    let source = Source::new("one", format!("first\n{line}é\r\nlast"));
    let place = |start, end| source.place(homepoint::diagnostic::Span::new(start, end));
    let begin = Instant::now();
    let places: Vec<_> = (0..2000).map(|n| place(6 + n, 6 + n + 3)).collect();
    assert!(begin.elapsed() < LONG);
    assert!(places.iter().all(|place| place.excerpt().as_ptr() == places[0].excerpt().as_ptr()));
    assert_eq!((places[7].line, places[7].column, places[7].length), (2, 8, 3));
    let end = 6 + line.len() + 'é'.len_utf8();
    let last = place(end - 2, end + 2);
    assert_eq!((last.line, last.column, last.length), (2, line.len() + 1, 2));
    assert!(last.excerpt().ends_with('é'));
    assert_eq!((place(end + 2, end + 4).line, place(end + 2, end + 4).excerpt()), (3, "last"));
    assert_eq!((place(0, 99).line, place(0, 99).length, place(5, 5).column), (1, 5, 6));
}

#[test]
fn many_columns_cost_their_number_and_one_warning() {
    let mut header = "q [m],x [m]".to_owned();
    let mut row = "1,1".to_owned();
    for n in 0..100_000 {
        write!(header, ",c{n}").unwrap();
        row += ",0";
    }
    let begin = Instant::now();
    let found = read(CAMPAIGN.as_bytes(), format!("{header}\n{row}\n").as_bytes()).unwrap();
    assert!(begin.elapsed() < LONG, "{:?}", begin.elapsed());
    assert_eq!(found.0.len(), 1, "{found}");
    let message = &found.0[0].message;
    assert!(message.contains("`c0`, `c1`") && message.contains("and 99992 more"), "{message}");
    // Of the same name, without names, and none that the model wants.
    for header in ["q [m]", "", "c"].map(|name| vec![name; 100_000].join(",")) {
        let begin = Instant::now();
        let found = read(CAMPAIGN.as_bytes(), format!("{header}\n{row}\n").as_bytes()).unwrap_err();
        assert!(begin.elapsed() < LONG, "{:?}", begin.elapsed());
        assert!(found.0.len() <= 20);
        all_short(&found);
    }
    let begin = Instant::now();
    let distinct = header.replace(" [m]", "_of [m]");
    let found = read(CAMPAIGN.as_bytes(), format!("{distinct}\n{row}\n").as_bytes()).unwrap_err();
    assert!(begin.elapsed() < LONG, "{:?}", begin.elapsed());
    all_short(&found);
}

#[test]
fn unused_columns_give_one_warning_with_the_names_that_may_be_meant() {
    let warning = |header: &str| {
        let found = read(CAMPAIGN.as_bytes(), format!("{header}\n1,1,2,3\n").as_bytes());
        found.unwrap().to_string()
    };
    let all = warning("q [m],x [m],note,other");
    assert!(
        all.contains("the columns `note`, `other` are not used: model `m` does not declare them")
    );
    let near = warning("q [m],x [m],note,q_rat");
    assert!(
        near.contains(":1:18: warning") && near.contains("`q_rat`: did you mean `q_rate`?"),
        "{near}"
    );
}

/// A name in `unused` that no column has hides nothing.
#[test]
fn wrong_names_in_unused_are_reported() {
    let campaign = CAMPAIGN.replace(
        "data = \"run.csv\"",
        "data = { file = \"run.csv\", unused = [\"note\", \"nte\"] }",
    );
    assert_ne!(campaign, CAMPAIGN);
    let found = read(campaign.as_bytes(), b"q [m],x [m],note\n1,1,2\n").unwrap().to_string();
    assert!(found.contains("`unused` names `nte`, which is no column of"), "{found}");
    assert!(!found.contains("`note`"), "{found}");
}

/// A column in `unused` counts as not there, also where the model has a name like it.
#[test]
fn unused_columns_are_not_there() {
    let with = |data: &str| CAMPAIGN.replace("data = \"run.csv\"", &format!("data = {{ {data} }}"));
    let of = |data: &str, table: &str| read(with(data).as_bytes(), table.as_bytes());
    let table = "q [m],x [m],other [m]\n1,1,2\n";
    let other = "file = \"run.csv\", unused = [\"q\"], columns = { q = \"other [m]\" }";
    assert!(of(other, table).unwrap().0.is_empty());
    // An input that the run states as a constant is none of two.
    let constant = "file = \"run.csv\", unused = [\"q\", \"other\"] }\ninputs = { q = \"1 m\"";
    assert!(of(constant, table).unwrap().0.is_empty());
    let missing = of("file = \"run.csv\", unused = [\"x\"]", table).unwrap_err().to_string();
    assert!(missing.contains("found q, x (`unused`), other"), "{missing}");
    let both = "file = \"run.csv\", unused = [\"other\"], columns = { q = \"other [m]\" }";
    let both = of(both, table).unwrap_err().to_string();
    assert!(both.contains("the column `other` of `run.csv` is in `unused`, too"), "{both}");
}

#[test]
fn no_message_quotes_a_long_text_whole() {
    let long = "9z".repeat(200_000);
    let table = format!("q [m],x [m]\n1,{long}\n");
    let mut told = vec![read(CAMPAIGN.as_bytes(), table.as_bytes()).unwrap_err()];
    let table = format!("q [m],x [{long}],{long},{long}\n1,1,1,1\n");
    told.push(read(CAMPAIGN.as_bytes(), table.as_bytes()).unwrap_err());
    let table = format!("q [m],x [m],{long}\n1,1,1\n");
    told.push(read(CAMPAIGN.as_bytes(), table.as_bytes()).unwrap());
    let table = format!("q [m],x [m]\n1,1{}\n", "0".repeat(400_000));
    told.push(read(CAMPAIGN.as_bytes(), table.as_bytes()).unwrap_err());
    for line in [
        "title = 'LONG' + 'LONG'",
        "title = { LONG = 1 }",
        "LONG = 1",
        "effects = 'LONG'",
        "delay_range = 'LONG'",
        "delay_range = '1 LONG'",
        "delay_range = '9LONG s'",
        "parameters = { LONG = { LONG = 'LONG' }, 'LONG' = { sum = 'LONG', scope = 'LONG' } }",
        "inputs = { q = { period = '1 LONG' }, LONG = {} }",
        "measurands = { LONG = { sigma = 'LONG' } }",
        "setups = { LONG = {} }",
        "timing = { method = 'LONG' }",
        "timing = { method = 'serial', baud = 'LONG', bits = 'LONG', LONG = 1 }",
        "specification = { LONG = 1, rates = { LONG = 'LONG' } }",
    ] {
        let text = format!("{}\n{CAMPAIGN}", line.replace("LONG", &long[..100_000]));
        told.push(read(text.as_bytes(), b"q [m],x [m]\n1,1\n").unwrap_err());
    }
    for entry in [
        "role = 'LONG'",
        "signals = ['LONG']",
        "columns = { LONG = 'q', q = 'LONG [m]', x = 'y [LONG]' }",
        "inputs = { LONG = '1 m', q = 'LONG' }",
        "plan = { trigger = 'LONG', LONG = { LONG = 1 } }",
        "timing = { captures = 'LONG', LONG = 1 }",
        "LONG = 1",
    ] {
        let run = format!("[[runs]]\nname = 'LONG'\n{entry}\ndata = 'LONG'\n");
        let text = format!("{CAMPAIGN}{}", run.replace("LONG", &long[..100_000]));
        told.push(read(text.as_bytes(), b"q [m],x [m]\n1,1\n").unwrap_err());
    }
    told.iter().for_each(all_short);
}

#[test]
fn a_campaign_that_is_no_text_is_told_at_its_place() {
    let bytes = [CAMPAIGN.as_bytes(), b"title = \"caf\xe9\"\n"].concat();
    let fault = read(&bytes, b"").unwrap_err().to_string();
    assert!(fault.contains("campaign.toml:5:13: error: not UTF-8 text"), "{fault}");
    assert!(fault.contains("save the file as UTF-8"), "{fault}");
}
