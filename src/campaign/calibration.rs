//! An input's certificate: its calibration corrections, and what they leave open.
//!
//! `arm_angle = { resolution = "0.36 arcsec", calibration = { U = "4.2 arcsec", k = 2 } }`: a
//! reading of the encoder is rounded to its resolution (rectangular, new in every sample, part of
//! the input's random error), and at any position it is wrong by an error that stays the same
//! whenever the arm comes by: the calibration's uncertainty, which no number of readings makes
//! smaller.
//!
//! With `corrections = "encoder.csv"` (columns `arm_angle [deg],correction [arcsec]`) the recorded
//! values are corrected, `value + correction(value)`, straight lines between the rows, repeating
//! after one turn for an angle; `U` is then what remains.

use crate::campaign::signal::Track;
use crate::campaign::statement::Spread;

/// How well an input's values are known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct InputSpread {
    /// Standard deviation of what scatters (`sigma`).
    pub noise: Option<f64>,
    /// Resolution: the width of a rectangle.
    pub resolution: Option<f64>,
    /// What calibration leaves open, the same at the same position.
    pub calibration: Option<Spread>,
}

impl InputSpread {
    /// Standard uncertainty of one value as it scatters from sample to sample; 0 if it does not,
    /// but is not known either. `None`: nothing is said.
    pub fn random(&self) -> Option<f64> {
        let resolution = self.resolution.map(|step| step / 12.0_f64.sqrt());
        let parts = [self.noise, resolution, self.calibration.map(|_| 0.0)];
        parts.into_iter().flatten().reduce(f64::hypot)
    }
}

/// Corrections of an input: positions in order, with the correction at each.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Corrections {
    pub(crate) positions: Vec<f64>,
    pub(crate) values: Vec<f64>,
    /// 0 where they do not repeat.
    pub(crate) period: f64,
}

impl Corrections {
    /// The correction at a value, and its derivative.
    fn at(&self, value: f64) -> (f64, f64) {
        let (first, count) = (self.positions[0], self.positions.len());
        let turns = if self.period > 0.0 { ((value - first) / self.period).floor() } else { 0.0 };
        let inside = value - turns * self.period;
        let next = self.positions.partition_point(|position| *position <= inside);
        let knot = |index: usize| match index < count {
            true => (self.positions[index], self.values[index]),
            false => (first + self.period, self.values[0]),
        };
        if self.period == 0.0 && (next == 0 || next == count) {
            return (self.values[next.saturating_sub(1)], 0.0);
        }
        // Rounding of whole turns may leave a value just below the first row.
        let next = next.max(1);
        let ((a, low), (b, high)) = (knot(next - 1), knot(next));
        let slope = (high - low) / (b - a);
        (low + slope * (inside - a), slope)
    }

    /// Corrects recorded values; a stream's are corrected before it is smoothed.
    pub(crate) fn correct(&self, value: &mut f64) -> f64 {
        let (correction, slope) = self.at(*value);
        *value += correction;
        1.0 + slope
    }

    /// Corrects what was captured, rates along with values.
    pub(crate) fn correct_track(&self, track: &mut Track) {
        match track {
            Track::Captured { value, rate, acceleration } => {
                for (row, value) in value.iter_mut().enumerate() {
                    let gain = self.correct(value);
                    for column in [&mut *rate, &mut *acceleration].into_iter().flatten() {
                        column[row] *= gain;
                    }
                }
            }
            Track::Constant(value) => {
                self.correct(value);
            }
            Track::Absent | Track::Logged(_) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    #[test]
    fn corrections_of_an_angle_repeat_by_turns() {
        let corrections = Corrections {
            positions: vec![1.0, 2.0, 4.0],
            values: vec![0.1, 0.3, -0.1],
            period: TAU,
        };
        for turn in [-TAU, 0.0, 3.0 * TAU] {
            let (value, slope) = corrections.at(turn + 1.5);
            assert!((value - 0.2).abs() < 1e-12 && (slope - 0.2).abs() < 1e-12);
            // Between the last row and the first of the next turn.
            let (value, slope) = corrections.at(turn + 5.0);
            let expected = 0.2 / (TAU - 3.0);
            assert!((slope - expected).abs() < 1e-12 && (value + 0.1 - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn whole_turns_from_the_first_row_are_the_first_row() {
        let corrections =
            Corrections { positions: vec![0.1, 2.0], values: vec![0.3, 0.7], period: TAU };
        for turns in -200..200 {
            let (value, _) = corrections.at(0.1 + f64::from(turns) * TAU);
            assert!((value - 0.3).abs() < 1e-12, "{turns}: {value}");
        }
        let one = Corrections { positions: vec![0.1], values: vec![0.3], period: TAU };
        assert_eq!(one.at(5.0), (0.3, 0.0));
    }

    #[test]
    fn corrections_of_a_length_hold_at_their_ends() {
        let corrections =
            Corrections { positions: vec![1.0, 2.0], values: vec![0.1, 0.3], period: 0.0 };
        assert_eq!(corrections.at(0.0), (0.1, 0.0));
        assert_eq!(corrections.at(7.0), (0.3, 0.0));
        assert!((corrections.at(1.25).0 - 0.15).abs() < 1e-12);
    }
}
