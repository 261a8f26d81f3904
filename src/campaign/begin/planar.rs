//! Poses in a plane: a model to begin with, with the scales of a path of dead reckoning where one of
//! the logs is that.

use crate::campaign::begin::candidate::Candidate;
use crate::campaign::begin::log::Log;
use crate::campaign::begin::models::{Made, tables};
use crate::campaign::begin::scatter::Sigma;
use crate::campaign::begin::text::Table;
use crate::campaign::begin::word::Word;
use crate::units::Unit;

/// Rows of a stream that are smoothed together.
const SMOOTHED: f64 = 20.0;

/// So much of the way, and of a radian, is about zero.
const NEAR_ZERO: f64 = 0.03;

/// Quantities of a plain motion where one of the paths is of dead reckoning.
const BENT: &str = r#"
# One of the paths begins about at zero, as that of dead reckoning (wheel counts, steps, an integrated gyro)
# does: its distances and headings have scale errors, and a wrong heading bends the path more and
# more. That is an integral over the way, which formulas do not have: BEND was computed from the
# stream's poses, to first order. A heading that is wrong by much needs it computed again.
# Clocks of such recorders often run at another rate, too: `calibrate --with sample_clock_rate`.
# A circle alone hardly tells the lever from the scales: look at `calibrate --noise sandwich`.
away_x = '(1 + distance_scale) * (point_x + heading_scale * bend_x)'
away_y = '(1 + distance_scale) * (point_y + heading_scale * bend_y)'
"#;

/// Their parameters and inputs.
const SCALES: &str = r#"distance_scale = { unit = "1", scope = "instrument", about = "by how much the data's distances are longer" }
heading_scale  = { unit = "1", scope = "instrument", about = "by how much its turns are larger" }
"#;
const BENDS: &str = r#"bend_x      = { unit = "m", signal = true, smooth = "SMOOTH" }
bend_y      = { unit = "m", signal = true, smooth = "SMOOTH" }
"#;
/// The offset of the heading, without what it is about.
const HEADING_OFFSET: &str = r#"heading_offset = { unit = "rad", scope = "instrument","#;
/// The file of the bend.
const BEND: &str = "bend.csv";

const PLANAR: &str = r#"# Poses in a plane: what moves carries a second point, seen by another recorder in its own frame.
name   = "planar_pose"
title  = "Poses in a plane: delay, frame and lever arm"
source = "rigid motion in a plane"

[inputs]                       # smooth: guessed from the rate of the log; shorter than what moves
ref_x       = { unit = "m", signal = true, smooth = "SMOOTH" }
ref_y       = { unit = "m", signal = true, smooth = "SMOOTH" }
ref_heading = { unit = "rad", signal = true, smooth = "SMOOTH", period = "360 deg" }

[parameters]
lever_forward  = { unit = "m", scope = "instrument", about = "from the point of the stream to that of the data" }
lever_left     = { unit = "m", scope = "instrument" }
heading_offset = { unit = "rad", scope = "instrument", about = "from the heading of the stream to that of the data" }
frame_turn     = { unit = "rad", scope = "setup", about = "from the frame of the stream to that of the data" }
frame_x        = { unit = "m", scope = "setup" }
frame_y        = { unit = "m", scope = "setup" }

[quantities]
point_x = 'ref_x + lever_forward * cos(ref_heading) - lever_left * sin(ref_heading)'
point_y = 'ref_y + lever_forward * sin(ref_heading) + lever_left * cos(ref_heading)'

[measurands]
x       = { value = 'cos(frame_turn) * point_x - sin(frame_turn) * point_y + frame_x', unit = "m" }
y       = { value = 'sin(frame_turn) * point_x + cos(frame_turn) * point_y + frame_y', unit = "m" }
heading = { value = 'ref_heading + heading_offset + frame_turn', kind = "angle", unit = "rad", period = "360 deg" }

[delays]                       # one clock stamps them all
clock = { of = ["x", "y", "heading"] }
"#;

/// Poses in a plane in both files.
pub(super) fn planar(data: &Log, stream: &Log) -> Option<Made> {
    let pose = |log: &Log, names: [&str; 3]| {
        let pose = log.guess.plane.as_ref().ok()?;
        let words = names.into_iter().zip(pose);
        let words = words.map(|(name, guessed)| Word::of(name, log, Some(guessed)));
        std::iter::once(Word::time(log)).chain(words).collect::<Option<Vec<Word>>>()
    };
    let (of_data, of_stream) =
        (pose(data, ["x", "y", "heading"])?, pose(stream, ["ref_x", "ref_y", "ref_heading"])?);
    let text = PLANAR.replace("SMOOTH", &smooth(stream));
    let bend = if [data, stream].into_iter().any(begins_at_zero) {
        bend(stream, &of_stream)
    } else {
        None
    };
    let text = if bend.is_some() { reckoned(&text, &smooth(stream)) } else { text };
    let units = [("x", "m"), ("y", "m"), ("heading", "rad")];
    let sigmas = units.map(|(name, symbol)| {
        let unit = Unit::parse(symbol).unwrap_or_else(|_| Unit::one());
        Sigma::of_columns(name, &of_data, data, &unit)
    });
    let mut tables = tables((data, of_data), (stream, of_stream));
    if bend.is_some() {
        tables.push(Table {
            path: BEND.into(),
            form: String::new(),
            words: Vec::new(),
            open: Vec::new(),
            unused: None,
        });
    }
    Some(Made {
        name: "planar_pose".into(),
        text,
        tables,
        sigmas: sigmas.to_vec(),
        file: bend.map(|text| (BEND.to_owned(), text)),
        takes: "a position in a plane and a heading",
    })
}

