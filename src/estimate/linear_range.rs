//! Whether a value lies within the range for which the form of its effect, or of its model, holds.
//!
//! A simulator's sensitivities (the derivative of what it predicts by one of its parameters, logged
//! as a stream) are exact at the value that was simulated. An effect that multiplies such a stream
//! by a parameter states how far from there it may be used, and from which value it counts. A
//! parameter of a model is the whole value. Beyond, the remedy is another simulation at the value
//! that was found. It does not judge how wrong the form is there.

use crate::engine::Problem;
use crate::estimate::calibrate::Estimate;
use crate::model::Setting;
use crate::units::Unit;

/// A value beyond the range of its effect's form.
#[derive(Clone, Debug, PartialEq)]
pub struct BeyondRange {
    /// The parameter.
    pub parameter: String,
    /// Of which setup or run.
    pub of: Option<String>,
    /// Whether it is one of the model: then it does not count from what was simulated.
    pub is_of_model: bool,
    /// How far it is (SI) from what was simulated.
    pub value: f64,
    /// Largest value (SI) for which the form holds.
    pub range: f64,
    /// The value (SI) at which to simulate again, where it is stated which was simulated.
    pub simulate_at: Option<f64>,
    /// The unit in which people read it.
    pub unit: Unit,
}

impl BeyondRange {
    /// A value of a parameter with this setting, where it is beyond its range. Only the name of an
    /// effect's parameter has a point.
    pub fn of(
        setting: &Setting,
        (parameter, of): (&str, Option<&str>),
        value: f64,
        unit: &Unit,
    ) -> Option<Self> {
        let is_of_model = !parameter.contains('.');
        let from = setting.simulated_at.filter(|_| is_of_model).unwrap_or(0.0);
        let value = value - from;
        let range = setting.linear_range.filter(|range| value.abs() > *range)?;
        Some(Self {
            parameter: parameter.to_owned(),
            of: of.map(str::to_owned),
            is_of_model,
            value,
            range,
            simulate_at: setting.simulated_at.map(|at| at + value),
            unit: unit.clone(),
        })
    }
}

/// Estimates beyond the ranges that their parameters state, in their order.
pub fn beyond_range(problem: &Problem, estimates: &[Estimate]) -> Vec<BeyondRange> {
    let of = |one: &Estimate| {
        let setting = &problem.layout.instances.get(one.instance?)?.setting;
        BeyondRange::of(setting, (&one.name, one.of.as_deref()), one.value?, &one.declared)
    };
    estimates.iter().filter_map(of).collect()
}
