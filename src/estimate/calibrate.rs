//! The joint estimate of everything: start, batch, noise levels, covariance, observability.

use crate::engine::{Point, Problem};
use crate::estimate::arrow::normal_matrix;
use crate::estimate::batch::{Fit, FitError, Options, Outcome};
use crate::estimate::combination::combinations;
use crate::estimate::levels::fit_with_levels;
use crate::estimate::noise::Noise;
use crate::estimate::refused::{Outside, Refused, outside_range, outside_streams};
use crate::estimate::remedies::Open;
use crate::estimate::start::{Aligned, start};
use crate::estimate::stationary::Stationary;
use crate::estimate::withheld::{limits, withheld};
use crate::estimate::words::{Unobservable, describe};
use crate::estimate::{covariance, observability, variance};

pub use crate::estimate::calibration::{Bound, Calibration, Estimate, Held};

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
