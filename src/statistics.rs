//! Medians, the scatter that follows from them, and tail probabilities as logarithms: the chi squared of a strong effect lies far beyond what a
//! double holds (it underflows near 1400).
//!
//! `ln Q(a, x)` of the incomplete gamma function by Legendre's continued fraction where `x > a + 1`
//! (modified Lentz, Press et al., *Numerical Recipes*, 6.2), else from its complement.

use statrs::distribution::{ContinuousCDF, StudentsT};
use statrs::function::erf::erfc;
pub use statrs::function::gamma::ln_gamma;
use statrs::function::gamma::{gamma_lr, gamma_ur};

/// Standard deviation over median absolute deviation of a normal distribution.
pub const NORMAL: f64 = 1.482_602_2;

/// The median of some numbers, which change their order: of an even number of them the upper of the
/// middle two. It takes one pass.
pub fn upper_median(numbers: &mut [f64]) -> Option<f64> {
    let middle = numbers.len() / 2;
    if numbers.is_empty() {
        return None;
    }
    let (_, median, _) = numbers.select_nth_unstable_by(middle, f64::total_cmp);
    Some(*median)
}

/// The median of the sizes of numbers, NaN not counted; `None` of none.
pub fn median_size<'a>(values: impl IntoIterator<Item = &'a f64>) -> Option<f64> {
    let sizes = values.into_iter().map(|value| value.abs()).filter(|size| !size.is_nan());
    upper_median(&mut sizes.collect::<Vec<f64>>())
}

/// The robust standard deviation of numbers about zero, NaN not counted; `None` of none.
pub fn robust<'a>(values: impl IntoIterator<Item = &'a f64>) -> Option<f64> {
    median_size(values).map(|median| NORMAL * median)
}

/// Terms of the continued fraction at most; it needs about the root of its argument.
const TERMS: usize = 100_000;

/// Natural logarithm of the probability that chi squared of so many degrees of freedom exceeds a
/// value.
pub fn ln_chi_squared(value: f64, degrees: usize) -> f64 {
    if degrees == 0 || value.is_nan() || value <= 0.0 {
        return 0.0;
    }
    ln_gamma_tail(0.5 * degrees as f64, 0.5 * value)
}

/// Natural logarithm of the probability that chi squared of so many degrees of freedom is below a
/// value.
pub fn ln_below(value: f64, degrees: usize) -> f64 {
    if degrees == 0 || value.is_nan() || value <= 0.0 {
        return f64::NEG_INFINITY;
    }
    gamma_lr(0.5 * degrees as f64, 0.5 * value).max(f64::MIN_POSITIVE).ln()
}

/// `ln Q(a, x)` of the incomplete gamma function: half the degrees and half the value of chi
/// squared.
pub fn ln_gamma_tail(a: f64, x: f64) -> f64 {
    if a.is_nan() || x.is_nan() || a <= 0.0 || x <= 0.0 {
        return 0.0;
    }
    if x < a + 1.0 {
        return (-gamma_lr(a, x)).ln_1p();
    }
    a * x.ln() - x - ln_gamma(a) + fraction(a, x).ln()
}

/// `1/(x+1-a- 1(1-a)/(x+3-a- ...))`.
fn fraction(a: f64, x: f64) -> f64 {
    let tiny = 1e-300;
    let mut b = x + 1.0 - a;
    let mut c = 1.0 / tiny;
    let mut d = 1.0 / b;
    let mut h = d;
    for i in 1..TERMS {
        let i = i as f64;
        let numerator = -i * (i - a);
        b += 2.0;
        d = numerator * d + b;
        d = if d.abs() < tiny { tiny } else { d };
        c = b + numerator / c;
        c = if c.abs() < tiny { tiny } else { c };
        d = 1.0 / d;
        h *= d * c;
        if (d * c - 1.0).abs() < 1e-15 {
            break;
        }
    }
    h
}

/// Noncentralities beyond this are as good as normal.
const LARGE: f64 = 1_200.0;

