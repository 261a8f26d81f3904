//! How unlikely a candidate's gain is by chance.

use super::Entry;
use super::thresholds::LEAST_LAMBDA;
use crate::statistics::{ln_chi_squared, ln_f};

/// Fewer stretches do not show how scores scatter.
pub const LEAST_STRETCHES: usize = 20;

/// A score test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Score {
    /// What the candidate would take off the sum of squares.
    pub gain: f64,
    /// Its degrees of freedom.
    pub degrees: usize,
    /// Logarithm of the probability of such a gain without the effect; members of a family are paid
    /// for.
    pub ln_p: f64,
}

impl Score {
    /// Whether it is below a level of chance (a logarithm), and large enough to be declared.
    pub fn is_seen(&self, level: f64) -> bool {
        self.ln_p <= level && self.lambda() >= LEAST_LAMBDA
    }

    /// Length of the signature in units of the noise: the gain less what chance gives.
    pub fn lambda(&self) -> f64 {
        (self.gain - self.degrees as f64).max(0.0).sqrt()
    }
}

/// The score test of an entry, one of so many members.
pub fn score(entry: &Entry, members: usize) -> Score {
    let (gain, degrees) = (entry.gain(), entry.degrees());
    of_gain(gain, degrees, members)
}

/// The score test of a gain.
pub fn of_gain(gain: f64, degrees: usize, members: usize) -> Score {
    let ln_p = ln_chi_squared(gain, degrees) + (members.max(1) as f64).ln();
    Score { gain, degrees, ln_p: ln_p.min(0.0) }
}

/// What supports a score besides the noise that is known: how scores scatter from stretch to
/// stretch.
#[derive(Clone, Copy, Debug)]
pub struct Support {
    /// Number of stretches.
    pub stretches: usize,
    /// Correlation of neighbours in time that is left.
    pub memory: f64,
}

impl Support {
    /// Logarithm of the probability by chance of a gain, if noise is as unruly as it looks: a test
    /// of F with scores that scatter `inflation` times as much as the noise says, or, where
    /// stretches are too few to show that, the most that a memory of this strength can pretend.
    /// Members of a family are paid for in the score test alone: few stretches would never give so
    /// many.
    pub fn ln_p(&self, gain: f64, degrees: usize, inflation: f64) -> f64 {
        if self.stretches < LEAST_STRETCHES {
            let most = (1.0 + self.memory) / (1.0 - self.memory);
            ln_chi_squared(gain / most, degrees)
        } else {
            let d = degrees as f64;
            ln_f(gain / (d * inflation.max(1.0)), d, self.stretches as f64 - 1.0)
        }
    }
}
