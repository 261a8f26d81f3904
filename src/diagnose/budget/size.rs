//! How large an effect is in a fit, against what is typical and what can be.

use crate::diagnose::fitted::Fitted;
use crate::diagnose::thresholds::{LARGEST_DELAY, LARGEST_RATE, LARGEST_SCALE};
use crate::effect::Acts;
use crate::units::{Dimension, Unit};

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
        if own.is_own {
            return true;
        }
        let acts = effect_of(fitted, &own.name).map(|one| one.effect.acts);
        let is_timing = acts == Some(Acts::Timing);
        let is_dynamic = is_timing || acts == Some(Acts::Servo);
        let most = |(_, typical, unit): (f64, f64, &Unit)| match unit.dimension {
            Dimension::TIME if is_dynamic => LARGEST_DELAY,
            Dimension::NONE if typical >= LARGEST_RATE || unit.is_angle() => f64::INFINITY,
            Dimension::NONE if is_timing => LARGEST_RATE,
            Dimension::NONE => LARGEST_SCALE,
            _ => f64::INFINITY,
        };
        sizes(fitted, &own.name).all(|one| one.0 <= most(one))
    }
}

/// The values of an effect in a fit with their typical magnitudes (SI) and units.
fn sizes<'a>(
    fitted: &'a Fitted,
    name: &str,
) -> impl Iterator<Item = (f64, f64, &'a Unit)> + use<'a> {
    let prefix = format!("{name}.");
    let instances = fitted.problem.layout.instances.iter().zip(&fitted.fit.point.values);
    instances.filter(move |(one, _)| one.name.starts_with(&prefix)).filter_map(|(one, value)| {
        let most = value[..one.dimension()].iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        Some((most, one.setting.typical?, &one.unit))
    })
}
