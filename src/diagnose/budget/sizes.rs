//! How large effects are. Values of a term by the parameters that they are of, as the sums find them:
//! where a fit begins, and the size of what is not in the fit. Values in a fit against what is typical
//! and what can be. It fits nothing.

use std::collections::BTreeMap;

use crate::diagnose::fitted::Fitted;
use crate::diagnose::thresholds::{LARGEST_DELAY, LARGEST_RATE, LARGEST_SCALE};
use crate::effect::Acts;
use crate::engine::point::NamedValue;
use crate::units::{Dimension, Unit};

use super::in_fit::effect_of;
use super::linear::Linear;
use super::selection::Selection;

/// A value of an effect that is not in the fit, as the sums find it.
#[derive(Clone, Debug)]
pub struct Size {
    /// The parameter's full name.
    pub parameter: String,
    /// Component of it.
    pub component: usize,
    /// The setup, run, rig or instrument that it holds for.
    pub of: Option<String>,
    /// The value (SI).
    pub value: f64,
    /// Unit in which results give the parameter.
    pub unit: Unit,
}

/// A sum of values of several effects, which is better determined than each.
#[derive(Clone, Debug)]
pub struct WellDetermined {
    /// The values with their factors (SI); that of the row is the first, with the factor 1.
    pub terms: Vec<(f64, Size)>,
    /// The sum (SI).
    pub value: f64,
    /// Its standard uncertainty.
    pub sigma: f64,
}

impl Linear {
    /// A value (SI) of a column with its parameter; `None` of columns of no parameter.
    pub fn size(&self, column: usize, value: f64) -> Option<Size> {
        let own = column.checked_sub(self.sums.nominal);
        let (parameter, component, of) = if let Some(own) = own {
            let owner = self.sums.owners.get(own)?;
            (owner.parameter.clone(), owner.component, owner.of.clone())
        } else {
            let layout = &self.fitted.problem.layout;
            layout.instances.iter().enumerate().find_map(|(index, instance)| {
                let mut own = layout.own_columns(index);
                let (component, _) = own.find(|(_, other)| *other == column)?;
                Some((instance.name.clone(), component, instance.whose().map(str::to_owned)))
            })?
        };
        Some(Size { unit: self.unit_of(&parameter), parameter, component, of, value })
    }

    /// The unit in which results give a parameter of a candidate or of a row.
    fn unit_of(&self, parameter: &str) -> Unit {
        self.fitted.unit_of_parameter(parameter, self.declared_unit_of(parameter))
    }

    /// The unit in which it is declared.
    fn declared_unit_of(&self, parameter: &str) -> Unit {
        let instances = &self.fitted.problem.layout.instances;
        if let Some(own) = instances.iter().find(|one| one.name == parameter) {
            return own.unit.clone();
        }
        let own = self.candidates.iter().filter(|one| {
            parameter.strip_prefix(one.name.as_str()).is_some_and(|rest| rest.starts_with('.'))
        });
        own.filter_map(|one| one.unit(parameter)).next().unwrap_or_else(Unit::one)
    }

    /// Values of a term's parameters beside a model, as the sums find them best.
    pub fn sizes(&self, selection: &Selection<'_>, model: &[usize], term: usize) -> Vec<Size> {
        let with = [model, &[term]].concat();
        let values = selection.values(&with);
        let own = &selection.terms[term].columns;
        let first = values.len() - own.len();
        let mut sums: BTreeMap<usize, f64> = BTreeMap::new();
        for (number, combination) in own.iter().enumerate() {
            for (column, by) in combination {
                *sums.entry(*column).or_default() += by * values[first + number];
            }
        }
        sums.into_iter().filter_map(|(column, value)| self.size(column, value)).collect()
    }

    /// The same as the start of a fit.
    pub fn start(
        &self,
        selection: &Selection<'_>,
        model: &[usize],
        term: usize,
    ) -> Vec<NamedValue> {
        let sizes = self.sizes(selection, model, term).into_iter();
        sizes.map(|one| (one.parameter, one.component, one.of, one.value)).collect()
    }

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
