//! The one price of a term: from a drop of chi squared to a log Bayes factor.
//!
//! A term has `k` values with a normal prior whose width suits its gain best, which is never
//! narrower than one standard uncertainty. So
//!
//! `ln BF = gain / 2 - k / 2 (1 + ln max(1, gain / k)) - ln members - ln candidates`
//!
//! where `members` of the family were tried, and `candidates` of its kind were in the competition
//! (correction for multiple testing). No typical magnitude enters here.

use crate::statistics::ln_gamma;

/// What a term takes off chi squared beyond a model.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gain {
    /// Drop of chi squared.
    pub gain: f64,
    /// Degrees of freedom: directions that the model does not absorb.
    pub degrees: usize,
}

impl Gain {
    /// What is taken off beyond what chance gives.
    pub fn excess(self) -> f64 {
        (self.gain - self.degrees as f64).max(0.0)
    }

    /// Noncentrality: the length of the signature in units of the noise, less what chance gives.
    pub fn noncentrality(self) -> f64 {
        self.excess().sqrt()
    }
}

/// ln of what so many values cost at this gain, one of `members` tried and of `candidates`.
pub fn price(gain: Gain, members: usize, candidates: usize) -> f64 {
    let k = gain.degrees.max(1) as f64;
    let width = (gain.gain / k).max(1.0);
    0.5 * gain.degrees as f64 * (1.0 + width.ln())
        + (members.max(1) as f64).ln()
        + (candidates.max(1) as f64).ln()
}

/// The log Bayes factor of a term against the model without it; that of an absorbed term is -1.
pub fn ln_bayes_factor(gain: Gain, members: usize, candidates: usize) -> f64 {
    if gain.degrees == 0 { -1.0 } else { 0.5 * gain.gain - price(gain, members, candidates) }
}

/// The same where the noise is known from so many degrees of freedom of a model without the term: few values
/// that explain nearly all that there is make noise look larger than it is. The Bayes factor of the prior
/// above with the noise integrated out (Liang et al. 2008), which it is of many degrees of freedom.
pub fn ln_bayes_factor_of_any_noise(
    gain: Gain,
    freedom: f64,
    members: usize,
    candidates: usize,
) -> f64 {
    let k = gain.degrees as f64;
    let (left, share) = (freedom - k, (gain.gain / freedom).clamp(0.0, MOST_EXPLAINED));
    if gain.degrees == 0 || 2.0 * left < k {
        return -1.0;
    }
    let width = (share / (1.0 - share) * left / k).max(1.0);
    let choices = members.max(1) as f64 * candidates.max(1) as f64;
    0.5 * (left * width.ln() - freedom * (1.0 + (width - 1.0) * (1.0 - share)).ln()) - choices.ln()
}

/// Share of chi squared that a term explains, as far as it counts: readings are rounded.
const MOST_EXPLAINED: f64 = 1.0 - 1e-9;
/// Noncentrality below which an effect counts as none.
const SMALLEST: f64 = 2.0;
/// Part of a log Bayes factor below which differences are rounding: gains are sums over readings, and a
/// clock that was set by seconds has a gain of 1e11.
pub const ROUNDING: f64 = 1e-9;

/// The posterior probability of what has a log Bayes factor, against nothing and others; what differs by
/// rounding alone is as probable.
pub fn posterior(ln_bayes: f64, others: impl Iterator<Item = f64>) -> f64 {
    let rounding = ROUNDING * ln_bayes;
    let others = others.map(|other| other - ln_bayes);
    let others = others.map(|by| if by.abs() < rounding { 0.0 } else { by });
    let odds: f64 = others.chain([-ln_bayes]).map(f64::exp).sum();
    1.0 / (1.0 + odds)
}

/// The logarithm of 50: sizes are log-uniform from [`SMALLEST`] to 100.
const LN_RANGE: f64 = 3.912_023;
/// Step and reach of the integral over sizes, in units of the noise.
const STEP: f64 = 0.1;
const REACH: f64 = 8.0;

/// The log Bayes factor of values whose noncentrality is log-uniform from 2 to 100 (and on with the
/// same density), in any direction. Unlike that of the best prior width its mean over sizes up to 100
/// is 1 where nothing is there, so posterior probabilities are made of it.
pub fn ln_bayes_factor_of_any_size(gain: Gain) -> f64 {
    let k = gain.degrees as f64;
    if gain.degrees == 0 {
        return 0.0;
    }
    let score = gain.gain.max(0.0).sqrt();
    let first = ((gain.gain - k).max(0.0).sqrt() - REACH).max(SMALLEST);
    let count = ((score + REACH - first).max(REACH) / STEP).ceil() as usize;
    let term = |step: usize| {
        let size = first + STEP * (step as f64 + 0.5);
        ln_hypergeometric(0.5 * k, 0.5 * size * score) - 0.5 * size * size - size.ln()
    };
    let terms: Vec<f64> = (0..count).map(term).collect();
    let most = terms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let sum: f64 = terms.iter().map(|one| (one - most).exp()).sum();
    most + (sum * STEP / LN_RANGE).ln()
}

/// The logarithm of the confluent hypergeometric limit function 0F1(; b; x²), by which the density of
/// noncentral chi squared exceeds the central one: its series, or Debye's expansion of the Bessel
/// function that it is (Abramowitz and Stegun 1964, 9.6.47 and 9.7.7).
fn ln_hypergeometric(b: f64, x: f64) -> f64 {
    if b == 0.5 {
        // cosh 2 x
        return 2.0 * x + (-4.0 * x).exp().ln_1p() - std::f64::consts::LN_2;
    }
    let square = x * x;
    if square < 400.0 + b {
        let (mut term, mut sum, mut n) = (1.0_f64, 1.0_f64, 0.0_f64);
        while term > 1e-16 * sum {
            term *= square / ((b + n) * (n + 1.0));
            sum += term;
            n += 1.0;
        }
        return sum.ln();
    }
    let (order, y) = (b - 1.0, 2.0 * x);
    let root = order.hypot(y);
    let ln_bessel =
        root + order * (y / (order + root)).ln() - 0.5 * (2.0 * std::f64::consts::PI * root).ln();
    ln_gamma(b) - order * x.ln() + ln_bessel
}

