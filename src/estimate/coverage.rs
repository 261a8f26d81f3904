//! The coverage factor of a combined uncertainty whose parts rest on few degrees of freedom.
//!
//! Welch-Satterthwaite: `ν = u⁴ / Σ (u_i⁴ / ν_i)`; then `k` is Student's t for the level that k = 2
//! has where nothing is short of degrees of freedom, 95.45 % (GUM, JCGM 100:2008, G.4 and table
//! G.2).

use statrs::distribution::{ContinuousCDF, StudentsT};

/// Part of a normal distribution within two standard deviations.
pub const LEVEL: f64 = 0.954_499_736_103_641_6;

/// A combined standard uncertainty and what it expands to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Combined {
    /// Combined standard uncertainty.
    pub sigma: f64,
    /// Effective degrees of freedom; infinite if no part is short of them.
    pub degrees_of_freedom: f64,
    /// Coverage factor for [`LEVEL`].
    pub coverage_factor: f64,
}

impl Combined {
    /// From standard uncertainties with their degrees of freedom (`None`: as if infinitely many).
    pub fn of(parts: impl IntoIterator<Item = (f64, Option<f64>)>) -> Self {
        let (mut variance, mut few) = (0.0, 0.0);
        for (sigma, degrees) in parts {
            variance += sigma * sigma;
            few += degrees.map_or(0.0, |degrees| sigma.powi(4) / degrees);
        }
        let degrees_of_freedom = if few > 0.0 { variance * variance / few } else { f64::INFINITY };
        let coverage_factor = coverage_factor(degrees_of_freedom);
        Self { sigma: variance.sqrt(), degrees_of_freedom, coverage_factor }
    }

    /// Expanded uncertainty.
    pub fn expanded(&self) -> f64 {
        self.coverage_factor * self.sigma
    }
}

/// Student's t for [`LEVEL`], two-sided; 2 for infinitely many degrees of freedom.
pub fn coverage_factor(degrees_of_freedom: f64) -> f64 {
    // For many the first term of its expansion about the normal distribution, (z³ + z) / 4ν at z =
    // 2, is exact to 1e-8; the library's inverse loses digits there.
    if degrees_of_freedom > 1e4 {
        return 2.0 + 2.5 / degrees_of_freedom;
    }
    StudentsT::new(0.0, 1.0, degrees_of_freedom)
        .map_or(2.0, |student| student.inverse_cdf(0.5 * (1.0 + LEVEL)))
}
