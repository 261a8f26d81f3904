//! Readings that are rounded more coarsely than they are stated to be known: rounding to steps of `q`
//! has a standard uncertainty of `q / √12` by itself (GUM, F.2.2.1).

use crate::diagnostic::Diagnostic;
use crate::engine::Part;

/// Readings of a measurand that are looked at, at most, and least.
const MOST: usize = 4000;
const LEAST: usize = 20;
/// Different numbers among them at least.
const DIFFERENT: usize = 3;
/// Part of a step by which a multiple of it may be off, for it is written in digits.
const OFF: f64 = 1e-3;
/// How many times what is stated rounding has at least.
const COARSER: f64 = 1.5;

/// Measurands of one component whose readings are multiples of too large a step.
pub(super) fn resolution(part: &Part) -> Vec<Diagnostic> {
    let measurands = part.system.assembly.names.measurands.iter().enumerate();
    let coarse = measurands.filter_map(|(m, measurand)| {
        let slot = &part.slots()[m];
        let step = step(&some_of(part, slot.column)).filter(|_| slot.components == 1)?;
        let (rounding, stated) = (step / 12.0_f64.sqrt(), part.sigma[m]);
        if rounding.is_nan() || rounding < COARSER * stated {
            return None;
        }
        let shown = |value: f64| {
            let unit = measurand.unit.of_differences();
            format!("{} {}", short(value / unit.factor), unit.symbol)
        };
        let message = format!(
            "all readings of `{}` are multiples of {}, apart from a constant: rounding alone has a standard uncertainty of {}, where {} is stated",
            measurand.name,
            shown(step),
            shown(rounding),
            shown(stated)
        );
        let help = "log more digits, or state the uncertainty that the rounding has";
        Some(Diagnostic::warning(message).help(help))
    });
    coarse.collect()
}

/// The first readings of a column, of all runs.
fn some_of(part: &Part, column: usize) -> Vec<f64> {
    let each = MOST / part.runs.len().max(1) + 1;
    let heads = part.runs.iter().map(|run| run.record.head(each));
    heads.flat_map(|samples| samples.readings[column].clone()).collect()
}

/// The step of which all numbers are multiples, apart from a constant; `None` of few.
fn step(readings: &[f64]) -> Option<f64> {
    let mut sorted: Vec<f64> = readings.iter().copied().filter(|one| !one.is_nan()).collect();
    let count = sorted.len();
    sorted.sort_by(f64::total_cmp);
    sorted.dedup();
    if count < LEAST || sorted.len() < DIFFERENT {
        return None;
    }
    let steps = sorted.windows(2).map(|pair| pair[1] - pair[0]);
    let least = steps.min_by(f64::total_cmp)?;
    let first = sorted[0];
    let is_multiple = |value: &f64| {
        let times = (value - first) / least;
        (times - times.round()).abs() < OFF * times.abs().max(1.0).sqrt()
    };
    sorted.iter().all(is_multiple).then_some(least)
}

/// A number to two digits and more.
fn short(value: f64) -> String {
    let digits = (1.0 - value.abs().log10().floor()).clamp(0.0, 9.0) as usize;
    let text = format!("{value:.digits$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::{short, step};

    #[test]
    fn steps_of_rounded_numbers_are_found() {
        let wave = |n: usize| 3.0 + (0.37 * n as f64).sin();
        let rounded: Vec<f64> = (0..200).map(|n| (wave(n) / 0.25).round() * 0.25).collect();
        assert!(step(&rounded).is_some_and(|one| (one - 0.25).abs() < 1e-9));
        // Degrees in radians.
        let turned: Vec<f64> =
            (0..400).map(|n| ((wave(n) * 57.3).round() / 10.0).to_radians()).collect();
        assert!(step(&turned).is_some_and(|one| (one - 0.1_f64.to_radians()).abs() < 1e-9));
        assert_eq!(step(&(0..200).map(wave).collect::<Vec<_>>()), None);
        assert_eq!(step(&[1.0; 50]), None);
        assert_eq!(step(&rounded[..10]), None);
        assert_eq!([0.25, 0.072169, 12.0, 3e-5].map(short), ["0.25", "0.072", "12", "0.00003"]);
    }
}
