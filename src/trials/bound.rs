//! Bounds of a rate from a count: Clopper and Pearson (Biometrika 26, 1934), one-sided 95 %.
//!
//! The lower bound of `k` out of `n` is the 5 % point of the beta distribution `B(k, n - k + 1)`,
//! the upper one the 95 % point of `B(k + 1, n - k)`. They are never too narrow.

use statrs::function::beta::inv_beta_reg;

/// One-sided confidence.
pub const CONFIDENCE: f64 = 0.95;

/// How often something happened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Count {
    /// Times it happened.
    pub hits: usize,
    /// Times it could have.
    pub trials: usize,
}

impl Count {
    /// Counts one more.
    pub fn add(&mut self, hit: bool) {
        self.hits += usize::from(hit);
        self.trials += 1;
    }

    /// Share; `None` without trials.
    pub fn rate(self) -> Option<f64> {
        (self.trials > 0).then(|| self.hits as f64 / self.trials as f64)
    }

    /// What the true rate exceeds, at [`CONFIDENCE`].
    pub fn lower(self) -> f64 {
        let (k, n) = (self.hits as f64, self.trials as f64);
        if self.hits == 0 { 0.0 } else { inv_beta_reg(k, n - k + 1.0, 1.0 - CONFIDENCE) }
    }

    /// What the true rate stays below, at [`CONFIDENCE`].
    pub fn upper(self) -> f64 {
        let (k, n) = (self.hits as f64, self.trials as f64);
        if self.hits >= self.trials { 1.0 } else { inv_beta_reg(k + 1.0, n - k, CONFIDENCE) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Probability of at least so many.
    fn at_least(hits: usize, trials: usize, rate: f64) -> f64 {
        let mut term = (1.0 - rate).powi(trials as i32);
        let mut below = 0.0;
        for k in 0..hits {
            below += term;
            term *= (trials - k) as f64 / (k + 1) as f64 * rate / (1.0 - rate);
        }
        1.0 - below
    }

    #[test]
    fn bounds_are_those_of_the_tables() {
        // No event in n: the upper bound solves (1 - p)^n = 0.05 (the rule of three).
        for trials in [1, 10, 59, 1000] {
            let exact = 1.0 - 0.05_f64.powf(1.0 / trials as f64);
            assert!((Count { hits: 0, trials }.upper() - exact).abs() < 1e-9);
            assert!((Count { hits: trials, trials }.lower() - (1.0 - exact)).abs() < 1e-9);
        }
    }

    #[test]
    fn at_the_bound_the_count_has_the_stated_probability() {
        // The second route: the sum of the binomial distribution itself.
        for (hits, trials) in [(3, 20), (95, 100), (2, 500)] {
            let count = Count { hits, trials };
            let so_many = at_least(hits, trials, count.lower());
            let more = at_least(hits + 1, trials, count.upper());
            assert!((so_many - 0.05).abs() < 1e-6, "{hits} of {trials}: {so_many}");
            assert!((more - 0.95).abs() < 1e-6, "{hits} of {trials}: {more}");
        }
    }
}
