//! Poses in a plane: a model to begin with, with the scales of a path of dead reckoning where one of
//! the logs is that (`reckoned`).

use crate::campaign::begin::log::Log;
use crate::campaign::begin::models::{Made, tables};
use crate::campaign::begin::neighbours::Inputs;
use crate::campaign::begin::reckoned::{BEND, Reckoned, not_computed};
use crate::campaign::begin::scatter::Sigma;
use crate::campaign::begin::text::Table;
use crate::campaign::begin::word::Word;
use crate::units::Unit;

/// Rows of a stream that are smoothed together.
const SMOOTHED: f64 = 20.0;

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

/// Poses in a plane in both files; of dead reckoning at a scale of its heading that is stated.
/// Notes are of what could not be computed.
pub(super) fn planar(
    data: &Log,
    stream: &Log,
    heading_scale: Option<f64>,
    notes: &mut Vec<String>,
) -> Option<Made> {
    let pose = |log: &Log, names: [&str; 3]| {
        let pose = log.guess.plane.as_ref().ok()?;
        let words = names.into_iter().zip(pose);
        let words = words.map(|(name, guessed)| Word::of(name, log, Some(guessed)));
        std::iter::once(Word::time(log)).chain(words).collect::<Option<Vec<Word>>>()
    };
    let (of_data, of_stream) =
        (pose(data, ["x", "y", "heading"])?, pose(stream, ["ref_x", "ref_y", "ref_heading"])?);
    let text = PLANAR.replace("SMOOTH", &smooth(stream));
    let reckoned = Reckoned::of((data, &of_data), (stream, &of_stream), heading_scale);
    notes.extend(not_computed(data, stream));
    let text = reckoned.as_ref().map_or(text.clone(), |own| own.model(&text, &smooth(stream)));
    let units = [("x", "m"), ("y", "m"), ("heading", "rad")];
    let sources = Inputs { log: stream, words: &of_stream, is_whole: true };
    let sigmas = units.map(|(name, symbol)| {
        let unit = Unit::parse(symbol).unwrap_or_else(|_| Unit::one());
        match reckoned.as_ref().is_some_and(|own| own.is_of_data) {
            true => Sigma::of_integrated(name, &of_data, data, &unit),
            false => Sigma::of_columns(name, &of_data, data, &unit, sources),
        }
    });
    let mut tables = tables((data, of_data), (stream, of_stream));
    if reckoned.is_some() {
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
        file: reckoned.map(|own| (BEND.to_owned(), own.table)),
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

/// How long to smooth a stream: some of its rows.
fn smooth(stream: &Log) -> String {
    let spacing = stream.spacing().unwrap_or(0.01);
    format!("{:.0e} s", SMOOTHED * spacing.max(1e-9))
}
