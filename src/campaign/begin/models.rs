//! Models to begin with, where none of the library fits: poses in a plane, and columns in pairs.

use crate::campaign::begin::guess::{Guessed, base};
use crate::campaign::begin::log::Log;
use crate::campaign::begin::text::{Table, Word, quoted, sigma};
use crate::campaign::header::TIME;
use crate::model::name;
use crate::units::Unit;

/// A model that was made, and the columns that it takes.
pub(super) struct Made {
    pub(super) name: String,
    pub(super) text: String,
    pub(super) tables: Vec<Table>,
    pub(super) sigmas: Vec<(String, String)>,
}

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

/// Poses in a plane in both files.
pub(super) fn planar(data: &Log, stream: &Log) -> Option<Made> {
    let pose = |log: &Log, names: [&str; 3]| {
        let others = &log.guess.others;
        let find = |axis: &str| {
            others.iter().find(|one| base(&log.survey.columns[one.column].name).0 == axis)
        };
        let all = [find("x"), find("y"), log.guess.heading.as_ref()];
        let mut words = vec![Word::of(TIME, log, log.guess.time.as_ref())?];
        for (name, guessed) in names.into_iter().zip(all) {
            let mut guessed = guessed?.clone();
            if name.ends_with('x') || name.ends_with('y') {
                metres(&mut guessed);
            }
            words.push(Word::of(name, log, Some(&guessed))?);
        }
        Some(words)
    };
    let (of_data, of_stream) =
        (pose(data, ["x", "y", "heading"])?, pose(stream, ["ref_x", "ref_y", "ref_heading"])?);
    let units = [("x", "m"), ("y", "m"), ("heading", "rad")];
    let sigmas = units.map(|(name, symbol)| {
        let unit = Unit::parse(symbol).unwrap_or_else(|_| Unit::one());
        (name.to_owned(), sigma(name, &of_data, data, &unit))
    });
    Some(Made {
        name: "planar_pose".into(),
        text: PLANAR.replace("SMOOTH", &smooth(stream)),
        tables: tables((data, of_data), (stream, of_stream)),
        sigmas: sigmas.to_vec(),
    })
}

/// How long to smooth a stream: some of its rows.
fn smooth(stream: &Log) -> String {
    let spacing = stream.spacing().unwrap_or(0.01);
    format!("{:.0e} s", SMOOTHED * spacing.max(1e-9))
}

/// A coordinate without a unit is taken for one in metres.
fn metres(guessed: &mut Guessed) {
    if guessed.unit.symbol == "1"
        && let Ok(metre) = Unit::parse("m")
    {
        guessed.unit = metre;
        guessed.why = "coordinate; the file has no unit, CHECK `m`".into();
    }
}

fn tables(data: (&Log, Vec<Word>), stream: (&Log, Vec<Word>)) -> Vec<Table> {
    let table = |(log, words): (&Log, Vec<Word>)| Table { path: log.survey.path.clone(), words };
    vec![table(data), table(stream)]
}

/// Words for what was asked for, and for what came of it, in one log.
const ASKED: [&str; 10] =
    ["sent", "cmd", "command", "ref", "reference", "set", "setpoint", "desired", "target", "goal"];
const CAME: [&str; 9] =
    ["reported", "meas", "measured", "act", "actual", "read", "state", "feedback", "fb"];

/// What a name says beside words for what was asked for and what came of it.
fn stem(name: &str, words: &[&str]) -> Option<String> {
    let base = base(name).0;
    let parts: Vec<&str> = base.split(['_', '.', ' ']).collect();
    let rest: Vec<&str> = parts.iter().copied().filter(|part| !words.contains(part)).collect();
    (rest.len() < parts.len()).then(|| rest.join("_"))
}

