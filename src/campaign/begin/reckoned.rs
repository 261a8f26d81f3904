//! A path of dead reckoning: by how much it bends for a scale of its heading.
//!
//! Wheel counts, steps or an integrated gyro turn by `1 + h` times the true turns. Each step of the
//! path is then turned by `h` times the turns `T` since the first pose: the path is `∫ R(h T) dp`. That
//! is an integral over the way, which formulas do not have. It is computed at a value of `h`, with its
//! derivative there. An offset of the point on the body needs no integral: turned with it, and over
//! `1 + h`, it is exact.
//!
//! Turns are counted from the mean heading, the turn up to there is one of the frame: counted from the
//! first pose, the derivative has the noise of the path times a number of one sign, and a diagnosis finds
//! the one in the other.

use std::collections::BTreeSet;

use crate::campaign::begin::candidate::Candidate;
use crate::campaign::begin::log::Log;
use crate::campaign::begin::turns::{Heading, heading_scale};
use crate::campaign::begin::word::Word;
use crate::campaign::glitches::glitches;

/// The file of the bend.
pub(super) const BEND: &str = "bend.csv";
/// Turns (rad) that a scale of the heading may be off by: the derivative then leaves about half the square of
/// it, in parts of the way.
const SMALL: f64 = 0.02;
/// So much of the way, and of a radian, is about zero.
const NEAR_ZERO: f64 = 0.03;

const BENT: &str = r#"
# DEAD_RECKONING begins about at zero, as a path of dead reckoning (wheel counts, steps, an integrated gyro)
# does: its distances and headings have scale errors, and a wrong heading bends the path more and
# more. That is an integral over the way, which formulas do not have: BEND was computed from the
# stream's poses at a heading_scale of SCALE (WHY).
# Turns count from the first pose of the stream: frame_turn, frame_x and frame_y are those there.
# Where `calibrate` finds another scale by more than RANGE, compute BEND and this model again:
#     homepoint new FOLDER --from LOG LOG --heading-scale VALUE
# Clocks of such recorders often run at another rate, too: `calibrate --with sample_clock_rate`.
# A circle alone hardly tells the lever from the scales: look at `calibrate --noise sandwich`.
middle_turn = 'frame_turn + heading_scale * (MEAN rad - FIRST rad)'
direction   = 'ref_heading + heading_scale * (ref_heading - MEAN rad)'
path_x      = 'ref_x + bend_x + (heading_scale - (SCALE)) * bend_x_by_scale'
path_y      = 'ref_y + bend_y + (heading_scale - (SCALE)) * bend_y_by_scale'
point_x     = '(1 + distance_scale) * path_x + LEVER * (lever_forward * cos(direction) - lever_left * sin(direction))'
point_y     = '(1 + distance_scale) * path_y + LEVER * (lever_forward * sin(direction) + lever_left * cos(direction))'
"#;
/// A distance of the other sign, beside two angles that are half a turn off, fits as well: hence the bound.
const SCALES: &str = r#"distance_scale = { unit = "1", scope = "instrument", lower = "-0.9", about = "by how much the data's distances are longer" }
heading_scale  = { unit = "1", scope = "instrument", start = "SCALE", simulated_at = "SCALE", linear_range = "RANGE", about = "by how much its turns are larger" }
"#;
const BENDS: &str = r#"bend_x          = { unit = "m", signal = true, smooth = "SMOOTH" }
bend_y          = { unit = "m", signal = true, smooth = "SMOOTH" }
bend_x_by_scale = { unit = "m", signal = true, smooth = "SMOOTH" }
bend_y_by_scale = { unit = "m", signal = true, smooth = "SMOOTH" }
"#;

/// The offset of the heading, without what it is about.
const HEADING_OFFSET: &str = r#"heading_offset = { unit = "rad", scope = "instrument","#;

/// How a path of dead reckoning bends.
#[derive(Clone, Debug)]
pub(super) struct Reckoned {
    /// The text of the table.
    pub(super) table: String,
    scale: String,
    why: &'static str,
    range: String,
    /// The first heading of the stream, and the mean of all.
    headings: [f64; 2],
    /// Whether it is that of the data, not of the stream.
    pub(super) is_of_data: bool,
}

