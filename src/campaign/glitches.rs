//! Single values of a stream that are far off their neighbours: bits that flipped, a value of another
//! channel. No curve goes through them and its neighbours; they are left out.

use crate::campaign::stream_rows::leave_rows_out;
use crate::diagnostic::{Diagnostic, decimals};
use crate::model::InputDeclaration;

/// Passes at most.
const MOST_PASSES: usize = 20;
/// Differences below such a part of the largest value are those of binary numbers.
const ROUNDED: f64 = 1e-12;
/// Values beside a value with which it is compared.
const BESIDE: usize = 8;
/// A glitch is suspected where it stands out by so many times what three quarters of the values beside
/// it do. It is one where it does by so many times what any of them does without those suspected, and
/// so many times the least step: the last digit of an encoder that stands still may turn. Scatter
/// reaches neither.
const SUSPECT: f64 = 8.0;
const GLITCH: f64 = 5.0;
const STEPS: f64 = 30.0;
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

/// The values, by number. Those that are left out no longer hide others beside them.
pub(crate) fn glitches(times: &[f64], values: &[f64]) -> Vec<usize> {
    let least = least_step(values);
    let mut rest: Vec<usize> = (0..values.len()).collect();
    let mut found = Vec::new();
    // Each pass is linear.
    for _ in 0..MOST_PASSES {
        let new = far_off(times, values, &rest, least);
        if new.is_empty() {
            break;
        }
        rest.retain(|row| new.binary_search(row).is_err());
        found.extend(new);
    }
    found.sort_unstable();
    found
}

/// The step to which values are rounded, if they are; infinite where there is none. It is that of second
/// differences: a steady motion has none, and rounded values have whole steps in them, too.
pub(crate) fn least_step(values: &[f64]) -> f64 {
    let finite = values.iter().filter(|value| value.is_finite());
    let size = finite.fold(0.0_f64, |most, value| most.max(value.abs()));
    let steps = values.windows(3).map(|three| (three[2] - 2.0 * three[1] + three[0]).abs());
    steps.filter(|step| *step > ROUNDED * size).fold(f64::INFINITY, f64::min)
}

/// Those of some rows that are glitches beside the others.
fn far_off(times: &[f64], values: &[f64], rows: &[usize], least: f64) -> Vec<usize> {
    let off = off(times, values, rows);
    let is_suspect = |at: &usize| {
        let neighbours =
            [at.wrapping_sub(1), at + 1].map(|n| off.get(n).map(|other| -other / off[*at]));
        if neighbours.iter().any(|part| part.is_none_or(|part| !(NEIGHBOUR..1.0).contains(&part))) {
            return false;
        }
        let before = at.saturating_sub(BESIDE)..at.saturating_sub(1);
        let after = (at + 2).min(off.len())..(at + 2 + BESIDE).min(off.len());
        let mut beside: Vec<f64> = before.chain(after).map(|n| off[n].abs()).collect();
        let most = 3 * beside.len() / 4;
        beside.len() >= BESIDE
            && off[*at].abs() > STEPS * least
            && off[*at].abs() > SUSPECT * *beside.select_nth_unstable_by(most, f64::total_cmp).1
    };
    let suspects: Vec<usize> = (0..off.len()).filter(is_suspect).collect();
    // `off` has no value for the first row.
    let mut next = suspects.iter().map(|at| at + 1).peekable();
    let mut at = 0..;
    let is_left = |_: &&usize| at.next().is_none_or(|at| next.next_if_eq(&at).is_none());
    let rest: Vec<usize> = rows.iter().filter(is_left).copied().collect();
    let beside = self::off(times, values, &rest);
    let is_glitch = |(before, at): &(usize, &usize)| {
        // Where it would stand in the rest.
        let place = **at - before;
        let near = place.saturating_sub(BESIDE)..(place + BESIDE).min(beside.len());
        near.into_iter().all(|n| off[**at].abs() > GLITCH * beside[n].abs())
    };
    suspects.iter().enumerate().filter(is_glitch).map(|(_, at)| rows[at + 1]).collect()
}

/// How far values of rows, but the first and the last, are off the line between their neighbours.
fn off(times: &[f64], values: &[f64], rows: &[usize]) -> Vec<f64> {
    let off = |three: &[usize]| {
        let [from, own, to] = [three[0], three[1], three[2]];
        let part = (times[own] - times[from]) / (times[to] - times[from]);
        let off = values[own] - (values[from] + part * (values[to] - values[from]));
        if off.is_finite() { off } else { 0.0 }
    };
    rows.windows(3).map(off).collect()
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

    /// Two in a hundred values of a path are off by a normal deviate of 0.15 m, beside noise of 0.4 mm.
    #[test]
    fn glitches_among_others_are_found_down_to_some_of_the_noise() {
        let count = 6000;
        let mut state = 7_u64;
        let mut uniform = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut normal = || (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
        let times: Vec<f64> = (0..count).map(|n| 0.01 * f64::from(n)).collect();
        let path = |t: &f64| (0.7 * t).sin() + 0.2 * (2.3 * t).cos();
        let clean: Vec<f64> = times.iter().map(|t| path(t) + 4e-4 * normal()).collect();
        assert!(glitches(&times, &clean).is_empty());
        let mut values = clean.clone();
        let mut far = Vec::new();
        for row in (20..5980).step_by(50) {
            // Some of them three rows apart.
            for row in [row, row + 3 * (row % 3)] {
                values[row] += 0.15 * normal();
            }
        }
        far.extend((0..values.len()).filter(|row| (values[*row] - clean[*row]).abs() > 8e-3));
        let found = glitches(&times, &values);
        let missed = far.iter().filter(|row| !found.contains(row)).count();
        assert!(far.len() > 150 && missed <= 2, "{missed} of {}", far.len());
        assert!(found.iter().all(|row| values[*row] != clean[*row]), "{found:?}");
        // The steps of a steady motion are not those of rounding.
        let mut steady: Vec<f64> = times.iter().map(|t| 0.01 * t + 1e-6 * normal()).collect();
        assert!(glitches(&times, &steady).is_empty());
        [300, 900, 2500].into_iter().for_each(|row| steady[row] += 1e-3);
        assert_eq!(glitches(&times, &steady), [300, 900, 2500]);
    }
}
