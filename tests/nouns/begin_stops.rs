//! Campaigns begun from tables of poses in any order.

use std::fmt::Write as _;

use homepoint::units::parse_quantity;

use crate::begin::begun_with;
use crate::stream::Stream;

const ARM: &str = "name = \"arm\"\n[inputs]\na = { unit = \"rad\" }\nb = { unit = \"rad\" }\n\
    [parameters]\nlength = { unit = \"m\" }\n\
    [measurands]\nx = { value = 'length * cos(a) * cos(b)', unit = \"m\" }\n";

/// Poses of two joints in degrees, without units, each of them `times` in a row of rows; with stamps a second
/// apart, or none.
fn poses(times: usize, stamped: bool) -> (&'static str, String) {
    let mut random = Stream(7);
    let mut text = if stamped { "t_s,a,b,x [m]\n" } else { "a,b,x [m]\n" }.to_owned();
    for pose in 0..60 {
        let [a, b] = [170.0, 90.0].map(|most| most * (2.0 * random.uniform() - 1.0));
        for again in 0..times {
            let x = 1.5 * a.to_radians().cos() * b.to_radians().cos() + 2e-5 * random.normal();
            if stamped {
                write!(text, "{},", pose * times + again).unwrap();
            }
            writeln!(text, "{a:.3},{b:.3},{x:.6}").unwrap();
        }
    }
    ("poses.csv", text)
}

/// Between poses in any order readings differ by metres, which is no noise: whether the rows have stamps or
/// not.
#[test]
fn poses_in_any_order_show_no_noise() {
    for stamped in [false, true] {
        let text = begun_with(ARM, &[poses(1, stamped)]);
        assert!(text.contains("# x = { sigma = \"... m\" }   # WRITE it"), "{text}");
        assert!(!text.contains("\nx = { sigma"), "{text}");
    }
}

/// Nor do poses on a grid, whose lines are smooth between the leaps from one to the next.
#[test]
fn poses_on_a_grid_show_no_noise() {
    let rows = (0..64).fold("a [deg],b [deg],x [m]\n".to_owned(), |text, row| {
        let [a, b] = [row / 8, row % 8].map(|at| 24.0 * f64::from(at) - 84.0);
        let x = 1.5 * a.to_radians().cos() * b.to_radians().cos();
        format!("{text}{a},{b},{x:.6}\n")
    });
    let text = begun_with(ARM, &[("grid.csv", rows)]);
    assert!(text.contains("# x = { sigma = \"... m\" }   # WRITE it"), "{text}");
}

#[test]
fn poses_that_are_repeated_show_the_noise() {
    let text = begun_with(ARM, &[poses(2, false)]);
    let (_, rest) = text.split_once("\nx = { sigma = \"").unwrap_or_else(|| panic!("{text}"));
    let sigma = parse_quantity(rest.split_once('"').unwrap().0).unwrap().0;
    assert!((sigma / 2e-5 - 1.0).abs() < 0.3, "{sigma} {text}");
    assert!(text.contains("at the same inputs"), "{text}");
}

/// Rows that lost their inputs are no repeats of each other.
#[test]
fn rows_without_inputs_show_no_noise() {
    let (name, text) = poses(1, false);
    let lost = |(row, line): (usize, &str)| match line.rsplit_once(',') {
        Some((_, x)) if row % 4 == 1 => format!("NaN,NaN,{x}\n"),
        _ => format!("{line}\n"),
    };
    let text: String = text.lines().enumerate().map(lost).collect();
    let text = begun_with(ARM, &[(name, text)]);
    assert!(!text.contains("\nx = { sigma"), "{text}");
}

/// Angles that go far beyond a turn in radians are degrees, unless the model says so already; a few values
/// decide nothing.
#[test]
fn angles_beyond_a_turn_are_degrees() {
    let text = begun_with(ARM, &[poses(1, false)]);
    for joint in ["a", "b"] {
        let line = format!("{joint} = {{ column = \"{joint}\", unit = \"deg\" }},");
        assert!(text.contains(&line) && text.contains("CHECK `deg`"), "{text}");
    }
    let small: String = (0..60).fold("a,b,x [m]\n".to_owned(), |text, row| {
        let a = if row == 9 { 99.0 } else { f64::from(row % 7) - 3.0 };
        format!("{text}{a},{:.2},1.0{row:02}\n", 0.1 * a)
    });
    let text = begun_with(ARM, &[("poses.csv", small)]);
    assert!(text.contains("a = { column = \"a\", unit = \"rad\" },"), "{text}");
}

/// Where the model decides which file is the stream, no rate of rows does.
#[test]
fn the_reason_for_the_stream_is_that_of_the_choice() {
    let model = "name = \"own\"\n[inputs]\npan = { unit = \"rad\", signal = true }\n[parameters]\nzero = { unit = \"rad/s\" }\n\
        [measurands]\nspeed = { value = 'rate(pan) + zero', unit = \"rad/s\" }\n";
    let log = |head: &str, every: f64| {
        (0..400).fold(format!("t_s,{head}\n"), |text, row| {
            let t = every * f64::from(row);
            format!("{text}{t:.3},{:.5}\n", t.sin())
        })
    };
    let files = [("gyro.csv", log("speed [rad/s]", 0.01)), ("head.csv", log("pan [rad]", 0.02))];
    let text = begun_with(model, &files);
    assert!(text.contains("with the columns of the model's inputs is the stream"), "{text}");
    assert!(!text.contains("more rows a second"), "{text}");
}