/// A pose of a log (SI), with its stamp as the file has it.
#[derive(Clone, Copy, Debug)]
struct Pose {
    stamp: f64,
    x: f64,
    y: f64,
    heading: f64,
}

impl Reckoned {
    /// Of a stream, for data; words are those of the stamps, x, y and the heading. At the scale of the heading
    /// that is stated, else that of the headings of both. `None` where neither begins about at zero, or the
    /// stream was not read to its end.
    pub(super) fn of(
        (data, of_data): (&Log, &[Word]),
        (stream, of_stream): (&Log, &[Word]),
        stated: Option<f64>,
    ) -> Option<Self> {
        let is_of_data = begins_at_zero(data);
        if !is_of_data && !begins_at_zero(stream) || stream.survey.is_cut {
            return None;
        }
        let (own, poses) = (poses(data, of_data)?, poses(stream, of_stream)?);
        let headings = |log: &Log, poses: &[Pose]| -> Option<Vec<Heading>> {
            let unit = &log.guess.time.as_ref()?.unit;
            Some(poses.iter().map(|pose| (unit.to_si(pose.stamp), pose.heading)).collect())
        };
        let (of_data, of_stream) = (headings(data, &own)?, headings(stream, &poses)?);
        let (scale, why) = match stated.or_else(|| heading_scale(&of_data, &of_stream)) {
            Some(scale) if stated.is_some() => (scale, "stated"),
            Some(scale) => (scale, "that of the headings of both logs"),
            None => (0.0, why_no_scale(&of_data, &of_stream)),
        };
        // As the model states it.
        let scale = format!("{scale:.6}");
        let value: f64 = scale.parse().ok()?;
        let first = poses.first()?.heading;
        let mean = poses.iter().map(|pose| pose.heading).sum::<f64>() / poses.len() as f64;
        // As the model states them.
        let headings = [first, mean].map(|one| (1e7 * one).round() * 1e-7);
        let most = poses.iter().map(|pose| (pose.heading - mean).abs());
        let range = format!("{:.1e}", SMALL / most.fold(SMALL, f64::max));
        let unit = &stream.guess.time.as_ref()?.unit.symbol;
        let table = table(&poses, unit, value, headings);
        Some(Self { table, scale, why, range, headings, is_of_data })
    }

    /// The model of poses in a plane with the scales of this path.
    pub(super) fn model(&self, planar: &str, smooth: &str) -> String {
        let (first, rest) = planar.split_once("point_x = ").unwrap_or((planar, ""));
        let (_, rest) = rest.split_once("\n\n").unwrap_or(("", rest));
        let section = |name: &str, text: &str| format!("\n{}\n[{name}]\n", text.trim_start());
        let planar = format!("{first}{}\n{rest}", BENT.trim_start())
            .replace("\n\n[parameters]\n", &section("parameters", BENDS).replace("SMOOTH", smooth))
            .replace("\n\n[quantities]\n", &section("quantities", SCALES))
            .replace("'ref_heading + heading_offset", "'direction + heading_offset")
            .replace("(frame_turn)", "(middle_turn)")
            .replace("heading_offset + frame_turn", "heading_offset + middle_turn")
            // Runs begin at different headings, and have one mean heading in the formulas.
            .replace(HEADING_OFFSET, &HEADING_OFFSET.replace("instrument", "setup"));
        let (log, lever) = match self.is_of_data {
            // The path of a point that is off the axis goes round it, with the scales of the path.
            true => ("The data", "(1 + distance_scale) / (1 + heading_scale)"),
            false => ("The stream", "1"),
        };
        let [first, mean] = self.headings.map(|one| format!("{one:.7}"));
        [
            ("DEAD_RECKONING", log),
            ("LEVER", lever),
            ("SCALE", &self.scale),
            ("WHY", self.why),
            ("RANGE", &self.range),
            ("FIRST", &first),
            ("MEAN", &mean),
            ("BEND", BEND),
        ]
        .iter()
        .fold(planar, |text, (word, own)| text.replace(word, own))
    }
}

