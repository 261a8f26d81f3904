//! How large an effect is in a fit, against what is typical and what can be.

use crate::diagnose::fitted::Fitted;
use crate::diagnose::thresholds::{LARGEST_DELAY, LARGEST_RATE};
use crate::effect::Acts;
use crate::units::Dimension;

use super::in_fit::effect_of;
use super::linear::Linear;

impl Linear {
    /// Log prior of the size of an effect in a fit: a Cauchy distribution about zero whose width is
    /// the typical magnitude, at its largest value.
    pub fn ln_size_prior(&self, fitted: &Fitted, term: usize) -> f64 {
        let ratio = |(value, typical, _)| value / typical;
        let most = sizes(fitted, &self.terms[term].name).map(ratio).fold(0.0, f64::max);
        -most.powi(2).ln_1p()
    }

    /// Whether the size of an effect in a fit can be; a user's own may have any.
    pub fn is_plausible(&self, fitted: &Fitted, term: usize) -> bool {
        let own = &self.terms[term];
        let acts = effect_of(fitted, &own.name).map(|one| one.effect.acts);
        let is_timing = acts == Some(Acts::Timing);
        if own.is_own || !(is_timing || acts == Some(Acts::Servo)) {
            return true;
        }
        let most = |(_, typical, dimension)| match dimension {
            Dimension::TIME => LARGEST_DELAY,
            Dimension::NONE if is_timing && typical < LARGEST_RATE => LARGEST_RATE,
            _ => f64::INFINITY,
        };
        sizes(fitted, &own.name).all(|one| one.0 <= most(one))
    }
}

/// The values of an effect in a fit with their typical magnitudes (SI) and dimensions.
fn sizes<'a>(
    fitted: &'a Fitted,
    name: &str,
) -> impl Iterator<Item = (f64, f64, Dimension)> + use<'a> {
    let prefix = format!("{name}.");
    let instances = fitted.problem.layout.instances.iter().zip(&fitted.fit.point.values);
    instances.filter(move |(one, _)| one.name.starts_with(&prefix)).filter_map(|(one, value)| {
        let most = value[..one.dimension()].iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        Some((most, one.setting.typical?, one.unit.dimension))
    })
}
