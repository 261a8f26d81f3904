//! The joint estimate of everything: start, batch, noise levels, covariance, observability.

use nalgebra::DMatrix;

use crate::engine::{Point, Problem};
use crate::estimate::align::Alignment;
use crate::estimate::arrow::normal_matrix;
use crate::estimate::batch::{Fit, FitError, Options, Outcome, fit};
use crate::estimate::combination::combinations;
use crate::estimate::noise::Noise;
use crate::estimate::refused::{Outside, Refused, outside_range, outside_streams};
use crate::estimate::remedies::Open;
use crate::estimate::start::{Aligned, start};
use crate::estimate::stationary::Stationary;
use crate::estimate::withheld::{limits, sensitivities, withheld};
use crate::estimate::words::{Unobservable, describe};
use crate::estimate::{covariance, observability, variance};
use crate::graph::Scope;

/// Rounds of estimating noise levels and fitting again.
const NOISE_ROUNDS: usize = 12;

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

/// Estimates everything from a problem.
///
/// # Errors
/// [`FitError`] where the problem cannot be fitted at all, say because bounds exclude each other. A
/// poor fit is a result.
pub fn calibrate(mut problem: Problem, options: &Options) -> Result<Calibration, FitError> {
    let (point, aligned) = start(&problem);
    let (mut fit, mut levels) = fit_with_levels(&mut problem, point, options)?;
    if fit.outcome.is_result() && problem.count_smoothing(&fit.point) {
        let before = fit.iterations;
        (fit, levels) = fit_with_levels(&mut problem, fit.point, options)?;
        fit.iterations += before;
    }
    finish(problem, fit, levels, aligned)
}

/// The same from a point on.
///
/// # Errors
/// As [`calibrate`].
pub fn calibrate_from(
    mut problem: Problem,
    start: Point,
    options: &Options,
) -> Result<Calibration, FitError> {
    let (fit, levels) = fit_with_levels(&mut problem, start, options)?;
    finish(problem, fit, levels, Vec::new())
}

/// Fits, estimates noise levels, fits again, until the levels stand.
fn fit_with_levels(
    problem: &mut Problem,
    start: Point,
    options: &Options,
) -> Result<(Fit<Point>, Vec<variance::Level>), FitError> {
    let unknown = variance::unknown_levels(problem);
    if unknown.is_empty() {
        return Ok((fit(problem, start, options)?, Vec::new()));
    }
    variance::start_levels(problem, &unknown);
    let first = fit(problem, start, options)?;
    settle_levels(problem, first, &unknown, options)
}

/// Estimates noise levels from a fit, fits again, until the levels stand.
pub(crate) fn settle_levels(
    problem: &mut Problem,
    first: Fit<Point>,
    unknown: &[variance::Unknown],
    options: &Options,
) -> Result<(Fit<Point>, Vec<variance::Level>), FitError> {
    let mut best = first;
    let mut iterations = best.iterations;
    let mut levels = Vec::new();
    for _ in 0..NOISE_ROUNDS {
        if best.outcome == Outcome::NotFinite {
            break;
        }
        let Some((found, change)) = variance::estimate(problem, &mut best.point, unknown) else {
            best.outcome = Outcome::NotFinite;
            break;
        };
        levels = found;
        best = fit(problem, best.point.clone(), options)?;
        iterations += best.iterations;
        if change < 1e-4 {
            break;
        }
    }
    best.iterations = iterations;
    Ok((best, levels))
}