/// Probability that noncentral chi squared exceeds a value: a Poisson mixture of chi squared tails,
/// `Q(a + 1, x) = Q(a, x) + x^a e^-x / Γ(a + 1)` from one to the next.
pub fn noncentral_chi_squared(value: f64, degrees: usize, noncentrality: f64) -> f64 {
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

/// Natural logarithm of the probability that a standard normal number exceeds a value.
pub fn ln_normal(value: f64) -> f64 {
    let both = ln_chi_squared(value * value, 1);
    if value > 0.0 { both - 2.0_f64.ln() } else { (-0.5 * both.exp()).ln_1p() }
}

/// The value that Student's t of so many degrees of freedom exceeds in neither direction with this
/// probability.
pub fn student(probability: f64, degrees: f64) -> f64 {
    StudentsT::new(0.0, 1.0, degrees)
        .map_or(f64::INFINITY, |student| student.inverse_cdf(0.5 * (1.0 + probability)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tails_are_those_of_the_tables() {
        // Two degrees of freedom: exp(-x/2), however far out.
        for value in [0.1, 1.0, 10.0, 100.0, 1e4, 1e6] {
            assert!((ln_chi_squared(value, 2) + 0.5 * value).abs() < 1e-12 * value.max(1.0));
        }
        // Abramowitz and Stegun, table 26.8: the 1 % points.
        for (degrees, value) in [(1, 6.634_896_6), (4, 13.276_704), (30, 50.892_181)] {
            let found = ln_chi_squared(value, degrees).exp();
            assert!((found - 0.01).abs() < 1e-7, "{degrees}: {found}");
        }
        // F of (1, n) is the square of Student's t: t(0.995; 10) = 3.169273.
        assert!((ln_normal(2.326_347_9).exp() - 0.01).abs() < 1e-8);
        assert!((ln_normal(-2.326_347_9).exp() - 0.99).abs() < 1e-8);
        assert_eq!(ln_chi_squared(f64::NAN, 3), 0.0);
        assert!((student(0.95, 3.0) - 3.182_446_3).abs() < 1e-6);
        // From below: what is above has all but the rest.
        for (value, degrees) in [(3.0, 5), (30.0, 5), (1e-3, 6)] {
            let (above, below) = (ln_chi_squared(value, degrees), ln_below(value, degrees));
            assert!((above.exp() + below.exp() - 1.0).abs() < 1e-12, "{value} {degrees}");
        }
        // The first term of the series, x^a exp(-x) / Γ(a + 1).
        assert!((ln_below(2e-9, 4) - (-2.0 * 1e9_f64.ln() - 2.0_f64.ln())).abs() < 1e-6);
    }

    #[test]
    fn noncentral_tails_are_those_of_normal_numbers() {
        // One degree: P(|z + λ| > c).
        let phi = |x: f64| 0.5 * erfc(-x / std::f64::consts::SQRT_2);
        for (c, lambda) in [(1.0, 0.0), (5.1, 6.0), (5.1, 3.0), (2.0, 9.0), (20.0, 25.0)] {
            let c: f64 = c;
            let due = phi(lambda - c) + phi(-lambda - c);
            let found = noncentral_chi_squared(c * c, 1, lambda * lambda);
            assert!((found - due).abs() < 1e-10, "{c} {lambda}: {found} {due}");
        }
        // Mean of the distribution: the integral of its tail is d + λ².
        let mean: f64 =
            (0..40_000).map(|k| 0.005 * noncentral_chi_squared(0.005 * k as f64, 4, 30.0)).sum();
        assert!((mean - 34.0).abs() < 0.01, "{mean}");
        assert_eq!(noncentral_chi_squared(30.0, 2, 5_000.0), 1.0);
        // From the sum to the normal distribution, on both sides of the middle.
        for value in [1_120.0, 1_205.0, 1_290.0] {
            let (sum, normal) = (
                noncentral_chi_squared(value, 4, LARGE),
                noncentral_chi_squared(value, 4, LARGE + 1e-9),
            );
            assert!((sum - normal).abs() < 0.01, "{value}: {sum} {normal}");
        }
    }
}
