//! What is said of a `[timing]` or of captures that cannot be used: where, what, and what to do.

use homepoint::engine::open::{Request, open};

use crate::folder::Folder;

const PARAMETERS: &str = "radius = { value = \"1.146 m\", fixed = true }\n";
const TRIGGER: &str = "trigger [s],arm_angle [deg],arm_angle_rate [deg/s],distance [m]\n";
const SERIAL: &str = "request [s],reply [s],arm_angle [deg],arm_angle_rate [deg/s],distance [m]\n";
const LINE: &str = "method = \"serial\"\nbaud = \"19200 Bd\"\nbits = 80\n";

/// The first fault of a campaign: `file:line:column message | help`.
#[track_caller]
fn fault(timing: &str, run: &str, files: &[(&str, &str)]) -> String {
    let campaign = format!(
        "model = \"polar_one_rotation\"\n[timing]\n{timing}\n[parameters]\n{PARAMETERS}[measurands]\n\
         distance = {{ sigma = \"10 um\" }}\n[[runs]]\nname = \"fast\"\ndata = \"fast.csv\"\n{run}\n"
    );
    let files = [&[("campaign.toml", &campaign[..])], files].concat();
    let folder = Folder::new("timing-fault", &files);
    let opened = open(&Request::new([&folder]));
    let Err(faults) = opened else { panic!("nothing is wrong with {timing}") };
    let first = &faults.0[0];
    let place = first.place.as_ref().map_or_else(String::new, |place| {
        let file = place.file.rsplit('/').next().unwrap();
        format!("{file}:{}:{} ", place.line, place.column)
    });
    format!("{place}{} | {}", first.message, first.help.join("; "))
}

#[test]
fn tables_that_cannot_be_used() {
    let of = |timing: &str| fault(timing, "", &[("fast.csv", "distance [m]\n1\n")]);
    assert_eq!(
        of(""),
        "campaign.toml:2:1 [timing] does not say its method | write method = \"trigger\" or method = \"serial\""
    );
    assert_eq!(
        of("method = \"triger\""),
        "campaign.toml:3:10 unknown method `triger` | did you mean `trigger`?"
    );
    assert_eq!(
        of("method = \"serial\"\nbaud = \"-19200 Bd\"\nbits = 80"),
        "campaign.toml:4:8 baud must be greater than zero | "
    );
    assert_eq!(
        of("method = \"serial\"\nbaud = 19200\nbits = 80"),
        "campaign.toml:4:8 `19200` has no unit | write baud = \"19200 Bd\""
    );
    assert_eq!(
        of("method = \"serial\"\nbaud = \"19200 us\"\nbits = 80"),
        "campaign.toml:4:8 `us` is not a unit of baud | expected a unit such as `1/s`"
    );
    assert_eq!(
        of("method = \"serial\"\nbaud = \"19200 Bd\""),
        "campaign.toml:2:1 a serial interface needs `bits` | write bits = 80"
    );
    assert_eq!(
        of("method = \"serial\"\nbaud = \"19200 Bd\"\nbits = 80.5"),
        "campaign.toml:5:8 bits must be a whole number, one or more | count start, data, parity and stop bits of all its characters"
    );
    assert_eq!(
        of("method = \"trigger\"\nbits = 80"),
        "campaign.toml:4:1 `bits` belongs to a serial interface | write method = \"serial\", or leave it out"
    );
    assert_eq!(
        of("method = \"trigger\"\nedges = \"1 us\""),
        "campaign.toml:4:1 unknown key `edges` | did you mean `edge`?"
    );
    assert_eq!(
        of("method = \"trigger\"\nedge = \"1 um\""),
        "campaign.toml:4:8 `um` is not a unit of edge | expected a unit such as `s`"
    );
    assert_eq!(
        of(&format!("{LINE}resolution = \"105 us\"")),
        "campaign.toml:6:14 the captures are too coarse to tell one falling edge from the next | falling edges of the start bit may follow each other after two bits, 104.17 µs at this rate"
    );
    let gate = |gate: &str| of(&format!("method = \"trigger\"\ncontroller_gate = {gate}"));
    assert_eq!(
        gate("\"100 ns\""),
        "campaign.toml:4:19 expected a table, found a text | as in controller_gate = { at_most = \"100 ns\" }"
    );
    assert_eq!(
        gate("{ value = \"60 ns\" }"),
        "campaign.toml:4:29 the uncertainty of controller_gate is not stated | state `sigma`, or `U` with its `k`"
    );
    assert_eq!(
        gate("{ value = \"60 ns\", U = \"20 ns\" }"),
        "campaign.toml:4:42 the coverage factor of controller_gate is not stated | write it beside U: k = 2"
    );
    assert_eq!(
        gate("{ value = \"60 ns\", sigma = \"2 ns\", k = 2 }"),
        "campaign.toml:4:58 controller_gate has a coverage factor, but no expanded uncertainty | `k` belongs to `U`; `sigma` has none"
    );
    assert_eq!(
        gate("{ at_most = \"100 ns\", degrees_of_freedom = 0.5 }"),
        "campaign.toml:4:62 controller_gate has degrees of freedom, but no uncertainty | state `sigma`, or `U` with its `k`"
    );
}