/// What a fit says: its covariance, what it does not determine, its residuals.
///
/// # Errors
/// [`FitError`] if sums do not fit their blocks.
pub fn finish(
    problem: Problem,
    fit: Fit<Point>,
    levels: Vec<variance::Level>,
    aligned: Vec<Aligned>,
) -> Result<Calibration, FitError> {
    let limits = limits(&problem, &fit);
    let examined = match fit.outcome {
        Outcome::NotFinite => None,
        _ => Some(observability::examine(&fit.normal, &limits)?),
    };
    let directions = examined.as_ref().map_or(&[][..], |found| &found.directions);
    let covariance = covariance::of_determined(&fit.normal, directions);
    let (point, normal) = (&fit.point, &fit.normal);
    let open = Open { problem: &problem, point, normal, limits: &limits, directions };
    let unobservable: Vec<Unobservable> = (0..directions.len())
        .map(|at| match Stationary::of(&problem, point, &directions[at]) {
            Some(found) => Unobservable {
                words: found.words(),
                ..describe(&problem, &directions[at], found.remedy())
            },
            None => Unobservable {
                determined: combinations(&problem, point, &covariance, directions, at),
                ..describe(&problem, &directions[at], open.remedy(at))
            },
        })
        .collect();
    let withheld = withheld(&problem, &fit, examined.as_ref());
    let bounds = holding_bounds(&problem, &fit);
    let mut refused = Vec::new();
    if fit.outcome.is_result() {
        refused.extend(outside_range(&problem, &fit.point));
    }
    if fit.outcome.is_result() && unobservable.is_empty() && refused.is_empty() {
        let outside = outside_streams(&problem, &fit.point).into_iter();
        refused.extend(outside.filter(Outside::is_most).map(Refused::OutsideStreams));
    }
    let readings = problem.component_count() + fit.normal.priors.len();
    let rms = rms(&problem, &fit.point);
    let aligned = aligned
        .into_iter()
        .map(|one| (one.of, one.result.map_err(|error| error.to_string())))
        .collect();
    Ok(Calibration {
        problem,
        aligned,
        fit,
        covariance,
        unobservable,
        withheld,
        bounds,
        levels,
        readings,
        rms,
        noise: Noise::Stated,
        refused,
        held: Vec::new(),
    })
}

/// A value counts as on its bound within this part of it.
const ON_BOUND: f64 = 1e-12;

/// For each instance and component the bound on which it lies although the readings pull it beyond.
fn holding_bounds(problem: &Problem, fit: &Fit<Point>) -> Vec<Vec<Option<Bound>>> {
    let layout = &problem.layout;
    let pull = normal_matrix(&fit.normal).map(|(_, gradient)| gradient).ok();
    let held = |index: usize, component: usize| {
        let (_, column) = layout.own_columns(index).find(|(own, _)| *own == component)?;
        let pull = *pull.as_ref()?.get(column)?;
        let value = fit.point.values[index][component];
        let is_on =
            |bound: f64| bound.is_finite() && (value - bound).abs() <= ON_BOUND * bound.abs();
        let (lower, upper) = layout.bounds_of(index, component);
        match pull {
            _ if is_on(lower) && pull < 0.0 => Some(Bound::Lower),
            _ if is_on(upper) && pull > 0.0 => Some(Bound::Upper),
            _ => None,
        }
    };
    let components = |index: usize| 0..layout.instances[index].dimension();
    let each = |index| components(index).map(|component| held(index, component)).collect();
    (0..layout.instances.len()).map(each).collect()
}

/// rms of the residuals of each measurand over all campaigns, by name.
pub fn rms(problem: &Problem, point: &Point) -> Vec<(String, f64)> {
    let mut sums: Vec<(String, f64, usize)> = Vec::new();
    for (p, part) in problem.parts.iter().enumerate() {
        for r in 0..part.runs.len() {
            problem.visit_residuals(p, r, point, &mut |_, residuals| {
                for (measurand, slot) in
                    part.system.assembly.names.measurands.iter().zip(part.slots())
                {
                    let own = &residuals[slot.residual..slot.residual + slot.components];
                    if own.iter().any(|value| value.is_nan()) {
                        continue;
                    }
                    let square: f64 = own.iter().map(|value| value * value).sum();
                    match sums.iter_mut().find(|(name, _, _)| *name == measurand.name) {
                        Some((_, sum, count)) => {
                            *sum += square;
                            *count += 1;
                        }
                        None => sums.push((measurand.name.clone(), square, 1)),
                    }
                }
            });
        }
    }
    sums.into_iter().map(|(name, sum, count)| (name, (sum / count as f64).sqrt())).collect()
}