/// Why poses in a plane are not used: the logs that hold none, where one at least has a pose.
pub(super) fn not_used(logs: [&Log; 2]) -> Vec<String> {
    let has_pose = |log: &Log| {
        log.guess.plane.is_ok() || log.guess.heading.is_some() && log.guess.position.is_some()
    };
    let Some(own) = logs.into_iter().find(|log| has_pose(log)) else { return Vec::new() };
    let own = own.survey.path.display();
    let missing = logs.iter().filter_map(|log| Some((log, log.guess.plane.as_ref().err()?)));
    let line = |(log, why): (&&Log, &String)| {
        let file = log.survey.path.display();
        format!("poses of `{own}` are not used: `{file}` has no pose in a plane, for {why}")
    };
    missing.map(line).collect()
}

/// Whether a log's pose in a plane begins about at zero: the path of dead reckoning, of which the first
/// rows may be lost.
fn begins_at_zero(log: &Log) -> bool {
    let Ok(pose) = &log.guess.plane else { return false };
    let column = |axis: &Candidate| &log.survey.columns[axis.column];
    let first = pose.each_ref().map(|axis| {
        let value = column(axis).values.iter().find(|value| value.is_finite());
        value.map_or(f64::INFINITY, |value| axis.unit.to_si(*value))
    });
    let way = pose[..2].iter().map(|axis| column(axis).way() * axis.unit.factor);
    let near = NEAR_ZERO * way.fold(0.0, f64::max);
    let turn = std::f64::consts::TAU;
    let heading = first[2] - turn * (first[2] / turn).round();
    first[..2].iter().all(|place| place.abs() <= near) && heading.abs() <= NEAR_ZERO
}

/// The model of poses in a plane with the scales of a path of dead reckoning.
fn reckoned(planar: &str, smooth: &str) -> String {
    planar
        .replace(
            "\n\n[parameters]\n",
            &format!("\n{}\n[parameters]\n", BENDS.replace("SMOOTH", smooth)),
        )
        .replace("\n\n[quantities]\n", &format!("\n{SCALES}\n[quantities]\n"))
        .replace("\n\n[measurands]\n", &format!("\n{}\n[measurands]\n", BENT.replace("BEND", BEND)))
        .replace(
            "cos(frame_turn) * point_x - sin(frame_turn) * point_y",
            "cos(frame_turn) * away_x - sin(frame_turn) * away_y",
        )
        .replace(
            "sin(frame_turn) * point_x + cos(frame_turn) * point_y",
            "sin(frame_turn) * away_x + cos(frame_turn) * away_y",
        )
        .replace(
            "'ref_heading + heading_offset",
            "'(1 + heading_scale) * ref_heading + heading_offset",
        )
        // Setups begin at different headings, of which a scale makes different offsets.
        .replace(HEADING_OFFSET, &HEADING_OFFSET.replace("instrument", "setup"))
}

/// By how much a stream's path bends for a heading that is larger by a part of itself: `-∫ heading dy`
/// and `∫ heading dx`, heading from its mean, as a table. `None` of a stream that was not read to its end.
fn bend(stream: &Log, words: &[Word]) -> Option<String> {
    if stream.survey.is_cut {
        return None;
    }
    let (time, pose) = (stream.guess.time.as_ref()?, words.get(1..4)?);
    let column = |word: &Word| &stream.survey.columns[word.candidate.column].values;
    let rows = time.values.iter().enumerate().map(|(row, time)| {
        let si = |word: &Word| word.candidate.unit.to_si(column(word)[row]);
        (*time, si(&pose[0]), si(&pose[1]), si(&pose[2]))
    });
    let mut rows: Vec<_> = rows
        .filter(|(time, x, y, heading)| [time, x, y, heading].iter().all(|one| one.is_finite()))
        .collect();
    // Rows may be out of order.
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    let turn = std::f64::consts::TAU;
    for row in 1..rows.len() {
        let step = rows[row].3 - rows[row - 1].3;
        rows[row].3 -= turn * (step / turn).round();
    }
    let mean = rows.iter().map(|row| row.3).sum::<f64>() / rows.len().max(1) as f64;
    let mut text = format!("time [{}],bend_x [m],bend_y [m]\n", time.unit.symbol);
    let (mut bend_x, mut bend_y) = (0.0, 0.0);
    let mut last = *rows.first()?;
    for own in rows {
        let heading = 0.5 * (own.3 + last.3) - mean;
        bend_x -= heading * (own.2 - last.2);
        bend_y += heading * (own.1 - last.1);
        text += &format!("{},{bend_x:.7},{bend_y:.7}\n", own.0);
        last = own;
    }
    Some(text)
}

/// How long to smooth a stream: some of its rows.
fn smooth(stream: &Log) -> String {
    let spacing = stream.spacing().unwrap_or(0.01);
    format!("{:.0e} s", SMOOTHED * spacing.max(1e-9))
}
