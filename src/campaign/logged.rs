//! A stream that is logged beside the samples, made into a track: whole turns are taken out, corrections
//! put in, the rest is smoothed.
//!
//! Where a stream pauses, a turn cannot be told from its values alone: there the way that it went before
//! says how far it should have come.

use std::sync::Arc;

use crate::campaign::file::RunEntry;
use crate::campaign::samples::Loader;
use crate::campaign::signal::{Track, unwrap};
use crate::campaign::spline::{Spline, is_pause, mean_spacing};
use crate::campaign::table::{TIME, Table};
use crate::diagnostic::Diagnostic;
use crate::model::InputDeclaration;
use crate::units::Dimension;

/// Values before a pause that tell how the stream went on.
const BEFORE: usize = 32;
/// ... and at least over such a part of its length.
const PART_BEFORE: f64 = 0.1;

impl Loader<'_> {
    /// The track of an input that a stream holds; absent after a fault.
    pub(crate) fn logged(&mut self, index: usize, entry: &RunEntry, stream: &Table) -> Track {
        let input = &self.model.inputs[index];
        let span = entry.signals.first().map_or(entry.name.span, |name| name.span);
        let (Some(times), Some(values)) = (stream.values(TIME), stream.values(&input.name)) else {
            let message = format!("the stream of `{}` has no column `time [s]`", input.name);
            self.reader.fault(span, message, format!("columns found: {}", stream.names()));
            return Track::Absent;
        };
        let (times, mut values): (Vec<f64>, Vec<f64>) =
            times.iter().zip(values).filter(|(_, value)| !value.is_nan()).unzip();
        match self.inputs[index].period {
            Some(period) => take_turns_out(&times, &mut values, period),
            None => self.warnings.extend(turns(input, entry, &times, &values)),
        }
        if let Some(corrections) = &self.inputs[index].corrections {
            for value in &mut values {
                corrections.correct(value);
            }
        }
        match Spline::fit(&times, &values, self.inputs[index].smoothing) {
            Ok(spline) => Track::Logged(Arc::new(spline)),
            Err(error) => {
                let message = format!("the stream of `{}` cannot be smoothed: {error}", input.name);
                self.reader.fault(span, message, "");
                Track::Absent
            }
        }
    }
}

/// Takes jumps by whole periods out of a stream: values stay within half a period of the one before, and
/// after a pause of the value that the way before it leads to.
fn take_turns_out(times: &[f64], values: &mut [f64], period: f64) {
    let spacing = mean_spacing(times);
    // First within the stretches between pauses, so that the way before a pause is known.
    let mut start = 0;
    let mut known: Option<f64> = None;
    for end in 1..=values.len() {
        if end < values.len() && !is_pause(times[end] - times[end - 1], spacing) {
            continue;
        }
        let stretch = &mut values[start..end];
        unwrap(stretch, period, |_, _| 0.0);
        if let (Some(expected), Some(first)) = (known, stretch.first()) {
            let turns = ((first - expected) / period).round() * period;
            stretch.iter_mut().for_each(|value| *value -= turns);
        }
        known = times.get(end).map(|next| {
            let last = end - 1;
            values[last]
                + rate_before(times, values, last, next - times[last]) * (next - times[last])
        });
        start = end;
    }
}

/// How fast a stream went before a pause: over some values at least, and over a part of the pause, for stamps
/// may come in bursts; nothing where it is too short for that.
fn rate_before(times: &[f64], values: &[f64], last: usize, pause: f64) -> f64 {
    let enough = PART_BEFORE * pause;
    let early = times[..last].partition_point(|time| *time <= times[last] - enough);
    let from = early.saturating_sub(1).min(last.saturating_sub(BEFORE));
    let passed = times[last] - times[from];
    if passed > 0.0 && passed >= enough { (values[last] - values[from]) / passed } else { 0.0 }
}

/// Warns of an angle without period that jumps by more than half a turn where it mostly moves by less than a
/// quarter: an encoder that begins anew with each turn.
fn turns(
    input: &InputDeclaration,
    entry: &RunEntry,
    times: &[f64],
    values: &[f64],
) -> Option<Diagnostic> {
    let turn = std::f64::consts::TAU;
    let is_angle = input.unit.dimension == Dimension::NONE && input.unit.symbol != "1";
    let steps = || values.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let quick = steps().filter(|step| *step > 0.25 * turn).count();
    if !is_angle || 2 * quick > values.len() {
        return None;
    }
    let at = steps().position(|step| step > 0.5 * turn)?;
    let message = format!(
        "the stream of `{}` in run `{}` jumps by more than half a turn at {:.3} s",
        input.name, entry.name.text, times[at]
    );
    let help = format!(
        "the jump is taken for a motion; where the encoder begins anew with each turn, say so: `[inputs] {} = {{ period = \"360 deg\" }}`",
        input.name
    );
    Some(Diagnostic::warning(message).help(help))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An angle (rad) that turns at a rate (rad/s), as an encoder of one turn shows it, with a pause.
    fn encoder(rate: f64, pause: (f64, f64)) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let turn = std::f64::consts::TAU;
        let times = (0..2000).map(|n| f64::from(n) * 0.01);
        let times: Vec<f64> = times.filter(|t| *t < pause.0 || *t > pause.1).collect();
        let angles: Vec<f64> = times.iter().map(|t| 1.0 + rate * t).collect();
        let shown = angles.iter().map(|angle| angle.rem_euclid(turn)).collect();
        (times, shown, angles)
    }

    #[test]
    fn turns_are_counted_on_through_a_pause() {
        for rate in [0.1, 3.3, -3.3, 31.0] {
            for pause in [(9.0, 9.0), (5.0, 7.0), (12.0, 19.0)] {
                let (times, mut values, angles) = encoder(rate, pause);
                take_turns_out(&times, &mut values, std::f64::consts::TAU);
                let off = values.iter().zip(&angles).map(|(own, angle)| (own - angle).abs());
                assert!(off.fold(0.0, f64::max) < 1e-9, "{rate} {pause:?}");
            }
        }
    }

    #[test]
    fn stamps_that_come_in_bursts_lead_nowhere() {
        let (_, mut values, angles) = encoder(3.3, (9.0, 9.0));
        for size in [5, 50] {
            // So many values at a time, so that most intervals are next to nothing.
            let burst = |n: usize| 0.01 * (n - n % size) as f64 + 1e-6 * (n % size) as f64;
            let times: Vec<f64> = (0..values.len()).map(burst).collect();
            take_turns_out(&times, &mut values, std::f64::consts::TAU);
            let off = values.iter().zip(&angles).map(|(own, angle)| (own - angle).abs());
            assert!(off.fold(0.0, f64::max) < 1e-9, "{size}");
        }
    }
}
