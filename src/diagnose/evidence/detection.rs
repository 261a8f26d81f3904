//! How often an effect of some size is declared, and how often it leads every other explanation.
//!
//! An effect whose signature has the length `λ` (in units of the noise, beyond what nominal
//! parameters follow) has a gain that is noncentral chi squared of `d` degrees and noncentrality
//! `λ²`. It is declared where the gain passes the three bars of the search: the chi squared level
//! of its family-wise share, [`LEAST_LAMBDA`], and what [`Support`] says ([`bar`]). Against another
//! effect that follows all but `x` of the signature the difference of the gains is normal about
//! `x²` (less the surplus of degrees) with variance `4 x²`.

use statrs::function::erf::erfc;
use statrs::function::gamma::{gamma_ur, ln_gamma};

use super::score::Support;
use super::thresholds::{ALIKE, LEAST_LAMBDA};
use crate::statistics::ln_chi_squared;

/// Steps of a bisection: far below what noise levels are known to.
const STEPS: usize = 60;
/// Noncentralities beyond this are as good as normal.
const LARGE: f64 = 1_200.0;

/// The gain that a test must exceed: `level` is the logarithm of its share of the false alarms,
/// shared by so many `members` of a family; `support` is what is known of how scores scatter.
pub fn bar(degrees: usize, members: usize, level: f64, support: Support) -> f64 {
    let d = degrees as f64;
    let chance =
        smallest(|gain| ln_chi_squared(gain, degrees) + (members.max(1) as f64).ln(), level);
    // The scatter of the scores is itself an estimate, and only what exceeds 1 counts: the mean of
    // max(1, 1 + s z) for a normal z is 1 + 0.4 s.
    let scatter = 1.0 + 0.4 * (2.0 / (support.stretches.max(1) as f64 * d)).sqrt();
    let supported = smallest(|gain| support.ln_p(gain, degrees, scatter), level);
    chance.max(supported).max(LEAST_LAMBDA.powi(2) + d)
}

/// The smallest argument at which a falling function is at most `level`.
fn smallest(falling: impl Fn(f64) -> f64, level: f64) -> f64 {
    solved(|gain| falling(gain) <= level)
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

/// Probability that an effect leads another one by more than [`ALIKE`] where the other follows all
/// but a part of length `apart` of its signature.
pub fn leads(apart: f64, degrees: usize, others: usize) -> f64 {
    let surplus = degrees as f64 - others as f64;
    // Degrees of freedom cost `ln p` what they add to the gain, about: only their scatter stays.
    let spread = (4.0 * apart * apart + 2.0 * surplus.abs()).max(1e-12).sqrt();
    0.5 * erfc(-(apart * apart - ALIKE) / (spread * std::f64::consts::SQRT_2))
}

#[cfg(test)]
mod tests {
    use super::*;

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

    #[test]
    fn bars_are_where_the_search_puts_them() {
        // Few degrees: the least length. Many: the level.
        let support = |stretches, memory| Support { stretches, memory };
        let few = support(0, 0.0);
        assert!((bar(1, 1, (1e-4_f64).ln(), few) - 26.0).abs() < 1e-9);
        let many = bar(30, 1, 0.01_f64.ln(), few);
        assert!((many - 55.0).abs() < 1e-9, "{many}");
        // Abramowitz and Stegun, table 26.8: the 1 % point of 60 degrees.
        assert!((bar(60, 1, 0.01_f64.ln(), few) - 88.3794).abs() < 1e-3);
        let level = (1e-4_f64).ln();
        assert!(bar(8, 1, level, support(60, 0.0)) > bar(8, 1, level, few));
        // A memory of 0.8 may pretend nine times as much.
        assert!((bar(60, 1, 0.01_f64.ln(), support(5, 0.8)) - 9.0 * 88.3794).abs() < 1e-2);
        assert!(leads(4.6, 1, 1) > 0.9 && leads(4.5, 1, 1) < 0.9);
    }
}
