//! Streams that go in steps: a command, or a value that is held until the next one comes.
//!
//! A curve through steps bends where nothing moved and is late, or early, by up to half a step's
//! length: a delay that rests on it is wrong without a sign of it in its uncertainty. Steps are
//! jumps that stand by themselves: what goes on before and behind a jump is small against it, and
//! jumps make up nearly all that the stream moves. The last digit of an encoder jumps like that,
//! too, but by one and the same little step.
//!
//! A logger slower than its file steps at even times, now and then one later; a load that is set
//! down steps whenever it is. Only the first stays the same quantity between the rows that change.

use crate::diagnostic::{Diagnostic, decimals};
use crate::model::InputDeclaration;
use crate::statistics::upper_median;

/// A change is a jump if it is so many times the median change.
const JUMP: f64 = 20.0;
/// What is beside a jump is smaller than this part of it.
const BESIDE: f64 = 0.1;
/// Jumps that a stream in steps has at least.
const LEAST: usize = 4;
/// The part of all squared changes that jumps by themselves make up.
const MOSTLY: f64 = 0.9;
/// A median jump of this part of the whole range is no digit of an encoder.
const LARGE: f64 = 0.05;
/// Nor are jumps whose median is so many times the least.
const VARIOUS: f64 = 3.0;
/// Times between the steps of a logger differ from multiples of their median by this part of it, or by
/// so many rows, at most.
const UNEVEN: f64 = 0.1;
const UNEVEN_ROWS: f64 = 1.5;
/// ... but for this part of them.
const MOST_UNEVEN: f64 = 0.1;

/// Warns of a stream that goes in steps.
pub(super) fn steps(input: &InputDeclaration, times: &[f64], values: &[f64]) -> Option<Diagnostic> {
    let changes: Vec<f64> = values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    if changes.len() < 3 * LEAST || changes.iter().any(|change| !change.is_finite()) {
        return None;
    }
    let middle = |all: &[f64]| upper_median(&mut all.to_vec()).unwrap_or(0.0);
    let median = middle(&changes);
    let stands = |n: Option<usize>, jump: f64| {
        n.and_then(|n| changes.get(n)).is_none_or(|beside| *beside <= BESIDE * jump)
    };
    let is_jump = |n: &usize| {
        let own = changes[*n];
        own > JUMP * median && stands(n.checked_sub(1), own) && stands(Some(n + 1), own)
    };
    let places: Vec<usize> = (0..changes.len()).filter(is_jump).collect();
    let jumps: Vec<f64> = places.iter().map(|n| changes[*n]).collect();
    let squares = |all: &[f64]| all.iter().map(|one| one * one).sum::<f64>();
    if jumps.len() < LEAST || squares(&jumps) < MOSTLY * squares(&changes) {
        return None;
    }
    let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), one| {
        (low.min(*one), high.max(*one))
    });
    let least = jumps.iter().copied().fold(f64::INFINITY, f64::min);
    let size = middle(&jumps);
    if size < LARGE * (high - low) && size < VARIOUS * least {
        return None;
    }
    let apart: Vec<f64> = places.windows(2).map(|pair| times[pair[1]] - times[pair[0]]).collect();
    let rows: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let as_column = format!(
        "give `{name}` without `signal = true`, as a column of the data beside the readings; to keep only the rows in which it changes would make a ramp of each step",
        name = input.name
    );
    let remedy = match are_even(&apart, middle(&apart), middle(&rows)) {
        true => format!(
            "its steps come at even times: where a logger slower than the file holds each value, keep only the rows in which `{}` changes; where it steps in truth, {as_column}",
            input.name
        ),
        false => format!(
            "its steps come at uneven times, as of a load that is set down or a valve that is switched: {as_column}"
        ),
    };
    let (name, count) = (&input.name, jumps.len());
    let apart = decimals(middle(&apart), 3);
    let message = format!(
        "the stream of `{name}` goes in steps ({count} of them, {apart} s apart in the median), between which it hardly moves"
    );
    let help = format!(
        "no curve follows a step, and a delay that rests on it is wrong; {remedy}; where it is a command, log what moved instead"
    );
    Some(Diagnostic::warning(message).help(help))
}