#[test]
fn captures_that_make_no_sense() {
    let trigger = "method = \"trigger\"";
    let of = |timing: &str, data: String| fault(timing, "", &[("fast.csv", &data)]);
    assert_eq!(
        of(trigger, format!("{TRIGGER}1,0,10,1\n1.1,1,10,1\n1.05,2,10,1\n")),
        "fast.csv:4:1 the edges are out of order here | rows are in the order of their edges, each later than the one before"
    );
    assert_eq!(
        of(trigger, format!("{TRIGGER}1,0,10,1\n,1,10,1\n")),
        "fast.csv:3:1 the row has no `trigger` | every sample has its edge; leave out the reading, not the capture"
    );
    assert_eq!(
        of(trigger, TRIGGER.replace("[s]", "[um]") + "1,0,10,1\n"),
        "fast.csv:1:10 `um` is not a unit of `trigger` | it is measured in units such as `s`"
    );
    assert_eq!(
        of(trigger, "time [s],".to_owned() + TRIGGER + "1,1,0,10,1\n"),
        "fast.csv:1:1 the file has ready times and captures, `time` and `trigger` | keep one: `[timing]` makes the times from captures"
    );
    assert_eq!(
        of(LINE, format!("{SERIAL}1,0.9,0,10,1\n")),
        "fast.csv:2:3 the reply comes before its request | are the two columns exchanged?"
    );
    assert_eq!(
        of(LINE, format!("{SERIAL}1,1.01,0,10,1\n1.1,1.101,1,10,1\n")),
        "fast.csv:3:5 the reply comes 1000.00 µs after its request began, which is 4166.67 µs long | check `baud` and `bits`: nothing can reply before the request is complete"
    );
    assert_eq!(
        of(LINE, format!("{SERIAL}1,1.11,0,10,1\n1.1,1.12,1,10,1\n")),
        "fast.csv:3:1 this request comes before the reply to the one before | requests and replies alternate: is a capture missing?"
    );
    let beside = |captures: &str| {
        let files = [("fast.csv", "distance [m]\n1\n1\n"), ("latch.csv", captures)];
        fault(trigger, "timing = { captures = \"latch.csv\" }", &files)
    };
    let rows = "trigger [s],arm_angle [deg],arm_angle_rate [deg/s]\n1,0,10\n1.1,1,10\n1.2,2,10\n";
    let more = beside(rows);
    assert!(more.starts_with("latch.csv:4:1 this capture has no reading | "), "{more}");
    let fewer = beside("trigger [s],arm_angle [deg],arm_angle_rate [deg/s]\n1,0,10\n");
    assert!(fewer.starts_with("fast.csv:3:1 this reading has no capture | "), "{fewer}");
    let twice = beside("trigger [s],arm_angle [deg],distance [m]\n1,0,1\n1.1,1,1\n");
    assert!(twice.starts_with("latch.csv:1:29 `distance` stands in `"), "{twice}");
    let none = beside("arm_angle [deg],arm_angle_rate [deg/s]\n0,10\n1,10\n");
    assert!(none.contains("has no column `trigger [s]` | method = \"trigger\" takes"), "{none}");
    let run = "timing = { captured = \"latch.csv\" }";
    assert_eq!(
        fault(trigger, run, &[("fast.csv", "distance [m]\n1\n")]),
        "campaign.toml:11:12 unknown key `captured` | did you mean `captures`?"
    );
}

