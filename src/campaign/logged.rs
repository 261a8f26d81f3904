//! A stream that is logged beside the samples, made into a track: whole turns are taken out,
//! corrections put in, the rest is smoothed.
//!
//! Where a stream pauses, a turn cannot be told from its values alone: there the way that it went
//! before says how far it should have come.

use std::sync::Arc;

use crate::campaign::counters::{counts, turns};
use crate::campaign::declared::RunEntry;
use crate::campaign::glitches::without_glitches;
use crate::campaign::header::TIME;
use crate::campaign::held_streams::without_held;
use crate::campaign::loader::Loader;
use crate::campaign::signal::{Track, unwrap};
use crate::campaign::spline::{Spline, SplineError, is_pause, mean_spacing};
use crate::campaign::steps::steps;
use crate::campaign::table::Table;
use crate::campaign::time_units::{Stamps, coarse};
use crate::diagnostic::Diagnostic;
use crate::model::InputDeclaration;

/// A stream that goes over so many periods counts turns by itself.
const COUNTED: f64 = 1.2;
/// Values beside a pause that tell how the stream went on.
const BEFORE: usize = 32;
/// ... and at least over such a part of its length.
const PART_BEFORE: f64 = 0.1;

impl Loader<'_> {
    /// The track of an input that a stream holds; absent after a fault.
    pub(crate) fn logged(&mut self, index: usize, entry: &RunEntry, stream: &Table) -> Track {
        let input = &self.model.inputs[index];
        let span = entry.signals.first().map_or(entry.name.span, |stream| stream.name.span);
        let (Some(times), Some(values)) = (stream.values(TIME), stream.values(&input.name)) else {
            return Track::Absent;
        };
        let (mut times, mut values): (Vec<f64>, Vec<f64>) =
            times.iter().zip(values).filter(|(_, value)| !value.is_nan()).unzip();
        let zero = stream.zero() as f64;
        let mut told = Vec::new();
        told.extend(without_held(input, &mut times, &mut values, zero));
        match self.inputs[index].period {
            Some(period) => {
                take_turns_out(&times, &mut values, period);
                told.extend(hardly_told(input, &values, period));
            }
            None => {
                let shown: Vec<f64> = times.iter().map(|time| time + zero).collect();
                told.extend(turns(input, &shown, &values));
                told.extend(counts(input, &shown, &values));
            }
        }
        told.extend(without_glitches(input, &mut times, &mut values, zero));
        told.extend(steps(input, &times, &values));
        let shown: Vec<f64> = times.iter().map(|time| time + zero).collect();
        let stamps = Stamps::of(entry, stream);
        told.extend(coarse(&shown, self.inputs[index].smoothing, stamps.as_ref()));
        let run = |one: Diagnostic| Diagnostic {
            message: format!("run `{}`: {}", entry.name.text, one.message),
            ..one
        };
        for one in told.into_iter().map(run) {
            // Inputs of one stream have its times in common.
            if self.warnings.iter().all(|known| known.message != one.message) {
                self.warnings.push(one);
            }
        }
        drop(shown);
        if let Some(corrections) = &self.inputs[index].corrections {
            for value in &mut values {
                corrections.correct(value);
            }
        }
        match Spline::fit(&times, &values, self.inputs[index].smoothing) {
            Ok(spline) => Track::Logged(Arc::new(spline)),
            Err(error) => {
                let message = format!("the stream of `{}` cannot be smoothed: {error}", input.name);
                let help = match error {
                    SplineError::Empty => format!(
                        "no row of the file has a number in the column of `{}`: is it the right one?",
                        input.name
                    ),
                    _ => String::new(),
                };
                self.reader.fault(span, message, help);
                Track::Absent
            }
        }
    }
}

