//! A stream that is logged beside the samples, made into a track: whole turns are taken out,
//! corrections put in, the rest is smoothed.
//!
//! Where a stream pauses, a turn cannot be told from its values alone: there the way that it went
//! before says how far it should have come.

use std::sync::Arc;

use crate::campaign::counters::{counts, turns};
use crate::campaign::declared::RunEntry;
use crate::campaign::header::TIME;
use crate::campaign::loader::Loader;
use crate::campaign::signal::{Track, unwrap};
use crate::campaign::spline::{Spline, is_pause, mean_spacing};
use crate::campaign::steps::steps;
use crate::campaign::table::Table;
use crate::campaign::time_units::coarse;
use crate::diagnostic::{Diagnostic, decimals};
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
        let (times, mut values): (Vec<f64>, Vec<f64>) =
            times.iter().zip(values).filter(|(_, value)| !value.is_nan()).unzip();
        let zero = stream.zero() as f64;
        let shown: Vec<f64> = times.iter().map(|time| time + zero).collect();
        let mut told = Vec::new();
        match self.inputs[index].period {
            Some(period) => {
                take_turns_out(&times, &mut values, period);
                told.extend(hardly_told(input, &values, period));
            }
            None => {
                told.extend(turns(input, &shown, &values));
                told.extend(counts(input, &shown, &values));
            }
        }
        told.extend(glitches(input, &shown, &values));
        told.extend(steps(input, &times, &values));
        told.extend(coarse(&shown, self.inputs[index].smoothing));
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
                self.reader.fault(span, message, "");
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

/// Values beside a value with which it is compared.
const BESIDE: usize = 8;
/// A glitch stands out by so many times what the values beside it stand out at most, and so many
/// times the least step: the last digit of an encoder that stands still may turn.
const GLITCH: f64 = 30.0;
/// Because of a glitch its neighbours are off by about half as much the other way; of where a
/// motion begins none is.
const NEIGHBOUR: f64 = 0.2;
/// Glitches told at most.
const TOLD: usize = 3;

/// Warns of single values far off the line between their neighbours, where those beside them are
/// not: the curve goes through them.
fn glitches(input: &InputDeclaration, times: &[f64], values: &[f64]) -> Option<Diagnostic> {
    let off = |i: usize| {
        let part = (times[i] - times[i - 1]) / (times[i + 1] - times[i - 1]);
        let line = values[i - 1] + part * (values[i + 1] - values[i - 1]);
        let off = values[i] - line;
        if off.is_finite() { off } else { 0.0 }
    };
    let off: Vec<f64> = (1..values.len().saturating_sub(1)).map(off).collect();
    let steps = values.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let least = steps.filter(|step| *step > 0.0).fold(f64::INFINITY, f64::min);
    let is_glitch = |i: &usize| {
        let neighbours =
            [i.wrapping_sub(1), i + 1].map(|n| off.get(n).map(|other| -other / off[*i]));
        if neighbours.iter().any(|part| part.is_none_or(|part| !(NEIGHBOUR..1.0).contains(&part))) {
            return false;
        }
        let before = i.saturating_sub(BESIDE)..i.saturating_sub(1);
        let after = (i + 2).min(off.len())..(i + 2 + BESIDE).min(off.len());
        let beside = before.chain(after).map(|n| off[n].abs());
        let count = beside.clone().count();
        let most = beside.fold(least, f64::max);
        count >= BESIDE && off[*i].abs() > GLITCH * most
    };
    let found: Vec<usize> = (0..off.len()).filter(is_glitch).collect();
    let at: Vec<String> =
        found.iter().take(TOLD).map(|i| format!("{} s", decimals(times[i + 1], 3))).collect();
    let more = if found.len() > TOLD {
        format!(" and {} more", found.len() - TOLD)
    } else {
        String::new()
    };
    (!found.is_empty()).then(|| {
        let message = format!(
            "the stream of `{}` has values far off their neighbours at {}{more}",
            input.name,
            at.join(", ")
        );
        Diagnostic::warning(message).help("the curve goes through them: leave such cells empty")
    })
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

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

    #[test]
    fn a_glitch_is_told_and_the_beginning_of_a_motion_is_none() {
        let model = "name = \"m\"\ntitle = \"m\"\n[inputs]\nq = { unit = \"m\", signal = true }\n[parameters]\nc = { unit = \"m\", scope = \"rig\" }\n[measurands]\nx = { value = 'q + c', unit = \"m\" }\n";
        let model =
            crate::model::Model::parse(crate::diagnostic::Source::new("m.toml", model)).unwrap();
        let input = &model.inputs[0];
        let times: Vec<f64> = (0..400).map(|n| 0.01 * f64::from(n)).collect();
        let stands_moves_and_swings = |t: &f64| match *t {
            t if t < 1.0 => 0.2,
            t if t < 2.0 => 0.2 + 0.5 * (t - 1.0),
            t if t < 3.0 => 0.7 + 0.05 * (7.0 * (t - 2.0)).sin(),
            // Put to another place.
            _ => 1.5,
        };
        let mut values: Vec<f64> = times.iter().map(stands_moves_and_swings).collect();
        assert!(glitches(input, &times, &values).is_none());
        values
            .iter_mut()
            .enumerate()
            .for_each(|(n, value)| *value += 1e-5 * (7.1 * n as f64).sin());
        assert!(glitches(input, &times, &values).is_none());
        values[50] = 0.0;
        values[250] = -999.0;
        let told = glitches(input, &times, &values).unwrap().message;
        assert!(told.contains("at 0.500 s, 2.500 s"), "{told}");
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