/// Why the headings of two logs have no scale.
fn why_no_scale(data: &[Heading], stream: &[Heading]) -> &'static str {
    let opposite: Vec<Heading> = data.iter().map(|(time, heading)| (*time, -heading)).collect();
    match heading_scale(&opposite, stream) {
        Some(_) => "the headings of the logs turn in opposite senses: change the sign of one",
        None => "the headings of the logs do not go along with each other",
    }
}

/// That the bend of a path of dead reckoning is not computed, for the stream was not read to its end.
pub(super) fn not_computed(data: &Log, stream: &Log) -> Option<String> {
    let is_reckoned = begins_at_zero(data) || begins_at_zero(stream);
    (is_reckoned && stream.survey.is_cut).then(|| {
        format!(
            "one of the logs begins as a path of dead reckoning does; its bend is not computed, for `{}` is too long: name a shorter log",
            stream.survey.path.display()
        )
    })
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

/// The poses of a log in the order of time, without single values that are far off, and without jumps by
/// whole turns.
fn poses(log: &Log, words: &[Word]) -> Option<Vec<Pose>> {
    let (time, words) = (log.guess.time.as_ref()?, words.get(1..4)?);
    let column = |word: &Word| &log.survey.columns[word.candidate.column].values;
    let poses = time.values.iter().enumerate().map(|(row, stamp)| {
        let si = |word: &Word| word.candidate.unit.to_si(column(word)[row]);
        Pose { stamp: *stamp, x: si(&words[0]), y: si(&words[1]), heading: si(&words[2]) }
    });
    let is_whole =
        |own: &Pose| [own.stamp, own.x, own.y, own.heading].iter().all(|one| one.is_finite());
    let mut poses: Vec<Pose> = poses.filter(is_whole).collect();
    // Rows may be out of order.
    poses.sort_by(|a, b| a.stamp.total_cmp(&b.stamp));
    poses.dedup_by(|a, b| a.stamp == b.stamp);
    let turn = std::f64::consts::TAU;
    for row in 1..poses.len() {
        let step = poses[row].heading - poses[row - 1].heading;
        poses[row].heading -= turn * (step / turn).round();
    }
    let stamps: Vec<f64> = poses.iter().map(|pose| pose.stamp).collect();
    let off = |of: fn(&Pose) -> f64| glitches(&stamps, &poses.iter().map(of).collect::<Vec<_>>());
    let off = [off(|own| own.x), off(|own| own.y), off(|own| own.heading)];
    let off: BTreeSet<usize> = off.concat().into_iter().collect();
    let mut row = 0..;
    poses.retain(|_| row.next().is_none_or(|row| !off.contains(&row)));
    Some(poses)
}

/// By how much the path is bent at a scale of the heading, and the derivative by that: from the origin of
/// the frame on, with the first heading up to the first pose.
fn table(poses: &[Pose], unit: &str, scale: f64, [first, mean]: [f64; 2]) -> String {
    let mut text =
        format!("time [{unit}],bend_x [m],bend_y [m],bend_x_by_scale [m],bend_y_by_scale [m]\n");
    let [mut bend_x, mut bend_y, mut bend_x_by_scale, mut bend_y_by_scale] = [0.0; 4];
    let mut last = Pose { stamp: 0.0, x: 0.0, y: 0.0, heading: first };
    for own in poses {
        let (dx, dy) = (own.x - last.x, own.y - last.y);
        let turned = 0.5 * (own.heading + last.heading) - mean;
        let (sin, cos) = (scale * turned).sin_cos();
        bend_x += (cos - 1.0) * dx - sin * dy;
        bend_y += sin * dx + (cos - 1.0) * dy;
        bend_x_by_scale -= turned * (sin * dx + cos * dy);
        bend_y_by_scale += turned * (cos * dx - sin * dy);
        text += &format!(
            "{},{bend_x:.7},{bend_y:.7},{bend_x_by_scale:.6},{bend_y_by_scale:.6}\n",
            own.stamp
        );
        last = *own;
    }
    text
}
