//! Single values of a stream that are far off their neighbours: bits that flipped, a value of another
//! channel. No curve goes through them and its neighbours; they are left out.

use crate::campaign::stream_rows::leave_rows_out;
use crate::diagnostic::{Diagnostic, decimals};
use crate::model::InputDeclaration;

/// Values beside a value with which it is compared.
const BESIDE: usize = 8;
/// A glitch stands out by so many times what the values beside it stand out at most, and so many
/// times the least step: the last digit of an encoder that stands still may turn.
const GLITCH: f64 = 30.0;
/// Because of a glitch its neighbours are off by about half as much the other way; of where a
/// motion begins none is.
const NEIGHBOUR: f64 = 0.2;
/// Glitches listed at most.
const LISTED: usize = 3;

/// Leaves single values out that are far off the line between their neighbours, where those beside
/// them are not; the warning of them. The first time is at `zero`.
pub(crate) fn without_glitches(
    input: &InputDeclaration,
    times: &mut Vec<f64>,
    values: &mut Vec<f64>,
    zero: f64,
) -> Option<Diagnostic> {
    let found = glitches(times, values);
    if found.is_empty() {
        return None;
    }
    let at = found.iter().take(LISTED).map(|i| format!("{} s", decimals(times[*i] + zero, 3)));
    let at = at.collect::<Vec<_>>().join(", ");
    leave_rows_out(times, values, |row| found.binary_search(&row).is_ok());
    let more = match found.len().saturating_sub(LISTED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let message = format!(
        "the stream of `{}` has values far off their neighbours at {at}{more}: these are left out",
        input.name
    );
    Some(Diagnostic::warning(message))
}

/// The values, by number.
pub(crate) fn glitches(times: &[f64], values: &[f64]) -> Vec<usize> {
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
    (0..off.len()).filter(is_glitch).map(|i| i + 1).collect()
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use super::*;

    #[test]
    fn a_glitch_is_left_out_and_the_beginning_of_a_motion_is_none() {
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
        assert!(glitches(&times, &values).is_empty());
        values
            .iter_mut()
            .enumerate()
            .for_each(|(n, value)| *value += 1e-5 * (7.1 * n as f64).sin());
        assert!(glitches(&times, &values).is_empty());
        values[50] = 0.0;
        values[250] = -999.0;
        assert_eq!(glitches(&times, &values), [50, 250]);
        let (mut times, rest) = (times, values.clone());
        let warning = without_glitches(input, &mut times, &mut values, 0.0).unwrap().message;
        assert!(warning.contains("at 0.500 s, 2.500 s"), "{warning}");
        assert_eq!((times.len(), values.len()), (398, 398));
        assert!(values == [&rest[..50], &rest[51..250], &rest[251..]].concat());
    }
}
