//! Campaigns begun from tables as instruments and their programs export them.

use crate::begin::begun;

/// A pose at a time: position (m), quaternion w x y z.
fn pose(t: f64) -> ([f64; 3], [f64; 4]) {
    let (half, tilt) = (0.3 * t.sin(), 0.4 * (1.3 * t).cos());
    let position = [t.sin(), 0.3 * t.cos(), -1.5 + 0.1 * t];
    (position, [half.cos(), half.sin() * tilt.sin(), 0.0, half.sin() * tilt.cos()])
}

fn row(cells: &[f64], separator: &str) -> String {
    cells.iter().map(|cell| format!("{cell:.6}")).collect::<Vec<_>>().join(separator)
}

/// Poses of a camera, in the format `tum`.
fn camera(begin: f64) -> (&'static str, String) {
    let line = |n: u32| {
        let t = 0.1 * f64::from(n);
        let ([x, y, z], [qw, qx, qy, qz]) = pose(t);
        format!("{:.3} {}\n", begin + t, row(&[x, y, z, qx, qy, qz, qw], " "))
    };
    ("camera.txt", (0..60).map(line).collect())
}

/// A tracked body as motion capture exports it: what a column is stands in the rows above its axis.
fn body(turns: &str, columns: &str, turn: impl Fn(f64) -> Vec<f64>) -> (&'static str, String) {
    let count = columns.split(',').count();
    let above = format!("{},Position,Position,Position", vec![turns; count - 3].join(","));
    let head = format!(
        "Format Version,1.23,Take Name,One,Length Units,Meters\n\n,Type{}\n,Name{}\n,,{above}\nFrame,Time (Seconds),{columns}\n",
        ",Rigid Body".repeat(count),
        ",Body A".repeat(count)
    );
    let line = |n: u32| {
        let t = 0.02 * f64::from(n);
        format!("{n},{t:.6},{}\n", row(&[&turn(t)[..], &pose(t).0].concat(), ","))
    };
    ("body.csv", head + &(0..300).map(line).collect::<String>())
}

#[test]
fn columns_of_one_name_are_told_apart_by_their_numbers() {
    let quaternion = |t: f64| {
        let [w, x, y, z] = pose(t).1;
        vec![x, y, z, w]
    };
    let files = [body("Rotation", "X,Y,Z,W,X,Y,Z", quaternion), camera(0.0)];
    let (text, ..) = begun(&files, Some("hand_eye")).unwrap();
    for words in [
        "{ file = \"body.csv\", header = 6, columns = {",
        "hand_x = { column = 7, unit = \"m\" }",
        "hand_z = { column = 9, unit = \"m\" }",
        "hand_qx = { column = 3, unit = \"1\" }",
        "hand_qw = { column = \"W\", unit = \"1\" }",
    ] {
        assert!(text.contains(words), "{words}\n{text}");
    }
    // Turns about three axes are no position.
    let angles = |t: f64| vec![10.0 * t.sin(), 5.0 * t, 20.0 * t.cos()];
    let files = [body("Rotation", "X,Y,Z,X,Y,Z", angles), camera(0.0)];
    let (text, ..) = begun(&files, None).unwrap();
    let is_position =
        |column: u32| text.contains(&format!("x = {{ column = {column}, unit = \"m\" }}"));
    assert!(is_position(6) && !is_position(3), "{text}");
}

fn clock(seconds: f64) -> String {
    let whole = seconds as u32;
    format!("{:02}:{:02}:{:06.3}", whole / 3600, whole / 60 % 60, seconds % 60.0)
}

/// Angles of a total station: numbers of points, dates and times of day.
fn station(head: &str, date: &str, decimal: &str) -> (&'static str, String) {
    let line = |n: u32| {
        let t = 0.1 * f64::from(n);
        let cells = row(&[100.0 + 20.0 * t.sin(), 95.0 + 3.0 * t.cos()], ";");
        format!("{n};{date};{};{cells}\n", clock(26_000.0 + t)).replace('.', decimal)
    };
    let rows: String = (0..300).map(line).collect();
    ("station.csv", format!("{head}\n{}", rows.replace(&date.replace('.', decimal), date)))
}