#[cfg(test)]
mod tests {
    use super::{
        Gain, ln_bayes_factor, ln_bayes_factor_of_any_noise, ln_bayes_factor_of_any_size,
        ln_hypergeometric,
    };

    /// Noise that many readings determine is known; of few, values that explain nearly all count far more.
    #[test]
    fn a_bayes_factor_of_any_noise_is_that_of_known_noise_for_many_readings() {
        for (gain, degrees) in [(40.0, 1), (90.0, 5), (300.0, 23)] {
            let gain = Gain { gain, degrees };
            let known = ln_bayes_factor(gain, 7, 20);
            let any = ln_bayes_factor_of_any_noise(gain, 1e8, 7, 20);
            assert!((any - known).abs() < 1e-3, "{any} {known}");
        }
        let most = Gain { gain: 85.0, degrees: 23 };
        let any = ln_bayes_factor_of_any_noise(most, 90.0, 1, 20);
        assert!(any > ln_bayes_factor(most, 1, 20) + 20.0, "{any}");
    }

    /// Over what chance gives, a proper Bayes factor is 1 on average: the sum over a grid of gains of
    /// its value times the density of chi squared.
    #[test]
    fn a_bayes_factor_of_any_size_is_one_on_average_where_nothing_is() {
        for degrees in [1_usize, 2, 3, 12, 40] {
            let half = 0.5 * degrees as f64;
            let ln_density = |gain: f64| {
                (half - 1.0) * gain.ln() - 0.5 * gain - half * 2.0_f64.ln() - super::ln_gamma(half)
            };
            // In the root of the gain, so that the density at zero is finite.
            let step = 0.01;
            let of = |n: u32| {
                let score = step * (f64::from(n) + 0.5);
                let gain = Gain { gain: score * score, degrees };
                let ln = ln_bayes_factor_of_any_size(gain) + ln_density(gain.gain);
                2.0 * score * step * ln.exp()
            };
            // Sizes up to 100 and their noise.
            let whole: f64 = (0..14_000).map(of).sum();
            // The density goes on beyond 100, by the logarithm.
            let due = (140.0_f64 / super::SMALLEST).ln() / super::LN_RANGE;
            assert!((whole - due).abs() < 0.005, "{degrees}: {whole} {due}");
        }
    }

    #[test]
    fn series_and_expansion_agree_where_they_meet() {
        for b in [1.0_f64, 1.5, 6.0, 20.0] {
            let edge = (400.0 + b).sqrt();
            let [below, above] =
                [edge * 0.999_999, edge * 1.000_001].map(|x| ln_hypergeometric(b, x));
            // The first term that the expansion leaves out.
            assert!((below - above).abs() < 0.01, "{b}: {below} {above}");
        }
        // sinh(2 x) / (2 x) for b = 3/2
        let x = 1.7_f64;
        let due = ((2.0 * x).sinh() / (2.0 * x)).ln();
        assert!((ln_hypergeometric(1.5, x) - due).abs() < 1e-12);
    }

    /// Marginal likelihood by numerical integration over the value and the best prior width.
    #[test]
    fn one_value_is_priced_as_its_marginal_likelihood() {
        for gain in [4.0_f64, 25.0, 100.0, 900.0] {
            let score = gain.sqrt();
            let marginal = |width: f64| {
                let steps = 20_000;
                let (low, high) = (-20.0 * width - score, 20.0 * width + score);
                let step = (high - low) / f64::from(steps);
                let density =
                    |x: f64| (x * score - 0.5 * x * x - 0.5 * (x / width).powi(2)).exp() / width;
                (0..steps).map(|i| density(low + step * f64::from(i))).sum::<f64>() * step
                    / (2.0 * std::f64::consts::PI).sqrt()
            };
            let widths = (1..400).map(|i| 0.1 * f64::from(i));
            let best = widths.map(|width| marginal(width).ln()).fold(f64::MIN, f64::max);
            let priced = ln_bayes_factor(Gain { gain, degrees: 1 }, 1, 1);
            assert!((best - priced).abs() < 0.02 * best.max(1.0), "{gain}: {best} {priced}");
        }
    }

    #[test]
    fn members_and_candidates_are_corrected_for() {
        let gain = Gain { gain: 43.0, degrees: 40 };
        assert!(ln_bayes_factor(gain, 1, 59) < 0.0);
        let one = Gain { gain: 25.0, degrees: 1 };
        let difference = ln_bayes_factor(one, 1, 1) - ln_bayes_factor(one, 40, 59);
        assert!((difference - (40.0_f64 * 59.0).ln()).abs() < 1e-12);
    }

    #[test]
    fn what_differs_by_rounding_is_as_probable() {
        let of = |own: f64, other: f64| super::posterior(own, [other].into_iter());
        assert!((of(8.0, 5.0) - 1.0 / (1.0 + (-3.0_f64).exp() + (-8.0_f64).exp())).abs() < 1e-12);
        assert!((of(1.6e11, 1.6e11 + 17.0) - 0.5).abs() < 1e-12);
        assert!(of(1.6e11, 1.7e11) < 1e-12);
    }
}
