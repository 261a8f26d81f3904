//! The one price of a term: from a drop of chi squared to a log Bayes factor.
//!
//! A term has `k` values with a normal prior whose width suits its gain best, which is never
//! narrower than one standard uncertainty. So
//!
//! `ln BF = gain / 2 - k / 2 (1 + ln max(1, gain / k)) - ln members - ln candidates`
//!
//! where `members` of the family were tried, and `candidates` of its kind were in the competition
//! (correction for multiple testing). No typical magnitude enters here.

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

#[cfg(test)]
mod tests {
    use super::{Gain, ln_bayes_factor};

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
}