#[test]
fn statements_that_no_circuit_can_keep() {
    let of = |timing: &str| fault(timing, "", &[("fast.csv", "distance [m]\n1\n")]);
    assert_eq!(
        of(&format!("{LINE}baud_tolerance = \"10 %\"")),
        "campaign.toml:6:18 a baud rate off by 10.000 % loses bits | the last of ten bits is then read half a bit off; such a line does not work, and crystals keep 100 ppm"
    );
    assert_eq!(
        of(&format!("{LINE}baud_tolerance = \"100000 ppm\"")),
        "campaign.toml:6:18 a baud rate off by 10.000 % loses bits | the last of ten bits is then read half a bit off; such a line does not work, and crystals keep 100 ppm"
    );
    assert_eq!(
        of("method = \"trigger\"\nedge = \"1 s\""),
        "campaign.toml:4:8 edge of 1e0 s is no property of an electronic circuit | times of the chain are shorter than 0.1 s: check the unit"
    );
    assert_eq!(
        of("method = \"serial\"\nbaud = \"19200 Bd\"\nbits = 1e12"),
        "campaign.toml:5:8 a request of 1e12 bits at 1.92e4 Bd takes 5.208e7 s | it is read to take 10 s at most: check `baud` and `bits`"
    );
    assert_eq!(
        of(&format!("{LINE}reply = {{ after = \"2 ms\" }}")),
        "campaign.toml:6:9 the reply begins before its request of 4.17 ms is complete | count from start bit to start bit"
    );
    assert_eq!(
        of(&format!("{LINE}reply = {{ scatter = \"2 ms\" }}")),
        "campaign.toml:6:9 `reply` does not say after what time it begins | write reply = { after = \"14 ms\" }"
    );
    assert_eq!(
        of("method = \"trigger\"\nreply = { after = \"2 ms\" }"),
        "campaign.toml:4:1 `reply` belongs to a serial interface | write method = \"serial\", or leave it out"
    );
}

#[test]
fn times_too_large_to_be_told_apart() {
    let resolution = "method = \"trigger\"\nresolution = \"25 ns\"";
    let data = format!("{TRIGGER}1700000000.0,0,10,1\n1700000000.1,1,10,1\n");
    assert_eq!(
        fault(resolution, "", &[("fast.csv", &data)]),
        "fast.csv:2:1 1700000000 s is so large a number that its neighbours are 377 ns apart | count from a later zero, say the start of the day"
    );
}

