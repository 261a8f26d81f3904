//! Scales that absorbed a wrong unit: free factors that start at 1 and end at that between two units.

use std::f64::consts::PI;

use crate::engine::layout::Instance;
use crate::estimate::calibrate::{Calibration, Estimate};
use crate::graph::Kind;

/// Factors between units that are mistaken for each other: prefixes, percent, degrees, inches. Nearer to 1
/// a scale may well be what it is.
const FACTORS: [f64; 6] = [1e3, 1e6, 1e9, 100.0, 180.0 / PI, 25.4];
/// Part of itself by which a scale may differ from a factor.
const NEAR: f64 = 0.01;

/// The scales of a fit, each with the factor that it is about.
pub fn unit_factors(result: &Calibration) -> Vec<(Estimate, f64)> {
    let instances = result.problem.layout.instances.iter().enumerate();
    let free = instances.filter(|(_, one)| starts_at_one(one));
    let estimates = free.flat_map(|(index, _)| result.estimates_of(index));
    let scales = estimates.filter(|one| !one.fixed);
    scales.filter_map(|one| Some((one.clone(), factor_near(one.value?)?))).collect()
}

/// Whether nothing but that it is about 1 is stated of a plain number.
fn starts_at_one(one: &Instance) -> bool {
    let start = if one.start_found { one.stated_start } else { one.setting.start_of(0) };
    one.kind == Kind::Scalar
        && one.unit.symbol == "1"
        && one.setting.sigma.is_none()
        && start == Some(1.0)
}

/// The factor between two units that a number is about, with either sign.
fn factor_near(scale: f64) -> Option<f64> {
    let both = FACTORS.into_iter().flat_map(|factor| [factor, factor.recip()]);
    both.into_iter().find(|factor| (scale.abs() / factor - 1.0).abs() < NEAR)
}

#[cfg(test)]
mod tests {
    use super::factor_near;

    #[test]
    fn a_scale_near_a_factor_of_units_is_doubtful() {
        assert_eq!(factor_near(999.129), Some(1e3));
        assert_eq!(factor_near(-0.001_002), Some(1e-3));
        assert!(
            factor_near(0.017_5).is_some_and(|near| (near - 1.0_f64.to_radians()).abs() < 1e-9)
        );
        for scale in [1.0, 0.99, 2.0, 60.0, 980.0, 0.0, f64::NAN, f64::INFINITY] {
            assert_eq!(factor_near(scale), None, "{scale}");
        }
    }
}