fn reference(date: &str) -> (&'static str, String) {
    let line = |n: u32| {
        let t = 0.03 * f64::from(n);
        let cells = row(&[100.0 + 20.0 * t.sin(), 95.0 + 3.0 * t.cos()], ",");
        format!("{date}T{}Z,{cells}\n", clock(26_000.0 + t))
    };
    let rows: String = (0..1000).map(line).collect();
    ("reference.csv", format!("stamp,Hz [gon],V [gon]\n{rows}"))
}

#[test]
fn dates_come_before_numbers_of_points() {
    let head = "Nr;Datum;Uhrzeit;Hz [gon];V [gon]";
    for (date, decimal) in [("28.11.2026", ","), ("28-Nov-2026", "."), ("2026/11/28", ".")] {
        let files = [station(head, date, decimal), reference("2026-11-28")];
        let (text, _, campaign) = begun(&files, None).unwrap();
        assert!(
            text.contains("time = [\"Datum\", \"Uhrzeit\"],   # guessed: stamps: a date"),
            "{text}"
        );
        assert!(
            text.contains("time = { column = \"stamp\" },   # guessed: stamps: dates"),
            "{text}"
        );
        // The clocks agree: only readings at the ends are left out.
        let left = campaign.left_out.iter().map(|one| one.samples).sum::<usize>();
        assert!(left < 30, "{left}");
    }
}

#[test]
fn an_order_of_dates_that_nothing_decides_is_a_guess() {
    let head = "Nr;Date;Time;Hz [gon];V [gon]";
    let files = [station(head, "07/03/2026", "."), reference("2026-03-07")];
    let (text, ..) = begun(&files, None).unwrap();
    let words = "dates = \"day/month/year\",   # guessed: no date decides; month/day/year? CHECK";
    assert!(text.contains(words), "{text}");
    // An order that the dates decide is none.
    let files = [station(head, "28/11/2026", "."), reference("2026-11-28")];
    let (text, ..) = begun(&files, None).unwrap();
    assert!(!text.contains("dates ="), "{text}");
}

#[test]
fn a_table_without_stamps_says_which_column_counts_its_rows() {
    let line = |n: u32| format!("{n},0,{}\n", row(&pose(0.01 * f64::from(n)).0, ","));
    let rows: String = (1..200).map(line).collect();
    let text = format!("Trajectories\n100\nFrame,Sub Frame,X,Y,Z\n,,mm,mm,mm\n{rows}");
    let fault = begun(&[("marker.csv", text), camera(0.0)], None).unwrap_err();
    assert!(fault.contains("has no column of stamps"), "{fault}");
    assert!(fault.contains("time = { column = \"Frame\", unit = \"10 ms\" }"), "{fault}");
}

/// The stamp of the message, not that of the recorder.
#[test]
fn the_stamps_of_a_known_format_are_taken() {
    let axes = |name: &str, axes: &[&str]| {
        axes.iter().map(|axis| format!(",field.pose.{name}.{axis}")).collect::<String>()
    };
    let head = format!(
        "%time,field.header.seq,field.header.stamp{}{}\n",
        axes("position", &["x", "y", "z"]),
        axes("orientation", &["x", "y", "z", "w"])
    );
    let line = |n: u64| {
        let ([x, y, z], [qw, qx, qy, qz]) = pose(0.02 * n as f64);
        let stamp = 1_732_777_890_000_000_000 + 20_000_000 * n;
        format!("{},{n},{stamp},{}\n", stamp + 3_000_000, row(&[x, y, z, qx, qy, qz, qw], ","))
    };
    let poses = ("poses.csv", head + &(0..300).map(line).collect::<String>());
    let (text, ..) = begun(&[poses, camera(1_732_777_890.0)], Some("hand_eye")).unwrap();
    let words = "time = { column = \"field.header.stamp\", unit = \"ns\" }";
    assert!(text.contains(words), "{text}");
}