/// Whatever is wrong, the first fault points into a file, and nothing panics or passes.
#[test]
fn every_bad_timing_points_into_its_file() {
    let good = format!("{TRIGGER}1,0,10,1\n1.1,1,10,1\n");
    let serial = |line: &str| format!("method = \"serial\"\n{line}");
    let tables = [
        "method = 5",
        "method = [\"trigger\"]",
        "method = \"\"",
        "method = \"trigger\"\nmethod = \"serial\"",
        "method = \"trigger\"\nedge = 1",
        "method = \"trigger\"\nedge = \"\"",
        "method = \"trigger\"\nedge = \"-1 us\"",
        "method = \"trigger\"\nedge = \"nan us\"",
        "method = \"trigger\"\nedge = \"inf us\"",
        "method = \"trigger\"\nedge = \"1e999 us\"",
        "method = \"trigger\"\nedge = \"1e300 us\"",
        "method = \"trigger\"\nedge = [\"1 us\"]",
        "method = \"trigger\"\nresolution = \"0 ns\"",
        "method = \"trigger\"\njitter = \"1 h\"",
        "method = \"trigger\"\njitter = { sigma = \"1 us\" }",
        "method = \"trigger\"\ncontroller_gate = {}",
        "method = \"trigger\"\ncontroller_gate = { at_most = \"-1 ns\" }",
        "method = \"trigger\"\ncontroller_gate = { at_most = \"1 ns\", value = \"1 ns\" }",
        "method = \"trigger\"\ncontroller_gate = { value = \"-1 ns\", sigma = \"1 ns\" }",
        "method = \"trigger\"\ncontroller_gate = { value = \"1 ns\", sigma = \"-1 ns\" }",
        "method = \"trigger\"\ncontroller_gate = { value = \"1 ns\", sigma = \"nan ns\" }",
        "method = \"trigger\"\ncontroller_gate = { value = \"1 ns\", U = \"1 ns\", k = 0 }",
        "method = \"trigger\"\ninstrument_gate = { value = \"1e9 s\", sigma = \"1 ns\" }",
        "method = \"trigger\"\nbaud = \"19200 Bd\"",
    ];
    let lines = [
        "bits = 80",
        "baud = \"0 Bd\"\nbits = 80",
        "baud = \"nan Bd\"\nbits = 80",
        "baud = \"inf Bd\"\nbits = 80",
        "baud = \"1e999 Bd\"\nbits = 80",
        "baud = \"1e-30 Bd\"\nbits = 80",
        "baud = \"19200\"\nbits = 80",
        "baud = \"19200 Bd\"\nbits = 0",
        "baud = \"19200 Bd\"\nbits = -80",
        "baud = \"19200 Bd\"\nbits = nan",
        "baud = \"19200 Bd\"\nbits = inf",
        "baud = \"19200 Bd\"\nbits = 1e30",
        "baud = \"19200 Bd\"\nbits = \"80\"",
        "baud = \"19200 Bd\"\nbits = true",
        "baud = \"19200 Bd\"\nbits = 80\nbaud_tolerance = \"-50 ppm\"",
        "baud = \"19200 Bd\"\nbits = 80\nbaud_tolerance = 50",
        "baud = \"19200 Bd\"\nbits = 80\nreference = \"end\"",
        "baud = \"19200 Bd\"\nbits = 80\nreply = \"14 ms\"",
        "baud = \"19200 Bd\"\nbits = 80\nreply = { after = \"14 ms\", scatter = \"-1 ms\" }",
        "baud = \"19200 Bd\"\nbits = 80\nreply = { after = \"14 ms\", when = \"1 ms\" }",
    ];
    let tables = tables.iter().map(|table| (*table).to_owned()).chain(lines.map(serial));
    for table in tables {
        let found = fault(&table, "", &[("fast.csv", &good)]);
        assert!(found.starts_with("campaign.toml:"), "{table}: {found}");
    }
    let captures = [
        String::new(),
        "\n\n".to_owned(),
        "trigger [s]\n".to_owned(),
        TRIGGER.to_owned(),
        format!("{TRIGGER}1,0,10,1\n1,1,10,1\n"),
        format!("{TRIGGER}nan,0,10,1\n"),
        format!("{TRIGGER}inf,0,10,1\n"),
        format!("{TRIGGER}1e999,0,10,1\n"),
        format!("{TRIGGER}1e18,0,10,1\n1e19,1,10,1\n"),
        format!("{TRIGGER}now,0,10,1\n"),
        format!("{TRIGGER}1;0;10|1\n"),
        format!("{TRIGGER}1,0,10\n"),
        format!("{TRIGGER}1,0,10,1,7\n"),
        format!("{TRIGGER}1,0,nan,1\n"),
        format!("{TRIGGER}1,0,1e999,1\n"),
        TRIGGER.replace("trigger", "triger") + "1,0,10,1\n",
        TRIGGER.replace("trigger [s]", "trigger") + "1,0,10,1\n",
        TRIGGER.replace("arm_angle [deg]", "trigger [s]") + "1,1,10,1\n",
        TRIGGER.replace("arm_angle", "arm") + "1,0,10,1\n",
    ];
    for text in captures {
        let found = fault("method = \"trigger\"", "", &[("fast.csv", &text)]);
        let points = found.starts_with("fast.csv:") || found.starts_with("campaign.toml:");
        assert!(points, "{text:?}: {found}");
    }
    let replies = [
        format!("{SERIAL}1,nan,0,10,1\n"),
        format!("{SERIAL}1,-1,0,10,1\n"),
        format!("{SERIAL}1,1,0,10,1\n"),
        format!("{SERIAL}1,1e999,0,10,1\n"),
        format!("{SERIAL},1.1,0,10,1\n"),
    ];
    for text in replies {
        let found = fault(LINE, "", &[("fast.csv", &text)]);
        assert!(found.starts_with("fast.csv:2:"), "{text:?}: {found}");
    }
    let run = "timing = { captures = \"latch.csv\" }";
    let beside =
        ["", "trigger [s]\n", "trigger [s]\n1\n1\n", "trigger [s]\n1\n2\n3\n", "x\n1\n2\n"];
    for text in beside {
        let files = [("fast.csv", "distance [m]\n1\n1\n"), ("latch.csv", text)];
        let found = fault("method = \"trigger\"", run, &files);
        assert!(found.split(' ').next().unwrap().matches(':').count() == 2, "{text:?}: {found}");
    }
    for run in [
        "timing = 5",
        "timing = { captures = 5 }",
        "timing = { bits = -1 }",
        "timing = { captures = \"none.csv\" }",
    ] {
        let found = fault(LINE, run, &[("fast.csv", &format!("{SERIAL}1,1.1,0,10,1\n"))]);
        assert!(found.starts_with("campaign.toml:"), "{run}: {found}");
    }
}
