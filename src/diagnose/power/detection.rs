//! How often an effect of some size enters the budget, is named, and leads every other effect.
//!
//! An effect whose signature has the length `λ` (in units of the noise, beyond what nominal
//! parameters follow) has a gain that is noncentral chi squared of `d` degrees and noncentrality
//! `λ²`. It enters where its log Bayes factor is [`ENTER`], and is a row where its gain is [`ROW`]
//! as well ([`critical_gains`]). Against another effect that follows all but `x` of the signature the
//! difference of the gains is normal about `x²` (less the surplus of degrees) with variance `4 x²`;
//! from `2` [`TIE`] on the two are no aliases.

use statrs::function::erf::erfc;
use statrs::function::gamma::{gamma_ur, ln_gamma};

use crate::diagnose::price::{Gain, ln_bayes_factor};
use crate::diagnose::thresholds::{ENTER, ROW, TIE};

/// Steps of a bisection: far below what noise levels are known to.
const STEPS: usize = 60;
/// Noncentralities beyond this are as good as normal.
const LARGE: f64 = 1_200.0;

/// Gains that an effect must reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CriticalGains {
    /// To enter the budget.
    pub enters: f64,
    /// To be a row of it.
    pub named: f64,
}

/// The gains that an effect of so many degrees must reach, one of `members` of its family and of
/// `candidates`.
pub fn critical_gains(degrees: usize, members: usize, candidates: usize) -> CriticalGains {
    let priced = |gain| ln_bayes_factor(Gain { gain, degrees }, members, candidates);
    let enters = solved(|gain| gain >= degrees as f64 && priced(gain) >= ENTER);
    CriticalGains { enters, named: enters.max(ROW) }
}

/// The smallest positive argument from which on something holds; infinite where it never does.
pub fn solved(holds: impl Fn(f64) -> bool) -> f64 {
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

/// Probability that noncentral chi squared exceeds a value: a Poisson mixture of chi squared tails,
/// `Q(a + 1, x) = Q(a, x) + x^a e^-x / Γ(a + 1)` from one to the next.
pub fn exceeds(value: f64, degrees: usize, noncentrality: f64) -> f64 {
    if degrees == 0 || value <= 0.0 {
        return f64::from(u8::from(degrees > 0));
    }
    if noncentrality > LARGE {
        let (d, far) = (degrees as f64, value - noncentrality - degrees as f64);
        return 0.5 * erfc(far / (4.0 * (d + 2.0 * noncentrality)).sqrt());
    }
    let (a, x, mean) = (0.5 * degrees as f64, 0.5 * value, 0.5 * noncentrality);
    let mut tail = gamma_ur(a, x);
    let mut next = (a * x.ln() - x - ln_gamma(a + 1.0)).exp();
    let mut weight = (-mean).exp();
    let (mut sum, mut weights) = (0.0, 0.0);
    for j in 0..10_000 {
        sum += weight * tail;
        weights += weight;
        let far = j as f64 > mean;
        if far && weight * (1.0 - tail).max(1e-16) < 1e-14 {
            break;
        }
        tail += next;
        next *= x / (a + j as f64 + 1.0);
        weight *= mean / (j as f64 + 1.0);
    }
    // What was not summed has tails of one.
    (sum + (1.0 - weights).max(0.0)).min(1.0)
}

/// Probability that an effect leads another one by more than a tie where the other follows all but
/// a part of length `apart` of its signature.
pub fn leads(apart: f64, degrees: usize, others: usize) -> f64 {
    let surplus = degrees as f64 - others as f64;
    // An approximation: surplus degrees of freedom count by their scatter alone, not by their price.
    let spread = (4.0 * apart * apart + 2.0 * surplus.abs()).max(1e-12).sqrt();
    0.5 * erfc(-(apart * apart - 2.0 * TIE) / (spread * std::f64::consts::SQRT_2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::ln_chi_squared;

    #[test]
    fn noncentral_tails_are_those_of_normal_numbers() {
        // One degree: P(|z + λ| > c).
        let phi = |x: f64| 0.5 * erfc(-x / std::f64::consts::SQRT_2);
        for (c, lambda) in [(1.0, 0.0), (5.1, 6.0), (5.1, 3.0), (2.0, 9.0), (20.0, 25.0)] {
            let c: f64 = c;
            let due = phi(lambda - c) + phi(-lambda - c);
            let found = exceeds(c * c, 1, lambda * lambda);
            assert!((found - due).abs() < 1e-10, "{c} {lambda}: {found} {due}");
        }
        // Mean of the distribution: the integral of its tail is d + λ².
        let mean: f64 = (0..40_000).map(|k| 0.005 * exceeds(0.005 * k as f64, 4, 30.0)).sum();
        assert!((mean - 34.0).abs() < 0.01, "{mean}");
        assert_eq!(exceeds(30.0, 2, 5_000.0), 1.0);
        // From the sum to the normal distribution, on both sides of the middle.
        for value in [1_120.0, 1_205.0, 1_290.0] {
            let (sum, normal) = (exceeds(value, 4, LARGE), exceeds(value, 4, LARGE + 1e-9));
            assert!((sum - normal).abs() < 0.01, "{value}: {sum} {normal}");
        }
    }

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
