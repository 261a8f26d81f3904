//! How often an effect of some size enters the budget, is named, and leads every other effect.
//!
//! An effect whose signature has the length `λ` (in units of the noise, beyond what nominal
//! parameters follow) has a gain that is noncentral chi squared of `d` degrees and noncentrality
//! `λ²`. It enters where its log Bayes factor is [`ENTER`], and is a row where its gain is [`ROW`]
//! as well ([`critical_gains`]). Against another effect that follows all but `x` of the signature the
//! difference of the gains is normal about `x²` (less the surplus of degrees) with variance `4 x²`;
//! from `2` [`TIE`] on the two are no aliases.

use statrs::function::erf::erfc;

use crate::diagnose::price::{Gain, ln_bayes_factor};
use crate::diagnose::thresholds::{ENTER, ROW, TIE};

/// Steps of a bisection: far below what noise levels are known to.
const STEPS: usize = 60;

/// Gains that an effect must reach to enter the budget, and to be a row of it.
#[derive(Clone, Copy)]
pub(super) struct CriticalGains {
    pub(super) enters: f64,
    pub(super) named: f64,
}

/// Those of an effect of so many degrees, one of `members` of its family and of `candidates`.
pub(super) fn critical_gains(degrees: usize, members: usize, candidates: usize) -> CriticalGains {
    let priced = |gain| ln_bayes_factor(Gain { gain, degrees }, members, candidates);
    let enters = solved(|gain| gain >= degrees as f64 && priced(gain) >= ENTER);
    CriticalGains { enters, named: enters.max(ROW) }
}

/// The smallest positive argument from which on something holds; infinite where it never does.
pub(super) fn solved(holds: impl Fn(f64) -> bool) -> f64 {
    let mut high = 1.0;
    while !holds(high) {
        high *= 4.0;
        if high > 1e12 {
            return f64::INFINITY;
        }
    }
    let mut low = 0.0;
    for _ in 0..STEPS {
        let middle = 0.5 * (low + high);
        if holds(middle) { high = middle } else { low = middle }
    }
    high
}

/// Probability that an effect leads another one by more than a tie where the other follows all but
/// a part of length `apart` of its signature.
pub(super) fn leads(apart: f64, degrees: usize, others: usize) -> f64 {
    let surplus = degrees as f64 - others as f64;
    // An approximation: surplus degrees of freedom count by their scatter alone, not by their price.
    let spread = (4.0 * apart * apart + 2.0 * surplus.abs()).max(1e-12).sqrt();
    0.5 * erfc(-(apart * apart - 2.0 * TIE) / (spread * std::f64::consts::SQRT_2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::ln_chi_squared;

    /// Chance passes the critical_gains of all effects together less often than the odds at which they enter.
    #[test]
    fn critical_gains_bound_false_alarms() {
        for (degrees, members, candidates) in [(1, 1, 1), (1, 1, 60), (2, 8, 60), (40, 1, 60)] {
            let bar = critical_gains(degrees, members, candidates).enters;
            let gain = Gain { gain: bar, degrees };
            assert!((ln_bayes_factor(gain, members, candidates) - ENTER).abs() < 1e-6);
            let tests = (members * candidates) as f64;
            let chance = tests * ln_chi_squared(bar, degrees).exp();
            assert!(chance < (-ENTER).exp(), "{degrees} {members} {candidates}: {chance}");
        }
        assert_eq!(critical_gains(1, 1, 60).named, ROW);
        assert!(critical_gains(60, 1, 60).named > ROW);
        // (x² - 6) / 2x = 1.28 at x = 4.05.
        assert!(leads(4.1, 1, 1) > 0.9 && leads(4.0, 1, 1) < 0.9);
    }
}