/// Whether nearly all of these times between steps are multiples of their median.
fn are_even(apart: &[f64], median: f64, row: f64) -> bool {
    let most = (UNEVEN * median).max(UNEVEN_ROWS * row);
    let is_uneven = |own: &&f64| {
        let multiple = (*own / median).round().max(1.0);
        (*own - multiple * median).abs() > most
    };
    apart.iter().filter(is_uneven).count() as f64 <= MOST_UNEVEN * apart.len() as f64
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use super::*;
    use crate::stream::Stream;

    fn told(value: impl Fn(f64) -> f64, noise: f64) -> Option<String> {
        let model = "name = \"m\"\n[inputs]\nq = { unit = \"m\", signal = true }\n[parameters]\nc = { unit = \"m\", scope = \"rig\" }\n[measurands]\nx = { value = 'q + c', unit = \"m\" }\n";
        let model =
            crate::model::Model::parse(crate::diagnostic::Source::new("m.toml", model)).unwrap();
        let mut stream = Stream(3);
        let times: Vec<f64> = (0..2000).map(|n| 0.01 * f64::from(n)).collect();
        let values: Vec<f64> = times.iter().map(|t| value(*t) + noise * stream.normal()).collect();
        steps(&model.inputs[0], &times, &values)
            .map(|one| format!("{} {:?}", one.message, one.help))
    }

    fn swinging(t: f64) -> f64 {
        0.4 * (1.3 * t).sin() + 0.2 * (2.9 * t).cos()
    }

    #[test]
    fn held_values_and_commands_go_in_steps() {
        let held = |t: f64| swinging((t * 5.0 + 1e-9).floor() / 5.0);
        let square = |t: f64| if (t * 0.5 + 1e-9).floor() as i64 % 2 == 0 { 0.1 } else { -0.1 };
        let said = told(held, 0.0).unwrap();
        assert!(said.contains("`q` goes in steps") && said.contains("0.200 s apart"), "{said}");
        assert!(told(square, 0.0).is_some());
        assert!(told(square, 1e-4).is_some());
    }

    /// Of a logger only the rows that change count; of a quantity that steps they would make ramps.
    #[test]
    fn the_remedy_is_that_of_the_cause() {
        let mut stream = Stream(8);
        for period in [0.137, 0.2, 0.51] {
            // One value in twenty comes a period later.
            let late: Vec<bool> = (0..400).map(|_| stream.uniform() < 0.05).collect();
            let held = |t: f64| {
                let own = (t / period + 1e-9).floor() as usize;
                swinging((own - usize::from(late[own] && own > 0)) as f64 * period)
            };
            let said = told(held, 0.0).unwrap();
            assert!(said.contains("even times: where a logger slower"), "{period}: {said}");
        }
        for _ in 0..20 {
            let loads: Vec<(f64, f64)> =
                (0..9).map(|_| (20.0 * stream.uniform(), stream.uniform())).collect();
            let set = |t: f64| loads.iter().filter(|(at, _)| *at < t).map(|(_, by)| by - 0.5).sum();
            if let Some(said) = told(set, 0.0) {
                assert!(
                    said.contains("uneven times") && said.contains("without `signal = true`"),
                    "{said}"
                );
            }
        }
    }

    #[test]
    fn what_moves_scatters_or_is_rounded_does_not() {
        assert!(told(swinging, 0.0).is_none());
        assert!(told(swinging, 0.05).is_none());
        // The last digit of an encoder that moves slowly.
        assert!(told(|t| (swinging(0.2 * t) / 1e-3).round() * 1e-3, 0.0).is_none());
        // It stands, moves within some samples, stands again.
        let stops = |t: f64| {
            let (stop, part) = ((t / 2.0).floor(), (t / 2.0).fract());
            0.1 * (stop + (part / 0.1).min(1.0))
        };
        assert!(told(stops, 0.0).is_none());
        // Single glitches go away and come back.
        assert!(told(|t| if (t - 7.0).abs() < 1e-6 { 5.0 } else { 0.0 }, 1e-3).is_none());
    }
}
