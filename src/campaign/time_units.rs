//! Whether times that count as seconds may be in thousandths of them or less: recordings of one motion
//! last about as long, and a stream is sampled more often than what it is smoothed over.
//!
//! It reads no file and changes no time.

use crate::campaign::spline::{Smoothing, mean_spacing};
use crate::diagnostic::{Diagnostic, decimals};

/// Units of time that programs write, in parts of a second.
const UNITS: [(f64, &str); 3] = [(1e3, "ms"), (1e6, "us"), (1e9, "ns")];
/// Durations within such a factor of each other are alike.
const ALIKE: f64 = 4.0;

/// The unit in which the times of the longer of two recordings may be, if it lasts `times` as long as
/// the other one.
pub(super) fn unit_of(times: f64) -> Option<&'static str> {
    let is_alike = |size: &f64| (size.recip() * times.abs()).ln().abs() < ALIKE.ln();
    UNITS.iter().find(|(size, _)| is_alike(size)).map(|(_, unit)| *unit)
}

/// Warns of a stream whose times are whole numbers and farther apart than what it is to be smoothed
/// over, which they would not be in a smaller unit.
pub(super) fn coarse(times: &[f64], smoothing: Smoothing) -> Option<Diagnostic> {
    let Smoothing::TimeConstant(time) = smoothing else { return None };
    let (period, spacing) = (time * std::f64::consts::TAU, mean_spacing(times));
    let are_counts = times.len() > 2 && times.iter().all(|time| time.fract() == 0.0);
    if !are_counts || spacing.is_nan() || spacing <= period {
        return None;
    }
    let (_, unit) = UNITS.iter().find(|(size, _)| spacing < size * period)?;
    let message = format!(
        "samples of a stream are {} s apart, and it is to be smoothed over {} s",
        decimals(spacing, 3),
        decimals(period, 3)
    );
    let help = format!("are its times in {unit}? {}", read_in(unit));
    Some(Diagnostic::warning(message).help(help))
}

/// What to write for a file whose times are in a unit.
pub(super) fn read_in(unit: &str) -> String {
    format!("columns = {{ time = \"time [{unit}]\" }} beside the file reads them so")
}

#[cfg(test)]
mod tests {
    use super::unit_of;

    #[test]
    fn durations_a_thousand_times_as_long_are_in_thousandths() {
        assert_eq!(unit_of(963.0), Some("ms"));
        assert_eq!(unit_of(2.2e6), Some("us"));
        assert_eq!(unit_of(0.4e9), Some("ns"));
        assert_eq!(unit_of(60.0), None);
        assert_eq!(unit_of(1.0), None);
    }
}
