//! The result of a joint estimate: values with their uncertainties, and what stands against them.
//! How it is found is the matter of [`crate::estimate::calibrate`].

use nalgebra::DMatrix;

use crate::engine::{Point, Problem};
use crate::estimate::align::Alignment;
use crate::estimate::batch::Fit;
use crate::estimate::noise::Noise;
use crate::estimate::refused::Refused;
use crate::estimate::withheld::sensitivities;
use crate::estimate::words::Unobservable;
use crate::estimate::{covariance, variance};
use crate::graph::Scope;

/// Which bound holds an estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bound {
    /// `lower`.
    Lower,
    /// `upper`.
    Upper,
}

impl Bound {
    /// Its key.
    pub fn word(self) -> &'static str {
        match self {
            Self::Lower => "lower",
            Self::Upper => "upper",
        }
    }
}

/// One component of one parameter as a person reads it, SI.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// `radius`, `position.x`, `orientation.z`, `collimation.offset`.
    pub name: String,
    /// One value for each of these.
    pub scope: Scope,
    /// The setup or run.
    pub of: Option<String>,
    /// Estimate; `None` where the data do not determine it.
    pub value: Option<f64>,
    /// Standard uncertainty (k = 1), not scaled by the variance factor; 0 if fixed, `None` where
    /// the data do not determine it or a bound holds the value.
    pub sigma: Option<f64>,
    /// The bound that holds the value: the readings pull it beyond. Uncertainties of other
    /// parameters are those without the bound.
    pub bound: Option<Bound>,
    /// Unit of the coherent SI value.
    pub unit: String,
    /// The unit in which people read it: as declared, or as the campaign states.
    pub declared: crate::units::Unit,
    /// Whether it was held fixed.
    pub fixed: bool,
    /// Index of its instance; `None` for the level of a random quantity.
    pub instance: Option<usize>,
}

/// The result of a joint estimate.
#[derive(Clone, Debug)]
pub struct Calibration {
    /// What was estimated from, with its weights.
    pub problem: Problem,
    /// Where iteration began.
    pub aligned: Vec<(Option<String>, Result<Alignment, String>)>,
    /// The fit.
    pub fit: Fit<Point>,
    /// Covariance of all columns at the estimate (of what is determined, if not all is).
    pub covariance: DMatrix<f64>,
    /// What cannot be determined.
    pub unobservable: Vec<Unobservable>,
    /// For each instance and component whether it takes part in what cannot be determined.
    pub withheld: Vec<Vec<bool>>,
    /// For each instance and component the bound that holds it.
    pub bounds: Vec<Vec<Option<Bound>>>,
    /// Levels of random quantities and noise factors estimated beside.
    pub levels: Vec<variance::Level>,
    /// Readings and priors.
    pub readings: usize,
    /// rms of the residuals of each measurand, SI.
    pub rms: Vec<(String, f64)>,
    /// The noise of which uncertainties take account.
    pub noise: Noise,
    /// Why the fit is no result although it settled.
    pub refused: Vec<Refused>,
    /// Members of effects that were held at zero because the model absorbs them.
    pub held: Vec<Held>,
}

/// A member of an effect that was held at zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Held {
    /// Its name.
    pub name: String,
    /// The run in which alone it is held, for no reading of that depends on it; `None` of all values.
    pub of: Option<String>,
    /// What does the same, in words.
    pub why: String,
}

impl Calibration {
    /// Whether the numbers can be used: converged, and all is determined.
    pub fn is_sound(&self) -> bool {
        self.unobservable.is_empty() && self.has_settled()
    }

    /// Whether the fit is a solution, though it may not determine everything.
    pub fn has_settled(&self) -> bool {
        self.refused.is_empty() && self.fit.outcome.is_result()
    }

    /// Number of unknowns.
    pub fn unknowns(&self) -> usize {
        self.problem.layout.columns.len() + self.levels.len()
    }

    /// Readings and priors less unknowns.
    pub fn degrees_of_freedom(&self) -> i64 {
        self.readings as i64 - self.unknowns() as i64
    }

    /// chi squared over degrees of freedom; `None` without degrees of freedom.
    pub fn variance_factor(&self) -> Option<f64> {
        let degrees = self.degrees_of_freedom();
        (degrees > 0).then(|| self.fit.cost / degrees as f64)
    }

    /// Every component of every parameter, in the order of the layout.
    pub fn estimates(&self) -> Vec<Estimate> {
        let mut estimates = Vec::new();
        for index in 0..self.problem.layout.instances.len() {
            estimates.extend(self.estimates_of(index));
        }
        for level in &self.levels {
            estimates.push(Estimate {
                name: level.name.clone(),
                scope: level.scope,
                of: level.of.clone(),
                value: Some(level.value),
                sigma: level.sigma,
                bound: None,
                unit: level.unit.si_symbol(),
                declared: self.shown(&level.name, &level.unit),
                fixed: false,
                instance: None,
            });
        }
        estimates
    }

    /// The unit in which people read a parameter.
    fn shown(&self, name: &str, declared: &crate::units::Unit) -> crate::units::Unit {
        let part = self.problem.parts.first();
        part.map_or_else(|| declared.clone(), |part| part.unit_of_parameter(name, declared))
    }

    /// The components of one instance.
    pub(crate) fn estimates_of(&self, index: usize) -> Vec<Estimate> {
        let layout = &self.problem.layout;
        let instance = &layout.instances[index];
        if layout.is_noise_only(index) {
            return Vec::new();
        }
        let values = self.fit.point.components(layout, index);
        let sensitivities = sensitivities(layout, &self.fit.point, index);
        let names: Vec<String> = if instance.dimension() == 1 {
            vec![instance.name.clone()]
        } else {
            ["x", "y", "z"].map(|axis| format!("{}.{axis}", instance.name)).to_vec()
        };
        names
            .into_iter()
            .zip(values)
            .zip(sensitivities)
            .enumerate()
            .map(|(component, ((name, value), sensitivity))| {
                let bound = self.bounds[index].get(component).copied().flatten();
                let determined = !self.withheld[index].get(component).is_some_and(|open| *open);
                let variance = covariance::of_combination(&self.covariance, &sensitivity);
                Estimate {
                    name,
                    scope: instance.setting.scope,
                    of: instance.of.clone(),
                    value: determined.then_some(value),
                    sigma: (determined && bound.is_none()).then(|| variance.max(0.0).sqrt()),
                    bound,
                    unit: instance.unit.si_symbol(),
                    declared: self.shown(&instance.name, &instance.unit),
                    fixed: sensitivity.is_empty(),
                    instance: Some(index),
                }
            })
            .collect()
    }
}