/// Columns of both files that are called alike, or of one log those asked for and those that came.
pub(super) fn pairs(data: &Log, stream: &Log) -> Option<Made> {
    let all = |log: &Log| -> Vec<Guessed> {
        let guess = &log.guess;
        let poses = guess.position.iter().flatten().chain(guess.attitude.iter().flatten());
        poses.chain(&guess.heading).chain(&guess.others).cloned().collect()
    };
    let name_of = |log: &Log, one: &Guessed| log.survey.columns[one.column].name.clone();
    let is_one_log = std::ptr::eq(data, stream);
    let own_key = |name: &str| {
        let is_asked = is_one_log && stem(name, &ASKED).is_some();
        (!is_asked).then(|| stem(name, &CAME).unwrap_or_else(|| base(name).0))
    };
    let other_key = |name: &str| match is_one_log {
        true => stem(name, &ASKED),
        false => Some(stem(name, &ASKED).unwrap_or_else(|| base(name).0)),
    };
    let mut made: Vec<(String, Guessed, Guessed)> = Vec::new();
    for own in all(data) {
        let Some(own_key) = own_key(&name_of(data, &own)) else { continue };
        let other = all(stream).into_iter().find(|other| {
            other_key(&name_of(stream, other)).as_ref() == Some(&own_key)
                && other.unit.dimension == own.unit.dimension
        });
        made.extend(other.map(|other| (identifier(&own_key), own, other)));
    }
    let note = if made.is_empty() {
        let other = |one: &Guessed| one.unit.symbol != "1";
        let first = |log: &Log| {
            let all = all(log);
            all.iter().find(|one| other(one)).or(all.first()).cloned()
        };
        let (own, other) = (first(data)?, first(stream)?);
        if is_one_log && own.column == other.column {
            return None;
        }
        made.push((identifier(&base(&name_of(data, &own)).0), own, other));
        "# No two columns are called alike: WRITE what the readings of the data have to do with the stream.\n"
    } else {
        ""
    };
    let mut text = format!(
        "{note}# Each reading is what the stream says, scaled and shifted: WRITE the equations of your rig.\n\
         name   = \"begun\"\ntitle  = \"Readings of one log against another\"\nsource = \"guessed from names\"\n\n[inputs]\n"
    );
    let (mut parameters, mut measurands) = (String::new(), String::new());
    let (mut of_data, mut of_stream) = (Vec::new(), Vec::new());
    for (name, own, other) in &made {
        let (unit, from) = (&own.unit.symbol, &other.unit.symbol);
        text += &format!("ref_{name} = {{ unit = {}, signal = true }}\n", quoted(from));
        let factor = match own.unit.dimension == other.unit.dimension {
            true => "1".to_owned(),
            false => format!("({unit})/({from})"),
        };
        parameters += &format!(
            "{name}_scale  = {{ unit = {}, scope = \"instrument\", start = {} }}\n{name}_offset = {{ unit = {}, scope = \"setup\" }}\n",
            quoted(&factor),
            quoted(&format!("1 {factor}")),
            quoted(unit)
        );
        measurands += &format!(
            "{name} = {{ value = '{name}_scale * ref_{name} + {name}_offset', unit = {} }}\n",
            quoted(unit)
        );
        of_data.extend(Word::of(name, data, Some(own)));
        of_stream.extend(Word::of(&format!("ref_{name}"), stream, Some(other)));
    }
    let names: Vec<String> = made.iter().map(|(name, ..)| quoted(name)).collect();
    text += &format!(
        "\n[parameters]\n{parameters}\n[measurands]\n{measurands}\n[delays]                       # one clock stamps them all\nclock = {{ of = [{}] }}\n",
        names.join(", ")
    );
    let sigmas = made
        .iter()
        .map(|(name, own, _)| (name.clone(), sigma(name, &of_data, data, &own.unit)))
        .collect();
    let time = |log: &Log| Word::of(TIME, log, log.guess.time.as_ref());
    let of_data = time(data).into_iter().chain(of_data).collect();
    let of_stream = time(stream).into_iter().chain(of_stream).collect();
    Some(Made {
        name: "begun".into(),
        text,
        tables: tables((data, of_data), (stream, of_stream)),
        sigmas,
    })
}

/// A name of a model.
fn identifier(text: &str) -> String {
    let plain: String =
        text.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    let plain = plain.trim_matches('_');
    match name::fault_of(plain) {
        None if !plain.is_empty() => plain.to_owned(),
        _ => format!("c_{plain}"),
    }
}
