//! Streams that begin anew, such as those of encoders with each turn and of counters when they are full,
//! where no `period` is stated: the jump would be taken for a motion.

use crate::campaign::order;
use crate::diagnostic::{Diagnostic, decimals};
use crate::model::InputDeclaration;
use crate::units::Dimension;

/// Warns of an angle without period that jumps by more than half a turn where it mostly moves by
/// less than a quarter: an encoder that begins anew with each turn.
pub(super) fn turns(input: &InputDeclaration, times: &[f64], values: &[f64]) -> Option<Diagnostic> {
    let turn = std::f64::consts::TAU;
    let is_angle = input.unit.is_angle();
    let steps = || values.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let quick = steps().filter(|step| *step > 0.25 * turn).count();
    if !is_angle || 2 * quick > values.len() {
        return None;
    }
    let at = steps().position(|step| step > 0.5 * turn)?;
    let message = format!(
        "the stream of `{}` jumps by more than half a turn at {} s",
        input.name,
        decimals(times[at], 3)
    );
    let help = format!(
        "the jump is taken for a motion; where the encoder begins anew with each turn, say so: `[inputs] {} = {{ period = \"360 deg\" }}`",
        input.name
    );
    Some(Diagnostic::warning(message).help(help))
}

/// Jumps of a counter are more than this part of its way, other steps less than that.
const COUNTS: (f64, f64) = (0.5, 0.1);

/// Warns of a count without period that jumps by the size of a counter and mostly goes on in small
/// steps.
pub(super) fn counts(
    input: &InputDeclaration,
    times: &[f64],
    values: &[f64],
) -> Option<Diagnostic> {
    let is_count = input.unit.dimension == Dimension::NONE && !input.unit.is_angle();
    let (least, most) = values
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), value| (value.min(a), value.max(b)));
    let way = most - least;
    let steps = || values.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let at = steps().position(|step| step > COUNTS.0 * way)?;
    // What a counter jumps by falls short of its size by the way in between.
    let large = |at: &usize| (values[at + 1] - values[*at]).abs() > COUNTS.1 * way;
    let size_at = |at: usize| {
        let before = at.checked_sub(1).map_or(0.0, |last| values[at] - values[last]);
        (values[at + 1] - values[at] - before).abs() / input.unit.factor
    };
    let sizes: Vec<f64> = (0..values.len() - 1).filter(large).map(size_at).collect();
    let first = *sizes.first()?;
    let all_alike = sizes.iter().all(|size| (size / first - 1.0).abs() < 0.05);
    let rounded = || {
        let mean = sizes.iter().sum::<f64>() / sizes.len() as f64;
        let digit = 10_f64.powf(mean.log10().floor() - 1.0);
        (sizes.len() > 1).then(|| (mean / digit).round() * digit)
    };
    let size = order::size(first).or_else(rounded)?;
    if !is_count || !all_alike || 20 * sizes.len() > values.len() {
        return None;
    }
    let symbol = if input.unit.symbol == "1" { "" } else { input.unit.symbol.as_str() };
    let message = format!(
        "the stream of `{}` jumps by about {size} at {} s, as a counter that begins anew",
        input.name,
        decimals(times[at], 3)
    );
    let help = format!(
        "the jump is taken for a motion; if it is such a counter, say so: `[inputs] {} = {{ period = \"{}\" }}`",
        input.name,
        format!("{size} {symbol}").trim_end()
    );
    Some(Diagnostic::warning(message).help(help))
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a failed test should stop")]

    use super::counts;

    /// Counters of any size, forwards and backwards; an oscillation is none.
    #[test]
    fn counters_are_recognised_by_what_they_jump_by() {
        let text = "name = \"cart\"\n[inputs]\nticks = { unit = \"1\", signal = true }\n\
             [parameters]\nk = { unit = \"1\", start = \"1\" }\n\
             [measurands]\nx = { value = 'k * ticks', unit = \"1\" }\n";
        let model = crate::model::Model::parse(crate::diagnostic::Source::new("cart.toml", text));
        let input = model.unwrap().inputs[0].clone();
        let times: Vec<f64> = (0..3000).map(|n| 0.01 * f64::from(n)).collect();
        let said = |value: &dyn Fn(f64) -> f64| {
            let values: Vec<f64> = times.iter().map(|t| value(*t).floor()).collect();
            counts(&input, &times, &values).map(|one| one.to_string())
        };
        for (size, rate) in [(256.0, 900.0), (9000.0, 3100.0), (4096.0, -2000.0), (1200.0, 150.0)] {
            let found = said(&|t: f64| (500.0 + rate * t).rem_euclid(size)).unwrap();
            assert!(found.contains(&format!("period = \"{size}\"")), "{size}: {found}");
        }
        assert_eq!(said(&|t: f64| 4000.0 * (3.0 * t).sin()), None);
        assert_eq!(said(&|t: f64| if t < 7.0 { 0.0 } else { 4500.0 }), None);
    }
}