/// Takes jumps by whole periods out of a stream: values stay within half a period of the one
/// before, and after a pause of the value that the way before it leads to, if it goes on like that
/// behind it. A stream that goes beyond its period counts turns by itself.
fn take_turns_out(times: &[f64], values: &mut [f64], period: f64) {
    let (least, most) =
        values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), value| {
            (least.min(*value), most.max(*value))
        });
    if most - least > COUNTED * period {
        return;
    }
    // First within the stretches between pauses, so that the ways before and behind one are known.
    let spacing = mean_spacing(times);
    let is_cut = |n: &usize| is_pause(times[*n] - times[*n - 1], spacing);
    let cuts: Vec<usize> = (1..values.len()).filter(is_cut).collect();
    let starts = || std::iter::once(0).chain(cuts.iter().copied());
    let ends = cuts.iter().copied().chain([values.len()]);
    for (start, end) in starts().zip(ends.clone()) {
        unwrap(&mut values[start..end], period, |_, _| 0.0);
    }
    for ((start, end), behind) in starts().zip(ends.clone()).zip(ends.skip(1)) {
        let (last, pause) = (end - 1, times[end] - times[end - 1]);
        let before = rate(&times[start..end], &values[start..end], pause, true);
        let after = rate(&times[end..behind], &values[end..behind], pause, false);
        let goes_on = (before - after).abs() * pause < period;
        let way = if goes_on { 0.5 * (before + after) * pause } else { 0.0 };
        let turns = ((values[end] - values[last] - way) / period).round() * period;
        values[end..behind].iter_mut().for_each(|value| *value -= turns);
    }
}

/// How fast a stretch goes at its end, or its beginning, beside a pause: over some values at least,
/// and over a part of the pause, for stamps may come in bursts; nothing where it is too short for
/// that.
fn rate(times: &[f64], values: &[f64], pause: f64, at_end: bool) -> f64 {
    let (last, enough) = (times.len() - 1, PART_BEFORE * pause);
    let (from, to) = if at_end {
        let early = times.partition_point(|time| *time <= times[last] - enough);
        (early.saturating_sub(1).min(last.saturating_sub(BEFORE)), last)
    } else {
        let late = times.partition_point(|time| *time < times[0] + enough);
        (0, late.max(BEFORE).min(last))
    };
    let passed = times[to] - times[from];
    if passed > 0.0 && passed >= enough { (values[to] - values[from]) / passed } else { 0.0 }
}

/// Warns of a stream that moves by a third of a period and more from value to value: a turn may be
/// lost.
fn hardly_told(input: &InputDeclaration, values: &[f64], period: f64) -> Option<Diagnostic> {
    let mut steps: Vec<f64> = values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    let middle = steps.len() / 2;
    let is_far =
        !steps.is_empty() && *steps.select_nth_unstable_by(middle, f64::total_cmp).1 > period / 3.0;
    is_far.then(|| {
        let message = format!(
            "the stream of `{}` moves by more than a third of its period from value to value",
            input.name
        );
        let help = "whole turns between values cannot be told: log it more often";
        Diagnostic::warning(message).help(help)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An angle (rad) that turns at a rate (rad/s), as an encoder of one turn shows it, with a
    /// pause.
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

    /// A stop in the pause, and an encoder that counts turns: nothing is added.
    #[test]
    fn what_stands_still_in_a_pause_gains_no_turns() {
        let times = (0..1500).map(|n| f64::from(n) * 0.01).filter(|t| *t < 5.0 || *t > 12.0);
        let times: Vec<f64> = times.collect();
        for start in [0.3, 12.0] {
            let angle = |t: &f64| start + t.min(5.0);
            let shown: Vec<f64> = times.iter().map(angle).collect();
            let mut values = shown.clone();
            take_turns_out(&times, &mut values, std::f64::consts::TAU);
            assert_eq!(values, shown);
        }
        let counted: Vec<f64> = times.iter().map(|t| 3.0 * t).collect();
        let mut values = counted.clone();
        take_turns_out(&times, &mut values, std::f64::consts::TAU);
        assert_eq!(values, counted);
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
